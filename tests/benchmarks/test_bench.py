"""The benchmark: what it reports, and that it compares like with like."""

import numpy as np
import pytest

from lola_drake.benchmarks import bench as module
from lola_drake.benchmarks.bench import bench, steady_walk
from lola_drake.benchmarks.bench_tables import bench_table
from lola_drake.block import law
from lola_drake.blocks.force_distribution import ForceDistribution
from lola_drake.signals import on_tick
from lola_drake.simulation import ENGINES, start

BLOCKS = {
    "drive_guard",
    "walking_pattern",
    "imu_stabilizer",
    "force_distribution",
    "force_control_l",
    "force_control_r",
    "com_dynamics_l",
    "com_dynamics_r",
    "inverse_kinematics",
    "joint_servos",
    "imu",
    "foot_force_sensor",
    "contact_switches",
}


@pytest.fixture(scope="module")
def content():
    """Return the result of a benchmark of one stride; it fails if the plants walk differently."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "_import_times", lambda: [1.0, 2.0, 4.0])
        return bench(repeats=1)


def test_result_has_the_promised_names(content):
    assert content["scenario"] == "walk_flat"
    assert {"closed_loop_over_plant", "real_time_factor", "tick_us", "versions"} <= set(content)
    assert set(content["tick_us"]) == {
        "closed_loop",
        "plant",
        "plant_implicit",
        "own_part",
        "all_blocks",
        "blocks",
    }
    assert set(content["plan_ms"]) == {"new_plan", "phase_reset"}
    assert content["engine"] == "fused"
    assert set(content["tick_us"]["blocks"]) == BLOCKS
    assert content["import_s"] == {"min": 1.0, "median": 2.0}


def test_numbers_belong_together(content):
    tick = content["tick_us"]
    ratio = tick["closed_loop"]["median"] / tick["plant"]["median"]
    assert content["closed_loop_over_plant"]["median"] == pytest.approx(ratio)
    assert content["real_time_factor"]["median"] == pytest.approx(
        1e3 / tick["closed_loop"]["median"]
    )
    assert content["peak_memory_mb"] > 50


def test_table_shows_every_block(content):
    names = list(bench_table(content).columns[0].cells)
    assert {name.strip() for name in names} >= BLOCKS


def test_another_motion_of_the_bare_plant_is_an_error(monkeypatch):
    """A replay that is wrong in one tick must not pass for the same walk."""
    record = module.record_commands

    def wrong(scenario, end, engine):
        commands = record(scenario, end, engine)
        commands[len(commands) // 2, 0] += 1e-3
        return commands

    monkeypatch.setattr(module, "record_commands", wrong)
    monkeypatch.setattr(module, "_import_times", lambda: [1.0])
    monkeypatch.setattr(module, "block_times", lambda *_: {"none": 0.0})
    with pytest.raises(ArithmeticError, match="has not walked"):
        bench(repeats=1)


@pytest.mark.parametrize("engine", ENGINES)
def test_blocks_alone_leave_the_run_as_it_was(engine):
    run = start("stand", engine=engine)
    run.advance(0.01)
    state = run.context.get_discrete_state()
    before = np.concatenate([state.value(i) for i in range(state.num_groups())])
    times = module.block_times(run)
    after = np.concatenate([state.value(i) for i in range(state.num_groups())])
    np.testing.assert_array_equal(before, after)
    assert set(times) >= BLOCKS - {"drive_guard"} and min(times.values()) > 0


def test_a_block_alone_is_really_evaluated(monkeypatch):
    """Each timed call works anew; the law is plain Python here, so that it can be counted."""
    calls = []
    monkeypatch.setenv("LOLA_COMPILE", "0")

    class Counting(ForceDistribution):
        @law
        def next_filtered_wrench(filtered_wrench, desired_wrench, rate_filter):
            calls.append(1)
            return tuple(filtered_wrench)

    for engine in ENGINES:
        run = start("stand", {"force_distribution": Counting}, engine)
        run.advance(0.005)
        calls.clear()
        module.block_times(run)
        assert module.CALLS * module.BATCHES <= len(calls) <= module.CALLS * module.BATCHES + 2


def test_steady_walking_begins_on_a_tick():
    """A moment later the first tick would be over: nothing would move in the first one measured."""
    _, begin, _ = steady_walk(3)
    assert begin == on_tick(begin)
