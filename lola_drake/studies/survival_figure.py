"""The share of worlds survived, over the height of what was not expected."""

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure

from lola_drake.figures.style import LEFT, RIGHT, look
from lola_drake.studies.survival import OBSTACLES

COLOURS = {"ref": RIGHT, "dyn": LEFT}


def survival_figure(content: Mapping) -> Figure:
    """Return the curves of survival.json, each with its interval as a band."""
    centimetres = 100 * np.array(content["heights_m"])
    with look():
        figure = Figure(figsize=(7.0, 2.6), layout="constrained")
        axes = figure.subplots(1, len(OBSTACLES), sharey=True)
        for ax, (name, obstacle) in zip(axes, OBSTACLES.items(), strict=True):
            for variant, points in content["survived"][name].items():
                share, low, high = (
                    100 * np.array([point[key] for point in points])
                    for key in ("share", "low", "high")
                )
                colour = COLOURS[variant]
                ax.fill_between(centimetres, low, high, color=colour, alpha=0.15, lw=0)
                ax.plot(centimetres, share, "o-", color=colour, ms=3, lw=1.2, label=variant)
            ax.set(xlabel="height (cm)", ylim=(-3, 103), title=obstacle.title)
        axes[0].set_ylabel(f"survived of {content['worlds']} worlds (%)")
        axes[0].legend(loc="lower left")
    return figure
