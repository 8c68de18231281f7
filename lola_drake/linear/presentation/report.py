"""Analyses as text for people, and as plain numbers for programs."""

import math

from lola_drake.linear.margin import Margins, disk_gain, disk_phase
from lola_drake.linear.studies.analyses import Analysis, Loop
from lola_drake.linear.tables import margin_table, pole_table


def report(analysis: Analysis) -> str:
    """Return an analysis as text."""
    parts = [_headline(analysis), pole_table(analysis.poles).as_text()]
    parts += [
        margin_table(loop.signal, loop.margins).as_text() + _together(loop)
        for loop in analysis.loops
    ]
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


def _together(loop: Loop) -> str:
    if loop.together is None:
        return ""
    disk = loop.together.disk
    low, high = disk_gain(disk)
    return (
        f"\nall at once: disk margin {disk:.2f} at {loop.together.disk_frequency:.3g} Hz,\n"
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
