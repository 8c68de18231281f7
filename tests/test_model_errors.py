"""The robot with errors: what of the plant changes, and by how much."""

import numpy as np
import pytest
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import DiagramBuilder

from lola_drake.controller import initial_stance
from lola_drake.ground import Ground
from lola_drake.model_errors import LEGS, PAD_NAMES, ModelErrors
from lola_drake.plant import PAD_LINKS, add_plant, set_start
from lola_drake.robot import Kinematics, add_lola
from lola_drake.scenario import Scenario, load_scenario, override


def robot(**errors):
    plant = MultibodyPlant(0.0)
    add_lola(plant, ModelErrors(**errors))
    plant.Finalize()
    return plant


def part_of(body):
    return LEGS.get(body.name(), 0)


def test_masses_and_inertias_of_each_part_are_scaled():
    plain, other = robot(), robot(mass=(1.05, 0.9, 1.1), inertia=(1.0, 1.0, 1.2))
    for index in plain.GetBodyIndices(plain.GetModelInstanceByName("lola")):
        before, after = plain.get_body(index), other.get_body(index)
        if not before.default_mass():
            continue
        k = part_of(before)
        assert after.default_mass() == pytest.approx((1.05, 0.9, 1.1)[k] * before.default_mass())
        inertias = (
            body.default_spatial_inertia().Shift(body.default_com()).CalcRotationalInertia()
            for body in (before, after)
        )
        before_I, after_I = (inertia.CopyToFullMatrix3() for inertia in inertias)
        factor = (1.05, 0.9, 1.1)[k] * (1.0, 1.0, 1.2)[k]
        assert after_I == pytest.approx(factor * before_I, rel=1e-9, abs=1e-12)


def test_each_leg_is_a_third_of_the_robot_or_less_and_both_are_alike():
    plant = robot()
    masses = np.zeros(3)
    for index in plant.GetBodyIndices(plant.GetModelInstanceByName("lola")):
        masses[part_of(plant.get_body(index))] += plant.get_body(index).default_mass()
    assert masses[1] == pytest.approx(masses[2])
    assert 0.1 < masses[1] / masses.sum() < 0.34


def test_the_pads_are_in_the_order_of_the_switches():
    assert PAD_NAMES == PAD_LINKS


def test_a_pad_that_is_higher_or_lower_is_so_in_its_foot():
    plain, other = robot(), robot(pad_height=(0, 0, 0, 0, 0, -0.001, 0, 0))
    for name in PAD_NAMES:
        heights = [
            plant.CalcRelativeTransform(
                plant.CreateDefaultContext(),
                plant.GetFrameByName(f"foot_{name[-1]}"),
                plant.GetFrameByName(name),
            ).translation()[2]
            for plant in (plain, other)
        ]
        assert heights[1] - heights[0] == pytest.approx(-0.001 * (name == PAD_NAMES[5]))


def pad_forces(errors):
    """Return the vertical force of each pad (N), the feet 1 mm deeper than the robot stands."""
    builder = DiagramBuilder()
    plant, _ = add_plant(builder, Ground(), errors)
    plant.Finalize()
    scenario = load_scenario("stand")
    stance = initial_stance(scenario, Kinematics())
    set_start(plant, scenario.start, Ground(), stance.q, stance.p_PT - [0, 0, 0.001])
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    results = plant.get_contact_results_output_port().Eval(plant.GetMyContextFromRoot(context))
    inspector = plant.get_geometry_query_input_port()
    scene = inspector.Eval(plant.GetMyContextFromRoot(context)).inspector()
    forces = dict.fromkeys(PAD_NAMES, 0.0)
    for i in range(results.num_hydroelastic_contacts()):
        info = results.hydroelastic_contact_info(i)
        surface = info.contact_surface()
        names = [scene.GetName(scene.GetFrameId(g)) for g in (surface.id_M(), surface.id_N())]
        for name in names:
            if name.split("::")[-1] in forces:
                forces[name.split("::")[-1]] += abs(info.F_Ac_W().translational()[2])
    return np.array([forces[name] for name in PAD_NAMES])


def test_a_pad_that_is_stiffer_carries_more_at_the_same_depth():
    plain = pad_forces(ModelErrors())
    factors = (1.1, 0.9, 1.0, 1.2, 1.0, 1.0, 0.8, 1.0)
    assert plain.min() > 10.0
    # Not quite, since the step that tells the forces lets the feet move.
    found = pad_forces(ModelErrors(pad_stiffness=factors))
    assert found == pytest.approx(np.array(factors) * plain, rel=0.015)


def test_the_real_servos_are_not_what_the_controller_takes_them_for():
    scenario = override(Scenario(), {"model_errors.servo_gain": 0.9})
    gain = Scenario().control.servos.position_gain
    assert scenario.real_servos().position_gain == pytest.approx(0.9 * gain)
    assert scenario.control.servos.position_gain == gain
    assert scenario.real_servos().velocity_bandwidth == scenario.control.servos.velocity_bandwidth
