"""Poles and margins as tables."""

import math
from collections.abc import Sequence

from lola_drake.linear.margin import Margins
from lola_drake.linear.poles import Pole
from lola_drake.linear.text_table import Table

SLOWEST, LEAST_DAMPED = 8, 8
"""How many poles are shown of each kind."""

LOW = 1e-3
"""A frequency below this (Hz) is told as 0."""


def pole_table(poles: list[Pole]) -> Table:
    """Return the slowest and the least damped poles."""
    oscillating = sorted((p for p in poles if p.z.imag > 0 and abs(p.z) > 0.5), key=_damping)
    shown = poles[:SLOWEST] + [p for p in oscillating[:LEAST_DAMPED] if p not in poles[:SLOWEST]]
    rows = tuple(
        (
            f"{p.s.real:.3g}" + (f" +-{p.s.imag:.3g}j" if p.s.imag else ""),
            f"{p.frequency:.3g}",
            "neutral" if p.is_neutral else f"{p.damping:.3f}",
            f"{p.dominating} ({p.participation:.0%})",
        )
        for p in shown
    )
    title = f"Poles: the {SLOWEST} slowest, and the {LEAST_DAMPED} least damped, of {len(poles)}"
    return Table(title, ("s (1/s)", "Hz", "damping", "dominated by"), rows)


def margin_table(signal: str, margins: Sequence["Margins"]) -> Table:
    """Return the margins of every entry of a signal at which a loop is opened.

    Each stands before the frequency (Hz) at which it is taken.
    """
    header = ("@ Hz", "gain up", "down", "phase deg", "delay ms", "disk", "max |S|")
    rows = tuple(
        (
            # What comes before is in the title.
            (m.name.partition("/")[2] or m.name) + ("" if m.stable else " UNSTABLE"),
            _at(m.gain_up, m.gain_up_frequency),
            _at(m.gain_down, m.gain_down_frequency),
            _at(m.phase, m.phase_frequency),
            _at(1e3 * m.delay, m.delay_frequency),
            _at(m.disk, m.disk_frequency),
            _at(m.peak_sensitivity, m.peak_sensitivity_frequency),
        )
        for m in margins
    )
    return Table(f"Margins, opened at {signal}", header, rows)


def _at(value: float, frequency: float) -> str:
    """Return a margin and where it is reached; `any` where it is never reached."""
    if not math.isfinite(value) or not math.isfinite(frequency):
        return "any"
    return f"{value:.3g} @{frequency:.3g}" if frequency >= LOW else f"{value:.3g} @0"


def _damping(pole: Pole) -> float:
    return pole.damping
