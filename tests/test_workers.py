"""Processes of a study: killed, stopped, left alone."""

import os
import random
import signal
import subprocess
import sys
import threading
import time

import pytest
from working import (
    asked_at_first,
    killed_at_first,
    killed_at_two,
    process_of,
    refused,
    slowly,
    squared,
    until_asked,
    wait_for_end,
)

from lola_drake import workers
from lola_drake.errors import LolaError
from lola_drake.workers import TRIES, Processes, WorkerLost, in_order, inline


def answers(crew, function, items):
    return {done.index: done.answer for done in crew(function, items)}


@pytest.mark.parametrize("crew", [inline, *map(Processes, (1, 2, 9))])
def test_every_item_is_answered_once(crew):
    done = list(crew(squared, [3, 1, 2]))
    assert sorted((one.index, one.answer) for one in done) == [(0, 9), (1, 1), (2, 4)]
    assert {one.tries for one in done} == {1}


def test_who_has_done_it_is_told():
    (done,) = inline(squared, [3])
    assert done.worker.startswith(f"{os.getpid()}@")
    workers = {done.worker for done in Processes(1)(squared, [1, 2, 3])}
    assert len(workers) == 1 and done.worker not in workers


def test_a_process_that_dies_again_and_again_takes_no_other_item_along():
    found = {done.index: done for done in Processes(2)(killed_at_two, [1, 2, 3, 4])}
    lost = found.pop(1)
    assert isinstance(lost.answer, WorkerLost) and lost.tries == TRIES
    assert str(lost.answer) == "its process was ended from outside, 3 times"
    assert {i: done.answer for i, done in found.items()} == {0: 1, 2: 3, 3: 4}


@pytest.mark.parametrize("jobs", [1, 2])
def test_answers_that_are_wanted_as_a_whole_come_in_the_order_of_their_items(jobs):
    heard = []
    found = in_order(jobs, squared, [3, 1, 2], lambda count, of: heard.append((count, of)))
    assert found == [9, 1, 4] and heard == [(1, 3), (2, 3), (3, 3)]


def test_a_whole_of_which_a_part_is_lost_is_none():
    with pytest.raises(WorkerLost):
        in_order(2, killed_at_two, [1, 2, 3])


@pytest.mark.parametrize("function", [killed_at_first, asked_at_first])
def test_a_process_that_is_ended_is_replaced_and_its_item_repeated(tmp_path, function):
    files = [str(tmp_path / name) for name in "abc"]
    found = list(Processes(2)(function, files))
    assert sorted(done.answer for done in found) == files
    assert {done.tries for done in found} == {2}


def test_processes_that_are_killed_now_and_then_lose_nothing(monkeypatch):
    made, begin = [], workers._Worker.__init__

    def noted(self):
        begin(self)
        made.append(self._process)

    monkeypatch.setattr(workers._Worker, "__init__", noted)
    chance, found = random.Random(1), {}
    for done in Processes(2)(slowly, list(range(30))):
        found[done.index] = done.answer
        if len(found) % 5 == 0:
            chance.choice(made[-2:]).kill()
    assert found == {k: k for k in range(30)}
    assert len(made) > 4
    assert all(process.poll() is not None for process in made)


def test_an_error_is_that_of_the_function():
    with pytest.raises(LolaError, match="no such thing"):
        list(Processes(2)(refused, [1, 2]))


def test_after_an_interruption_what_is_under_way_is_given(tmp_path):
    files = [tmp_path / name for name in "abc"]

    def interrupt():
        while not (files[0].exists() and files[1].exists()):
            time.sleep(0.01)
        os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=interrupt).start()
    found = {}
    with pytest.raises(KeyboardInterrupt):
        for done in Processes(2)(until_asked, files):
            found[done.index] = done.answer
    assert found == {0: files[0], 1: files[1]}
    assert not files[2].exists()


def test_a_process_ends_with_the_one_that_started_it(tmp_path):
    code = (
        "import os, signal, threading, time, working\n"
        "from lola_drake import workers\n"
        "made = []\n"
        "first = workers._Worker.__init__\n"
        "def noted(self):\n"
        "    first(self)\n"
        "    print(self._process.pid, flush=True)\n"
        "workers._Worker.__init__ = noted\n"
        "threading.Timer(1.0, lambda: os.kill(os.getpid(), signal.SIGKILL)).start()\n"
        "list(workers.Processes(2)(working.until_asked, ['a', 'b']))\n"
    )
    run = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
    )
    assert run.returncode == -signal.SIGKILL
    for pid in map(int, run.stdout.split()):
        wait_for_end(pid)


def test_a_process_makes_room_for_another_before_it_grows(monkeypatch):
    monkeypatch.setattr("lola_drake.workers.RUNS", 3)
    pids = list(answers(Processes(2), process_of, range(12)).values())
    assert os.getpid() not in pids
    assert max(pids.count(pid) for pid in pids) <= 3
