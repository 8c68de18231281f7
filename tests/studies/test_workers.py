"""Processes of a study: killed, stopped, left alone."""

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from lola_drake.scenario import ScenarioError
from lola_drake.studies.workers import WorkerLost, each_done


def squared(x):
    return x * x


def killed_at_two(x):
    if x == 2:
        os.kill(os.getpid(), signal.SIGKILL)
    return x


def refused(x):
    raise ScenarioError("no such thing")


def until_asked(x):
    """Go on until somebody asks for the end, as a run does; a file says that it has begun."""
    from lola_drake.interruption import interruption

    with interruption() as interrupted:
        Path(x).touch()
        while not interrupted.is_set():
            time.sleep(0.01)
    return x


@pytest.fixture(autouse=True)
def found_by_workers(monkeypatch):
    """Let workers import this module."""
    monkeypatch.syspath_prepend(os.path.dirname(__file__))
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([os.path.dirname(__file__), *sys.path]))
    monkeypatch.setitem(sys.modules, "test_workers", sys.modules[__name__])
    for function in (squared, killed_at_two, refused, until_asked):
        monkeypatch.setattr(function, "__module__", "test_workers")


@pytest.mark.parametrize("jobs", [1, 2, 9])
def test_every_item_is_answered_once(jobs):
    assert sorted(each_done(squared, [3, 1, 2], jobs)) == [(0, 9), (1, 1), (2, 4)]


def test_a_killed_process_takes_no_other_along():
    answers = dict(each_done(killed_at_two, [1, 2, 3, 4], 2))
    assert isinstance(answers.pop(1), WorkerLost)
    assert answers == {0: 1, 2: 3, 3: 4}


def test_an_error_is_that_of_the_function():
    with pytest.raises(ScenarioError, match="no such thing"):
        list(each_done(refused, [1, 2], 2))


def test_after_an_interruption_what_is_under_way_is_given(tmp_path):
    files = [tmp_path / name for name in "abc"]

    def interrupt():
        while not (files[0].exists() and files[1].exists()):
            time.sleep(0.01)
        os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=interrupt).start()
    answers = []
    with pytest.raises(KeyboardInterrupt):
        for answer in each_done(until_asked, files, 2):
            answers.append(answer)
    assert sorted(answers) == [(0, files[0]), (1, files[1])]
    assert not files[2].exists()


def test_a_process_ends_with_the_one_that_started_it(tmp_path):
    code = (
        "import os, signal, threading, time, test_workers\n"
        "from lola_drake.studies import workers\n"
        "made = []\n"
        "first = workers._Worker.__init__\n"
        "def noted(self):\n"
        "    first(self)\n"
        "    print(self._process.pid, flush=True)\n"
        "workers._Worker.__init__ = noted\n"
        "threading.Timer(1.0, lambda: os.kill(os.getpid(), signal.SIGKILL)).start()\n"
        "list(workers.each_done(test_workers.until_asked, ['a', 'b'], 2))\n"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=tmp_path)
    assert run.returncode == -signal.SIGKILL
    for pid in map(int, run.stdout.split()):
        wait_for_end(pid)


def wait_for_end(pid):
    for _ in range(1000):
        try:
            os.kill(pid, 0)
            with open(f"/proc/{pid}/stat") as stat:
                if stat.read().split()[2] == "Z":
                    return
        except (ProcessLookupError, FileNotFoundError):
            return
        time.sleep(0.01)
    pytest.fail("the process goes on")


def process_of(x):
    return os.getpid()


def test_a_process_makes_room_for_another_before_it_grows(monkeypatch):
    monkeypatch.setattr("lola_drake.studies.workers.RUNS", 3)
    answers = [answer for _, answer in each_done(process_of, range(12), jobs=2)]
    assert os.getpid() not in answers
    assert max(answers.count(pid) for pid in answers) <= 3
