"""What is drawn around the robot in 3D: ground forces, CoM, ZMP, footsteps, inclination, pressure.

The same markers serve a recorded replay and a running simulation.
"""

import numpy as np
from matplotlib.colors import to_rgba
from pydrake.geometry import Box, Cylinder, Meshcat, MeshcatCone, Rgba, Sphere
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix

from lola_drake.figures.footprints import sole_corners
from lola_drake.figures.style import FIRST, FOOT_COLOURS, FOOT_NAMES, PUSHED, SECOND, THIRD
from lola_drake.robot import PADS
from lola_drake.signals import FEET
from lola_drake.view3d.frames import Frame

ROOT = "/world/markers"
METRES_PER_NEWTON = 1e-3
"""Length of a force's arrow."""

PRESSURE = "#ff5a1f"
"""The colour of a loaded pad."""

EXAGGERATION = 10.0
"""So much more than the torso leans the needle above it; walking takes tenths of a degree."""

NO_PUSH = np.zeros((2, 3))

FULL_FORCE = 300.0
"""The force on a pad (N) from which on it glows as brightly as it can; half the robot's weight."""

LEAST_FORCE = 20.0
"""A ground force (N) below which no arrow is drawn."""

VERTICAL = "#8a8f98"
"""The colour of the needle that does not lean."""

LEGEND = (
    (FOOT_COLOURS["l"], "ground force, left"),
    (FOOT_COLOURS["r"], "right"),
    (THIRD, "CoM"),
    (SECOND, "ZMP"),
    (PRESSURE, "pressure of the pads"),
    (FIRST, "inclination of the torso, × 10"),
    (VERTICAL, "the vertical"),
    (f"{FOOT_COLOURS['l']}59", "planned footsteps, left"),
    (f"{FOOT_COLOURS['r']}59", "right"),
)
"""What the colours mean."""

PUSH_LEGEND = (PUSHED, "push")
"""What is there, too, in a run with pushes."""


class Markers:
    """The markers in one Meshcat scene."""

    def __init__(self, meshcat: Meshcat, pushes: int = 0):
        """Create all markers but the footsteps; of pushes as many as there may be at a time."""
        self._meshcat, self._pushes = meshcat, pushes
        for foot in FEET:
            self._add_arrow(_force_path(foot), FOOT_COLOURS[foot])
        for number in range(pushes):
            self._add_arrow(_push_path(number), PUSHED)
        meshcat.SetObject(f"{ROOT}/CoM/ball", Sphere(0.035), _rgba(THIRD))
        self._shine_through(f"{ROOT}/CoM/ball")
        meshcat.SetObject(f"{ROOT}/CoM/on the ground", Cylinder(0.022, 0.004), _rgba(THIRD))
        meshcat.SetObject(f"{ROOT}/ZMP", Cylinder(0.018, 0.008), _rgba(SECOND))
        for name, colour in (("vertical", VERTICAL), ("torso", FIRST)):
            path = f"{ROOT}/inclination/{name}"
            meshcat.SetObject(f"{path}/needle", Cylinder(0.005, 0.3), _rgba(colour))
            meshcat.SetTransform(f"{path}/needle", RigidTransform([0.0, 0.0, 0.15]))

    def _add_arrow(self, path: str, colour: str) -> None:
        self._meshcat.SetObject(f"{path}/shaft", Cylinder(0.009, 1.0), _rgba(colour))
        # The cone stands on its apex: turned over, it is an arrow's head.
        head = MeshcatCone(0.05, 0.022, 0.022)
        self._meshcat.SetObject(f"{path}/head/cone", head, _rgba(colour))
        turned = RigidTransform(RotationMatrix.MakeXRotation(np.pi), [0.0, 0.0, 0.05])
        self._meshcat.SetTransform(f"{path}/head/cone", turned)
        self._shine_through(f"{path}/shaft", f"{path}/head/cone")

    def _shine_through(self, *paths: str) -> None:
        """Let something be seen inside and behind the robot."""
        for path in paths:
            for name, value in (
                ("material.depthTest", False),
                ("material.transparent", True),
                ("renderOrder", 10.0),
            ):
                self._meshcat.SetProperty(f"{path}/<object>", name, value)

    def set_footsteps(self, footsteps: dict[str, list[np.ndarray]]) -> None:
        """Show planned footsteps: x, y, z, yaw of the TCP of each step in W, by foot."""
        length, width = np.ptp(sole_corners(np.zeros(3)), axis=0)
        self._meshcat.Delete(f"{ROOT}/planned footsteps")
        for foot, poses in footsteps.items():
            for i, (x, y, z, yaw) in enumerate(poses):
                path = f"{ROOT}/planned footsteps/{FOOT_NAMES[foot]}/{i}"
                colour = _rgba(FOOT_COLOURS[foot], 0.35)
                self._meshcat.SetObject(path, Box(length, width, 0.002), colour)
                pose = RigidTransform(RollPitchYaw(0.0, 0.0, yaw), [x, y, z + 0.002])
                self._meshcat.SetTransform(path, pose)

    def show(self, frame: Frame, time: float | None = None) -> None:
        """Move the markers; with a time, also in the recording."""
        put = self._meshcat.SetTransform
        for foot, force, origin in zip(FEET, frame.forces, frame.origins, strict=True):
            self._show_force(_force_path(foot), force, origin, time)
        for number in range(self._pushes):
            point, force = frame.pushes[number] if number < len(frame.pushes) else NO_PUSH
            # The arrow's head ends where it pushes.
            tail = point - METRES_PER_NEWTON * force
            self._show_force(_push_path(number), force, tail, time)
        put(f"{ROOT}/CoM/ball", RigidTransform(frame.com), time)
        ground = frame.zmp[2] if np.isfinite(frame.zmp[2]) else 0.0
        below = [frame.com[0], frame.com[1], ground + 0.003]
        put(f"{ROOT}/CoM/on the ground", RigidTransform(below), time)
        loaded = bool(np.isfinite(frame.zmp).all())
        self._meshcat.SetProperty(f"{ROOT}/ZMP", "visible", loaded, time)
        if loaded:
            put(f"{ROOT}/ZMP", RigidTransform(frame.zmp + [0.0, 0.0, 0.004]), time)
        roll, pitch, yaw = frame.torso[3:]
        top = frame.torso[:3] + [0.0, 0.0, 0.78]
        roll, pitch = np.clip([EXAGGERATION * roll, EXAGGERATION * pitch], -1.3, 1.3)
        put(f"{ROOT}/inclination/vertical", RigidTransform(top), time)
        put(f"{ROOT}/inclination/torso", RigidTransform(RollPitchYaw(roll, pitch, yaw), top), time)

    def _show_force(self, path: str, force: np.ndarray, origin: np.ndarray, time) -> None:
        size = float(np.linalg.norm(force))
        shown = size > LEAST_FORCE and bool(np.isfinite(origin).all())
        self._meshcat.SetProperty(path, "visible", shown, time)
        if not shown:
            return
        length = METRES_PER_NEWTON * size
        direction = RotationMatrix.MakeFromOneVector(force / size, 2)
        self._meshcat.SetTransform(path, RigidTransform(direction, origin), time)
        self._meshcat.SetProperty(f"{path}/shaft", "scale", [1.0, 1.0, length], time)
        self._meshcat.SetProperty(f"{path}/shaft", "position", [0.0, 0.0, length / 2], time)
        self._meshcat.SetProperty(f"{path}/head", "position", [0.0, 0.0, length], time)


class PressureMarkers:
    """A shell around each pad that glows as the ground presses on it."""

    def __init__(self, meshcat: Meshcat):
        """Create the shells."""
        self._meshcat = meshcat
        for foot in FEET:
            for i, pad in enumerate(PADS):
                path = _pad_path(foot, i)
                # A little larger than the pad, which would hide it.
                shell = Box(pad.length + 0.004, pad.width + 0.004, 0.028)
                meshcat.SetObject(path, shell, _rgba(PRESSURE, 0.5))
                meshcat.SetTransform(path, RigidTransform([pad.x, pad.y, 0.013]))

    def show(self, feet: np.ndarray, forces: np.ndarray, time: float | None = None) -> None:
        """Move the shells with the feet and let them glow.

        Args:
            feet: x, y, z (m), roll, pitch, yaw (rad) of both TCPs in W, shape (2, 6).
            forces: on the pads (N), left foot first, shape (8,).
            time: in a recording (s).
        """
        brightness = np.sqrt(np.clip(forces / FULL_FORCE, 0.0, 1.0)).reshape(len(FEET), -1)
        for foot, pose, pads in zip(FEET, feet, brightness, strict=True):
            place = RigidTransform(RollPitchYaw(pose[3:]), pose[:3])
            self._meshcat.SetTransform(f"{ROOT}/pressure/{FOOT_NAMES[foot]}", place, time)
            for i, bright in enumerate(pads):
                path = f"{_pad_path(foot, i)}/<object>"
                self._meshcat.SetProperty(path, "material.opacity", float(bright), time)


def _pad_path(foot: str, pad: int) -> str:
    return f"{ROOT}/pressure/{FOOT_NAMES[foot]}/{pad}"


def _force_path(foot: str) -> str:
    return f"{ROOT}/ground force/{FOOT_NAMES[foot]}"


def _push_path(number: int) -> str:
    return f"{ROOT}/push/{number}"


def _rgba(colour: str, alpha: float = 1.0) -> Rgba:
    return Rgba(*to_rgba(colour, alpha))
