"""Block diagrams of any system of the simulation, as SVG, PNG, PDF or DOT.

The SVG links every block to its source file and tells on hovering what flows through a port.
"""

import os
import re
from contextlib import suppress
from pathlib import Path

from pydrake.systems.framework import Diagram

from lola_drake.atomic_file import OutputError, whole_file
from lola_drake.diagram.block import Block
from lola_drake.diagram.card import draw_card
from lola_drake.diagram.drawing import Drawing, to_figure, to_svg
from lola_drake.diagram.graph import read_block
from lola_drake.diagram.layout import ROW, make_sheet
from lola_drake.diagram.paper import advice, save_pdf
from lola_drake.diagram.sheet import Link, draw_sheet
from lola_drake.scenario import load_scenario
from lola_drake.typed_yaml import suggestion
from lola_drake.world import build_simulation

FORMATS = (".svg", ".png", ".pdf", ".dot")
COMMAND = "lola diagram --all --force"

_PICTURES = (
    ("simulation", 1, False, "The closed loop: sensors, controller, plant."),
    ("simulation_depth_2", 2, False, "The closed loop with the controller opened."),
    ("simulation_with_logs", 1, True, "The closed loop with everything that is logged."),
    ("controller", 1, False, "The walking controller, from sensors to joints."),
)
"""File, depth, logs and caption of the pictures with more than one block."""


def block_diagram(
    diagram: Diagram,
    *,
    system: str | None = None,
    depth: int = 1,
    logging: bool = False,
    folder: Path | None = None,
    row: float = ROW,
) -> Drawing:
    """Return the picture of a diagram, or of one system in it.

    Args:
        diagram: Of Drake, for example from `build_simulation`.
        system: The name of a system somewhere inside; None for the whole.
        depth: How many levels to open; 0, or a system without any inside, is drawn alone with
            all that flows at its ports.
        logging: Whether to show the logs and what only they read.
        folder: Where the picture will lie; links to the source files start there. None for no
            links.
        row: Height of a port's row (pt); a live page writes values below the names.

    Raises:
        OutputError: If there is no such system, or it has fewer levels.
    """
    block = _way(read_block(diagram, logging=logging), system)[-1]
    if depth > max(_levels(block), 1):
        raise OutputError(f"depth {depth}: {block.name} has no more than {_levels(block)} to open")
    return _draw(block, depth, _linker(folder), row)


def save_diagram(diagram: Diagram, path: str | Path, **options) -> Path:
    """Write the picture of a diagram into a file; its ending decides the format.

    PDF has as many sheets of A4 side by side as the names of the ports need to be read. DOT is
    Drake's own graph of the system, for other tools that read it.

    Args:
        diagram: Of Drake.
        path: Ends in .svg, .png, .pdf or .dot; a missing folder is made.
        options: See `block_diagram`.

    Raises:
        OutputError: If the file cannot be written, or there is no such system or format.
    """
    path = Path(path)
    if path.suffix not in FORMATS:
        raise OutputError(f"{path}: the name of the file must end in {', '.join(FORMATS)}")
    if path.suffix == ".dot":
        drawing, text = None, _drake_graph(diagram, **options)
    else:
        drawing = block_diagram(diagram, folder=path.parent, **options)
        text = to_svg(drawing)
    with whole_file(path) as file:
        if drawing and path.suffix == ".pdf":
            save_pdf(drawing, file)
        elif drawing and path.suffix == ".png":
            to_figure(drawing).savefig(file, dpi=200)
        else:
            file.write_text(text, encoding="utf-8")
    return path


def write_all(folder: str | Path) -> list[Path]:
    """Write the pictures of the whole simulation and of each of its blocks, and their index.

    The same system gives the same files, byte for byte.
    """
    folder = Path(folder)
    diagram = build_simulation(load_scenario("walk_flat"))
    link = _linker(folder)
    blocks = [read_block(diagram, logging=logging) for logging in (False, True)]
    drawings = {}
    for name, depth, logging, _ in _PICTURES:
        whole = blocks[logging]
        block = whole.child(name) if name == "controller" else whole
        drawings[name] = _draw(block, depth, link)
    files = {f"{name}.svg": to_svg(drawing) for name, drawing in drawings.items()}
    leaves = [block for block in blocks[0].walk() if block.source and not block.children]
    files |= {f"{block.name}.svg": to_svg(_draw(block, 0, link)) for block in leaves}
    files["README.md"] = _index(drawings, leaves, link)
    for name, text in files.items():
        with whole_file(folder / name) as file:
            file.write_text(text, encoding="utf-8")
    return [folder / name for name in files]


def _index(drawings: dict[str, Drawing], blocks: list[Block], link: Link) -> str:
    lines = [
        "# Block diagrams",
        "",
        f"Written by `{COMMAND}`; a test fails when they are out of date. Open a picture to hover",
        "over its blocks, ports and wires, and to follow a block's name to its source file.",
    ]
    for name, _, _, caption in _PICTURES:
        title = name.replace("_", " ").capitalize()
        told = advice(drawings[name])
        about = f"{caption} For paper: {told}." if told else caption
        lines += ["", f"## {title}", "", about, "", f"[![{title}]({name}.svg)]({name}.svg)"]
    lines += ["", "## Every block alone", "", "| block | what it does | equations | source |"]
    lines += ["|---|---|---|---|"]
    for block in blocks:
        equations = ", ".join(map(str, block.equations))
        source = f"[{Path(link(block)).name}]({link(block)})"
        lines.append(f"| [{block.name}]({block.name}.svg) | {block.doc} | {equations} | {source} |")
    return "\n".join(lines) + "\n"


def _levels(block: Block) -> int:
    return max((1 + _levels(child) for child in block.children), default=0)


def _draw(block: Block, depth: int, link: Link, row: float = ROW) -> Drawing:
    if depth < 1 or not block.children:
        return draw_card(block, link)
    return draw_sheet(block, make_sheet(block, depth, row), link)


def _linker(folder: Path | None) -> Link:
    """Return what gives a block's source, or its manual if it is a library's, as a link."""

    def link(block: Block) -> str:
        if folder is None:
            return ""
        if block.source is not None:
            return Path(os.path.relpath(block.source, folder)).as_posix()
        return f"https://drake.mit.edu/pydrake/{block.module}.html#{block.module}.{block.type}"

    return link


def _way(block: Block, name: str | None) -> tuple[Block, ...]:
    """Return the blocks from the outermost to the one called `name`."""
    if name is None or block.name == name:
        return (block,)
    for child in block.children:
        with suppress(OutputError):
            return (block, *_way(child, name))
    known = [inner.name for inner in block.walk()]
    raise OutputError(f"{name}: no such system{suggestion(name, known)}")


def _drake_graph(diagram: Diagram, *, system: str | None = None, depth: int = 1, **_) -> str:
    way = _way(read_block(diagram, logging=True), system)
    for block in way[1:]:
        diagram = diagram.GetSubsystemByName(block.name)
    return _repeatable(diagram.GetGraphvizString(depth))


def _repeatable(dot: str) -> str:
    """Return Drake's DOT text with systems numbered as they appear, and with sorted wires."""
    numbers: dict[str, int] = {}

    def renumber(found: re.Match) -> str:
        return found[1] + str(numbers.setdefault(found[2], len(numbers)))

    lines = re.sub(r"\b(clusters?|s|_)(\d+)", renumber, dot).splitlines(keepends=True)
    wires = iter(sorted(line for line in lines if " -> " in line))
    return "".join(next(wires) if " -> " in line else line for line in lines)
