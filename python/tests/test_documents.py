"""The Python blocks of documents run, and print what stands under them.

The blocks of a document run one after another in a folder with `problems/`. A block of `text` that
follows a block of `python` is its output; figures may differ in their last digit. `BLESS=1 pytest
python/tests/test_documents.py` writes the present output into the documents.
"""

import contextlib
import io
import os
import pathlib
import re
import shutil

import pytest

ROOT = pathlib.Path(__file__).parents[2]
DOCUMENTS = ["docs/guide/python.md"]
BLOCK = re.compile(r"```python\n(.*?)```\n(?:\n```text\n(.*?)```\n)?", re.DOTALL)
FIGURE = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")


def last_digit(figure):
    digits, _, power = figure.partition("e")
    places = len(digits.partition(".")[2])
    return 10.0 ** (int(power or 0) - places)


def same(expected, found):
    """Returns whether two outputs are equal but for one in the last digit of figures with a point.

    Below 1e-7 round-off decides.
    """
    if FIGURE.sub("#", expected) != FIGURE.sub("#", found):
        return False
    pairs = zip(FIGURE.findall(expected), FIGURE.findall(found))
    return all(
        a == b
        or (abs(float(a)) < 1e-7 and abs(float(b)) < 1e-7)
        or ("." in a and abs(float(a) - float(b)) <= 1.01 * last_digit(a))
        for a, b in pairs
    )


@pytest.mark.parametrize("name", DOCUMENTS)
def test_blocks_print_what_stands_under_them(name, tmp_path, monkeypatch):
    document = ROOT / name
    text = document.read_text(encoding="utf-8")
    shutil.copytree(ROOT / "problems", tmp_path / "problems")
    monkeypatch.chdir(tmp_path)
    names, differences, run = {}, [], 0

    def printed(block):
        nonlocal run
        run += 1
        output = io.StringIO()
        with contextlib.redirect_stdout(output):
            exec(compile(block[1], f"{name}, block {run}", "exec"), names)
        found = output.getvalue()
        if same(block[2] or "", found):
            return block[0]
        differences.append((block[1], block[2], found))
        return f"```python\n{block[1]}```\n\n```text\n{found}```\n"

    now = BLOCK.sub(printed, text)
    assert run >= 5
    if os.environ.get("BLESS"):
        document.write_text(now, encoding="utf-8")
    else:
        assert not differences


def test_figures_may_differ_in_their_last_digit():
    assert same("1.25 m, 3 of 4", "1.26 m, 3 of 4")
    assert not same("1.25 m, 3 of 4", "1.27 m, 3 of 4")
    assert not same("1.25 m, 3 of 4", "1.25 m, 2 of 4")
    assert not same("1.25 m", "1.25 s")
    assert same("off by 3.1e-12 m", "off by 2.0e-16 m")
