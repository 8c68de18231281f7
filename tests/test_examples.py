"""The notebooks of examples/ run from their first cell to their last, in a quick form."""

from pathlib import Path

import pytest

nbformat = pytest.importorskip("nbformat")
nbclient = pytest.importorskip("nbclient")
pytest.importorskip("ipykernel")

NOTEBOOKS = sorted((Path(__file__).parents[1] / "examples").glob("*.ipynb"))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_runs(path, tmp_path, monkeypatch):
    monkeypatch.setenv("LOLA_QUICK", "1")
    notebook = nbformat.read(path, as_version=4)
    # Saved for readers with its results, and pictures among them.
    assert any("image/png" in output.get("data", {}) for output in outputs(notebook))
    options = {"timeout": 300, "resources": {"metadata": {"path": str(tmp_path)}}}
    nbclient.NotebookClient(notebook, kernel_name="python3", **options).execute()


def outputs(notebook):
    return [output for cell in notebook.cells for output in cell.get("outputs", ())]
