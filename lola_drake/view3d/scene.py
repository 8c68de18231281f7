"""The robot and its ground in Meshcat, and what can be seen of them."""

import logging
import secrets
import sys
from collections.abc import Callable

import numpy as np
from pydrake.geometry import (
    Meshcat,
    MeshcatParams,
    MeshcatVisualizer,
    MeshcatVisualizerParams,
    QueryObject,
    Rgba,
    SceneGraph,
)
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import DiagramBuilder

from lola_drake.plant import add_plant
from lola_drake.scenario import Ground

# Who wants to look is told where by the command; a page that is made needs no such message.
logging.getLogger("drake").addFilter(lambda record: "listening" not in record.getMessage())

Furnish = Callable[[DiagramBuilder, MultibodyPlant, SceneGraph], None]

WORLD = "/world"
"""Everything but camera and light; it moves so that the robot stays in sight."""

SQUARE, STRIP = 0.5, 0.009
"""Distance and width of the lines on the floor (m)."""

CAMERA, TARGET = (1.05, -1.35, 1.25), (0.0, 0.0, 1.02)
"""Where the camera stands and what it looks at, with the robot at x = y = 0 (m)."""


def hidden_address() -> str:
    """Return an address drawn among the 16 million of this machine, which only Linux has."""
    if sys.platform != "linux":
        return "localhost"
    return "127." + ".".join(str(1 + secrets.randbelow(254)) for _ in range(3))


def open_meshcat(*, hidden: bool = False) -> Meshcat:
    """Return a Meshcat server with a floor, at any free port of this machine.

    The sky is the page's: `sky.js` makes it light or dark.

    Args:
        hidden: whether nobody shall find it, since there is a `Door` to it.
    """
    host = hidden_address() if hidden else "localhost"
    meshcat = Meshcat(MeshcatParams(host=host, port=0, show_stats_plot=False))
    meshcat.SetProperty("/Axes", "visible", False)
    meshcat.SetProperty("/Grid", "visible", False)
    meshcat.SetCameraPose(CAMERA, TARGET)
    _lay_floor(meshcat)
    return meshcat


def _lay_floor(meshcat: Meshcat, reach: int = 9) -> None:
    """Lay out a grid of narrow strips, just below the feet."""
    marks = np.arange(-reach, reach + SQUARE / 2, SQUARE)
    sides = zip(marks - STRIP / 2, marks + STRIP / 2, strict=True)
    along = np.array([[(a, -reach), (b, -reach), (b, reach), (a, reach)] for a, b in sides])
    corners = np.concatenate([along, along[..., ::-1]]).reshape(-1, 2)
    first = 4 * np.arange(2 * len(marks))[:, None, None]
    faces = (first + [[0, 1, 2], [0, 2, 3]]).reshape(-1, 3)
    vertices = np.column_stack([corners, np.full(len(corners), -0.003)])
    meshcat.SetTriangleMesh(
        *("/floor", vertices.T, faces.T, Rgba(0.62, 0.64, 0.67, 1.0)),
        side=Meshcat.SideOfFaceToRender.kDoubleSide,
    )


def follow(meshcat: Meshcat, position: np.ndarray, time: float | None = None) -> None:
    """Move the world so that the camera sees what is at x and y of the position."""
    x, y = position[:2]
    meshcat.SetTransform(WORLD, RigidTransform([-x, -y, 0.0]), time)
    # The floor has no end: it moves within one of its squares.
    meshcat.SetTransform("/floor", RigidTransform([-(x % SQUARE), -(y % SQUARE), 0.0]), time)


class Puppet:
    """LOLA on a ground, without physics: it stands where it is put."""

    def __init__(self, ground: Ground, furnish: Furnish):
        """Build the scene.

        Args:
            ground: With what lies on it.
            furnish: Called with the builder, the plant before it is finalized, and the scene
                graph; adds what shows them.
        """
        builder = DiagramBuilder()
        plant, self.scene_graph = add_plant(builder, ground)
        furnish(builder, plant, self.scene_graph)
        plant.Finalize()
        self._plant, self._diagram = plant, builder.Build()
        self._context = self._diagram.CreateDefaultContext()
        self._plant_context = plant.GetMyMutableContextFromRoot(self._context)

    def pose(self, torso: np.ndarray, joints: np.ndarray, time: float = 0.0) -> None:
        """Put the robot somewhere.

        Args:
            torso: x, y, z (m), roll, pitch, yaw (rad) in W, shape (6,).
            joints: Joint angles (rad), shape (24,).
            time: In a recording (s).
        """
        quaternion = RollPitchYaw(torso[3:]).ToQuaternion().wxyz()
        self._plant.SetPositions(self._plant_context, np.r_[quaternion, torso[:3], joints])
        self._context.SetTime(time)
        self._diagram.ForcedPublish(self._context)

    def query(self) -> QueryObject:
        """Return what renders pictures of the robot where it stands."""
        context = self.scene_graph.GetMyContextFromRoot(self._context)
        return self.scene_graph.get_query_output_port().Eval(context)


def shown_in(meshcat: Meshcat, path: str = f"{WORLD}/lola") -> Furnish:
    """Return what shows a puppet in a Meshcat scene, under a path there."""

    def furnish(builder, plant, scene_graph) -> None:
        params = MeshcatVisualizerParams(prefix=path, enable_alpha_slider=False)
        MeshcatVisualizer.AddToBuilder(builder, scene_graph, meshcat, params)

    return furnish
