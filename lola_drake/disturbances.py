"""What a scenario does to the robot on purpose, in short: for summaries."""

from lola_drake.scenario import Scenario
from lola_drake.typed_yaml import leaves, plain

FAULTS = (
    "sensors.imu.drift",
    "sensors.foot_force.bias_l",
    "sensors.foot_force.bias_r",
    "sensors.contact.dead",
    "sensors.missed",
    "control.servos.missed",
)
"""The settings that are faults."""


def disturbances(scenario: Scenario) -> dict[str, object]:
    """Return the pushes and faults of a scenario as plain data; nothing where there are none."""
    usual, here = (leaves(plain(whole)) for whole in (Scenario(), scenario))
    faults = {key: here[key] for key in FAULTS if here[key] != usual[key]}
    found = {"pushes": plain(scenario.pushes), "faults": faults}
    return {name: what for name, what in found.items() if what}
