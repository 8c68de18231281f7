"""The robot's files open in strict readers, too."""

import re
import xml.etree.ElementTree as ElementTree

import pytest

from lola_drake.paths import models_dir

FOLDER = models_dir() / "lola"
MESHES = sorted(FOLDER.rglob("*.obj"))


@pytest.mark.parametrize("mesh", MESHES, ids=lambda path: path.stem)
def test_numbers_of_a_mesh_begin_with_a_digit(mesh):
    """Assimp passes over `.06` without a word: then a face names vertices that are not there."""
    count = {"v": 0, "vt": 0, "vn": 0}
    for line in mesh.read_text(encoding="utf-8").splitlines():
        kind, *values = line.split() or ["#"]
        if kind in count:
            assert all(re.fullmatch(r"-?\d+(\.\d+)?(e-?\d+)?", value) for value in values), line
            assert len(values) == (2 if kind == "vt" else 3), line
            count[kind] += 1
        elif kind == "f":
            for corner in values:
                for number, of in zip(corner.split("/"), ("v", "vt", "vn"), strict=False):
                    assert not number or 1 <= int(number) <= count[of], line
        elif kind == "mtllib":
            assert all((mesh.parent / name).is_file() for name in values), line


def test_the_urdf_names_files_that_are_there_and_meshes_that_are_read():
    robot = ElementTree.parse(FOLDER / "lola.urdf").getroot()
    names = [mesh.get("filename") for mesh in robot.iter("mesh")]
    assert len(names) > 20
    for name in names:
        path = name.removeprefix("package://lola_models/")
        assert any((place / path).is_file() for place in (models_dir(), FOLDER)), name


def test_transmissions_are_whole():
    """Strict parsers reject a file whose joints in transmissions have no hardware interface."""
    robot = ElementTree.parse(FOLDER / "lola.urdf").getroot()
    joints = {joint.get("name") for joint in robot.findall("joint")}
    transmissions = robot.findall("transmission")
    assert len(transmissions) == 24
    for transmission in transmissions:
        assert transmission.findtext("type") == "transmission_interface/SimpleTransmission"
        (joint,) = transmission.findall("joint")
        assert joint.get("name") in joints
        assert joint.findtext("hardwareInterface") == "hardware_interface/EffortJointInterface"
        assert len(transmission.findall("actuator")) == 1
