"""What stands in brackets is shown as it is written: in helps, tables and progress."""

import inspect
import os
import subprocess
import sys
import typing

import pytest
from typer.testing import CliRunner

from lola_drake.cli.app import app
from lola_drake.cli.common import progress_bar
from lola_drake.results import load_result


def commands(level, *path):
    """Yield the path of every command, and the function that it calls."""
    for info in level.registered_commands:
        yield (*path, info.name or info.callback.__name__.strip("_")), info.callback
    for group in level.registered_groups:
        more = () if group.name is None or not isinstance(group.name, str) else (group.name,)
        yield from commands(group.typer_instance, *path, *more)


def texts(function):
    """Return what is written as help of a command and of its options, in its source."""
    hints = typing.get_type_hints(function, include_extras=True).values()
    infos = (info for hint in hints for info in getattr(hint, "__metadata__", ()))
    return [inspect.getdoc(function), *(info.help for info in infos if info.help)]


def without_frames(text):
    return " ".join(text.translate(dict.fromkeys(map(ord, "│╭╮╰╯─"), " ")).split())


@pytest.mark.parametrize("path", [path for path, _ in commands(app)], ids=" ".join)
def test_a_help_shows_every_text_as_it_is_written(path):
    function = dict(commands(app))[path]
    shown = CliRunner(env={"COLUMNS": "2000"}).invoke(app, [*path, "--help"], color=False)
    assert shown.exit_code == 0
    for text in texts(function):
        assert without_frames(text) in without_frames(shown.stdout), text


def test_all_commands_are_among_those():
    names = {" ".join(path) for path, _ in commands(app)}
    assert {"simulate", "list", "sweep", "map", "study status", "study show"} <= names
    listed = CliRunner(env={"COLUMNS": "2000"}).invoke(app, ["--help"]).stdout
    assert all(name.split()[0] in listed for name in names)
    assert any("[cluster]" in text for _, function in commands(app) for text in texts(function))


def test_a_name_in_brackets_is_shown_as_it_is(lola):
    odd = "a [bold]{x} :cat:"
    done = lola("simulate", "stand", "--set", f"name='{odd}'", "-o", "run")
    assert done.exit_code == 0 and f"{odd} (dyn)" in done.stdout
    assert load_result("run").scenario.name == odd


def test_progress_of_a_name_in_brackets(capsys):
    with progress_bar("a[/b] {x}", 2.0, thread=False) as advance:
        advance(1.0)


def test_a_help_in_colours_has_its_brackets_too():
    environment = os.environ | {"COLUMNS": "120", "FORCE_COLOR": "1"}
    command = [sys.executable, "-m", "lola_drake", "sweep", "--help"]
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    assert done.returncode == 0 and "cluster" in done.stdout.split("(the extra")[1].split(")")[0]
