"""The frequency response of the nonlinear simulation, measured as on a test bench.

A sum of sines is added to one entry of a signal and the loop runs, contact and all. What comes
back at another entry is fitted by the same sines: no linear model has a part in it.
"""

from collections.abc import Sequence

import numpy as np

from lola_drake.linear.frequency import Response, frequency_response
from lola_drake.linear.studies.analyses import Analysis
from lola_drake.linear.studies.operating_points import Situation
from lola_drake.linear.text_table import Table
from lola_drake.linear.tick_loop import TickLoop

FREQUENCIES = (0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0, 10.0, 14.0, 19.0, 25.0, 30.0, 40.0, 60.0)
LIMIT = 30.0
"""Up to which frequency model and simulation are compared (Hz)."""

PART_OF_STEP = 0.2
"""Amplitude of each sine over the height of an analysis's step."""

TREND = 3
"""Degree of the polynomial that takes up the slow motions which the start has excited."""


def measured_response(
    situation: Situation,
    signal: str,
    output: str,
    amplitude: float,
    frequencies: Sequence[float] = FREQUENCIES,
    settling: float = 2.0,
    duration: float = 4.0,
) -> Response:
    """Return the response of one entry to what is added to another one.

    Args:
        situation: the operating point.
        signal: name of the entry that is disturbed.
        output: name of the entry that is measured.
        amplitude: of each sine, in the unit of `signal`.
        frequencies: of the sines (Hz).
        settling: time before the measurement (s).
        duration: of the measurement (s); a multiple of the slowest sine's period.
    """
    ticks = TickLoop(situation.diagram, situation.context)
    count, first = round((settling + duration) / ticks.period), round(settling / ticks.period)
    time = ticks.period * np.arange(count)
    angles = 2 * np.pi * np.outer(time, frequencies)
    # Schroeder's phases keep the sum of the sines low.
    order = np.arange(len(frequencies))
    angles -= np.pi * order * (order + 1) / len(frequencies)
    added = amplitude * np.cos(angles).sum(axis=1, keepdims=True)
    measured = ticks.run([output], count, signal, added)[first:, 0]
    trend = np.vander(time[first:] / duration, TREND + 1)
    regressors = np.hstack([np.cos(angles[first:]), np.sin(angles[first:]), trend])
    fit = np.linalg.lstsq(regressors, measured, rcond=None)[0]
    n = len(frequencies)
    values = (fit[:n] - 1j * fit[n : 2 * n]) / amplitude
    return Response(np.array(frequencies), values.reshape(-1, 1, 1))


def deviation(measured: Response, model: Response) -> tuple[np.ndarray, np.ndarray]:
    """Return measured over model: gain in dB and phase in degrees, each of shape (n,)."""
    ratio = measured.values[:, 0, 0] / model.values[:, 0, 0]
    return 20 * np.log10(np.abs(ratio)), np.degrees(np.angle(ratio))


def compare(analysis: Analysis) -> tuple[dict[str, Response], dict[str, Response], Table]:
    """Measure each input of an analysis to the output of the same number, and compare.

    Returns:
        The linear responses on a fine grid, the measured ones, and their largest deviations.
    """
    models, measured, rows = {}, {}, []
    fine = np.geomspace(min(FREQUENCIES), 2 * max(FREQUENCIES), 400)
    pairs = zip(analysis.definition.inputs, analysis.definition.outputs, strict=False)
    for k, (signal, output) in enumerate(pairs):
        name = f"{signal} -> {output}"
        amplitude = PART_OF_STEP * analysis.definition.steps[k]
        measured[name] = measured_response(analysis.workpoint.situation, signal, output, amplitude)
        model = analysis.model[k, k]
        models[name] = frequency_response(model, fine)
        gain, phase = deviation(measured[name], frequency_response(model, np.array(FREQUENCIES)))
        low = np.array(FREQUENCIES) <= LIMIT
        rows.append((name, f"{np.abs(gain[low]).max():.3f}", f"{np.abs(phase[low]).max():.3f}"))
    header = ("from -> to", "gain (dB)", "phase (deg)")
    title = f"Largest deviation of the simulation from the linear model up to {LIMIT:g} Hz"
    return models, measured, Table(title, header, tuple(rows))
