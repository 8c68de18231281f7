"""What one tick costs, in counts instead of time: laws, port readings, contact polygons.

The counts are upper bounds: they may shrink, and whoever lets them grow should know it.
"""

import functools
import importlib
import inspect
import pkgutil
from collections import Counter

import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import InputPort, OutputPort

from lola_drake import blocks
from lola_drake.block import Block
from lola_drake.robot import Kinematics
from lola_drake.scenario import load_scenario
from lola_drake.simulation import ENGINES, start
from lola_drake.theory import kinematics, step_plan
from lola_drake.world import build_simulation

TICKS = 50
"""In the middle of a swing: no step is planned, and one foot is on the ground."""

LAWS = {
    "WalkingPattern": 1,
    "ImuStabilizer": 1,
    "ForceDistribution": 2,
    "HybridForceControl": 12,
    "ComDynamics": 2,
    "InverseKinematics": 2,
    "JointServos": 3,
    "Imu": 2,
    "FootForceSensor": 1,
    "ContactSwitches": 2,
}
"""Laws per tick, of both feet where a block exists once per foot: none is asked for twice."""

OBJECTS = {"diagram": {"FootForceSensor": 1, "ContactSwitches": 2}}
OBJECTS["fused"] = {"FootForceSensor": 1, "ContactSwitches": 1}
"""How often a block looks into an object of Drake's per tick."""

PORT_READINGS = {"diagram": 80, "fused": 5}
POLYGONS_PER_PAD = 2

EVERY_ENGINE = pytest.mark.parametrize("engine", ENGINES)


def block_classes():
    """Return all blocks."""
    for found in pkgutil.iter_modules(blocks.__path__):
        module = importlib.import_module(f"{blocks.__name__}.{found.name}")
        for cls in vars(module).values():
            own = inspect.isclass(cls) and cls.__module__ == module.__name__
            if own and issubclass(cls, Block):
                yield cls


@pytest.fixture(scope="module")
def counts():
    """Return how often each thing happened in one tick of walking, on average, by engine."""
    counted = Counter()

    def counting(name, function):
        @functools.wraps(function)
        def call(*args, **kwargs):
            counted[name] += 1
            return function(*args, **kwargs)

        return call

    def count(engine):
        overrides = {"walk.start_time": 0.0, "pattern.first_double_support": 0.3, "duration": 2.0}
        run = start(load_scenario("walk_flat", overrides), engine=engine)
        run.advance(0.5)
        counted.clear()
        run.advance(0.5 + 0.001 * TICKS)
        return {name: number / TICKS for name, number in counted.items()}

    with pytest.MonkeyPatch.context() as patch:
        # Laws in machine code cannot be counted; they are the same, in the same order.
        patch.setenv("LOLA_COMPILE", "0")
        for cls in block_classes():
            for name, function in cls.laws.items():
                patch.setitem(cls.laws, name, counting(cls.__name__, function))
            for name, function in inspect.getmembers(cls, inspect.isfunction):
                if name == "next_state":
                    patch.setattr(cls, name, counting(cls.__name__, function))
                if name.startswith("read_"):
                    patch.setattr(cls, name, counting(f"objects of {cls.__name__}", function))
        for port in (InputPort, OutputPort):
            patch.setattr(port, "Eval", counting("port readings", port.Eval))
        patch.setattr(Kinematics, "update", counting("kinematics", Kinematics.update))
        poses = counting("kinematics", kinematics.body_poses)
        patch.setattr(kinematics, "body_poses", poses)
        patch.setattr(
            "lola_drake.blocks.walking_pattern.plan_step", counting("plans", step_plan.plan_step)
        )
        return {engine: count(engine) for engine in ENGINES}


@EVERY_ENGINE
@pytest.mark.parametrize("block", LAWS)
def test_laws_of_a_block(counts, engine, block):
    assert counts[engine][block] <= LAWS[block]


@EVERY_ENGINE
def test_every_block_is_counted(counts, engine):
    measured = {"port readings", "kinematics", "plans"}
    measured |= {f"objects of {block}" for block in OBJECTS[engine]}
    assert set(counts[engine]) - measured == set(LAWS)


@EVERY_ENGINE
def test_objects_of_drake(counts, engine):
    for block, most in OBJECTS[engine].items():
        assert counts[engine][f"objects of {block}"] <= most


@EVERY_ENGINE
def test_port_readings(counts, engine):
    assert counts[engine]["port readings"] <= PORT_READINGS[engine]


@EVERY_ENGINE
def test_kinematics_are_computed_once(counts, engine):
    assert counts[engine]["kinematics"] <= 1


@EVERY_ENGINE
def test_within_a_step_nothing_is_planned(counts, engine):
    assert counts[engine].get("plans", 0) == 0


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
