"""What a version promises to keep, as lists that the next versions are compared with.

docs/stability.md states the promises. Each list here names things that a later version must still
have: keys, commands, options, codes, names. It may have more.
"""

import ast
import json
import pathlib
import re
import subprocess

ROOT = pathlib.Path(__file__).resolve().parents[1]
FOLDER = ROOT / "release" / "promised"


def path(version):
    """Returns the file of a version."""
    return FOLDER / f"{version}.json"


def paths():
    """Returns the files of all versions."""
    return sorted(FOLDER.glob("*.json"))


def said(program, *arguments):
    found = subprocess.run([str(program), *arguments], check=True, capture_output=True, text=True, encoding="utf-8")
    return found.stdout


def keys(schema):
    """Returns the paths of all keys of a JSON Schema, with the values of choices."""
    found = set()

    def walk(part, place):
        if isinstance(part, list):
            for one in part:
                walk(one, place)
        if not isinstance(part, dict):
            return
        for name, inner in part.get("properties", {}).items():
            found.add(f"{place}.{name}" if place else name)
            walk(inner, f"{place}.{name}" if place else name)
        for value in part.get("enum", [part["const"]] if "const" in part else []):
            found.add(f"{place} = {json.dumps(value)}")
        for word in ("oneOf", "anyOf", "allOf", "items", "prefixItems"):
            walk(part.get(word), f"{place}[]" if "tems" in word else place)

    walk(schema, "")
    return sorted(found)


def commands(program):
    """Returns the names of all commands."""
    text = said(program, "--help").partition("Commands:")[2].partition("Options:")[0]
    return [name for name in re.findall(r"^  ([a-z][a-z-]*)  ", text, re.MULTILINE) if name != "help"]


def options(program):
    """Returns all commands and their options."""
    found = []
    for name in commands(program):
        found.append(f"slew {name}")
        text = said(program, name, "--help")
        named = re.findall(r"^ +(?:-\w, )?(--[a-z][a-z-]*)", text, re.MULTILINE)
        found += [f"slew {name} {option}" for option in named]
    return sorted(set(found))


def exit_codes(program):
    """Returns the exit codes."""
    text = said(program, "--help").partition("Exit codes:")[2].partition("\n\n")[0]
    return sorted(re.findall(r"(?:^|  )(\d+)  ", text, re.MULTILINE))


def python_names():
    """Returns the public names of the Python package, and those of its classes."""
    found = set()
    folder = ROOT / "python" / "slewkit"
    public = set()
    for node in ast.parse((folder / "__init__.py").read_text(encoding="utf-8")).body:
        if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") == "__all__":
            public = set(ast.literal_eval(node.value))
    for file in sorted(folder.glob("*.py")):
        for node in ast.parse(file.read_text(encoding="utf-8")).body:
            name = getattr(node, "name", "")
            if name not in public:
                continue
            found.add(name)
            if isinstance(node, ast.FunctionDef):
                found |= {f"{name}({argument.arg})" for argument in [*node.args.args, *node.args.kwonlyargs]}
            if isinstance(node, ast.ClassDef):
                for inner in node.body:
                    inside = getattr(inner, "name", "")
                    if isinstance(inner, ast.AnnAssign):
                        inside = getattr(inner.target, "id", "")
                    if inside and not inside.startswith("_"):
                        found.add(f"{name}.{inside}")
    return sorted(found)


def now(program):
    """Returns what the present version offers; `program` is its `slew`."""
    return {
        "spec": keys(json.loads(said(program, "schema"))),
        "plan file": keys(json.loads(said(program, "schema", "plan"))),
        "commands": options(program),
        "exit codes": exit_codes(program),
        "codes of messages": sorted(re.findall(r"^[EW]\d{4}", said(program, "explain"), re.MULTILINE)),
        "Python": python_names(),
    }


def broken(before, after):
    """Returns what `before` promised and `after` lacks."""
    return [
        f"{kind}: {one}"
        for kind, promised in before.items()
        for one in promised
        if one not in set(after.get(kind, ()))
    ]
