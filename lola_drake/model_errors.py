"""How the robot differs from what its controller takes it for.

The model in `models/lola` is the controller's; the robot's own is this one with its errors.
"""

from dataclasses import dataclass
from xml.etree import ElementTree

from lola_drake.parameters import parameter, validate
from lola_drake.paths import models_dir

# Drake knows its own elements by this prefix.
ElementTree.register_namespace("drake", "http://drake.mit.edu")

_LEG = ("hr{}", "ha{}", "hf{}", "kf{}", "sa{}", "sf{}", "foot_{}", "zf{}")
LEGS = {name.format(side): leg for leg, side in ((1, "r"), (2, "l")) for name in _LEG}
"""The links of the right (1) and the left leg (2); all others are the trunk (0)."""

PAD_NAMES = tuple(
    f"pad_{place}_{foot}"
    for foot in "lr"
    for place in ("rear_left", "rear_right", "front_left", "front_right")
)


@dataclass(frozen=True)
class ModelErrors:
    """What the robot is, over what the controller takes it for: factors, but for the heights."""

    mass: tuple[float, float, float] = parameter(
        (1.0, 1.0, 1.0),
        "of trunk with arms, right and left leg, their inertia with it",
        minimum=0.5,
        maximum=2.0,
    )
    inertia: tuple[float, float, float] = parameter(
        (1.0, 1.0, 1.0), "of the same, beyond what the mass says", minimum=0.5, maximum=2.0
    )
    pad_stiffness: tuple[float, ...] = parameter(
        (1.0,) * 8,
        "of the pads on their ground, in the order of the switches: left foot, then right, each "
        "rear left, rear right, front left, front right",
        minimum=0.5,
        maximum=2.0,
    )
    pad_height: tuple[float, ...] = parameter(
        (0.0,) * 8,
        "of the pads over where they should be, in the same order",
        "m",
        minimum=-0.01,
        maximum=0.01,
    )
    servo_gain: float = parameter(1.0, "of the servos' position loops", minimum=0.5, maximum=2.0)

    def __post_init__(self):
        validate(self)


def robot_urdf(errors: ModelErrors) -> str:
    """Return the robot's model with its errors, as URDF.

    A pad is as much stiffer as it is wider: the ground has a stiffness per area.
    """
    root = ElementTree.parse(models_dir() / "lola" / "lola.urdf").getroot()
    for link in root.iter("link"):
        part = LEGS.get(link.attrib["name"], 0)
        mass, inertia = link.find("inertial/mass"), link.find("inertial/inertia")
        if mass is not None and inertia is not None:
            _scale(mass, errors.mass[part])
            _scale(inertia, errors.mass[part] * errors.inertia[part])
        if link.attrib["name"] in PAD_NAMES:
            mesh = link.find("collision/geometry/mesh")
            assert mesh is not None
            width = errors.pad_stiffness[PAD_NAMES.index(link.attrib["name"])]
            mesh.set("scale", f"1 {width!r} 1")
    for joint in root.iter("joint"):
        if joint.attrib["name"] in PAD_NAMES:
            origin = joint.find("origin")
            assert origin is not None
            x, y, z = origin.attrib["xyz"].split()
            height = errors.pad_height[PAD_NAMES.index(joint.attrib["name"])]
            origin.set("xyz", f"{x} {y} {float(z) + height!r}")
    return ElementTree.tostring(root, encoding="unicode")


def _scale(element: ElementTree.Element, factor: float) -> None:
    for name, value in element.attrib.items():
        element.set(name, repr(factor * float(value)))
