"""What the Markdown of the repository needs to become a site: pages for folders that are linked, and
names of files above blocks."""

import json
import pathlib
import re

from mkdocs.structure.files import File

#: The folders that documents link to, and their titles.
FOLDERS = {
    "problems": "Worked specs",
    "examples": "Examples",
    "python/examples": "Python examples",
    "python/notebooks": "Notebooks",
}
#: A fence of a file, as ```toml maneuver.toml, and of a console with commands alone.
FENCE = re.compile(r"^```(\w+) (\S+)$", re.MULTILINE)
LINK = re.compile(r"\]\(([^)#:\s]+)\)")


def first_words(path):
    """Returns the first sentence of the comment at the top of a file."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".ipynb":
        # The title.
        return json.loads(text)["cells"][0]["source"][0].strip("# \n")
    lines = []
    for line in text.splitlines():
        if line.startswith("#!"):
            continue
        if not line.startswith(("#", "//!", '"""')):
            break
        lines.append(line.lstrip("#/! ").strip('"'))
    found = re.match(r".*?[.:](?=\s|$)", " ".join(lines))
    return (found[0].rstrip(".:") if found else " ".join(lines)).replace("|", "\\|")


def listed(folder, title):
    """Returns the page of a folder."""
    rows = [f"# {title}\n", "| file | what it is |", "|---|---|"]
    for path in sorted(folder.rglob("*")):
        if path.suffix in {".toml", ".rs", ".py", ".sh", ".ipynb"}:
            name = path.relative_to(folder).as_posix()
            rows.append(f"| [{name}]({name}) | {first_words(path)} |")
    return "\n".join(rows) + "\n"


def on_files(files, config):
    top = pathlib.Path(config.docs_dir)
    for folder, title in FOLDERS.items():
        page = listed(top / folder, title)
        files.append(File.generated(config, f"{folder}/index.md", content=page))
    return files


def on_page_markdown(markdown, page, config, files):
    here = pathlib.Path(config.docs_dir, page.file.src_uri).parent

    def link(found):
        target = here / found[1]
        return f"]({found[1].rstrip('/')}/index.md)" if target.is_dir() else found[0]

    return LINK.sub(link, FENCE.sub(r'```\1 title="\2"', markdown))
