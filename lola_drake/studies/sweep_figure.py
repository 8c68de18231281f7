"""A sweep as a figure: curves with bands over one key, heat maps over two, else every point."""

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from lola_drake.figures.style import FAINT, FIRST, LEFT, RIGHT, look

COLOURS = {"ref": RIGHT, "dyn": LEFT, "original": FIRST}

SURVIVED = "survived (%)"

WIDTH, ROW = 7.0, 2.6
"""Inches: the width of both columns of a paper, and the height of a row."""


def sweep_figure(content: Mapping) -> Figure:
    """Return the figure of sweep.json: the share that survives above, the metric below."""
    with look():
        keys = list(content["factors"])
        if len(keys) == 1 and _numeric(content, keys[0]):
            return _curves(content, keys[0])
        if len(keys) == 2 and _is_grid(content):
            return _maps(content, keys)
        return _scattered(content, keys)


def _curves(content: Mapping, key: str) -> Figure:
    figure = Figure(figsize=(WIDTH, ROW), layout="constrained")
    survived, metric = figure.subplots(1, 2)
    points = sorted(content["points"], key=lambda point: point["values"][key])
    x = [point["values"][key] for point in points]
    for variant in content["variants"]:
        at = [point["variants"][variant] for point in points]
        shares = [[100 * a["survived"][name] for name in ("share", "low", "high")] for a in at]
        _band(survived, x, np.array(shares), variant)
        medians = [[a["metric"]["median"], *(a["metric"]["interval_95"] or [None] * 2)] for a in at]
        _band(metric, x, np.array(medians, dtype=float), variant)
    survived.set(xlabel=_label(content, key), ylabel=SURVIVED, ylim=(-3, 103))
    metric.set(xlabel=_label(content, key), ylabel=f"{content['metric']}, median", ylim=(0, None))
    survived.legend(loc="lower left")
    return figure


def _band(ax: Axes, x: Sequence[float], rows: np.ndarray, variant: str) -> None:
    """Draw a curve with its interval; `rows` has middle, low and high, shape (n, 3)."""
    colour = COLOURS[variant]
    ax.fill_between(x, rows[:, 1], rows[:, 2], color=colour, alpha=0.15, lw=0)
    ax.plot(x, rows[:, 0], "o-", color=colour, ms=3, lw=1.2, label=variant)


def _maps(content: Mapping, keys: Sequence[str]) -> Figure:
    variants = content["variants"]
    figure = Figure(figsize=(WIDTH, 2 * ROW), layout="constrained")
    rows = figure.subplots(2, len(variants), squeeze=False)
    columns, lines = (content["factors"][key]["values"] for key in keys)
    for axes, name, read in (
        (rows[0], SURVIVED, lambda found: 100 * found["survived"]["share"]),
        (rows[1], f"{content['metric']}, median", lambda found: found["metric"]["median"]),
    ):
        tables = [
            np.array([read(point["variants"][v]) for point in content["points"]], dtype=float)
            for v in variants
        ]
        # The first key is the outer one of the points.
        tables = [table.reshape(len(columns), len(lines)).T for table in tables]
        known = [table[np.isfinite(table)] for table in tables]
        top = max((values.max() for values in known if len(values)), default=1.0)
        for ax, variant, table in zip(axes, variants, tables, strict=True):
            limits = {"vmin": 0.0, "vmax": 100.0 if name == SURVIVED else top}
            image = ax.imshow(table, origin="lower", aspect="auto", cmap="cividis", **limits)
            ax.set_facecolor(FAINT)
            ax.set_xticks(range(len(columns)), map(_short, columns))
            ax.set_yticks(range(len(lines)), map(_short, lines))
            ax.set(xlabel=_label(content, keys[0]), title=variant)
            ax.grid(visible=False)
        axes[0].set_ylabel(_label(content, keys[1]))
        figure.colorbar(image, ax=list(axes), label=name)
    return figure


def _scattered(content: Mapping, keys: Sequence[str]) -> Figure:
    """Draw the metric's median of every point over each key; a cross where not all survived."""
    figure = Figure(figsize=(WIDTH, ROW * len(keys)), layout="constrained")
    for ax, key in zip(figure.subplots(len(keys), 1, squeeze=False)[:, 0], keys, strict=True):
        numeric = _numeric(content, key)
        names = [str(value) for value in content["factors"][key]["values"]]
        for variant in content["variants"]:
            for whole, marker in ((True, "o"), (False, "x")):
                points = [
                    point
                    for point in content["points"]
                    if (point["variants"][variant]["survived"]["share"] == 1) is whole
                ]
                values = [point["values"][key] for point in points]
                x = values if numeric else [names.index(str(value)) for value in values]
                y = [point["variants"][variant]["metric"]["median"] for point in points]
                label = f"{variant}, {'all' if whole else 'not all'} survived"
                style = {"color": COLOURS[variant], "ms": 4, "ls": "none", "alpha": 0.7}
                ax.plot(x, np.array(y, dtype=float), marker, label=label, **style)
        if not numeric:
            ax.set_xticks(range(len(names)), names)
        ax.set(xlabel=_label(content, key), ylabel=f"{content['metric']}\nmedian", ylim=(0, None))
    figure.axes[0].legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2)
    return figure


def _is_grid(content: Mapping) -> bool:
    sizes = [len(factor["values"]) for factor in content["factors"].values()]
    return content["design"] == "grid" and np.prod(sizes) == len(content["points"])


def _numeric(content: Mapping, key: str) -> bool:
    return all(
        isinstance(value, (int, float)) and not isinstance(value, bool)
        for value in content["factors"][key]["values"]
    )


def _label(content: Mapping, key: str) -> str:
    unit = content["factors"][key]["unit"]
    return f"{key} ({unit})" if unit else key


def _short(value: object) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
