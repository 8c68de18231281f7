"""What each pad of the feet bears: read off the recorded poses, by the plant's own contact."""

import numpy as np
from pydrake.geometry import ContactSurface, HydroelasticContactRepresentation
from pydrake.math import RollPitchYaw
from pydrake.systems.framework import DiagramBuilder

from lola_drake.plant import add_plant, pad_geometries
from lola_drake.results import Result
from lola_drake.signals import CONTACT

PAD_NAMES = CONTACT.entry_names()
"""Of the columns of `pad_forces`, such as `pads_l.rear_left`."""


def pad_forces(result: Result, samples: np.ndarray) -> np.ndarray:
    """Return the vertical force on every pad (N), left foot first, shape (len(samples), 8).

    It is that of the springs of the ground alone; what damping adds, while a foot lands, is not
    in the record.
    """
    builder = DiagramBuilder()
    plant, scene_graph = add_plant(builder, result.scenario.terrain, result.scenario.model_errors)
    plant.Finalize()
    pads = pad_geometries(plant)
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    plant_context = plant.GetMyMutableContextFromRoot(context)
    query = scene_graph.get_query_output_port()
    query_context = scene_graph.GetMyContextFromRoot(context)
    forces = np.zeros((len(samples), len(PAD_NAMES)))
    torsos = result.signals["torso_pose"][samples]
    joints = result.signals["joint_position"][samples]
    for row, torso, q in zip(forces, torsos, joints, strict=True):
        quaternion = RollPitchYaw(torso[3:]).ToQuaternion().wxyz()
        plant.SetPositions(plant_context, np.r_[quaternion, torso[:3], q])
        surfaces = query.Eval(query_context).ComputeContactSurfaces(
            HydroelasticContactRepresentation.kTriangle
        )
        for surface in surfaces:
            first, second = surface.id_M().get_value(), surface.id_N().get_value()
            if first in pads or second in pads:
                row[pads.get(first, pads.get(second))] += _vertical(surface)
    return forces


def _vertical(surface: ContactSurface) -> float:
    """Return the vertical part of the pressure's integral over a contact surface (N)."""
    mesh, pressure = surface.tri_mesh_W(), surface.tri_e_MN()
    at_vertices = [pressure.EvaluateAtVertex(i) for i in range(mesh.num_vertices())]
    return sum(
        abs(mesh.face_normal(i)[2])
        * mesh.area(i)
        * sum(at_vertices[mesh.element(i).vertex(k)] for k in range(3))
        / 3
        for i in range(mesh.num_triangles())
    )
