"""Analyses as text for people, and as plain numbers for programs."""

import math

from lola_drake.linear.margins import Margins, disk_gain, disk_phase
from lola_drake.linear.poles import Pole
from lola_drake.linear.studies.analyses import Analysis, Loop
from lola_drake.linear.studies.text_table import Table

SLOWEST, LEAST_DAMPED = 8, 8
"""How many poles are shown of each kind."""


def report(analysis: Analysis) -> str:
    """Return an analysis as text."""
    parts = [_headline(analysis), pole_table(analysis.poles).as_text()]
    parts += [margin_table(loop).as_text() + _together(loop) for loop in analysis.loops]
    parts += [table.as_text() for table in analysis.tables]
    return "\n\n".join(parts)


def _headline(analysis: Analysis) -> str:
    point, model = analysis.workpoint.situation, analysis.model
    lines = [f"{analysis.name}: {analysis.definition.doc}"]
    if point.residual is None:
        drift = model.operating_point.residual
        lines.append(f"at {point.description}, frozen in time (no equilibrium: drift {drift:.1e}):")
        lines.append("what is not much faster than a step says nothing about stability here")
    else:
        lines.append(f"at {point.description}, an equilibrium to {point.residual:.1e} per tick")
    cut, held = model.operating_point.cut, model.operating_point.held
    lines.append(f"{model.nstates} states; {len(cut)} cut that nothing here excites or observes")
    lines.append(f"held: {', '.join(held)}")
    return "\n".join(lines)


def pole_table(poles: list[Pole]) -> Table:
    """Return the slowest and the least damped poles."""
    oscillating = sorted((p for p in poles if p.z.imag > 0 and abs(p.z) > 0.5), key=_damping)
    shown = poles[:SLOWEST] + [p for p in oscillating[:LEAST_DAMPED] if p not in poles[:SLOWEST]]
    rows = tuple(
        (
            f"{p.z.real:.6f}" + (f" +-{p.z.imag:.6f}j" if p.z.imag else ""),
            f"{p.s.real:.3g}" + (f" +-{p.s.imag:.4g}j" if p.s.imag else ""),
            f"{p.frequency:.3g}",
            "neutral" if p.is_neutral else f"{p.damping:.3f}",
            f"{p.dominating} ({p.participation:.0%})",
        )
        for p in shown
    )
    title = f"Poles: the {SLOWEST} slowest, and the {LEAST_DAMPED} least damped, of {len(poles)}"
    return Table(title, ("z", "s (1/s)", "Hz", "damping", "dominated by"), rows)


def margin_table(loop: Loop) -> Table:
    """Return the margins of every entry of a loop."""
    header = ("loop", "stable", "gain up", "gain down", "phase", "delay", "disk", "max |S|")
    rows = tuple(
        (
            m.name,
            "yes" if m.stable else "NO",
            _at(m.gain_up, m.gain_up_frequency),
            _at(m.gain_down, m.gain_down_frequency),
            _at(m.phase, m.phase_frequency, " deg"),
            _at(1e3 * m.delay, m.delay_frequency, " ms"),
            _at(m.disk, m.disk_frequency),
            _at(m.peak_sensitivity, m.peak_sensitivity_frequency),
        )
        for m in loop.margins
    )
    return Table(f"Margins, opened at {loop.signal}", header, rows)


def _together(loop: Loop) -> str:
    if loop.together is None:
        return ""
    disk = loop.together.disk
    low, high = disk_gain(disk)
    return (
        f"\nall at once: disk margin {disk:.2f} at {loop.together.disk_frequency:.3g} Hz, "
        f"gains x{low:.2f} to x{high:.2f} or {disk_phase(disk):.0f} deg in every channel"
    )


def as_numbers(analysis: Analysis) -> dict[str, object]:
    """Return an analysis as what JSON can hold."""
    point = analysis.model.operating_point
    return {
        "analysis": analysis.name,
        "scenario": analysis.workpoint.scenario.name,
        "at": analysis.workpoint.at,
        "time_s": point.time,
        "residual": point.residual,
        "states": analysis.model.nstates,
        "cut": list(point.cut),
        "held": list(point.held),
        "poles": [
            {
                "z": [p.z.real, p.z.imag],
                "s": [p.s.real, p.s.imag],
                "frequency_Hz": p.frequency,
                "damping": p.damping,
                "dominating": p.dominating,
                "participation": p.participation,
            }
            for p in analysis.poles
            if p.z
        ],
        "margins": {
            loop.signal: {
                "signals": [_finite(m) for m in loop.margins],
                "disk_together": loop.together.disk if loop.together else None,
            }
            for loop in analysis.loops
        },
        "tables": [{"title": t.title, "header": t.header, "rows": t.rows} for t in analysis.tables],
    }


def _finite(margins: Margins) -> dict[str, object]:
    return {
        key: None if isinstance(value, float) and not math.isfinite(value) else value
        for key, value in vars(margins).items()
    }


def _at(value: float, frequency: float, unit: str = "") -> str:
    """Return a margin and where it is reached; `any` where it is never reached."""
    if not math.isfinite(value) or not math.isfinite(frequency):
        return "any"
    return f"{value:.{2 if value >= 0.1 else 4}f}{unit} ({frequency:.3g} Hz)"


def _damping(pole: Pole) -> float:
    return pole.damping
