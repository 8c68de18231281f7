"""A running simulation to look at and to take part in, in a browser.

The view attends to a simulation from outside: the diagram that runs is the same as without it.
"""

import dataclasses
import time

import numpy as np
from pydrake.geometry import Meshcat
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import ExternallyAppliedSpatialForce

from lola_drake.blocks.walking_pattern import unpack_request
from lola_drake.errors import OutputError
from lola_drake.figures.footprints import to_world
from lola_drake.plant import plant_truth
from lola_drake.results import Result
from lola_drake.run import Run
from lola_drake.scenario import DESCRIPTION, Scenario
from lola_drake.signals import FEET
from lola_drake.simulation import simulate
from lola_drake.theory.gait import advance, foothold
from lola_drake.view3d.controls import PAUSE, STOP, Controls
from lola_drake.view3d.frames import frames_of
from lola_drake.view3d.markers import Markers
from lola_drake.view3d.scene import Puppet, follow, shown_in

CHUNK = 0.03
"""Simulated time between two pictures (s)."""

KEPT = 5000
"""Samples of the log to keep when nothing is recorded."""

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

    def __init__(self, scenario: Scenario, meshcat: Meshcat):
        """Prepare the scene; the panel appears when the simulation begins.

        Args:
            scenario: What will be run. Without steps and commands of its own the robot follows
                the panel.
            meshcat: Where to show it; the simulation waits until somebody looks.
        """
        self.stopped = self.interfered = False
        self._scenario, self._meshcat = scenario, meshcat
        self._puppet, self._markers = Puppet(scenario, shown_in(meshcat)), Markers(meshcat)
        self._controls: Controls | None = None
        self._paused = False
        self._clock = _Clock()
        self._push_end = 0.0
        self._planned: bytes | None = None

    def __call__(self, run: Run) -> float | None:
        """Attend to a simulation, see `simulate`."""
        if self._controls is None:
            self._open(run)
        if self._controls.clicked(STOP):
            self.stopped = True
        if self._controls.clicked(PAUSE):
            self._paused = not self._paused
        if self.stopped:
            return None
        if self._paused or not self._meshcat.GetNumActiveConnections():
            self._clock.stop()
            time.sleep(0.02)
            return 0.0
        self._act(run)
        self._draw(run)
        self._clock.wait(run.time, self._controls.rate)
        return CHUNK

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

    def _open(self, run: Run) -> None:
        walk = self._scenario.walk
        self._steered = not walk.steps and not walk.command
        force = run.plant.get_applied_spatial_force_input_port()
        pushes = not force.HasValue(run.plant.GetMyContextFromRoot(run.context))
        self._controls = Controls(self._meshcat, steering=self._steered, pushes=pushes)
        self._controls.show_gains(run)
        self._draw(run)

    def _act(self, run: Run) -> None:
        """Do to the simulation what the user asks for."""
        self.interfered |= self._controls.apply_gains(run)
        if self._steered:
            run.command(self._controls.command())
            self.interfered |= bool(np.any(self._controls.command()))
        for impulse in self._controls.pushes():
            self.interfered = True
            push(run, impulse)
            self._push_end = run.time + PUSH_TIME
        if 0.0 < self._push_end < run.time + CHUNK / 2:
            push(run, np.zeros(2))
            self._push_end = 0.0

    def _draw(self, run: Run) -> None:
        signals = signals_now(run)
        (frame,) = frames_of(signals, self._scenario.ground)
        now = run.time
        self._puppet.pose(frame.torso, signals["joint_position"][0], now)
        self._markers.show(frame)
        follow(self._meshcat, frame.torso)
        self._meshcat.SetSimulationTime(now)
        request = run.state("walking_pattern", "request")
        if request.tobytes() != self._planned:
            self._planned = request.tobytes()
            self._markers.set_footsteps(next_footsteps(self._scenario, request))


def walk_live(scenario: Scenario, view: LiveView) -> None:
    """Let a user steer the robot until they stop it; after a fall it begins again."""
    endless = dataclasses.replace(scenario, duration=LONGEST)

    def attend(run: Run) -> float | None:
        step = view(run)
        if step:
            run.forget(KEPT)
        return step

    again = True
    while again:
        view.restart()
        result = simulate(endless, attend=attend)
        if result.error is not None:
            raise OutputError(f"the walk {result.end}")
        again = result.completed or result.fall_time is not None


class _Clock:
    """Keeps simulated time from running ahead of real time."""

    def __init__(self):
        self._start: tuple[float, float] | None = None
        self._rate = 0.0

    def stop(self) -> None:
        """Let the time that passes now not count."""
        self._start = None

    def wait(self, now: float, rate: float) -> None:
        """Sleep until the simulated time is due."""
        if self._start is None or rate != self._rate:
            self._start, self._rate = (now, time.perf_counter()), rate
        if rate > 0.0:
            began, real = self._start
            ahead = (now - began) / rate - (time.perf_counter() - real)
            if ahead > 0.0:
                time.sleep(ahead)
            elif ahead < -0.2:
                # Too slow for the rate: lost time is not made up for later.
                self._start = (now, time.perf_counter())


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
    force = ExternallyAppliedSpatialForce()
    force.body_index, force.p_BoBq_B = torso.index(), [0.0, 0.0, PUSH_HEIGHT]
    x, y = (impulse[0] * forward + impulse[1] * left) / PUSH_TIME
    force.F_Bq_W = SpatialForce([0.0, 0.0, 0.0], [x, y, 0.0])
    port = plant.get_applied_spatial_force_input_port()
    port.FixValue(context, [force] if np.any(impulse) else [])


def signals_now(run: Run) -> dict[str, np.ndarray]:
    """Return what the markers need of a run's signals, as a record of one row."""
    names = ("contact_wrench_l", "contact_wrench_r", "ground_force")
    return plant_truth(run.plant, run.plant_state[None]) | {
        name: run.signal(name)[None] for name in names
    }


def next_footsteps(scenario: Scenario, state: np.ndarray) -> dict[str, list[np.ndarray]]:
    """Return x, y, z, yaw in W of the footsteps that the walking pattern has planned ahead.

    Args:
        scenario: What is run.
        state: Of the walking pattern.
    """
    request, start = unpack_request(state), scenario.start
    path, swing = request.path, request.swing
    base = scenario.ground.height_at(start.x, start.y) + request.ground
    footsteps: dict[str, list[np.ndarray]] = {foot: [] for foot in FEET}
    for displacement in request.displacements:
        path = advance(path, displacement)
        x, y, yaw = foothold(path, swing, scenario.pattern.step_width)
        place = to_world(scenario, np.array([[x, y]]))[0]
        footsteps[FEET[swing]].append(np.r_[place, base, yaw + np.deg2rad(start.heading_deg)])
        swing = 1 - swing
    return footsteps
