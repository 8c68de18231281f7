"""The plant: the ground's stiffness, the pads, the start, and when the robot has fallen."""

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import AddMultibodyPlant, ContactModel, MultibodyPlantConfig
from pydrake.multibody.tree import JointIndex
from pydrake.systems.framework import DiagramBuilder
from scipy.spatial.transform import Rotation

from lola_drake.ground import Ground
from lola_drake.obstacles import Obstacle
from lola_drake.paths import models_dir
from lola_drake.plant import (
    FALLEN,
    MESH_SHARE,
    PAD_FRICTION,
    add_ground,
    add_plant,
    has_fallen,
    pad_geometries,
    pad_joints,
    plant_truth,
    set_start,
)
from lola_drake.robot import PADS, add_lola, posture
from lola_drake.signals import FEET, JOINTS, PERIOD
from lola_drake.walk import StartPose

STIFFNESS = 2e5
THIN = Obstacle(name="thin", size=(2.0, 2.0), height=0.02)
HIGH = Obstacle(name="high", size=(2.0, 1.6), height=0.15)
TURNED = Obstacle(name="turned", position=(1.0, 0.5), heading_deg=90.0, size=(0.4, 1.0))


@pytest.fixture(scope="module")
def built():
    """Return the plant and its scene graph, on a floor with a board."""
    builder = DiagramBuilder()
    plant, scene_graph = add_plant(builder, Ground(obstacles=(TURNED,)))
    plant.Finalize()
    diagram = builder.Build()
    yield plant, scene_graph
    del diagram


@pytest.fixture(scope="module")
def plant(built):
    return built[0]


class Standing:
    """LOLA with level feet on a ground, at rest and in continuous time: only springs push."""

    def __init__(self, *obstacles):
        builder = DiagramBuilder()
        config = MultibodyPlantConfig(time_step=0.0, contact_model="hydroelastic")
        self.plant, _ = AddMultibodyPlant(config, builder)
        add_lola(self.plant)
        add_ground(self.plant, Ground(stiffness=STIFFNESS, obstacles=obstacles))
        self.plant.Finalize()
        self.diagram = builder.Build()
        self.root = self.diagram.CreateDefaultContext()
        self.context = self.plant.GetMyMutableContextFromRoot(self.root)
        self.surface = max((obstacle.height for obstacle in obstacles), default=0.0)
        self.place(0.0)
        tcp = self.plant.GetFrameByName("tcp_l").CalcPoseInWorld(self.context)
        self.sole = tcp.translation()[2]

    def place(self, torso_height):
        q = np.r_[1.0, 0.0, 0.0, 0.0, 0.0, 0.0, torso_height, posture(0.4, 0.8)]
        self.plant.SetPositions(self.context, q)

    def force(self, depth):
        """Return the ground's vertical force with both soles this deep in it (N)."""
        self.place(self.surface - depth - self.sole)
        results = self.plant.get_contact_results_output_port().Eval(self.context)
        infos = [
            results.hydroelastic_contact_info(i) for i in range(results.num_hydroelastic_contacts())
        ]
        return sum(abs(info.F_Ac_W().translational()[2]) for info in infos)


@pytest.mark.parametrize("obstacles", [(), (THIN,), (HIGH,)], ids=["floor", "thin", "high"])
def test_ground_is_as_stiff_as_it_is_said_to_be(obstacles):
    standing = Standing(*obstacles)
    forces = [standing.force(depth) for depth in (0.001, 0.002, 0.003)]
    # Two feet of four pads each, every one of them with the area stiffness c_A,z = E/d.
    assert np.diff(forces) / 0.001 == pytest.approx([2 * STIFFNESS] * 2, rel=0.01)
    assert forces[0] == pytest.approx(2 * STIFFNESS * 0.001, rel=0.01)


def test_a_soft_mat_is_a_field_of_springs_until_the_floor():
    mat = Obstacle("mat", size=(2.0, 2.0), height=0.05, relative_stiffness=0.1)
    standing = Standing(mat)
    forces = [standing.force(depth) for depth in (0.01, 0.03, 0.049)]
    assert forces == pytest.approx([2 * 0.1 * STIFFNESS * d for d in (0.01, 0.03, 0.049)], rel=0.01)


@pytest.mark.parametrize(("pitch", "roll"), [(-8.0, 0.0), (8.0, 0.0), (0.0, 8.0), (6.0, -6.0)])
def test_a_slope_pushes_along_its_normal_and_is_as_stiff(pitch, roll):
    slope = Obstacle("s", size=(4.0, 4.0), height=0.6, pitch_deg=pitch, roll_deg=roll)
    standing, normal = Standing(slope), np.array(slope.normal)
    plant, context = standing.plant, standing.context
    inclined = RigidTransform(RollPitchYaw(*np.radians([roll, pitch, 0.0])), [0.0, 0.0, 0.6])
    force = np.zeros(3)
    above = RigidTransform([0.0, 0.0, -0.002 - standing.sole])
    torso = plant.GetBodyByName("torso")
    plant.SetFloatingBaseBodyPoseInWorldFrame(context, torso, inclined @ above)
    results = plant.get_contact_results_output_port().Eval(context)
    for i in range(results.num_hydroelastic_contacts()):
        pushed = results.hydroelastic_contact_info(i).F_Ac_W().translational()
        force += pushed * np.sign(pushed[2])
    assert force @ normal == pytest.approx(2 * STIFFNESS * 0.002, rel=0.01)
    assert np.linalg.norm(np.cross(force, normal)) < 0.01 * (force @ normal)


def test_pads_have_the_friction_that_the_ground_is_said_to_have():
    builder = DiagramBuilder()
    ice = Obstacle("ice", (2.0, 0.0), relative_friction=0.2)
    plant, scene_graph = add_plant(builder, Ground(friction=0.6, obstacles=(ice,)))
    inspector = scene_graph.model_inspector()

    def own(geometry):
        properties = inspector.GetProximityProperties(geometry)
        return properties.GetProperty("material", "coulomb_friction").static_friction()

    world = plant.GetCollisionGeometriesForBody(plant.world_body())
    pad = own(plant.GetCollisionGeometriesForBody(plant.GetBodyByName("pad_rear_left_l"))[0])
    assert pad == PAD_FRICTION
    expected = {"floor": 0.6, "ice": 0.12}
    found = {inspector.GetName(g).split("::")[-1]: 2 * pad * own(g) / (pad + own(g)) for g in world}
    assert found == pytest.approx(expected)


def test_pad_mesh_is_the_two_gauss_points_of_a_pad():
    lines = (models_dir() / "lola" / "meshes" / "pad.obj").read_text().splitlines()
    vertices = np.array([line.split()[1:] for line in lines if line.startswith("v ")], float)
    faces = np.array([line.split()[1:] for line in lines if line.startswith("f ")], int) - 1
    corners = vertices[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
    pad = PADS[0]
    expected = [[0, 0, -MESH_SHARE * pad.area / 2]] * 2  # facing down
    np.testing.assert_allclose(normals, expected, rtol=1e-7)
    gauss = pad.length / 2 / np.sqrt(3)
    np.testing.assert_allclose(corners.mean(axis=1), [[-gauss, 0, 0], [gauss, 0, 0]], atol=1e-9)
    assert [pad.length, pad.width, 0] == pytest.approx(np.ptp(vertices, axis=0))


def test_lifted_feet_feel_no_ground():
    assert Standing(THIN).force(-0.001) == 0.0


def test_only_the_torso_floats(plant):
    floating = [plant.get_body(i).name() for i in plant.GetFloatingBaseBodies()]
    assert floating == ["torso"]


def test_nothing_is_welded_to_the_world(plant):
    world = plant.GetBodiesWeldedTo(plant.world_body())
    assert [body.name() for body in world] == [plant.world_body().name()]
    assert plant.num_velocities() == 6 + len(JOINTS)


def test_contact_is_hydroelastic_in_discrete_time(plant):
    assert plant.get_contact_model() == ContactModel.kHydroelastic
    assert plant.time_step() == PERIOD


def test_every_pad_has_a_switch_of_its_own(built):
    pads = pad_geometries(built[0])
    assert len(pads) == 8
    assert sorted(pads.values()) == list(range(8))


def test_all_collisions_of_the_feet_are_pads(built):
    plant, _ = built
    pads = pad_geometries(built[0])
    bodies = plant.GetBodyIndices(plant.GetModelInstanceByName("lola"))
    found = {
        geometry.get_value()
        for body in bodies
        for geometry in plant.GetCollisionGeometriesForBody(plant.get_body(body))
    }
    assert found == set(pads)


def test_switches_are_ordered_as_the_pads(built):
    plant, _ = built
    for switch, joint in enumerate(pad_joints(plant)):
        weld = plant.get_joint(JointIndex(joint))
        _, y, _ = weld.frame_on_parent().GetFixedPoseInBodyFrame().translation()
        link = weld.parent_body().name()
        assert link == ("foot_l", "zfl", "foot_r", "zfr")[switch // 2]
        assert (switch % 2 == 0) == (y > 0)


def test_height_of_the_bare_floor_is_zero():
    assert Ground().height_at(0.3, -5.0) == 0.0


@pytest.mark.parametrize(
    ("place", "height"),
    [((1.0, 0.5), 0.04), ((1.45, 0.5), 0.04), ((1.0, 0.75), 0.0), ((1.55, 0.5), 0.0)],
)
def test_height_on_a_turned_board(place, height):
    assert Ground(obstacles=(TURNED,)).height_at(*place) == height


def test_higher_board_counts():
    assert Ground(obstacles=(HIGH, THIN)).height_at(0.0, 0.0) == HIGH.height
    assert Ground(obstacles=(HIGH, THIN)).height_at(0.0, 0.9) == THIN.height


def test_robot_starts_where_it_is_told():
    builder = DiagramBuilder()
    ground = Ground(obstacles=(TURNED,))
    plant, _ = add_plant(builder, ground)
    plant.Finalize()
    q = posture(0.4, 0.8)
    set_start(plant, StartPose(x=1.0, y=0.5, heading_deg=90.0), ground, q, np.array([0.1, 0, 0.9]))
    positions = plant.GetPositions(plant.CreateDefaultContext())
    assert positions[4:7] == pytest.approx([1.0, 0.6, 0.94])
    assert positions[:4] == pytest.approx([np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)])
    assert positions[7:] == pytest.approx(q)


def torso_at(height, rotation):
    x, y, z, w = rotation.as_quat()
    return np.r_[w, x, y, z, 0.0, 0.0, height, np.zeros(len(JOINTS))]


@pytest.mark.parametrize("direction", [0.0, 1.0, 2.0, 4.0])
@pytest.mark.parametrize(("degrees", "fallen"), [(0, False), (44, False), (46, True), (170, True)])
def test_inclined_robot_has_fallen(direction, degrees, fallen):
    axis = np.array([np.cos(direction), np.sin(direction), 0.0])
    inclined = Rotation.from_rotvec(np.deg2rad(degrees) * axis)
    turned = inclined * Rotation.from_rotvec([0.0, 0.0, 2.5])
    assert has_fallen(torso_at(1.0, turned)) is fallen


def test_low_robot_has_fallen():
    height, _ = FALLEN
    upright = Rotation.identity()
    assert has_fallen(torso_at(height - 0.01, upright))
    assert not has_fallen(torso_at(height + 0.01, upright))


def test_truth_of_a_state_is_its_poses_and_joints(plant):
    rotation = Rotation.from_euler("ZYX", [0.4, -0.2, 0.1])
    q = torso_at(0.9, rotation)
    q[7:] = posture(0.4, 0.8)
    v = np.arange(plant.num_velocities())
    truth = plant_truth(plant, np.array([np.r_[q, v]]))
    assert truth["torso_pose"][0] == pytest.approx([0.0, 0.0, 0.9, 0.1, -0.2, 0.4])
    assert truth["joint_position"][0] == pytest.approx(q[7:])
    assert truth["joint_velocity"][0] == pytest.approx(v[6:])
    for foot in FEET:
        # The feet are level in the torso.
        assert truth[f"foot_pose_{foot}"][0, 3:] == pytest.approx([0.1, -0.2, 0.4])


def test_true_com_is_over_the_feet_of_a_standing_robot(plant):
    q = torso_at(0.9, Rotation.identity())
    q[7:] = posture(0.4, 0.8)
    truth = plant_truth(plant, np.array([np.r_[q, np.zeros(plant.num_velocities())]]))
    middle = (truth["foot_pose_l"] + truth["foot_pose_r"])[0, :3] / 2
    com = truth["com_position"][0]
    assert com[:2] == pytest.approx(middle[:2], abs=0.05)
    assert com[2] - middle[2] == pytest.approx(0.88, abs=0.03)
