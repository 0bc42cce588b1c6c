"""Notebooks run from their first cell to their last, show pictures, and are stored without outputs.

`BLESS=1 pytest python/tests/test_notebooks.py` removes the outputs that Jupyter has stored.
"""

import json
import os
import pathlib

import pytest

ROOT = pathlib.Path(__file__).parents[2]
NOTEBOOKS = sorted((ROOT / "python/notebooks").glob("*.ipynb"))


def test_there_is_a_notebook_for_each_task():
    names = {path.stem for path in NOTEBOOKS}
    assert names == {"imager", "telescope", "thrusters", "ground_pass", "monte_carlo"}


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_stored_without_outputs(path):
    text = path.read_text(encoding="utf-8")
    notebook = json.loads(text)
    for cell in notebook["cells"]:
        cell["metadata"] = {}
        if cell["cell_type"] == "code":
            cell["outputs"], cell["execution_count"] = [], None
    notebook["metadata"] = {
        "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
        "language_info": {"name": "python"},
    }
    bare = json.dumps(notebook, indent=1, ensure_ascii=False) + "\n"
    if os.environ.get("BLESS"):
        path.write_text(bare, encoding="utf-8")
    else:
        assert text == bare, "BLESS=1 removes the outputs"


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_runs_from_the_first_cell_to_the_last(path, tmp_path, monkeypatch):
    nbformat = pytest.importorskip("nbformat")
    from nbclient import NotebookClient

    # The kernel of this environment, and no other that the machine knows.
    monkeypatch.setenv("JUPYTER_PREFER_ENV_PATH", "1")
    notebook = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    # A cell that raises ends the run with its traceback.
    NotebookClient(notebook, timeout=600, kernel_name="python3", resources={"metadata": {"path": tmp_path}}).execute()

    outputs = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    shown = [output.data for output in outputs if "data" in output]
    plans = [data for data in shown if "solved and verified" in data.get("text/html", "")]
    pictures = [data for data in shown if "image/png" in data or "data:image/svg+xml" in data.get("text/html", "")]
    assert plans and len(pictures) >= 3
    assert not [output for output in outputs if output.output_type == "stream" and output.name == "stderr"]
