"""Runs in a notebook: a short table of one, and the replay inline."""

from dataclasses import dataclass, field
from html import escape

from lola_drake.results import Result
from lola_drake.view3d.replay import loading_page, packed_replay


@dataclass(frozen=True)
class View:
    """A page that a notebook shows where it is the value of a cell.

    Attributes:
        page: HTML, complete.
        height: Of the frame (pixels).
    """

    page: str = field(repr=False)
    height: int = 480

    def _repr_html_(self) -> str:
        style = f"width: 100%; height: {self.height}px; border: 0; border-radius: 6px"
        return f'<iframe srcdoc="{escape(self.page)}" style="{style}" title="replay"></iframe>'


def show(*results: Result, height: int = 480) -> View:
    """Return the 3D replay of runs, for a notebook; the last one whole, the others as ghosts.

    It holds all it needs (about 2 MB for 10 s); without a notebook write a page and open that:
    `lola.write_report([result], "report.html")`.

    Args:
        results: At least one run.
        height: Of the view (pixels).
    """
    if not results:
        raise ValueError("show: which run? There is none")
    title = ", ".join(f"{result.scenario.name} ({result.scenario.variant})" for result in results)
    return View(loading_page(title, packed_replay(*results)), height)
