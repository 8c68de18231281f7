"""How the `lola` command begins."""

import os
import signal
import subprocess
import sys
import types

import pytest

from lola_drake import __main__ as lola


class Replaced(Exception):
    """The process was replaced by another one."""


@pytest.fixture
def replaced(monkeypatch):
    """Return a list that gets the program and the arguments of the process that follows."""
    following = []

    def execv(program, arguments):
        following.append((program, arguments))
        raise Replaced

    monkeypatch.setattr(os, "execv", execv)
    monkeypatch.setattr(os, "environ", {**os.environ})
    os.environ.pop("GLIBC_TUNABLES", None)
    monkeypatch.setattr(sys, "platform", "linux")
    return following


def test_it_begins_again_with_more_blocks_at_hand(replaced, monkeypatch):
    monkeypatch.setattr(sys, "orig_argv", ["python", "-X", "dev", "lola", "simulate", "stand"])
    with pytest.raises(Replaced):
        lola.main()
    again = [sys.executable, "-X", "dev", "lola", "simulate", "stand"]
    assert replaced == [(sys.executable, again)]
    assert "glibc.malloc.tcache_count=127" in os.environ["GLIBC_TUNABLES"].split(":")


def test_a_users_own_setting_is_left_alone(replaced, monkeypatch, capsys):
    monkeypatch.setenv("GLIBC_TUNABLES", "glibc.malloc.check=0")
    monkeypatch.setattr(sys, "argv", ["lola", "list"])
    with pytest.raises(SystemExit) as end:
        lola.main()
    assert end.value.code == 0
    assert not replaced
    assert "walk_flat" in capsys.readouterr().out
    assert os.environ["GLIBC_TUNABLES"] == "glibc.malloc.check=0"


def test_elsewhere_it_begins_once(replaced, monkeypatch, capsys):
    monkeypatch.setattr(sys, "platform", "darwin")
    monkeypatch.setattr(sys, "argv", ["lola", "list"])
    with pytest.raises(SystemExit):
        lola.main()
    assert not replaced
    assert "walk_flat" in capsys.readouterr().out


def test_the_command_ends_as_it_would_without_beginning_again(tmp_path):
    environment = {name: value for name, value in os.environ.items() if name != "GLIBC_TUNABLES"}
    command = [sys.executable, "-m", "lola_drake", "simulate", "no_such_scenario"]
    run = subprocess.run(command, env=environment, cwd=tmp_path, capture_output=True, text=True)
    assert run.returncode == 2
    assert run.stderr.startswith("lola: ")
    assert run.stderr.count("\n") == 1


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("becomes", [None, ImportError("numpy is broken"), SystemError("none")])
def test_a_stop_in_the_middle_of_an_import_is_one_line(monkeypatch, capsys, number, becomes):
    def app(prog_name):
        try:
            os.kill(os.getpid(), number)
        except KeyboardInterrupt:
            if becomes is None:
                raise
        raise becomes

    before = {one: signal.getsignal(one) for one in (signal.SIGINT, signal.SIGTERM)}
    monkeypatch.setenv("GLIBC_TUNABLES", "mine")
    monkeypatch.setitem(sys.modules, "lola_drake.cli.app", types.SimpleNamespace(app=app))
    try:
        with pytest.raises(SystemExit) as end:
            lola.main()
    finally:
        for one, handler in before.items():
            signal.signal(one, handler)
    assert end.value.code == 130
    assert capsys.readouterr().err == "lola: stopped\n"


def test_an_error_of_its_own_is_not_hidden(monkeypatch):
    def app(prog_name):
        raise ZeroDivisionError

    monkeypatch.setenv("GLIBC_TUNABLES", "mine")
    monkeypatch.setitem(sys.modules, "lola_drake.cli.app", types.SimpleNamespace(app=app))
    with pytest.raises(ZeroDivisionError):
        lola.main()
