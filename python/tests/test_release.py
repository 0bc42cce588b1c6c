"""Releases: licences and bills of materials are complete, and promises are compared."""

import json
import os
import pathlib
import subprocess
import sys

import pytest

pytest.importorskip("tomllib", reason="release/run needs Python 3.11")
ROOT = pathlib.Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "release"))

import dependencies  # noqa: E402
import promises  # noqa: E402


@pytest.mark.parametrize("root", ["slewkit-cli", "slewkit-python"])
def test_the_bill_of_materials_is_valid_and_complete(root):
    from cyclonedx.schema import SchemaVersion
    from cyclonedx.validation.json import JsonStrictValidator

    bill = dependencies.sbom(root)
    assert JsonStrictValidator(SchemaVersion.V1_6).validate_str(json.dumps(bill)) is None
    assert dependencies.sbom(root) == bill, "equal sources give equal files"

    # Every package of the lock file that cargo compiles for the program is named, with its checksum.
    tree = dependencies.cargo("tree", "--locked", "-p", root, "-e", "normal,build", "--prefix", "none")
    compiled = {tuple(line.split()[:2]) for line in tree.splitlines()} - {(root, f"v{dependencies.version()}")}
    assert {(one["name"], f"v{one['version']}") for one in bill["components"]} == compiled
    locked = dependencies.checksums()
    for one in bill["components"]:
        hashes = [found["content"] for found in one.get("hashes", [])]
        key = one["name"], one["version"]
        assert hashes == ([locked[key]] if key in locked else []), key
        assert one["licenses"][0]["expression"]
    scopes = {one["name"]: one["scope"] for one in bill["components"]}
    # A procedural macro is not linked; the library is.
    assert scopes["serde_derive"] == "excluded" and scopes["nalgebra"] == "required"
    known = {bill["metadata"]["component"]["bom-ref"], *(one["bom-ref"] for one in bill["components"])}
    assert all({one["ref"], *one["dependsOn"]} <= known for one in bill["dependencies"])


def test_every_linked_package_is_listed_with_a_text_of_its_licence():
    text = dependencies.third_party("slewkit-cli")
    table, _, texts = text.partition("\n## ")
    for name, version in dependencies.needed("slewkit-cli"):
        if not name.startswith("slewkit"):
            assert f"| {name} | {version} | " in table
            assert f"{name} {version}" in texts or f"{name} {version}" in table.partition("come without")[2]


@pytest.mark.parametrize(
    "expression, fulfilled_by",
    [
        ("MIT", [{"MIT"}]),
        ("MIT OR Apache-2.0", [{"MIT"}, {"Apache-2.0"}]),
        ("(MIT OR Apache-2.0) AND Unicode-3.0", [{"MIT", "Unicode-3.0"}, {"Apache-2.0", "Unicode-3.0"}]),
        ("MIT OR Apache-2.0 AND ISC", [{"MIT"}, {"Apache-2.0", "ISC"}]),
        ("Apache-2.0 WITH LLVM-exception OR MIT", [{"Apache-2.0 WITH LLVM-exception"}, {"MIT"}]),
    ],
)
def test_expressions_of_licences_are_read(expression, fulfilled_by):
    assert dependencies.alternatives(expression) == fulfilled_by


@pytest.mark.parametrize("expression", ["", "MIT OR", "(MIT", "MIT)", "MIT Apache-2.0", "AND MIT"])
def test_what_is_no_expression_is_refused(expression):
    with pytest.raises(ValueError, match="not an SPDX expression"):
        dependencies.alternatives(expression)


class Found:
    name, version = "tied", "1.0.0"

    def __init__(self, licence):
        self.licence = licence


def test_a_licence_that_may_not_be_linked_stops_a_release():
    licences = ["GPL-3.0-only", "GPL-3.0-only OR MIT", "MIT AND GPL-3.0", ""]
    reasons = dependencies.refused([Found(licence) for licence in licences])
    assert reasons == [
        "tied 1.0.0 is under GPL-3.0-only, which ALLOWED lacks",
        "tied 1.0.0 is under MIT AND GPL-3.0, which ALLOWED lacks",
        "tied 1.0.0 names no licence",
    ]


def test_what_a_version_promised_and_the_next_lacks_is_found():
    program = os.environ.get("SLEW", ROOT / "target/debug/slew")
    promised = promises.now(program)
    assert {kind: len(each) > 5 for kind, each in promised.items()} == dict.fromkeys(promised, True)
    assert "maneuver.duration_s" in promised["spec"] and 'maneuver.minimize = "fuel"' in promised["spec"]
    assert "trajectory.time_s" in promised["plan file"]
    assert "slew plan --set" in promised["commands"] and "130" in promised["exit codes"]
    assert "Plan.torque" in promised["Python"] and "plan(overrides)" in promised["Python"]

    assert promises.broken(promised, promised) == []
    more = {kind: [*each, "new"] for kind, each in promised.items()}
    assert promises.broken(promised, more) == []
    less = promised | {"spec": [key for key in promised["spec"] if key != "maneuver.duration_s"]}
    assert promises.broken(promised, less) == ["spec: maneuver.duration_s"]


def test_a_release_has_one_version_and_licences_that_may_be_linked():
    done = subprocess.run([sys.executable, ROOT / "release/run", "check"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert f"slewkit {dependencies.version()}" in done.stdout


def test_a_part_that_does_not_exist_is_refused_with_the_list_of_parts():
    done = subprocess.run([sys.executable, ROOT / "release/run", "upload"], capture_output=True, text=True)
    assert done.returncode == 2 and "release/run PART" in done.stdout
