"""Long runs and many runs: what the benchmark reports of them."""

import pytest

from lola_drake.benchmarks import bench_scaling as module
from lola_drake.benchmarks.bench_scaling import bench_scaling
from lola_drake.benchmarks.bench_tables import scaling_table
from lola_drake.scenario import load_scenario


@pytest.fixture(scope="module")
def content():
    """Return the result for runs that stand and are short."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "steady_walk", lambda repeats: (load_scenario("stand"), 0.05, 0.1))
        patch.setattr(module, "SHORT", 1.0)
        patch.setattr(module, "LONG", 2.0)
        return bench_scaling(repeats=1)


def test_result_has_the_promised_names(content):
    assert set(content) == {"cost_60_s_over_10_s", "memory_mb", "two_processes_over_one"}
    assert all(ratio > 0 for ratio in content["two_processes_over_one"].values())
    assert all(ratio > 0 for ratio in content["cost_60_s_over_10_s"].values())


def test_memory_is_that_of_a_process_of_its_own(content):
    assert list(content["memory_mb"]) == ["after_1_s", "after_2_s"]
    assert all(50 < memory < 1000 for memory in content["memory_mb"].values())


def test_table_shows_everything(content):
    rows = list(scaling_table(content).columns[0].cells)
    assert rows[:2] == ["a stride after 60 s / after 10 s", "two processes / one"]


def test_a_process_that_dies_is_an_error():
    with pytest.raises(EOFError), module._process(module._memory_mb, None, (1.0,)) as pipe:
        pipe.recv()
