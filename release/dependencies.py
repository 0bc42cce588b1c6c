"""What the program and the wheel are made of: dependencies, their licences, and the SBOM.

`cargo tree` names the packages that one root package needs with its own features on one platform;
`cargo metadata` has their licences and sources; `Cargo.lock` has their checksums.
"""

import datetime
import hashlib
import json
import os
import pathlib
import re
import subprocess
import tomllib
import uuid

ROOT = pathlib.Path(__file__).resolve().parents[1]

#: Licences under which a dependency may be linked into the program. Those that are not permissive
#: are in CONDITIONS.
ALLOWED = {
    "0BSD",
    "Apache-2.0",
    "Apache-2.0 WITH LLVM-exception",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "BSL-1.0",
    "CC0-1.0",
    "ISC",
    "MIT",
    "MPL-2.0",
    "Unicode-3.0",
    "Unlicense",
    "Zlib",
}
#: What the licences require that are more than a notice.
CONDITIONS = {"MPL-2.0": "unchanged; its source is at the address of the package"}
#: Names of files with the text of a licence, or with a notice that it requires.
TEXTS = re.compile(r"^(licen[cs]e|copying|notice|unlicense|copyright)", re.IGNORECASE)


def cargo(*arguments):
    """Returns what a command of cargo prints."""
    command = ["cargo", *arguments]
    return subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout


def host():
    """Returns the platform of the compiler."""
    printed = subprocess.run(["rustc", "-vV"], check=True, capture_output=True, text=True).stdout
    return re.search(r"^host: (\S+)$", printed, re.MULTILINE)[1]


def version():
    """Returns the version of the workspace."""
    with open(ROOT / "Cargo.toml", "rb") as file:
        return tomllib.load(file)["workspace"]["package"]["version"]


def checksums():
    """Returns the SHA-256 of each package of a registry, from Cargo.lock."""
    with open(ROOT / "Cargo.lock", "rb") as file:
        packages = tomllib.load(file)["package"]
    return {(one["name"], one["version"]): one["checksum"] for one in packages if "checksum" in one}


class Package:
    """A package: `key` is its name and version."""

    def __init__(self, found, checksum):
        self.name, self.version = found["name"], found["version"]
        self.key = self.name, self.version
        self.description = " ".join((found["description"] or "").split())
        # An old way to write "or".
        self.licence = (found["license"] or "").replace(" / ", "/").replace("/", " OR ")
        self.repository = found["repository"] or found["homepage"]
        self.folder = pathlib.Path(found["manifest_path"]).parent
        self.ours = found["source"] is None
        self.checksum = checksum

    @property
    def purl(self):
        return f"pkg:cargo/{self.name}@{self.version}"

    def texts(self):
        """Returns the texts of licences and notices that come with the package."""
        files = [path for path in sorted(self.folder.iterdir()) if TEXTS.match(path.name) and path.is_file()]
        return [path.read_text(encoding="utf-8", errors="replace").strip() for path in files]


LINE = re.compile(r"^(\d+)(\S+) v(\S+)")
#: Edges that lead to what is linked into a program: a procedural macro takes part in the build alone.
LINKED = "normal,no-proc-macro"


def needed(root, edges=LINKED):
    """Returns the packages that `root` needs, each with the keys of its direct dependencies."""
    tree = cargo("tree", "--locked", "-p", root, "-e", edges, "--target", host(), "--prefix", "depth")
    found, above = {}, []
    for line in tree.splitlines():
        depth, name, number = LINE.match(line).groups()
        key = name, number
        found.setdefault(key, set())
        del above[int(depth) :]
        if above:
            found[above[-1]].add(key)
        above.append(key)
    return found


def packages():
    """Returns all packages of the workspace and its dependencies on this platform, by key."""
    metadata = json.loads(
        cargo("metadata", "--locked", "--format-version", "1", "--filter-platform", host())
    )
    locked = checksums()
    each = (Package(one, locked.get((one["name"], one["version"]))) for one in metadata["packages"])
    return {package.key: package for package in each}


def alternatives(expression):
    """Returns the sets of licences, each of which fulfils an SPDX expression."""
    tokens = re.findall(r"\(|\)|[^\s()]+", expression)

    def either():
        found = both()
        while tokens and tokens[0] == "OR":
            tokens.pop(0)
            found = found + both()
        return found

    def both():
        found = one()
        while tokens and tokens[0] == "AND":
            tokens.pop(0)
            other = one()
            found = [a | b for a in found for b in other]
        return found

    def one():
        if not tokens:
            raise ValueError(f"not an SPDX expression: {expression!r}")
        name = tokens.pop(0)
        if name == "(":
            found = either()
            if not tokens or tokens.pop(0) != ")":
                raise ValueError(f"not an SPDX expression: {expression!r}")
            return found
        if name in (")", "OR", "AND", "WITH"):
            raise ValueError(f"not an SPDX expression: {expression!r}")
        if tokens and tokens[0] == "WITH":
            name = f"{name} {tokens.pop(0)} {tokens.pop(0)}"
        return [{name}]

    found = either()
    if tokens:
        raise ValueError(f"not an SPDX expression: {expression!r}")
    return found


def refused(found):
    """Returns the reason for each package that may not be linked."""
    reasons = []
    for package in found:
        if not package.licence:
            reasons.append(f"{package.name} {package.version} names no licence")
        elif not any(licences <= ALLOWED for licences in alternatives(package.licence)):
            reasons.append(f"{package.name} {package.version} is under {package.licence}, which ALLOWED lacks")
    return reasons


def third_party(root):
    """Returns the list of the dependencies of `root` with the texts of their licences."""
    all_packages = packages()
    found = [package for key in sorted(needed(root)) if not (package := all_packages[key]).ours]
    lines = [
        f"# Third-party licences of {root} {version()}",
        "",
        f"The program contains {len(found)} packages by others on {host()}, each under the licence that is",
        "named beside it. The texts follow the table.",
        "",
        "| package | version | licence | source |",
        "|---|---|---|---|",
    ]
    for package in found:
        licence = package.licence
        for name, condition in CONDITIONS.items():
            if not any(name not in licences for licences in alternatives(licence)):
                licence = f"{licence}: {condition}"
        source = package.repository or f"https://crates.io/crates/{package.name}"
        lines.append(f"| {package.name} | {package.version} | {licence} | {source} |")

    # Many packages have the same text but for the line of the copyright.
    texts = {}
    without = []
    for package in found:
        own = package.texts()
        if not own:
            without.append(f"{package.name} {package.version}")
        for text in own:
            texts.setdefault(text, []).append(f"{package.name} {package.version}")
    if without:
        lines += ["", "These packages come without a text of their own; the SPDX texts of their licences apply:"]
        lines += [f"{', '.join(without)}."]
    for text, names in texts.items():
        lines += ["", f"## {', '.join(names)}", "", "```text", text.replace("```", "'''"), "```"]
    return "\n".join(lines) + "\n"


def component(package, kind, scope=None):
    """Returns a component of CycloneDX."""
    found = {"type": kind, "bom-ref": package.purl, "name": package.name, "version": package.version}
    if package.description:
        found["description"] = package.description
    if scope:
        found["scope"] = scope
    if package.checksum:
        found["hashes"] = [{"alg": "SHA-256", "content": package.checksum}]
    found["licenses"] = [{"expression": package.licence}]
    found["purl"] = package.purl
    if package.repository:
        found["externalReferences"] = [{"type": "vcs", "url": package.repository}]
    return found


def moment():
    """Returns the time of the commit, or that of SOURCE_DATE_EPOCH, so that equal sources give equal
    files."""
    seconds = os.environ.get("SOURCE_DATE_EPOCH")
    if seconds is None:
        command = ["git", "log", "-1", "--format=%ct"]
        seconds = subprocess.run(command, cwd=ROOT, capture_output=True, text=True).stdout.strip() or "0"
    return datetime.datetime.fromtimestamp(int(seconds), datetime.timezone.utc)


def sbom(root):
    """Returns the bill of materials of `root` as CycloneDX 1.6.

    Packages that only take part in the build are in it too, with the scope "excluded"."""
    all_packages = packages()
    linked, built = needed(root), needed(root, "normal,build")
    (top,) = [key for key in linked if key[0] == root]
    components = []
    for key in sorted(built):
        if key != top:
            scope = "required" if key in linked else "excluded"
            components.append(component(all_packages[key], "library", scope))
    dependencies = [
        {"ref": all_packages[key].purl, "dependsOn": sorted(all_packages[other].purl for other in built[key])}
        for key in sorted(built)
    ]
    document = {
        "$schema": "http://cyclonedx.org/schema/bom-1.6.schema.json",
        "bomFormat": "CycloneDX",
        "specVersion": "1.6",
        "version": 1,
        "metadata": {
            "timestamp": moment().strftime("%Y-%m-%dT%H:%M:%SZ"),
            "component": component(all_packages[top], "application"),
            "properties": [{"name": "slewkit:platform", "value": host()}],
        },
        "components": components,
        "dependencies": dependencies,
    }
    content = hashlib.sha256(json.dumps(document, sort_keys=True).encode()).hexdigest()
    document["serialNumber"] = f"urn:uuid:{uuid.uuid5(uuid.NAMESPACE_OID, content)}"
    return document
