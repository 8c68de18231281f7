"""The `lola` command with a stand-in for the simulation."""

import sys
import types

import pytest
from typer.testing import CliRunner

from lola_drake.cli.app import app


@pytest.fixture
def lola(make_result, monkeypatch, tmp_path):
    """Return a function that runs the command in an empty folder; the outcome can be set."""
    monkeypatch.chdir(tmp_path)
    outcome, runs, drawn = {}, [], []

    def simulate(scenario, progress=None, attend=None, engine="fused", folder=None, force=False):
        runs.append(scenario)
        if progress is not None:
            progress(scenario.duration / 2)
        result = make_result(scenario, **outcome)
        if folder is not None:
            result.save(folder, force=force)
        return result

    module = types.SimpleNamespace(simulate=simulate)
    monkeypatch.setitem(sys.modules, "lola_drake.simulation", module)
    pictures = types.SimpleNamespace(write_pictures=lambda result, folder: drawn.append(folder))
    monkeypatch.setitem(sys.modules, "lola_drake.reports.run_report", pictures)

    def run(*arguments):
        return CliRunner().invoke(app, arguments)

    run.outcome, run.runs, run.drawn = outcome, runs, drawn
    return run
