"""Pictures of the analyses: Bode, sensitivity, poles and zeros, steps, root locus."""

import numpy as np
import scipy.linalg
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure

from lola_drake.figures.style import add_title
from lola_drake.linear.frequency import Response, frequency_response
from lola_drake.linear.margins import one_loop
from lola_drake.linear.presentation.look import COLOURS, FAINT, INK, LIMIT, MAP, in_look
from lola_drake.linear.studies.analyses import Analysis, Locus, step_response
from lola_drake.linear.studies.tables import contact_responses, controllers_gradient
from lola_drake.robot import PADS
from lola_drake.theory.contact_model import contact_matrix

SHOWN = np.geomspace(0.05, 500.0, 400)
"""Frequencies of the Bode plots (Hz)."""

QUIETEST = 0.1
"""A loop whose gain is below this everywhere is left out of the pictures."""

WINDOW = (-160.0, 12.0, 0.0, 45.0)
"""Part of the s-plane that is shown: real part (1/s) and frequency (Hz)."""


@in_look
def analysis_figure(analysis: Analysis) -> Figure:
    """Return the picture of an analysis."""
    figure = Figure(figsize=(12.0, 6.4), layout="constrained")
    title = (
        f"{analysis.name}: {analysis.definition.doc} ({analysis.workpoint.situation.description})"
    )
    add_title(figure, title)
    axes = figure.subplots(2, 3, width_ratios=(1.2, 1.0, 1.0))
    curves = _curves(analysis)
    draw_bode(axes[0, 0], axes[1, 0], curves)
    axes[0, 0].set_title("open loop" if analysis.loops else "response")
    draw_poles_and_zeros(axes[0, 1], analysis)
    if analysis.locus:
        draw_locus(axes[1, 1], analysis.locus)
    draw_steps(axes[0, 2], analysis)
    if analysis.loops:
        draw_sensitivity(axes[1, 2], curves)
    elif analysis.name == "contact":
        draw_contact(axes[1, 2], analysis)
    else:
        axes[1, 2].set_axis_off()
    return figure


def draw_bode(gain: Axes, phase: Axes, curves: dict[str, Response]) -> None:
    """Draw gain (dB) and phase (deg) over frequency."""
    for colour, (name, response) in zip(COLOURS, curves.items(), strict=False):
        values = response.values.ravel()
        gain.semilogx(response.frequencies, _dB(values), color=colour, label=name)
        angle = np.degrees(np.unwrap(np.angle(values)))
        angle -= 360.0 * np.round(angle[len(angle) // 3] / 360.0)
        phase.semilogx(response.frequencies, angle, color=colour)
    gain.axhline(0.0, color=FAINT, lw=0.8)
    gain.set(ylabel="gain (dB)", ylim=(max(gain.get_ylim()[0], -80.0), None))
    phase.axhline(-180.0, color=FAINT, lw=0.8)
    phase.set(xlabel="frequency (Hz)", ylabel="phase (deg)", ylim=(-540, 200))
    phase.set_yticks(np.arange(-540, 181, 90))
    # The phase falls towards the right: its lower left is free.
    phase.legend(*gain.get_legend_handles_labels(), loc="lower left")


def draw_sensitivity(axes: Axes, curves: dict[str, Response]) -> None:
    """Draw the gain of S = 1/(1 + L); its peak is the inverse distance of L from -1."""
    for colour, response in zip(COLOURS, curves.values(), strict=False):
        axes.semilogx(response.frequencies, _dB(1 / (1 + response.values.ravel())), color=colour)
    axes.axhline(6.0, color=LIMIT, lw=0.8, ls=":")
    axes.set(title="sensitivity 1/(1 + L)", xlabel="frequency (Hz)", ylabel="gain (dB)")
    axes.set_ylim(-30, None)


def draw_poles_and_zeros(axes: Axes, analysis: Analysis) -> None:
    """Draw poles of the model, and zeros from its first input to its first output."""
    s = _s(np.array([pole.z for pole in analysis.poles]))
    axes.plot(s.real, s.imag / (2 * np.pi), "x", color=INK, ms=5, mew=1.2, label="poles")
    zeros = _zeros(analysis)
    axes.plot(
        zeros.real, zeros.imag / (2 * np.pi), "o", mfc="none", color=COLOURS[0], ms=5, label="zeros"
    )
    _s_plane(axes)
    axes.set_title(f"poles; zeros of {analysis.model.output_labels[0]}", fontsize=8.5)
    axes.legend(loc="center left", bbox_to_anchor=(0.0, 0.75))


def draw_locus(axes: Axes, locus: Locus) -> None:
    """Draw the poles over a parameter, from dark to light; the nominal value is circled."""
    spread = locus.values[0] > 0 and locus.values[-1] / locus.values[0] > 4
    norm = (LogNorm if spread else Normalize)(locus.values[0], locus.values[-1])
    colours = ScalarMappable(norm, MAP)
    for value, z in zip(locus.values, locus.poles, strict=True):
        s = _s(z)
        axes.plot(s.real, s.imag / (2 * np.pi), "o", ms=3.5, mew=0, color=colours.to_rgba(value))
        if np.isclose(value, locus.nominal):
            axes.plot(s.real, s.imag / (2 * np.pi), "o", mfc="none", color=INK, ms=6, mew=0.7)
    bar = axes.figure.colorbar(colours, ax=axes, label=locus.key, pad=0.01)
    bar.set_ticks(locus.values, labels=[f"{value:g}" for value in locus.values])
    bar.ax.minorticks_off()
    _s_plane(axes)
    axes.set_title(f"root locus over {locus.key.split('.')[-1]} (nominal circled)")


def draw_steps(axes: Axes, analysis: Analysis) -> None:
    """Draw the response of each output to a step at the input of the same number."""
    lowest = 0.0
    for k, (colour, height) in enumerate(zip(COLOURS, analysis.definition.steps, strict=False)):
        times, outputs = step_response(analysis.model, k, height)
        moved, answers = analysis.definition.units[k]
        largest = np.abs(outputs[:, k]).max() or 1.0
        name = analysis.model.input_labels[k].split("/")[-1]
        label = f"{name}: {height:g} {moved}, at most {largest:.2g} {answers}"
        axes.plot(1e3 * times, outputs[:, k] / largest, color=colour, label=label)
        lowest = min(lowest, (outputs[:, k] / largest).min())
    axes.axhline(0.0, color=FAINT, lw=0.8)
    axes.set(title="steps, each over its largest value", xlabel="time (ms)")
    # Above 1 there is room for the legend alone.
    axes.set(ylim=(lowest - 0.1, 1.1 + 0.45 * (1.1 - lowest)), yticks=_halves(lowest))
    axes.legend(loc="upper right")


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


def _curves(analysis: Analysis) -> dict[str, Response]:
    """Return the responses to draw: of every loop with the others closed, or of the model."""
    if not analysis.loops:
        response = frequency_response(analysis.model, SHOWN).values
        n = min(response.shape[1:])
        return {
            _short(analysis.model.output_labels[k]): Response(SHOWN, response[:, k, k])
            for k in range(n)
        }
    found = {}
    for loop in analysis.loops:
        for k, name in enumerate(loop.transfer.input_labels):
            response = frequency_response(one_loop(loop.transfer, k), SHOWN)
            if np.abs(response.values).max() > QUIETEST and not _is_among(response, found):
                found[_short(name)] = response
    return dict(list(found.items())[: len(COLOURS)])


def _is_among(response: Response, others: dict[str, Response]) -> bool:
    """Return whether a response lies on another one, such as that of the other foot."""
    return any(np.allclose(response.values, other.values, rtol=1e-2) for other in others.values())


def _halves(lowest: float) -> np.ndarray:
    """Return the multiples of a half from a number up to 1."""
    return np.arange(np.ceil(2 * lowest), 3) / 2


def _zeros(analysis: Analysis) -> np.ndarray:
    """Return the zeros from the first input to the first output, in the s-plane."""
    model = analysis.model
    pencil = np.block([[model.A, model.B[:, :1]], [model.C[:1], model.D[:1, :1]]])
    mass = scipy.linalg.block_diag(np.eye(model.nstates), np.zeros((1, 1)))
    z = scipy.linalg.eigvals(pencil, mass)
    return _s(z[np.isfinite(z) & (np.abs(z) < 2)])


def _s(z: np.ndarray) -> np.ndarray:
    """Return the poles of the z-plane that are seen in the window of the s-plane.

    Those that lie on each other there appear once.
    """
    s = np.log(z[np.abs(z) > 1e-6].astype(complex)) * 1e3
    low, high, bottom, top = WINDOW
    frequency = s.imag / (2 * np.pi)
    seen = (s.real >= low) & (s.real <= high) & (frequency >= bottom) & (frequency <= top)
    return np.unique((2 * s[seen]).round() / 2)


def _s_plane(axes: Axes) -> None:
    low, high, bottom, top = WINDOW
    axes.axvline(0.0, color=LIMIT, lw=0.8)
    for damping in (0.1, 0.3, 0.7):
        imaginary = 2 * np.pi * top
        real = -damping / np.sqrt(1 - damping**2) * imaginary
        axes.plot([0, real], [0, top], color=FAINT, lw=0.6, ls=":")
    axes.set(xlim=(low, high), ylim=(bottom, top))
    axes.set(xlabel="real part of s (1/s)", ylabel="imaginary part (Hz)")


def _short(label: str) -> str:
    return "/".join(label.split("/")[-3:])


def _dB(values: np.ndarray) -> np.ndarray:
    return 20 * np.log10(np.maximum(np.abs(values), 1e-12))
