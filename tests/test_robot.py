"""The robot's model and the controller's kinematics."""

import numpy as np
import pytest
from mirror import MIRRORED_JOINTS, mirror_signs
from one_foot import foot_angles
from pydrake.multibody.plant import MultibodyPlant

from lola_drake.paths import models_dir
from lola_drake.robot import (
    JOINT_INDEX,
    PADS,
    Kinematics,
    add_lola,
    foot_sensor_geometry,
    posture,
    solve_posture,
)
from lola_drake.signals import FEET, JOINTS
from lola_drake.theory.constants import GRAVITY
from lola_drake.theory.kinematics import FOOT_TASK

H = 1e-6
TASK_MIRROR = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0])


@pytest.fixture(scope="module")
def kinematics():
    return Kinematics()


@pytest.fixture(scope="module")
def plant(kinematics):
    return kinematics.plant


@pytest.fixture
def zero_pose(plant):
    """Return a context in which the torso is upright at the origin and all joints are at zero."""
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, np.r_[1.0, np.zeros(plant.num_positions() - 1)])
    return context


def some_postures(count=5):
    """Return bent postures, all joints turned a little at random."""
    random = np.random.default_rng(3)
    return [posture(0.4, 0.8) + random.uniform(-0.15, 0.15, len(JOINTS)) for _ in range(count)]


POSTURES = pytest.mark.parametrize("q", some_postures())


def w_at(kinematics, q):
    kinematics.update(q)
    return kinematics.w.copy()


def test_joints_are_named_and_ordered_as_in_the_signals(plant):
    joints = [plant.get_joint(i) for i in plant.GetJointIndices()]
    driven = sorted(
        (j for j in joints if j.num_velocities() == 1), key=lambda j: j.velocity_start()
    )
    assert tuple(joint.name() for joint in driven) == JOINTS


def test_actuators_are_ordered_as_the_joints(plant):
    actuators = [plant.get_joint_actuator(i) for i in plant.GetJointActuatorIndices()]
    assert tuple(actuator.joint().name() for actuator in actuators) == JOINTS


def test_joint_index_finds_every_joint():
    assert [JOINTS[JOINT_INDEX[name]] for name in JOINTS] == list(JOINTS)


def test_all_drives_have_a_gear_and_a_rotor(plant):
    actuators = [plant.get_joint_actuator(i) for i in plant.GetJointActuatorIndices()]
    assert min(actuator.default_gear_ratio() for actuator in actuators) > 1
    assert min(actuator.default_rotor_inertia() for actuator in actuators) > 0


def test_limits_are_finite_and_the_zero_pose_is_within(kinematics):
    lower, upper = kinematics.position_limits
    assert lower.shape == upper.shape == (len(JOINTS),)
    assert np.isfinite(lower).all() and np.isfinite(upper).all()
    assert (lower < 0).all() and (upper > 0).all()


def test_limits_are_those_of_the_joints(kinematics, plant):
    lower, upper = kinematics.position_limits
    for i, name in enumerate(JOINTS):
        joint = plant.GetJointByName(name)
        assert (lower[i], upper[i]) == (joint.position_lower_limit(), joint.position_upper_limit())
        assert kinematics.velocity_limits[i] == joint.velocity_upper_limit()
        assert kinematics.effort_limits[i] == plant.GetJointActuatorByName(name).effort_limit()


def test_walking_posture_keeps_the_limits(kinematics):
    lower, upper = kinematics.position_limits
    q = posture(0.4, 0.8)
    assert (lower < q).all() and (q < upper).all()


def test_left_and_right_drives_are_equally_strong(kinematics):
    mirror = MIRRORED_JOINTS
    assert np.array_equal(kinematics.effort_limits, kinematics.effort_limits[mirror])
    assert np.array_equal(kinematics.velocity_limits, kinematics.velocity_limits[mirror])


def test_robot_weighs_60_kg(kinematics):
    assert kinematics.mass == pytest.approx(60.0, abs=1e-9)


def test_robot_is_180_cm_tall(plant, zero_pose):
    mesh = (models_dir() / "lola" / "meshes" / "head.obj").read_text().splitlines()
    vertices = np.array([line.split()[1:4] for line in mesh if line.startswith("v ")], dtype=float)
    head = plant.GetFrameByName("vt").CalcPoseInWorld(zero_pose) @ vertices.T
    sole = plant.GetFrameByName("tcp_l").CalcPoseInWorld(zero_pose).translation()
    assert head[2].max() - sole[2] == pytest.approx(1.80, abs=0.01)


@pytest.mark.parametrize("foot", FEET)
def test_tcp_is_on_the_sole_level_and_before_the_ankle(plant, zero_pose, foot):
    tcp = plant.GetFrameByName(f"tcp_{foot}").CalcPoseInWorld(zero_pose)
    ankle = plant.GetBodyByName(f"sf{foot}").EvalPoseInWorld(zero_pose).translation()
    assert tcp.rotation().matrix() == pytest.approx(np.eye(3))
    assert tcp.translation() - ankle == pytest.approx([0.04, 0.0, -0.1])


def test_tcp_is_the_centroid_of_the_pads():
    assert np.mean([[pad.x, pad.y] for pad in PADS], axis=0) == pytest.approx([0.0, 0.0])


@pytest.mark.parametrize("foot", [0, 1])
def test_pads_are_where_they_are_said_to_be(kinematics, foot):
    kinematics.update(posture(0.4, 0.8))
    points, _ = kinematics.pads(foot)
    tcp = kinematics.w[FOOT_TASK * foot :][:2]
    assert points - tcp == pytest.approx(np.array([[pad.x, pad.y] for pad in PADS]), abs=1e-9)


@POSTURES
@pytest.mark.parametrize("foot", [0, 1])
def test_pads_heights_change_as_their_rates_say(kinematics, plant, zero_pose, q, foot):
    tcp = plant.GetFrameByName(f"tcp_{FEET[foot]}")
    links = [plant.GetFrameByName(f"{link}{FEET[foot]}") for link in ("foot_", "zf")]
    centres = np.array([[pad.x, pad.y, 0.0] for pad in PADS]).T
    pads = [
        (link, plant.CalcPointsPositions(zero_pose, tcp, p_TcpPads, link))
        for link, p_TcpPads in zip(links, np.hsplit(centres, 2), strict=True)
    ]

    def heights(q):
        # Of the pads' centres over the CoM, from the model itself.
        kinematics.update(q)
        heights, context = [], kinematics.context
        for frame, p_BPads in pads:
            p_WPads = plant.CalcPointsPositions(context, frame, p_BPads, plant.world_frame())
            heights += list(p_WPads[2])
        return np.array(heights) - plant.CalcCenterOfMassPositionInWorld(context)[2]

    differences = [(heights(q + e) - heights(q - e)) / (2 * H) for e in H * np.eye(len(JOINTS))]
    kinematics.update(q)
    _, rates = kinematics.pads(foot)
    assert rates == pytest.approx(np.array(differences).T, abs=1e-6)


@POSTURES
def test_jacobian_is_the_derivative_of_w(kinematics, q):
    differences = [
        (w_at(kinematics, q + e) - w_at(kinematics, q - e)) / (2 * H)
        for e in H * np.eye(len(JOINTS))
    ]
    kinematics.update(q)
    assert kinematics.jacobian == pytest.approx(np.array(differences).T, abs=1e-6)


@pytest.mark.parametrize(("hip", "knee"), [(0.0, 0.0), (0.4, 0.8), (0.3, 0.9)])
def test_posture_has_level_feet_side_by_side(kinematics, hip, knee):
    left, right = np.split(w_at(kinematics, posture(hip, knee)), 2)
    assert left[3:] == pytest.approx(np.zeros(3), abs=1e-12)
    assert left == pytest.approx(right * TASK_MIRROR, abs=1e-12)


def test_solved_posture_has_the_feet_where_they_are_wanted(kinematics):
    q = posture(0.4, 0.8)
    w = w_at(kinematics, q)
    w[[0, 2, FOOT_TASK]] += [0.1, 0.04, -0.1]
    w[[3, 5]] += [0.05, 0.1]
    assert w_at(kinematics, solve_posture(kinematics, w, q)) == pytest.approx(w, abs=1e-9)


def test_solving_leaves_the_start_alone(kinematics):
    q = posture(0.4, 0.8)
    kept = q.copy()
    solve_posture(kinematics, w_at(kinematics, q) + [0.01, *np.zeros(11)], q)
    assert np.array_equal(q, kept)


def test_posture_that_fits_is_not_changed(kinematics):
    q = some_postures()[0]
    assert np.array_equal(solve_posture(kinematics, w_at(kinematics, q), q), q)


def test_foot_out_of_reach_is_an_error(kinematics):
    w = w_at(kinematics, posture(0.4, 0.8))
    w[2] -= 0.5
    with pytest.raises(ValueError, match="no posture reaches"):
        solve_posture(kinematics, w, posture(0.4, 0.8))


def test_mirroring_the_joints_twice_changes_nothing():
    assert [MIRRORED_JOINTS[i] for i in MIRRORED_JOINTS] == list(range(len(JOINTS)))


def test_left_and_right_are_mirrored_and_the_middle_is_kept():
    names = {name: JOINTS[MIRRORED_JOINTS[i]] for i, name in enumerate(JOINTS)}
    assert names["thfr"] == "thfl" and names["tefl"] == "tefr"
    assert [name for name, other in names.items() if name == other] == ["tbr", "tba", "tvp", "tvt"]


def test_mirrored_joints_have_mirrored_axes(plant):
    assert np.abs(mirror_signs(plant)) == pytest.approx(1.0)


@POSTURES
def test_mirrored_posture_has_mirrored_feet(kinematics, plant, q):
    mirrored = (mirror_signs(plant) * q)[MIRRORED_JOINTS]
    left, right = np.split(w_at(kinematics, q), 2)
    expected = np.r_[right * TASK_MIRROR, left * TASK_MIRROR]
    assert w_at(kinematics, mirrored) == pytest.approx(expected, abs=1e-12)


@POSTURES
def test_w_is_the_tcp_relative_to_the_com_and_the_foots_angles(kinematics, q):
    left, right = np.split(w_at(kinematics, q), 2)
    com, _ = kinematics.centroidal_inertia(q)
    context = kinematics.context
    for foot, w in zip(FEET, (left, right), strict=True):
        tcp = kinematics.plant.GetFrameByName(f"tcp_{foot}").CalcPoseInWorld(context)
        assert w[:3] == pytest.approx(tcp.translation() - com, abs=1e-12)
        assert w[3:] == pytest.approx(foot_angles(tcp.rotation().matrix()), abs=1e-12)


@POSTURES
def test_centroidal_inertia_is_that_of_a_body(kinematics, q):
    _, inertia = kinematics.centroidal_inertia(q)
    moments = np.linalg.eigvalsh(inertia)
    assert inertia == pytest.approx(inertia.T)
    assert moments[0] > 0 and moments[2] < moments[0] + moments[1]


def test_weight_below_the_sensor_is_that_of_foot_and_toe(kinematics, plant):
    _, weight, _ = foot_sensor_geometry(kinematics)
    mass = sum(plant.GetBodyByName(name).default_mass() for name in ("foot_l", "zfl"))
    assert weight == pytest.approx(mass * GRAVITY)


def test_sensor_is_above_the_weight_it_carries(kinematics):
    (x, y, z), _, com = foot_sensor_geometry(kinematics)
    assert (x, y, z) == pytest.approx((-0.04, 0.0, 0.055))
    assert 0 < com[2] < z


def test_robot_can_be_added_to_any_plant():
    plant = MultibodyPlant(time_step=0.001)
    instance = add_lola(plant)
    plant.Finalize()
    assert plant.num_velocities(instance) == 6 + len(JOINTS)
