"""A drawing made of lines and labels, as SVG written here or as PNG and PDF by Matplotlib.

What is drawn names a style and no colours. The SVG carries two palettes and follows the reader's
choice of light or dark; pixels and paper are light. Lengths are in points, y points downwards.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from html import escape
from typing import Any

PAGE = (785.0, 538.0)
"""A4 landscape within margins of 10 mm (pt)."""

FONTS = "'Helvetica Neue',Helvetica,Arial,'DejaVu Sans',sans-serif"

FILLING = "@media (min-width:1100px){svg:root{width:100%;height:auto;max-height:100vh}}\n"
"""Opened alone it fills a wide window; in a page it has the size of a sheet of paper at most."""

PAPER = "page"
"""The style of what lies below all; in a window of its own the SVG has it all around, too."""

DARK = "@media screen and (prefers-color-scheme:dark)"
"""When an SVG is dark, unless a page says otherwise; paper never is."""

Point = tuple[float, float]
Colours = tuple[str, str]
"""One colour for light and one for dark surroundings."""


@dataclass(frozen=True)
class Style:
    """How one kind of line or label looks; the fill of a label is its colour."""

    fill: Colours | None = None
    stroke: Colours | None = None
    width: float = 1.0
    dash: tuple[float, float] | None = None


@dataclass(frozen=True)
class Line:
    """A polyline or, closed, a polygon, its corners rounded with the radius."""

    style: str
    points: tuple[Point, ...]
    radius: float = 0.0
    closed: bool = False


@dataclass(frozen=True)
class Label:
    """A text beside, before or around a point; `anchor` is start, middle or end."""

    style: str
    x: float
    y: float
    text: str
    size: float = 9.0
    anchor: str = "start"
    bold: bool = False


@dataclass(frozen=True)
class Group:
    """Things that belong together.

    Attributes:
        items: what they are.
        title: a hint that shows on hovering.
        href: a link that opens on clicking.
        style: of the whole.
        signal: what flows there, for scripts in a page around the SVG.
    """

    items: tuple["Line | Label | Group", ...]
    title: str = ""
    href: str = ""
    style: str = ""
    signal: str = ""


Item = Line | Label | Group


@dataclass(frozen=True, repr=False)
class Drawing:
    """A page of items; a notebook shows it as SVG.

    Attributes:
        title, description: For readers that cannot see it, and for search.
        styles: By the names that the items use.
        extra_css: Rules for the SVG beside those of the styles.
    """

    width: float
    height: float
    items: tuple[Item, ...]
    styles: dict[str, Style]
    title: str = ""
    description: str = ""
    extra_css: str = ""

    def __repr__(self):
        return f"<Drawing of {self.title or 'something'}, {self.width:.0f} x {self.height:.0f} pt>"

    def _repr_svg_(self) -> str:
        return to_svg(self)


def rectangle(
    style: str, x: float, y: float, width: float, height: float, radius: float = 0.0
) -> Line:
    """Return a rectangle by its upper left corner."""
    right, bottom = x + width, y + height
    return Line(style, ((x, y), (right, y), (right, bottom), (x, bottom)), radius, closed=True)


def dot(style: str, x: float, y: float, radius: float) -> Line:
    """Return a small disc."""
    return rectangle(style, x - radius, y - radius, 2 * radius, 2 * radius, radius)


def moved(items: Iterable[Item], dx: float, dy: float) -> tuple[Item, ...]:
    """Return the items at another place."""

    def one(item: Item) -> Item:
        if isinstance(item, Group):
            return replace(item, items=moved(item.items, dx, dy))
        if isinstance(item, Line):
            points = tuple((x + dx, y + dy) for x, y in item.points)
            return Line(item.style, points, item.radius, item.closed)
        return Label(
            item.style, item.x + dx, item.y + dy, item.text, item.size, item.anchor, item.bold
        )

    return tuple(one(item) for item in items)


Command = tuple[str, tuple[Point, ...]]
"""M, L, Q or Z, as in SVG, with its points."""


def outline(line: Line) -> list[Command]:
    """Return the line as M, L, Q and Z commands with their points."""
    points = line.points
    commands: list[Command]
    if line.radius <= 0 or len(points) < 3:
        commands = [("L", (point,)) for point in points[1:]]
        return [("M", points[:1]), *commands, *([("Z", ())] if line.closed else [])]
    if line.closed:
        corners = [
            _corner(points[i - 1], points[i], points[(i + 1) % len(points)], line.radius)
            for i in range(len(points))
        ]
        commands = [command for corner in corners for command in corner]
        return [("M", commands[0][1]), *commands[1:], ("Z", ())]
    commands = [("M", points[:1])]
    for before, point, after in zip(points, points[1:], points[2:], strict=False):
        commands += _corner(before, point, after, line.radius)
    return [*commands, ("L", points[-1:])]


def _corner(before: Point, point: Point, after: Point, radius: float) -> list[Command]:
    def toward(other: Point) -> Point:
        length = math.dist(point, other)
        part = min(radius, length / 2) / length if length else 0.0
        return point[0] + part * (other[0] - point[0]), point[1] + part * (other[1] - point[1])

    return [("L", (toward(before),)), ("Q", (point, toward(after)))]


def to_svg(drawing: Drawing, dark: str = DARK) -> str:
    """Return the drawing as an SVG document; wider than a page, it is scaled to fit one.

    Args:
        drawing: What is drawn.
        dark: The CSS rule in which the dark palette stands.
    """
    scale = min(1.0, PAGE[0] / drawing.width, PAGE[1] / drawing.height)
    width, height = (f"{scale * length:.0f}pt" for length in (drawing.width, drawing.height))
    box = f"0 0 {_number(drawing.width)} {_number(drawing.height)}"
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}"'
        f' viewBox="{box}" role="img" font-family="{FONTS}">',
        f"<title>{escape(drawing.title)}</title>",
        f"<desc>{escape(drawing.description)}</desc>",
        f"<style>\n{_css(drawing, dark)}</style>",
        *(_svg(item) for item in drawing.items),
        "</svg>",
    ]
    return "\n".join(parts) + "\n"


def _css(drawing: Drawing, when_dark: str) -> str:
    light, dark = [], []
    for name, style in drawing.styles.items():
        shade = [
            "".join(
                f"{key}:{colours[i] if colours else 'none'};"
                for key, colours in (("fill", style.fill), ("stroke", style.stroke))
            )
            for i in (0, 1)
        ]
        more = f"stroke-width:{_number(style.width)};" if style.stroke else ""
        if style.dash:
            more += f"stroke-dasharray:{' '.join(map(_number, style.dash))};"
        light.append(f".{name}{{{shade[0]}{more}}}\n")
        dark.append(f".{name}{{{shade[1]}}}\n")
        if name == PAPER and style.fill:
            light.append(f"svg:root{{background:{style.fill[0]}}}\n")
            dark.append(f"svg:root{{background:{style.fill[1]}}}\n")
    palette = f"{when_dark}{{\n{''.join(dark)}}}\n"
    return "".join(light) + palette + FILLING + drawing.extra_css


def _svg(item: Item) -> str:
    if isinstance(item, Line):
        path = "".join(
            name + " ".join(f"{_number(x)},{_number(y)}" for x, y in points)
            for name, points in outline(item)
        )
        return f'<path class="{item.style}" d="{path}"/>'
    if isinstance(item, Label):
        bold = ' font-weight="bold"' if item.bold else ""
        # The point is the middle of a small letter's height.
        y = _number(item.y + 0.35 * item.size)
        return (
            f'<text class="{item.style}" x="{_number(item.x)}" y="{y}"'
            f' font-size="{_number(item.size)}" text-anchor="{item.anchor}"{bold}>'
            f"{escape(item.text)}</text>"
        )
    inside = "\n".join(_svg(entry) for entry in item.items)
    title = f"<title>{escape(item.title)}</title>" if item.title else ""
    style, signal = (
        f' {name}="{escape(value)}"' if value else ""
        for name, value in (("class", item.style), ("data-signal", item.signal))
    )
    group = f"<g{style}{signal}>{title}\n{inside}\n</g>"
    return f'<a href="{escape(item.href)}">{group}</a>' if item.href else group


def _number(value: float) -> str:
    return f"{value:.2f}".rstrip("0").rstrip(".")


def to_figure(drawing: Drawing):
    """Return the drawing as a Matplotlib figure, in light colours."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(drawing.width / 72, drawing.height / 72))
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set(xlim=(0, drawing.width), ylim=(drawing.height, 0))
    plot_items(axes, drawing)
    return figure


def plot_items(axes, drawing: Drawing, scale: float = 1.0) -> None:
    """Plot a drawing into Matplotlib's axes in which one of its points is `scale` points."""
    axes.axis("off")
    for item in drawing.items:
        _plot(axes, item, drawing.styles, scale)


def _plot(axes, item: Item, styles: dict[str, Style], scale: float) -> None:
    from matplotlib.patches import PathPatch
    from matplotlib.path import Path

    if isinstance(item, Group):
        for entry in item.items:
            _plot(axes, entry, styles, scale)
        return
    style = styles[item.style]
    fill, stroke = (colours[0] if colours else "none" for colours in (style.fill, style.stroke))
    if isinstance(item, Label):
        anchor = {"start": "left", "middle": "center", "end": "right"}[item.anchor]
        weight = "bold" if item.bold else "normal"
        axes.text(
            *(item.x, item.y, item.text),
            **{"fontsize": 0.9 * scale * item.size, "ha": anchor, "va": "center_baseline"},
            **{"color": fill, "weight": weight, "family": "DejaVu Sans", "clip_on": True},
        )
        return
    codes = {"M": (Path.MOVETO,), "L": (Path.LINETO,), "Q": (Path.CURVE3,) * 2}
    points: list[Point] = []
    commands: list[Any] = []  # Matplotlib's codes
    for name, ends in outline(item):
        points += ends or [item.points[0]]
        commands += codes.get(name, (Path.CLOSEPOLY,))
    pen = {"lw": scale * style.width} | ({"linestyle": (0, style.dash)} if style.dash else {})
    path = Path(points, commands)
    axes.add_patch(PathPatch(path, facecolor=fill, edgecolor=stroke, **pen))
