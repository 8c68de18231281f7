"""The push at which half of the worlds fall, over its direction: a polar plot for every law."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from lola_drake.figures.style import DASHED, FIRST, INK, LEFT, RIGHT, SECOND, THIRD, look

COLOURS = (LEFT, RIGHT, FIRST, SECOND, THIRD, INK)
"""Of the settings in which a law was tried."""

LEAST = 3
"""Directions that make a polar plot."""


def pushes(evaluation: Mapping) -> list[Mapping]:
    """Return the trials of an evaluation that are pushes, by their direction."""
    found = (each for each in evaluation["trials"].values() if each["direction_deg"] is not None)
    return sorted(found, key=lambda trial: trial["direction_deg"])


def push_figure(evaluations: Sequence[Mapping]) -> Figure | None:
    """Return a plot for every law, a line for each setting and variant; `ref` is dashed.

    Forward is up. An open ring is at the largest push that was tried: less than half fell there.
    None where there are too few directions.
    """
    shown = [each for each in evaluations if len(pushes(each)) >= LEAST]
    if not shown:
        return None
    laws = list(dict.fromkeys(each["law"].split()[0] for each in shown))
    settings = list(dict.fromkeys(_setting(each) for each in shown))
    rows, columns = -(-len(laws) // 3), min(len(laws), 3)
    with look():
        figure = Figure(figsize=(0.4 + 2.5 * columns, 0.5 + 2.5 * rows), layout="constrained")
        axes = figure.subplots(rows, columns, subplot_kw={"projection": "polar"}, squeeze=False)
        for ax, law in zip(axes.flat, laws, strict=False):
            for each in (each for each in shown if each["law"].split()[0] == law):
                colour = COLOURS[settings.index(_setting(each)) % len(COLOURS)]
                for variant in pushes(each)[0]["half"]:
                    _line(ax, each, variant, colour)
            ax.set(title=law, rlim=(0, _most(shown)), theta_zero_location="N")
            ax.set_xticks(np.radians([0, 90, 180, 270]), ["forward", "left", "backward", "right"])
            ax.tick_params(pad=1)
            ax.set_rlabel_position(-22)
        for ax in axes.flat[len(laws) :]:
            ax.remove()
        handles = {line.get_label(): line for ax in axes.flat for line in ax.lines}
        figure.legend(
            handles.values(), handles.keys(), loc="outside lower center", ncols=min(columns, 2)
        )
        unit = pushes(shown[0])[0]["unit"]
        figure.suptitle(f"half of the worlds fall at ({unit})", x=0.01, ha="left", fontsize=9)
    return figure


def _setting(evaluation: Mapping) -> str:
    return " ".join(evaluation["law"].split()[1:])


def _most(evaluations: Sequence[Mapping]) -> float:
    """Return the largest push that is drawn."""
    reached = [
        _reach(trial, variant)[0]
        for each in evaluations
        for trial in pushes(each)
        for variant in trial["half"]
    ]
    return 1.05 * max(reached)


def _reach(trial: Mapping, variant: str) -> tuple[float, bool]:
    """Return the push at which half fall, or else the largest that was tried; and whether it is."""
    size = trial["half"][variant]
    return (trial["curves"][variant][-1]["size"], True) if size is None else (size, False)


def _line(ax, evaluation: Mapping, variant: str, colour: str) -> None:
    trials = pushes(evaluation)
    angles = np.radians([trial["direction_deg"] for trial in trials])
    reaches, beyond = map(np.array, zip(*(_reach(t, variant) for t in trials), strict=True))
    label = ", ".join(filter(None, [variant, _setting(evaluation)]))
    style = DASHED if variant == "ref" else "solid"
    ax.plot(*(np.append(x, x[0]) for x in (angles, reaches)), color=colour, ls=style, label=label)
    ax.scatter(angles, reaches, s=12, c=np.where(beyond, "white", colour), ec=colour, zorder=3)
