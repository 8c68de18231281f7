"""The robot in MuJoCo in the place of Drake's plant: Newton, its ground, its servos, and a walk."""

import numpy as np
import pytest
from momentum import load, upper_momentum

mujoco = pytest.importorskip("mujoco")

from lola_drake.blocks.joint_servos import JointServosParams  # noqa: E402
from lola_drake.ground import Ground  # noqa: E402
from lola_drake.mujoco_model import (  # noqa: E402
    mujoco_model,
    to_drake,
    to_qpos,
    to_qvel,
)
from lola_drake.obstacles import Obstacle  # noqa: E402
from lola_drake.robot import PADS, Kinematics  # noqa: E402
from lola_drake.scenario import ScenarioError, load_scenario  # noqa: E402
from lola_drake.signals import PERIOD  # noqa: E402
from lola_drake.simulation import simulate, start  # noqa: E402
from lola_drake.theory.constants import GRAVITY  # noqa: E402
from lola_drake.theory.contact_model import contact_matrix  # noqa: E402
from lola_drake.world import build_simulation  # noqa: E402

WEIGHT = Kinematics().mass * GRAVITY


def mujoco_run(name, *changes):
    return start(load_scenario(name, ["plant=mujoco", "sensors.ideal=true", *changes]))


def step_of(run):
    """Return what the plant says of the step that begins now: all of it, and the reactions."""
    context = run.plant.GetMyContextFromRoot(run.context)
    return (
        run.plant.GetOutputPort("step").Eval(context),
        run.plant.get_reaction_forces_output_port().Eval(context),
    )


def test_positions_and_velocities_there_and_back():
    random = np.random.default_rng(0)
    q, v = random.standard_normal(31), random.standard_normal(30)
    q[:4] /= np.linalg.norm(q[:4])
    assert to_drake(to_qpos(q), to_qvel(q, v)) == pytest.approx(np.r_[q, v])


def test_standing_robot_sinks_as_deep_as_the_ground_is_stiff():
    for stiffness in (1e5, 3e5):
        run = mujoco_run("stand", f"ground.stiffness={stiffness}")
        run.advance(1.5)
        force = run.signal("ground_force")
        assert force[[2, 5]] == pytest.approx(WEIGHT / 2, rel=2e-3)
        kinematics = Kinematics().plant
        context = kinematics.CreateDefaultContext()
        kinematics.SetPositionsAndVelocities(context, run.plant_state)
        feet = [kinematics.GetFrameByName(f"tcp_{foot}") for foot in "lr"]
        heights = [f.CalcPoseInWorld(context).translation()[2] for f in feet]
        assert heights == pytest.approx([-WEIGHT / 2 / stiffness] * 2, rel=0.04)


@pytest.mark.parametrize(("roll", "pitch"), [(0.0, 0.0), (0.006, 0.0), (0.0, -0.006)])
def test_balls_under_a_foot_are_the_paper_s_field_of_springs(roll, pitch):
    """With the same stiffness each, their depths give U x, and no pad's own rotation is lost."""
    model = mujoco_run("stand").plant.model
    data, height = mujoco.MjData(model), -0.003
    data.qpos[3] = 1.0
    mujoco.mj_kinematics(model, data)
    foot = model.body("foot_l").id
    balls = [
        i
        for i in range(model.ngeom)
        if model.body_rootid[model.geom_bodyid[i]] and "_l_" in model.geom(i).name
    ]
    places = data.geom_xpos[balls] - data.xpos[foot] - [0.04, 0.0, -0.055 + 0.005]
    assert len(places) == 16 and np.abs(places[:, 2]).max() < 1e-9
    x, y = places[:, 0], places[:, 1]
    depth = -(height + y * roll - x * pitch)
    force = 3e5 / 16 * depth
    found = [(y * force).sum(), (-x * force).sum(), force.sum()]
    area = sum(pad.area for pad in PADS)
    expected = contact_matrix(PADS, 3e5 / area) @ [roll, pitch, height]
    assert found == pytest.approx(expected, rel=1e-9, abs=1e-9)


@pytest.fixture(scope="module")
def walking():
    """Return a run in the middle of a walk's first steps."""
    run = mujoco_run("walk_flat")
    run.advance(1.9)
    return run


def test_what_holds_soles_and_pads_are_newtons(walking):
    """The rate of momentum above the sensors is gravity and what they carry; of all, the pads."""
    robot, worst = Kinematics().plant, np.zeros(6)
    context = robot.CreateDefaultContext()
    joints = [robot.GetJointByName(f"fts_{foot}").index() for foot in "lr"]
    for k in range(60):
        step, reactions = step_of(walking)
        robot.SetPositionsAndVelocities(context, walking.plant_state)
        momentum, gravity = upper_momentum(robot, context)
        whole = robot.CalcSpatialMomentumInWorldAboutPoint(context, np.zeros(3)).translational()
        frames = {f: robot.GetFrameByName(f"foot_{f}").CalcPoseInWorld(context) for f in "lr"}
        read = [reactions[j] for j in joints]
        reading = np.concatenate([-np.r_[r.translational(), r.rotational()] for r in read])
        carried = sum(load(frames[f], reading, f) for f in "lr")
        walking.advance(walking.time + PERIOD)
        robot.SetPositionsAndVelocities(context, walking.plant_state)
        rate = (upper_momentum(robot, context)[0] - momentum) / PERIOD
        worst = np.maximum(worst, np.abs(rate - gravity - carried))
        after = robot.CalcSpatialMomentumInWorldAboutPoint(context, np.zeros(3)).translational()
        pads = walking.signal("ground_force").reshape(2, 3).sum(axis=0)
        total = (after - whole) / PERIOD + [0.0, 0.0, WEIGHT]
        assert np.abs(total - pads).max() < 2.0, k
    assert worst.max() < 2.0


def test_drives_obey_the_servos_law_at_the_end_of_the_step_and_their_limits():
    run = mujoco_run("stand")
    plant, context = run.plant, run.plant.GetMyContextFromRoot(run.context)
    q = run.plant_state[7:31]
    desired = q + 1e-3
    desired[5] += 1.0  # the left knee's servo is at its limit
    port = plant.GetInputPort("command")
    port.FixValue(context, np.r_[desired, np.full(24, 0.1), np.full(24, 2.0)])
    step, _ = step_of(run)
    torque = plant.get_net_actuation_output_port().Eval(context)
    after, rate = step[7:31], step[31 + 6 : 61]
    kp, kd = -plant.model.actuator_biasprm[:, 1:3].T
    law = kp * (desired - after) + kd * (0.1 - rate) + 2.0
    assert torque[5] == plant.torque_limit[5] < law[5]
    limited = np.clip(law, -plant.torque_limit, plant.torque_limit)
    assert torque == pytest.approx(limited, rel=1e-6, abs=1e-6)


def test_a_board_is_where_it_is_in_drake():
    board = "{name: b, position: [0.5, 0.2], heading_deg: 30, size: [2, 1.5], height: 0.05}"
    changes = [f"ground.obstacles=[{board}]", "start.x=0.5", "start.y=0.2", "duration=0.3"]
    heights = [
        simulate(load_scenario("stand", [f"plant={plant}", *changes])).signals["com_position"][-1]
        for plant in ("drake", "mujoco")
    ]
    assert heights[0] == pytest.approx(heights[1], abs=2e-4)
    assert heights[0][2] > 0.9


def test_the_top_of_an_inclined_board_is_where_it_is_said_to_be():
    board = Obstacle("b", (1.0, 0.5), 30.0, size=(2.0, 1.0), height=0.5, pitch_deg=-8, roll_deg=5)
    model = mujoco_model(JointServosParams(), Ground(obstacles=(board,)))
    data, heights = mujoco.MjData(model), []
    mujoco.mj_forward(model, data)
    places = [(1.0, 0.5), (1.5, 0.6), (0.6, 0.4), (0.9, 0.8)]
    for x, y in places:
        start, down = np.array([x, y, 2.0]), np.array([0.0, 0.0, -1.0])
        depth = mujoco.mj_ray(model, data, start, down, None, 1, -1, np.zeros(1, dtype=np.int32))
        heights.append(2.0 - depth)
    assert heights == pytest.approx([board.height_at(x, y) for x, y in places], abs=1e-9)


def test_a_push_and_a_soft_mat_do_the_same_as_in_drake():
    mat = "{name: mat, size: [2, 2], height: 0.05, relative_stiffness: 0.4}"
    push = "{time: 0.1, duration: 0.05, impulse: 6, direction_deg: 60, elevation_deg: 20}"
    changes = [f"ground.obstacles=[{mat}]", f"pushes=[{push}]", "duration=0.2"]
    torsos = [
        simulate(load_scenario("stand", [f"plant={plant}", *changes])).signals["torso_pose"]
        for plant in ("drake", "mujoco")
    ]
    assert torsos[0][-1, 3] < -2e-3
    assert torsos[1][-1] == pytest.approx(torsos[0][-1], abs=3e-4)


def test_lola_walks_in_mujoco_as_in_drake():
    changes = ["sensors.ideal=true", "duration=2.6"]
    drake, mujoco_ = (
        simulate(load_scenario("walk_flat", [f"plant={plant}", *changes]))
        for plant in ("drake", "mujoco")
    )
    assert drake.completed and mujoco_.completed
    for name, allowed in (("torso_pose", 2e-3), ("com_position", 2e-3), ("joint_position", 0.02)):
        assert np.abs(drake.signals[name] - mujoco_.signals[name])[500:].max() < allowed, name
    forces = [result.signals["ground_force"][500:, [2, 5]] for result in (drake, mujoco_)]
    assert np.sqrt(np.mean((forces[0] - forces[1]) ** 2)) < 0.05 * WEIGHT
    torques = [result.signals["joint_torque"][500:] for result in (drake, mujoco_)]
    size, difference = (np.sqrt(np.mean(t**2)) for t in (torques[0], torques[0] - torques[1]))
    assert difference < 0.1 * size


def test_the_same_run_twice_has_the_same_bits():
    runs = [simulate(load_scenario("walk_flat", ["plant=mujoco", "duration=1.2"])) for _ in "ab"]
    assert all((runs[0].signals[n] == runs[1].signals[n]).all() for n in runs[0].signals)
    assert runs[0].versions["mujoco"] == mujoco.__version__


def test_what_only_drake_can_do_is_refused():
    with pytest.raises(ScenarioError, match="plant: 'mujoco' runs in the fused engine alone"):
        build_simulation(load_scenario("stand", ["plant=mujoco"]))
