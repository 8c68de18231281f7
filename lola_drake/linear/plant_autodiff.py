"""A multibody plant and its geometry as a copy that differentiates itself.

Drake's conversion to AutoDiff forgets the implicit PD gains of the actuators without a word; the
copy gets them again here.
"""

from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import Context, DiagramBuilder

from lola_drake.linear.isolated import Instance


def autodiff_plant(plant: Instance, scene_graph: Instance | None) -> Instance:
    """Return the plant over AutoDiffXd in the same state, with nothing connected but its geometry.

    Args:
        plant: a finalized MultibodyPlant.
        scene_graph: its geometry; None if it has none.
    """
    builder = DiagramBuilder()
    copy = builder.AddSystem(plant.system.Clone())
    if scene_graph:
        geometry = builder.AddSystem(scene_graph.system.Clone())
        builder.Connect(geometry.get_query_output_port(), copy.get_geometry_query_input_port())
        builder.Connect(
            copy.get_geometry_pose_output_port(),
            geometry.get_source_pose_port(copy.get_source_id()),
        )
    diagram = builder.Build().ToAutoDiffXd()
    root = diagram.CreateDefaultContext()
    root.SetTime(plant.context.get_time())
    instances = [plant, scene_graph] if scene_graph else [plant]
    for system, instance in zip(diagram.GetSystems(), instances, strict=True):
        context: Context = system.GetMyMutableContextFromRoot(root)
        context.SetStateAndParametersFrom(instance.context)
    converted = diagram.GetSystems()[0]
    set_same_gains(plant.system, converted)
    return Instance(converted, converted.GetMyMutableContextFromRoot(root), (diagram, root))


def set_same_gains(plant: MultibodyPlant, converted: MultibodyPlant) -> None:
    """Give every actuator of the converted plant the PD gains of the original."""
    for index in plant.GetJointActuatorIndices():
        actuator = plant.get_joint_actuator(index)
        if actuator.has_controller():
            gains = actuator.get_controller_gains()
            converted.get_joint_actuator(index).set_controller_gains(gains)
