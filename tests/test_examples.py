"""What examples/ holds runs from beginning to end, in a quick form."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"
NOTEBOOKS, SCRIPTS = (sorted(EXAMPLES.glob(f"*.{kind}")) for kind in ("ipynb", "py"))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_runs(path, tmp_path, monkeypatch):
    nbformat = pytest.importorskip("nbformat")
    nbclient = pytest.importorskip("nbclient")
    pytest.importorskip("ipykernel")
    monkeypatch.setenv("LOLA_QUICK", "1")
    notebook = nbformat.read(path, as_version=4)
    # Saved for readers with its results, and pictures among them.
    assert any("image/png" in output.get("data", {}) for output in outputs(notebook))
    options = {"timeout": 300, "resources": {"metadata": {"path": str(tmp_path)}}}
    nbclient.NotebookClient(notebook, kernel_name="python3", **options).execute()


def outputs(notebook):
    return [output for cell in notebook.cells for output in cell.get("outputs", ())]


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.stem)
def test_script_runs(path, tmp_path):
    done = subprocess.run(
        [sys.executable, path],
        cwd=tmp_path,
        env=os.environ | {"LOLA_QUICK": "1"},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    assert "'x': " in done.stdout


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.stem)
def test_script_says_how_it_is_used_on_the_command_line(path):
    name, law = path.read_text(encoding="utf-8").split("--block ")[1].split()[0].split("=")
    from lola_drake.scenario import OwnLaw
    from lola_drake.swap import load_laws

    loaded = load_laws([OwnLaw(name, str(EXAMPLES.parent / law))])
    assert name in loaded
