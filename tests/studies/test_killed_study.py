"""A study that is killed at any moment and started again ends with the rows of an undisturbed one.

Whole processes are killed; the simulation in them is real, and short.
"""

import os
import random
import signal
import subprocess
import sys

import pytest
from working import wait_for_end

from lola_drake.scenario import load_scenario  # noqa: F401  # for SCENARIOS
from lola_drake.studies.store import Store
from lola_drake.studies.study import Study
from lola_drake.workers import inline

SCENARIOS = '[load_scenario("stand", {"seed": k, "duration": 0.3}) for k in range(6)]'

STUDY = f"""
import sys
from lola_drake.scenario import load_scenario
from lola_drake.studies.study import Study
from lola_drake.workers import Processes

study = Study(sys.argv[1], Processes(2))
study.run({SCENARIOS}, lambda done: print(done, flush=True))
"""


def begin(file):
    return subprocess.Popen(
        [sys.executable, "-c", STUDY, str(file)],
        stdout=subprocess.PIPE,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))},
    )


def rows(file):
    """Return what a run's numbers are, of each run, whoever has made it and how fast."""
    told = {"wall_time_s", "real_time_factor"}
    return {
        row.key: {name: value for name, value in row.summary.items() if name not in told}
        for row in Store(file, must_exist=True).rows()
    }


def children(process):
    """Return the processes that a process has started."""
    found = subprocess.run(["ps", "-o", "pid=", "--ppid", str(process.pid)], capture_output=True)
    return [int(pid) for pid in found.stdout.split()]


@pytest.mark.skipif(sys.platform != "linux", reason="asks for processes as Linux does")
def test_the_rows_are_those_of_an_undisturbed_study(tmp_path):
    chance, killed = random.Random(3), tmp_path / "killed.sqlite"
    for kind in (signal.SIGKILL, signal.SIGTERM):
        study = begin(killed)
        # Its first line tells what is there; some time after the next one it ends.
        for _ in range(2):
            study.stdout.readline()
        workers = children(study)
        with pytest.raises(subprocess.TimeoutExpired):
            study.wait(chance.uniform(0.0, 0.1))
        study.send_signal(kind)
        study.wait()
        for pid in workers:
            wait_for_end(pid)
    assert 0 < len(rows(killed)) < 6
    assert begin(killed).wait() == 0
    whole = tmp_path / "whole.sqlite"
    Study(whole, inline).run(eval(SCENARIOS))
    assert len(rows(whole)) == 6
    assert rows(killed) == rows(whole)


def test_two_studies_at_once_in_one_file_end_with_each_run_once(tmp_path):
    file = tmp_path / "runs.sqlite"
    studies = [begin(file), begin(file)]
    assert [study.wait() for study in studies] == [0, 0]
    assert len(rows(file)) == len(list(Store(file).rows())) == 6
