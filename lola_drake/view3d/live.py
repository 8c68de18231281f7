"""A running simulation to look at and to take part in, in a browser.

The view attends to a simulation from outside: the diagram that runs is the same as without it.
"""

import dataclasses
import time
from collections.abc import Callable, Iterator

import numpy as np
from pydrake.geometry import Meshcat

from lola_drake.blocks.walking_pattern import unpack_request
from lola_drake.errors import OutputError
from lola_drake.figures.footprints import to_world
from lola_drake.pad_forces import pad_forces
from lola_drake.plant import pad_joints, plant_truth
from lola_drake.pushes import applied_force
from lola_drake.results import Result
from lola_drake.run import Run
from lola_drake.scenario import DESCRIPTION, Scenario
from lola_drake.signals import FEET, PERIOD
from lola_drake.simulation import simulate
from lola_drake.theory.footholds import UP, advance, clear_foothold
from lola_drake.view3d.controls import KEEP, PAUSE, REPLAY, STOP, Controls
from lola_drake.view3d.frames import Frame, frame_samples, frames_at, frames_of, seen_pushes
from lola_drake.view3d.live_page import LivePage
from lola_drake.view3d.markers import Markers, PressureMarkers
from lola_drake.view3d.pace import Clock, Pace
from lola_drake.view3d.readout import Readout
from lola_drake.view3d.scene import Puppet, follow, shown_in

CHUNK = 0.03
"""Simulated time between two pictures (s)."""

LOOK_BACK = 20.0
"""What can be shown again, or kept (s)."""

REPLAYED_PER_SECOND = 25
"""Pictures of what is shown again."""

LONGEST = 3600.0
"""After which time a walk begins again (s)."""

PUSH_TIME, PUSH_HEIGHT = 0.12, 0.25
"""How long a push lasts (s), and how far above the torso's origin it acts (m)."""


class LiveView:
    """Shows a simulation while it runs, at the rate and with the gains of its panel.

    Attributes:
        stopped: Whether the user has asked to end it.
        interfered: Whether the user has done anything that the scenario does not say.
    """

    def __init__(
        self,
        scenario: Scenario,
        meshcat: Meshcat,
        page: LivePage | None = None,
        keep: Callable[[Result], str] | None = None,
    ):
        """Prepare the scene; the panel appears when the simulation begins.

        Args:
            scenario: What will be run. Without steps and commands of its own the robot follows
                the panel.
            meshcat: Where to show it; the simulation waits until somebody looks.
            page: What to tell how it goes on.
            keep: Keeps the record of the last seconds when the user asks for it, and returns
                where.
        """
        self.stopped = self.interfered = False
        self._scenario, self._meshcat = scenario, meshcat
        self._steered = not scenario.walk.steps and not scenario.walk.command
        self._puppet = Puppet(scenario.terrain, shown_in(meshcat))
        self._markers = Markers(meshcat, len(scenario.pushes))
        self._pressure = PressureMarkers(meshcat)
        self._controls: Controls | None = None
        self._paused = False
        self._clock = Clock()
        self._push_end = 0.0
        self._planned: bytes | None = None
        self._page, self._keep = page, keep
        self._readout: Readout | None = None
        self._replayed: Iterator[None] = iter(())
        self._kept = ""
        self._pace = Pace()

    def __call__(self, run: Run) -> float | None:
        """Attend to a simulation, see `simulate`."""
        self._pace.computed(run.time)
        if self._controls is None:
            self._controls = self._opened(run)
        controls = self._controls
        if controls.clicked(STOP):
            self.stopped = True
        if controls.clicked(PAUSE):
            self._paused = not self._paused
        if self.stopped:
            return None
        if controls.clicked(REPLAY):
            self._replayed = self._replay(run)
        if self._keep and controls.clicked(KEEP):
            self._kept = self._keep(run.recent(LOOK_BACK))
        if self._waits(run):
            self._clock.stop()
            return 0.0
        self._act(run, controls)
        self._draw(run)
        self._tell(run, "runs")
        self._clock.wait(run.time, controls.rate)
        self._pace.begin(run.time)
        return CHUNK

    def _waits(self, run: Run) -> bool:
        """Wait a moment if there is a reason; return whether there was."""
        if not self._meshcat.GetNumActiveConnections():
            time.sleep(0.02)
            return True
        if next(self._replayed, self) is not self:
            return True
        if self._paused:
            self._tell(run, "paused")
            time.sleep(0.02)
        return self._paused

    def _replay(self, run: Run) -> Iterator[None]:
        """Show what was in the last seconds, a picture at a time."""
        past = run.recent(LOOK_BACK)
        samples = frame_samples(past.times, REPLAYED_PER_SECOND)
        feet = np.stack([past.signals[f"foot_pose_{foot}"][samples] for foot in FEET], axis=1)
        joints, forces = past.signals["joint_position"][samples], pad_forces(past, samples)
        for k, frame in enumerate(frames_at(past, samples)):
            began, now = time.perf_counter(), past.times[samples[k]]
            self._show(frame, joints[k], feet[k], forces[k], now)
            self._tell(run, f"replays {now - past.duration:.1f} s", frame)
            yield
            time.sleep(max(1 / REPLAYED_PER_SECOND - (time.perf_counter() - began), 0.0))

    def _tell(self, run: Run, state: str, frame: Frame | None = None) -> None:
        """Tell the page how it goes on."""
        if self._readout is not None:
            shown = frame or self._frame
            self._readout.tell(
                run, shown, f"{state}; {self._kept}".strip("; "), self._pace.possible
            )

    def signed(self, result: Result) -> Result:
        """Return the record of the run; what cannot be repeated says so."""
        if not self.interfered:
            return result
        note = "(Changed by hand while it ran.)"
        before = result.scenario.description[: DESCRIPTION - len(note) - 1]
        description = f"{before} {note}".strip()
        scenario = dataclasses.replace(result.scenario, description=description)
        return dataclasses.replace(result, scenario=scenario)

    def restart(self) -> None:
        """Forget the simulation: the next call begins with another one."""
        self._controls = None
        self._clock.stop()

    def _opened(self, run: Run) -> Controls:
        run.look_back = LOOK_BACK
        force = run.plant.get_applied_spatial_force_input_port()
        pushes = not force.HasValue(run.plant.GetMyContextFromRoot(run.context))
        controls = Controls(
            self._meshcat,
            steering=self._steered,
            pushes=pushes,
            keeping=self._keep is not None,
        )
        controls.show_gains(run)
        if self._page is not None:
            self._readout = Readout(self._page, run, controls)
        self._draw(run)
        return controls

    def _act(self, run: Run, controls: Controls) -> None:
        """Do to the simulation what the user asks for."""
        self.interfered |= controls.apply_gains(run)
        if self._steered:
            run.command(controls.command())
            self.interfered |= bool(np.any(controls.command()))
        for impulse in controls.pushes():
            self.interfered = True
            push(run, impulse)
            self._push_end = run.time + PUSH_TIME
        if 0.0 < self._push_end < run.time + CHUNK / 2:
            push(run, np.zeros(2))
            self._push_end = 0.0

    def _draw(self, run: Run) -> None:
        signals = signals_now(run)
        pushes = seen_pushes(self._scenario, run.time)
        (self._frame,) = frames_of(signals, self._scenario.terrain, [pushes])
        feet = np.stack([signals[f"foot_pose_{foot}"][0] for foot in FEET])
        self._show(self._frame, signals["joint_position"][0], feet, pad_forces_now(run), run.time)
        self._meshcat.SetSimulationTime(run.time)
        request = run.state("walking_pattern", "request")
        if request.tobytes() != self._planned:
            self._planned = request.tobytes()
            self._markers.set_footsteps(next_footsteps(self._scenario, request))

    def _show(
        self, frame: Frame, joints: np.ndarray, feet: np.ndarray, forces: np.ndarray, now: float
    ) -> None:
        self._puppet.pose(frame.torso, joints, now)
        self._markers.show(frame)
        self._pressure.show(feet, forces)
        follow(self._meshcat, frame.torso)


def walk_live(scenario: Scenario, view: LiveView) -> None:
    """Let a user steer the robot until they stop it; after a fall it begins again."""
    endless = dataclasses.replace(scenario, duration=LONGEST)

    def attend(run: Run) -> float | None:
        step = view(run)
        if step:
            run.forget(round(LOOK_BACK / PERIOD))
        return step

    again = True
    while again:
        view.restart()
        result = simulate(endless, attend=attend)
        if result.error is not None:
            raise OutputError(f"the walk {result.end}")
        again = result.completed or result.fall_time is not None


def push(run: Run, impulse: np.ndarray) -> None:
    """Push the torso until the next call.

    Args:
        run: of a scenario.
        impulse: Forward and to the left, as the robot sees it, when it lasts `PUSH_TIME` (Ns).
    """
    plant = run.plant
    context = plant.GetMyMutableContextFromRoot(run.context)
    torso = plant.GetBodyByName("torso")
    forward = plant.EvalBodyPoseInWorld(context, torso).rotation().matrix()[:2, 0]
    left = np.array([-forward[1], forward[0]])
    x, y = (impulse[0] * forward + impulse[1] * left) / PUSH_TIME
    force = applied_force(torso.index(), (0.0, 0.0, PUSH_HEIGHT), np.array([x, y, 0.0]))
    port = plant.get_applied_spatial_force_input_port()
    port.FixValue(context, [force] if np.any(impulse) else [])


def signals_now(run: Run) -> dict[str, np.ndarray]:
    """Return what the markers need of a run's signals, as a record of one row."""
    names = ("contact_wrench_l", "contact_wrench_r", "ground_force")
    return plant_truth(run.plant, run.plant_state[None]) | {
        name: run.signal(name)[None] for name in names
    }


def pad_forces_now(run: Run) -> np.ndarray:
    """Return the force that every pad bears, across it (N), left foot first, shape (8,)."""
    plant = run.plant
    reactions = plant.get_reaction_forces_output_port().Eval(
        plant.GetMyContextFromRoot(run.context)
    )
    return np.array([-reactions[joint].translational()[2] for joint in pad_joints(plant)])


def next_footsteps(scenario: Scenario, state: np.ndarray) -> dict[str, list[np.ndarray]]:
    """Return x, y, z, yaw in W of the footsteps that the walking pattern has planned ahead.

    Args:
        scenario: What is run.
        state: Of the walking pattern.
    """
    request, start = unpack_request(state), scenario.start
    path, swing = request.path, request.swing
    base = scenario.terrain.height_at(start.x, start.y) + request.ground
    feet = [foot[[0, 1, 3]] for foot in request.feet]
    footsteps: dict[str, list[np.ndarray]] = {foot: [] for foot in FEET}
    for displacement in request.displacements:
        path, base = advance(path, displacement[:UP]), base + displacement[UP]
        width = scenario.pattern.step_width
        x, y, yaw = feet[swing] = clear_foothold(path, swing, width, feet[1 - swing])
        place = to_world(scenario, np.array([[x, y]]))[0]
        footsteps[FEET[swing]].append(np.r_[place, base, yaw + np.deg2rad(start.heading_deg)])
        swing = 1 - swing
    return footsteps
