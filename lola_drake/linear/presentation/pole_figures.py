"""Poles and zeros: all of them in the z-plane, the slow ones again in the s-plane."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm, Normalize

from lola_drake.linear.frequency import zeros
from lola_drake.linear.presentation.look import COLOURS, FAINT, INK, LIMIT, MAP
from lola_drake.linear.studies.analyses import Analysis, Locus
from lola_drake.scenario_keys import settings

WINDOW = (-160.0, 12.0, 0.0, 45.0)
"""Part of the s-plane that is shown: real part (1/s) and frequency (Hz)."""

MARKED = (0.05, 0.1, 0.2, 0.3, 0.4)
"""Frequencies that are written at the unit circle, in parts of the sample rate."""


def draw_z_plane(axes: Axes, analysis: Analysis) -> None:
    """Draw all poles, those of the root locus too, and the zeros from first input to output."""
    _unit_circle(axes, analysis.model.dt)
    if analysis.locus:
        shades = _colours(analysis.locus).to_rgba(np.array(analysis.locus.values))
        for shade, z in zip(shades, analysis.locus.poles, strict=True):
            axes.plot(*_upper(z), "o", ms=2.5, mew=0, color=shade)
    z = np.array([pole.z for pole in analysis.poles])
    model = analysis.model
    # Those far outside come from sampling: there is one for nearly every pole.
    seen = [zero for zero in zeros(model[0, 0]) if abs(zero) < 1.15]
    axes.plot(*_upper(z), "x", color=INK, ms=4.5, mew=1.0, label=f"{model.nstates} poles")
    axes.plot(*_upper(np.array(seen)), "o", mfc="none", color=COLOURS[0], ms=4.5, label="zeros")
    first = "/".join(model.output_labels[0].split(" ")[0].split("/")[-2:])
    axes.set_title(f"all poles (z); zeros of {first}", fontsize=8.5)
    axes.legend(loc="lower center", ncols=2, bbox_to_anchor=(0.5, -0.02))


def draw_s_plane(axes: Axes, analysis: Analysis) -> None:
    """Draw the slow poles, over a parameter from dark to light; the nominal value is circled."""
    locus, dt = analysis.locus, analysis.model.dt
    nominal = np.array([pole.z for pole in analysis.poles])
    axes.plot(*_slow(nominal, dt), "x", color=INK, ms=4.5, mew=1.0)
    if locus:
        colours = _colours(locus)
        shades = colours.to_rgba(np.array(locus.values))
        for value, shade, z in zip(locus.values, shades, locus.poles, strict=True):
            axes.plot(*_slow(z, dt), "o", ms=3.5, mew=0, color=shade)
            if np.isclose(value, locus.nominal):
                axes.plot(*_slow(z, dt), "o", mfc="none", color=INK, ms=6, mew=0.7)
        label = f"{locus.key} ({settings(locus.key)[0].unit})"
        bar = axes.figure.colorbar(colours, ax=axes, label=label, pad=0.01)
        bar.set_ticks(locus.values, labels=[f"{value:g}" for value in locus.values])
        bar.ax.minorticks_off()
    low, high, bottom, top = WINDOW
    axes.axvline(0.0, color=LIMIT, lw=0.8)
    for damping in (0.1, 0.3, 0.7):
        reach = -damping / np.sqrt(1 - damping**2) * 2 * np.pi * top
        axes.plot([0, reach], [0, top], color=FAINT, lw=0.6, ls=":")
    axes.set(xlim=(low, high), ylim=(bottom, top))
    axes.set(xlabel="real part of s (1/s)", ylabel="imaginary part (Hz)")
    axes.set_title(f"the slow poles (s){'; nominal circled' if locus else ''}", fontsize=8.5)


def _unit_circle(axes: Axes, dt: float) -> None:
    angle = np.linspace(0, np.pi, 200)
    axes.plot(np.cos(angle), np.sin(angle), color=LIMIT, lw=0.8)
    for part in MARKED:
        x, y = np.cos(2 * np.pi * part), np.sin(2 * np.pi * part)
        axes.text(1.06 * x, 1.06 * y, f"{part / dt:g} Hz", fontsize=6.5, ha="center", color=FAINT)
    axes.set(aspect="equal", xlim=(-1.25, 1.25), ylim=(-0.3, 1.2), yticks=(0, 0.5, 1))


def _upper(z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return real and imaginary parts of what is not the lower one of a pair."""
    z = np.asarray(z, dtype=complex)
    upper = z[z.imag > -1e-12]
    return upper.real, upper.imag


def _slow(z: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the poles of the z-plane that are seen in the window of the s-plane, each once."""
    s = np.log(z[np.abs(z) > 1e-6].astype(complex)) / dt
    low, high, bottom, top = WINDOW
    frequency = s.imag / (2 * np.pi)
    seen = (s.real >= low) & (s.real <= high) & (frequency >= bottom) & (frequency <= top)
    s = np.unique((2 * s[seen]).round() / 2)
    return s.real, s.imag / (2 * np.pi)


def _colours(locus: Locus) -> ScalarMappable:
    spread = locus.values[0] > 0 and locus.values[-1] / locus.values[0] > 4
    return ScalarMappable(
        (LogNorm if spread else Normalize)(locus.values[0], locus.values[-1]), MAP
    )
