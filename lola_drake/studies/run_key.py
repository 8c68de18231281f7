"""What a run is known by: its whole scenario, the laws it names, and the software."""

import dataclasses
import hashlib
import json
from functools import cache, lru_cache
from pathlib import Path

from lola_drake.paths import models_dir
from lola_drake.results import software_versions
from lola_drake.scenario import Scenario
from lola_drake.typed_yaml import plain

ABOVE_THE_SIMULATION = (
    "benchmarks",
    "cli",
    "diagram",
    "figures",
    "linear",
    "reports",
    "studies",
    "view3d",
)
"""Folders of the package that no run's numbers depend on."""


def run_key(scenario: Scenario) -> str:
    """Return a digest of everything that a run's numbers depend on.

    Of laws of one's own it covers the files that the scenario names.
    """
    digest = hashlib.sha256(software_digest().encode())
    for field in dataclasses.fields(scenario):
        digest.update(_line(getattr(scenario, field.name)).encode())
    for own in scenario.blocks:
        path = Path(own.law.rpartition(":")[0])
        # One that is missing is told of by the run itself.
        digest.update(path.read_bytes() if path.is_file() else b"")
    return digest.hexdigest()


@lru_cache(256, typed=True)
def _line(section: object) -> str:
    """Return a section of a scenario as a line; many scenarios of a study share most of them."""
    return json.dumps(plain(section)) + "\n"


@cache
def software_digest() -> str:
    """Return a digest of everything but the scenario that a run's numbers depend on.

    It covers the package up to the simulation, the robot, and the versions of what they use.
    """
    package, robot = Path(__file__).resolve().parents[1], models_dir() / "lola"
    sources = [
        path
        for path in package.rglob("*.py")
        if path.relative_to(package).parts[0] not in ABOVE_THE_SIMULATION
    ]
    digest = hashlib.sha256(json.dumps(software_versions(), sort_keys=True).encode())
    for path in sorted([*sources, *robot.glob("*.urdf")]):
        digest.update(path.read_bytes())
    return digest.hexdigest()
