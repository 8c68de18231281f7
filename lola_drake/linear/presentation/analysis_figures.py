"""The picture of an analysis: Bode, Nyquist, S and T, poles and zeros, steps, root locus."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lola_drake.figures.style import add_title
from lola_drake.linear.frequency import Response, frequency_grid, frequency_response
from lola_drake.linear.margin import Margins, disk_gain
from lola_drake.linear.margins import one_loop
from lola_drake.linear.presentation.look import COLOURS, FAINT, INK, LIMIT, in_look
from lola_drake.linear.presentation.pole_figures import draw_s_plane, draw_z_plane
from lola_drake.linear.studies.analyses import Analysis, settled_step
from lola_drake.linear.studies.tables import contact_responses, controllers_gradient
from lola_drake.robot import PADS
from lola_drake.theory.contact_model import contact_matrix

LOWEST = 0.05
"""Lowest frequency of the Bode plots (Hz)."""

FINE = 0.03
"""How far a curve moves between two points that are drawn (part of its value)."""

REACH = 2.6
"""How far from zero a Nyquist curve is shown."""


@in_look
def analysis_figure(analysis: Analysis) -> Figure:
    """Return the picture of an analysis."""
    right = bool(analysis.loops) or analysis.name == "contact"
    figure = Figure(figsize=(16.0 if right else 12.0, 7.2), layout="constrained")
    place = analysis.workpoint.situation.description
    add_title(figure, f"{analysis.name}: {analysis.definition.doc} ({place})")
    grid = figure.add_gridspec(6, 4 if right else 3)
    curves, note = _curves(analysis)
    gain, phase = (figure.add_subplot(grid[rows, 0]) for rows in _shares(2))
    draw_bode(gain, phase, curves)
    gain.set_title(note, fontsize=8.5)
    draw_z_plane(figure.add_subplot(grid[:3, 1]), analysis)
    draw_s_plane(figure.add_subplot(grid[3:, 1]), analysis)
    for k, rows in enumerate(_shares(len(analysis.definition.steps))):
        draw_step(figure.add_subplot(grid[rows, 2]), analysis, k)
    if analysis.loops:
        draw_nyquist(figure.add_subplot(grid[:3, 3]), curves)
        draw_sensitivity(figure.add_subplot(grid[3:, 3]), curves)
    elif right:
        draw_contact(figure.add_subplot(grid[:3, 3]), analysis)
    return figure


def _shares(count: int) -> list[slice]:
    """Return the rows of a grid of six for one, two or three pictures above each other."""
    return [slice(6 // count * k, 6 // count * (k + 1)) for k in range(count)]


def draw_bode(gain: Axes, phase: Axes, curves: dict[str, Response]) -> None:
    """Draw gain (dB) and phase (deg) over frequency."""
    for colour, (name, response) in zip(COLOURS, curves.items(), strict=False):
        values = response.values.ravel()
        gain.semilogx(response.frequencies, _dB(values), color=colour, label=name)
        angle = np.degrees(np.unwrap(np.angle(values)))
        # At 1 Hz between -270 and 90 deg.
        middle = angle[np.abs(np.log(response.frequencies)).argmin()]
        angle -= 360.0 * np.ceil((middle - 90.0) / 360.0)
        phase.semilogx(response.frequencies, angle, color=colour)
    gain.axhline(0.0, color=FAINT, lw=0.8)
    gain.set(ylabel="gain (dB)", ylim=(max(gain.get_ylim()[0], -80.0), None))
    phase.axhline(-180.0, color=FAINT, lw=0.8)
    phase.set(xlabel="frequency (Hz)", ylabel="phase (deg)", ylim=(-540, 200))
    phase.set_yticks(np.arange(-540, 181, 90))
    # The phase falls towards the right: its lower left is free.
    phase.legend(*gain.get_legend_handles_labels(), loc="lower left", fontsize=7)


def draw_nyquist(axes: Axes, curves: dict[str, Response]) -> None:
    """Draw the loops in the plane of L, and the disk that the most critical one touches."""
    angle = np.linspace(0, 2 * np.pi, 200)
    axes.plot(np.cos(angle), np.sin(angle), color=FAINT, lw=0.6, ls=":")
    for colour, response in zip(COLOURS, curves.values(), strict=False):
        L = response.values.ravel()
        axes.plot(L.real, L.imag, color=colour)
    disk = min(_disk(response) for response in curves.values())
    low, high = disk_gain(disk)
    if np.isfinite(high):
        centre, radius = -(1 / low + 1 / high) / 2, (1 / low - 1 / high) / 2
        axes.fill(
            centre + radius * np.cos(angle), radius * np.sin(angle), color=LIMIT, alpha=0.15, lw=0
        )
    axes.plot(-1, 0, "+", color=LIMIT, ms=8, mew=1.4)
    axes.set(aspect="equal", xlim=(-REACH, REACH), ylim=(-REACH, REACH))
    axes.set(xlabel="real part of L", ylabel="imaginary part")
    axes.set_title(f"Nyquist, and the disk of {disk:.3g} around -1", fontsize=8.5)


def draw_sensitivity(axes: Axes, curves: dict[str, Response]) -> None:
    """Draw the gains of S and T; the peak of S is the inverse distance of L from -1."""
    for colour, response in zip(COLOURS, curves.values(), strict=False):
        L = response.values.ravel()
        axes.semilogx(response.frequencies, _dB(1 / (1 + L)), color=colour)
        axes.semilogx(response.frequencies, _dB(L / (1 + L)), color=colour, ls="--", lw=0.8)
    axes.axhline(6.0, color=LIMIT, lw=0.8, ls=":")
    axes.set(xlabel="frequency (Hz)", ylabel="gain (dB)", ylim=(-40, None))
    axes.set_title("S = 1/(1 + L), dashed T = L/(1 + L)", fontsize=8.5)


def draw_step(axes: Axes, analysis: Analysis, k: int) -> None:
    """Draw the response of one output to a step at the input of the same number."""
    height = analysis.definition.steps[k]
    moved, answers = analysis.definition.units[k]
    times, outputs, settled = settled_step(analysis.model, k, height)
    axes.plot(1e3 * times, outputs[:, k], color=COLOURS[k % len(COLOURS)])
    axes.axhline(0.0, color=FAINT, lw=0.8)
    inputs, names = analysis.model.input_labels, analysis.model.output_labels
    axes.set_title(
        f"{_short(inputs[k], 1)} + {height:g} {moved}{'' if settled else ', not settled'}",
        fontsize=8.5,
    )
    axes.set(ylabel=f"{_short(names[k], 2)} ({answers})", xlabel="time (ms)")
    axes.ticklabel_format(axis="y", style="sci", scilimits=(-2, 3))


def draw_contact(axes: Axes, analysis: Analysis) -> None:
    """Draw the contact's stiffness over that of the ground's U, and what the controller meets."""
    scenario = analysis.workpoint.scenario
    area = sum(pad.area for pad in PADS)
    U = np.diag(contact_matrix(PADS, scenario.ground.stiffness / area))
    frequencies = np.geomspace(0.5, 60.0, 150)
    contact, met = contact_responses(analysis.workpoint, frequencies)
    for k, (colour, name) in enumerate(zip(COLOURS, ("T_x", "T_y", "F_z"), strict=False)):
        axes.loglog(frequencies, np.abs(contact[:, k, k] / U[k]), color=colour, label=name)
        axes.loglog(frequencies, np.abs(met[:, k, k] / U[k]), color=colour, ls="--")
    for share in np.diag(controllers_gradient(scenario)) / U:
        axes.axhline(share, color=INK, lw=0.8, ls=":")
    axes.plot([], [], color=INK, lw=0.8, ls=":", label="U of the controller")
    axes.set(xlabel="frequency (Hz)", ylim=(0.1, 10.0))
    axes.set_title("stiffness over U (dashed: as met)")
    axes.legend(loc="upper right")


def _curves(analysis: Analysis) -> tuple[dict[str, Response], str]:
    """Return the responses to draw, and a line that says which they are.

    Those of the loops of least disk margin, each with the others closed; or those of the model.
    """
    model = analysis.model
    if not analysis.loops:
        pairs = range(min(model.ninputs, model.noutputs))
        return {_short(model.output_labels[k]): _response(model[k, k]) for k in pairs}, "response"
    ranked: list[tuple[Margins, Response]] = []
    for loop in analysis.loops:
        for k, margins in enumerate(loop.margins):
            ranked.append((margins, _response(one_loop(loop.transfer, k))))
    ranked.sort(key=lambda found: found[0].disk)
    shown: dict[str, Response] = {}
    for margins, response in ranked:
        if len(shown) < len(COLOURS) and not _is_among(response, shown):
            shown[f"{_short(margins.name)}: {margins.disk:.2g}"] = response
    if len(shown) == len(ranked):
        return shown, f"all {len(ranked)} loops, and their disk margins"
    return (
        shown,
        f"{len(shown)} of {len(ranked)} loops: the others lie on these, or are more robust",
    )


def _response(system) -> Response:
    """Return the response at as many frequencies as a picture needs."""
    grid = frequency_grid(system)
    response = frequency_response(system, grid[grid >= LOWEST])
    values = np.log(response.values.ravel() + 1e-300)
    track = values + np.log(response.frequencies)
    kept, last = [], np.inf
    for k, value in enumerate(track):
        if abs(value - last) > FINE or k == len(track) - 1:
            kept.append(k)
            last = value
    return Response(response.frequencies[kept], response.values[kept])


def _is_among(response: Response, others: dict[str, Response]) -> bool:
    """Return whether a response lies on another one, such as that of the other foot."""
    x, y = np.log(response.frequencies), response.values.ravel()
    for other in others.values():
        at = np.interp(x, np.log(other.frequencies), other.values.ravel())
        if np.allclose(at, y, rtol=0.03, atol=0.01 * np.abs(y).max()):
            return True
    return False


def _disk(response: Response) -> float:
    L = response.values.ravel()
    return float(2 / np.abs((1 - L) / (1 + L)).max())


def _short(label: str, parts: int = 3) -> str:
    return "/".join(label.split(" ")[0].split("/")[-parts:])


def _dB(values: np.ndarray) -> np.ndarray:
    return 20 * np.log10(np.maximum(np.abs(values), 1e-12))
