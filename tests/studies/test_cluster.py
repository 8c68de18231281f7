"""A Dask cluster on this machine: the same answers, also when its workers are killed."""

import os
import subprocess
import sys

import pytest
from working import killed_at_first, refused, squared

from lola_drake.errors import LolaError
from lola_drake.paths import models_dir
from lola_drake.scenario import _find
from lola_drake.studies.cluster import Cluster, ClusterError

distributed = pytest.importorskip("distributed")


def test_a_worker_that_is_killed_is_replaced_and_its_item_repeated(tmp_path):
    """Each of two workers dies at the first item that it meets."""
    files = [str(tmp_path / name) for name in "ab"]
    found = list(Cluster("local", 2)(killed_at_first, files))
    assert sorted((done.index, done.answer) for done in found) == list(enumerate(files))
    assert all("@" in done.worker for done in found)


def test_an_error_is_that_of_the_function():
    with pytest.raises(LolaError, match="no such thing"):
        list(Cluster("local", 1)(refused, [1, 2]))


@pytest.fixture
def address(tmp_path):
    """Start a scheduler and a worker that know nothing of this checkout; return the address."""
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    folders = {"cwd": tmp_path, "env": environment, **quiet}
    command = [sys.executable, "-m", "dask", "scheduler", "--no-dashboard", "--port", "0"]
    file = tmp_path / "scheduler.json"
    scheduler = subprocess.Popen([*command, "--scheduler-file", str(file)], **folders)
    command = [sys.executable, "-m", "dask", "worker", "--nthreads", "1", "--no-dashboard"]
    worker = subprocess.Popen([*command, "--scheduler-file", str(file)], **folders)
    with distributed.Client(scheduler_file=str(file), timeout=60) as client:
        yield client.scheduler.address
    for process in (worker, scheduler):
        process.terminate()
        process.wait()


def test_the_package_is_sent_along(address):
    (done,) = Cluster(address)(_find, ["stand"])
    assert done.answer.read_text() == (models_dir() / "scenarios" / "stand.yaml").read_text()
    assert "sent" in done.answer.parts


def test_a_cluster_that_is_not_there_is_said_before_anything_runs(monkeypatch):
    monkeypatch.setattr("lola_drake.studies.cluster.PATIENCE", 0.5)
    with pytest.raises(ClusterError, match=r"cluster tcp://127\.0\.0\.1:1: "):
        list(Cluster("tcp://127.0.0.1:1")(squared, [1]))
    with pytest.raises(ClusterError, match="cluster nonsense://x: "):
        list(Cluster("nonsense://x")(squared, [1]))


def test_without_dask_it_is_said_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(ClusterError, match=r"pip install 'lola_drake\[cluster\]'"):
        list(Cluster()(squared, [1]))
