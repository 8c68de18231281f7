"""What came before a fall: contacts out of their time, and limits that were reached."""

from collections.abc import Iterator

import numpy as np

from lola_drake.contact_events import landings
from lola_drake.limits import limits_reached
from lola_drake.metrics import CALM, SETTLED, inclination_deg
from lola_drake.results import Result, run_limits
from lola_drake.signals import FEET, JOINTS

Event = dict[str, object]


def fall_events(result: Result) -> list[Event]:
    """Return what led to the fall of a run, in the order of time; nothing if it did not fall.

    Looked at is the time from a step before the torso was calm for the last time: an earlier
    disturbance was survived. The first event is what is called the cause. A late contact counts
    from when it was planned.

    Returns:
        `time_s` and `event` of each, such as "late contact of the left foot" or "joint_torque of
        tkfr"; of each limit the first time and place.
    """
    if result.fall_time is None:
        return []
    begins = _last_calm(result) - result.scenario.pattern.step_time
    found = [*_contacts(result), *_limits(result, begins)]
    found = [(time, event) for time, event in found if begins <= time <= result.fall_time]
    return [{"time_s": time, "event": event} for time, event in sorted(found)]


def _last_calm(result: Result) -> float:
    """Return when the torso inclined by less than `CALM` for the last time (s)."""
    size = np.linalg.norm(inclination_deg(result.signals["torso_pose"]), axis=1)
    calm = result.times[size < CALM]
    return float(calm[-1]) if len(calm) else 0.0


def _contacts(result: Result) -> Iterator[tuple[float, str]]:
    for landing in landings(result):
        if landing.kind != "punctual":
            foot = {"l": "left", "r": "right"}[landing.foot]
            yield (
                min(landing.planned, landing.measured),
                f"{landing.kind} contact of the {foot} foot",
            )


def _limits(result: Result, begins: float) -> Iterator[tuple[float, str]]:
    """Yield the first time of each kind of limit, and what was at it."""
    looked_at = result.times >= max(begins, SETTLED)
    times = result.times[looked_at]
    signals = {name: values[looked_at] for name, values in result.signals.items()}
    for kind, where in limits_reached(signals, run_limits(result.scenario)).items():
        if where.any():
            first = int(np.argmax(where.any(axis=1)))
            names = FEET if kind == "friction" else JOINTS
            yield float(times[first]), f"{kind} of {names[int(np.argmax(where[first]))]}"
