"""A drawing on sheets of A4: side by side, as many as its names need to be read.

Neighbours share what room is left, so that a block in which one ends is whole on the other.
"""

from pathlib import Path

from lola_drake.diagram.drawing import PAGE, Drawing, plot_items

SHEET = (842.0, 595.0)
"""A4 landscape (pt)."""

NAME, LEAST = 9.5, 6.0
"""Size of a port's name in a drawing, and the least on paper (pt)."""

MOST = 6
"""Sheets; what is still too small on these stays so."""


def sheets(drawing: Drawing) -> tuple[int, float]:
    """Return on how many sheets a drawing goes, and its scale there."""
    for count in range(1, MOST + 1):
        scale = min(1.0, count * PAGE[0] / drawing.width, PAGE[1] / drawing.height)
        if NAME * scale >= LEAST:
            break
    return count, scale


def windows(drawing: Drawing) -> list[tuple[float, float]]:
    """Return from where to where in a drawing each of its sheets goes."""
    count, scale = sheets(drawing)
    width = PAGE[0] / scale
    step = (drawing.width - width) / (count - 1) if count > 1 else 0.0
    return [(sheet * step, sheet * step + width) for sheet in range(count)]


def advice(drawing: Drawing) -> str:
    """Return what to know before a drawing is printed on one sheet; nothing if it can be read."""
    count, _ = sheets(drawing)
    if count == 1:
        return ""
    size = NAME * min(PAGE[0] / drawing.width, PAGE[1] / drawing.height)
    return f"on one sheet of A4 its names are {size:.1f} pt high; as PDF it takes {count} sheets"


def save_pdf(drawing: Drawing, path: Path) -> None:
    """Write a drawing as PDF, a page for each sheet, in light colours."""
    from matplotlib.backends.backend_pdf import PdfPages
    from matplotlib.figure import Figure

    _, scale = sheets(drawing)
    left, low = ((1 - inner / outer) / 2 for inner, outer in zip(PAGE, SHEET, strict=True))
    with PdfPages(path) as pages:
        for window in windows(drawing):
            figure = Figure(figsize=(SHEET[0] / 72, SHEET[1] / 72))
            axes = figure.add_axes((left, low, 1 - 2 * left, 1 - 2 * low))
            axes.set(xlim=window, ylim=(PAGE[1] / scale, 0))
            plot_items(axes, drawing, scale)
            pages.savefig(figure)
