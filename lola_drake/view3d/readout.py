"""What a live page tells: pose, speed, pace, and the signals at the ports of the blocks."""

import time
from collections import deque

import numpy as np

from lola_drake.run import Run
from lola_drake.signals import WALK_COMMAND, Signal, of_foot
from lola_drake.view3d.controls import Controls
from lola_drake.view3d.frames import Frame
from lola_drake.view3d.live_page import LivePage
from lola_drake.view3d.markers import LEGEND

EVERY = 0.1
"""Real time between two readings (s)."""

SPAN = 1.0
"""Time over which speed and pace are taken (s)."""


class Readout:
    """Tells a page ten times a second how a run goes on."""

    def __init__(self, page: LivePage, run: Run, controls: Controls):
        """Tell the page what there is."""
        self._page, self._signals = page, _signals(run)
        self._before = 0.0
        self._past: deque[tuple[float, float, np.ndarray]] = deque(maxlen=round(SPAN / EVERY))
        page.tell(
            "about",
            {
                "controls": controls.told(run),
                "legend": LEGEND,
                "signals": {
                    name: {
                        "doc": signal.doc,
                        "entries": signal.entry_names(),
                        "units": signal.entry_units(),
                    }
                    for name, signal in self._signals.items()
                },
            },
        )

    def tell(self, run: Run, frame: Frame, state: str, possible: float) -> None:
        """Tell how it is now, unless that has just been told or nobody looks.

        Args:
            run: what runs.
            frame: where the robot is.
            state: of the view, in a few words.
            possible: simulated time in a second of computing.
        """
        now = time.perf_counter()
        if now - self._before < EVERY or not self._page.watched:
            return
        self._before = now
        self._past.append((now, run.time, frame.com[:2]))
        (began, then, there), passed = self._past[0], max(now - self._past[0][0], 1e-3)
        simulated = run.time - then
        told = {
            "time": run.time,
            "position": frame.torso[:2].tolist(),
            "heading": np.degrees(frame.torso[5]),
            "lean": np.degrees(frame.torso[3:5]).tolist(),
            "speed": _speed(frame.com[:2] - there, simulated),
            "pace": simulated / passed if now > began else 0.0,
            "possible": possible,
            "state": state,
            "signals": {name: _numbers(run.signal(name)) for name in self._signals},
        }
        self._page.tell("now", told)


def _speed(way: np.ndarray, duration: float) -> float:
    return float(np.linalg.norm(way)) / duration if duration > 0.0 else 0.0


def _signals(run: Run) -> dict[str, Signal]:
    """Return all signals that a run can tell, by name."""
    known = {
        of_foot(name, block.foot): signal
        for block in run.blocks.values()
        for name, signal in block.outputs.items()
    }
    known.setdefault(WALK_COMMAND.name, WALK_COMMAND)
    return {name: signal for name, signal in known.items() if _has(run, name)}


def _has(run: Run, name: str) -> bool:
    try:
        run.signal(name)
    except KeyError:
        return False
    return True


def _numbers(values: np.ndarray) -> list[float | None]:
    """Return numbers with the digits that one can read; None for what is none."""
    return [float(f"{v:.5g}") if np.isfinite(v) else None for v in values]
