"""The numbers of a report's panels as one short text for the page that draws them.

A curve becomes whole numbers of 16 bits between its least and greatest value: of each, the
difference to the one before, since that shrinks best. `report.js` is the way back.
"""

import json
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lola_drake.contact_events import surprises
from lola_drake.figures.style import FOOT_NAMES, intervals
from lola_drake.pushes import Push
from lola_drake.reports.panels import Cell, Curve, time_panels
from lola_drake.reports.planes import EVERY, plane_panels
from lola_drake.results import Result
from lola_drake.signals import CONTACT, FEET, GAIT_PHASE, PERIOD
from lola_drake.view3d.replay import packed

LEVELS, NOTHING = 65534, 65535
"""Into how many levels a curve's range is cut, and what stands for NaN."""


def payload(results: Sequence[Result], names: Sequence[str]) -> dict[str, str]:
    """Return what the page draws, packed: the `shape` as JSON and the `numbers`."""
    numbers = _Numbers()
    panels = [
        {
            "title": same[0].title,
            "columns": same[0].columns,
            "folded": same[0].folded,
            "cells": [
                _cell(cells, numbers) for cells in zip(*(p.cells for p in same), strict=True)
            ],
        }
        for of in (time_panels, plane_panels)
        for same in zip(*map(of, results), strict=True)
    ]
    shape = {
        "runs": [_run(result, name) for result, name in zip(results, names, strict=True)],
        "duration": max(result.duration for result in results),
        "period": PERIOD,
        "events": events(results),
        "panels": panels,
    }
    return {"shape": packed(json.dumps(shape)), "numbers": packed(numbers.content())}


def events(results: Sequence[Result]) -> list[dict[str, Any]]:
    """Return the pushes, and in a comparison the contacts that came early or late, in time.

    Those are t_1, t_2 … of the paper's Fig. 6. The time of each is the last of the runs' landings;
    the run that falls first ends the list.
    """
    contacts = _unexpected_contacts(results) if len(results) > 1 else []
    pushes = dict.fromkeys(push for result in results for push in result.scenario.pushes)
    duration = max(result.duration for result in results)
    found = [_push(push) for push in pushes if push.time < duration]
    return sorted(contacts + found, key=lambda event: event["planned"])


def _push(push: Push) -> dict[str, Any]:
    what = f"{push.impulse:g} Ns at {push.direction_deg:g}° on {push.body}"
    return {"name": "push", "what": what, "planned": push.time, "time": push.end}


def _unexpected_contacts(results: Sequence[Result]) -> list[dict[str, Any]]:
    return [
        {
            "name": f"t{i + 1}",
            "what": f"{FOOT_NAMES[same[0].foot]} foot {same[0].kind}",
            "planned": min(landing.planned for landing in same),
            "time": max(landing.measured for landing in same),
        }
        for i, same in enumerate(surprises(results))
    ]


def _run(result: Result, name: str) -> dict[str, object]:
    gait, contact = result.signals["gait_phase"], result.signals["contact"]
    support = gait[:, GAIT_PHASE.slice("support")] > 0.5
    return {
        "name": name,
        "start": float(result.times[0]),
        "fall": result.fall_time,
        "planned": [_bars(result, support[:, i]) for i in range(len(FEET))],
        "closed": [
            _bars(result, contact[:, CONTACT.slice(f"pads_{foot}")].any(axis=1)) for foot in FEET
        ],
    }


def _bars(result: Result, true: ArrayLike) -> list[tuple[float, float]]:
    return [
        (round(start, 3), round(start + length, 3))
        for start, length in intervals(result.times, true)
    ]


def _cell(cells: Sequence[Cell], numbers: "_Numbers") -> dict[str, object]:
    """Return one pair of axes with the curves of all runs."""
    first, main = cells[0], len(cells) - 1
    curves = [
        _curve(curve, run, numbers)
        for run, cell in enumerate(cells)
        for curve in cell.curves
        if run == main or not curve.plan
    ]
    if len(cells) > 1:
        curves = [c for c in curves if c["name"] != "IMU"]
    return {
        "title": first.title,
        "unit": first.unit,
        "across": first.across,
        "square": first.square,
        "notes": first.notes if len(cells) == 1 else [],
        "outlines": [np.round(line, 4).tolist() for line in cells[main].outlines],
        "curves": curves,
    }


def _curve(curve: Curve, run: int, numbers: "_Numbers") -> dict[str, object]:
    drawn = {"name": curve.name, "run": run, "colour": curve.colour, "dash": curve.dash}
    drawn |= {"plan": curve.plan, "y": numbers.add(curve.values)}
    if curve.across is not None:
        drawn |= {"x": numbers.add(curve.across), "every": EVERY}
    return drawn


class _Numbers:
    """All curves behind each other."""

    def __init__(self) -> None:
        self._arrays: list[np.ndarray] = []
        self._count = 0

    def add(self, values: np.ndarray) -> tuple[int, int, float, float]:
        """Return where values begin, how many they are, their least one and the step."""
        finite = values[np.isfinite(values)]
        low, high = (finite.min(), finite.max()) if len(finite) else (0.0, 0.0)
        step = (high - low) / LEVELS or 1.0
        whole = np.where(np.isfinite(values), np.round((values - low) / step), NOTHING)
        self._arrays.append(np.diff(whole.astype("<u2"), prepend=np.uint16(0)))
        start, self._count = self._count, self._count + len(values)
        return start, len(values), float(low), float(step)

    def content(self) -> bytes:
        """Return all numbers: first their lower bytes, then the upper ones."""
        if not self._arrays:
            return b""
        return np.concatenate(self._arrays).view(np.uint8).reshape(-1, 2).T.tobytes()
