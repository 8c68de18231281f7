"""What one tick costs, in counts instead of time: calculations, port readings, contact polygons.

The counts are upper bounds: they may shrink, and whoever lets them grow should know it.
"""

import importlib
import inspect
import pkgutil
from collections import Counter

import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import InputPort, LeafSystem, OutputPort

from lola_drake import blocks
from lola_drake.robot import Kinematics
from lola_drake.scenario import load_scenario
from lola_drake.theory import step_plan
from lola_drake.world import build_simulation

TICKS = 50
"""In the middle of a swing: no step is planned, and one foot is on the ground."""

CALCULATIONS = {
    "WalkingPattern": 1,
    "ImuStabilizer": 1,
    "ForceDistribution": 2,
    "HybridForceControl": 6,
    "ComDynamics": 2,
    "InverseKinematics": 2,
    "JointServos": 1,
    "Imu": 1,
    "FootForceSensor": 1,
    "ContactSwitches": 1,
}
"""Calls into Python per tick, of both feet where a block exists once per foot."""

PORT_READINGS = 60
POLYGONS_PER_PAD = 2


def block_classes():
    """Return all blocks, with the module of each."""
    for found in pkgutil.iter_modules(blocks.__path__):
        module = importlib.import_module(f"{blocks.__name__}.{found.name}")
        for cls in vars(module).values():
            own = inspect.isclass(cls) and cls.__module__ == module.__name__
            if own and issubclass(cls, LeafSystem):
                yield cls


@pytest.fixture(scope="module")
def counts():
    """Return how often each thing happened in one tick of walking, on average."""
    counted = Counter()

    def counting(name, function):
        def call(*args, **kwargs):
            counted[name] += 1
            return function(*args, **kwargs)

        return call

    with pytest.MonkeyPatch.context() as patch:
        for cls in block_classes():
            for name, function in inspect.getmembers(cls, inspect.isfunction):
                if name.startswith(("_calc", "_update")):
                    patch.setattr(cls, name, counting(cls.__name__, function))
        for port in (InputPort, OutputPort):
            patch.setattr(port, "Eval", counting("port readings", port.Eval))
        patch.setattr(Kinematics, "update", counting("kinematics", Kinematics.update))
        patch.setattr(
            "lola_drake.blocks.walking_pattern.plan_step", counting("plans", step_plan.plan_step)
        )
        overrides = {"walk.start_time": 0.0, "duration": 2.0}
        simulator = Simulator(build_simulation(load_scenario("walk_flat", overrides)))
        simulator.AdvanceTo(1.0)
        counted.clear()
        simulator.AdvanceTo(1.0 + 0.001 * TICKS)
    return {name: count / TICKS for name, count in counted.items()}


@pytest.mark.parametrize("block", CALCULATIONS)
def test_calculations_of_a_block(counts, block):
    assert counts[block] <= CALCULATIONS[block]


def test_every_block_is_counted(counts):
    measured = {"port readings", "kinematics", "plans"}
    assert set(counts) - measured == set(CALCULATIONS)


def test_port_readings(counts):
    assert counts["port readings"] <= PORT_READINGS


def test_kinematics_are_computed_once(counts):
    assert counts["kinematics"] <= 1


def test_within_a_step_nothing_is_planned(counts):
    assert counts.get("plans", 0) == 0


def test_contact_polygons_of_a_standing_robot():
    diagram = build_simulation(load_scenario("stand"))
    simulator = Simulator(diagram)
    simulator.AdvanceTo(0.1)
    plant = diagram.GetSubsystemByName("plant")
    context = plant.GetMyContextFromRoot(simulator.get_context())
    results = plant.get_contact_results_output_port().Eval(context)
    contacts = results.num_hydroelastic_contacts()
    faces = sum(
        results.hydroelastic_contact_info(i).contact_surface().num_faces() for i in range(contacts)
    )
    assert contacts == 8
    assert faces <= POLYGONS_PER_PAD * contacts
