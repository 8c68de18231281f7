"""Block diagrams: complete, legible, the same every time, and those in the repository current."""

import re
import xml.etree.ElementTree as ElementTree
from itertools import combinations, pairwise
from pathlib import Path

import pytest
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import Gain, ZeroOrderHold

from lola_drake.atomic_file import OutputError
from lola_drake.diagram.block_diagram import COMMAND, block_diagram, save_diagram, write_all
from lola_drake.diagram.drawing import PAGE
from lola_drake.diagram.graph import read_block
from lola_drake.diagram.layout import make_box, make_sheet
from lola_drake.diagram.paper import NAME, advice, sheets, windows
from lola_drake.diagram.sheet import draw_sheet
from lola_drake.scenario import load_scenario
from lola_drake.world import build_simulation

COMMITTED = Path(__file__).parents[2] / "diagrams"


@pytest.fixture(scope="module")
def simulation():
    return build_simulation(load_scenario("walk_flat"))


@pytest.fixture(scope="module")
def controller(simulation):
    return read_block(simulation).child("controller")


def test_committed_diagrams_are_current(tmp_path):
    # Beside the package, as the committed folder is: links are part of the pictures.
    written = write_all(COMMITTED.parent / f".{tmp_path.name}-diagrams")
    try:
        fresh = {path.name: path.read_bytes() for path in written}
    finally:
        for path in written:
            path.unlink()
        written[0].parent.rmdir()
    present = {path.name: path.read_bytes() for path in COMMITTED.iterdir()}
    stale = {name for name in fresh | present if fresh.get(name) != present.get(name)}
    assert not stale, f"out of date, run `{COMMAND}`: {sorted(stale)}"


def test_every_wire_of_the_controller_is_drawn(simulation, controller):
    sheet = make_sheet(controller)
    drawn = {(wire.net.source, sink) for wire in sheet.wires for sink in wire.net.sinks if sink[0]}
    system = simulation.GetSubsystemByName("controller")
    wired = {
        (
            (source.get_name(), source.get_output_port(output).get_name()),
            (target.get_name(), target.get_input_port(port).get_name()),
        )
        for (target, port), (source, output) in system.connection_map().items()
    }
    assert wired and wired <= drawn
    for wire in sheet.wires:
        assert len(wire.lines) == len(wire.net.sinks)


def test_signals_for_logs_only_are_left_out_unless_asked_for(simulation, controller):
    assert [port.name for port in controller.outputs] == [
        "joint_desired_state",
        "joint_feedforward",
    ]
    names = {child.name for child in read_block(simulation).children}
    assert names.isdisjoint({"log", "log_multiplexer"})
    logged = read_block(simulation, logging=True)
    assert {child.name for child in logged.children if child.kind == "logging"} == {
        "log",
        "log_multiplexer",
    }
    exported = [port.name for port in logged.child("controller").outputs]
    assert {"task_reference", "com_dynamics_rate_l"} <= set(exported)


def segments(wire):
    return [segment for line in wire.lines for segment in pairwise(line)]


@pytest.mark.parametrize("depth", [1, 2])
@pytest.mark.parametrize("logging", [False, True])
def test_wires_are_rectangular_and_keep_out_of_blocks(simulation, depth, logging):
    sheet = make_sheet(read_block(simulation, logging=logging), depth)
    for wire in sheet.wires:
        for (x1, y1), (x2, y2) in segments(wire):
            assert x1 == x2 or y1 == y2
            for box in sheet.boxes:
                outside = (
                    max(x1, x2) <= box.x
                    or min(x1, x2) >= box.x + box.width
                    or max(y1, y2) <= box.y
                    or min(y1, y2) >= box.y + box.height
                )
                assert outside, f"{wire.net.source} runs through {box.content.name}"


def test_no_two_signals_run_on_top_of_each_other(controller):
    for first, second in combinations(make_sheet(controller).wires, 2):
        for a, b in segments(first):
            for c, d in segments(second):
                for along, across in ((0, 1), (1, 0)):
                    if a[across] == b[across] == c[across] == d[across]:
                        (low, high), (start, end) = (
                            sorted((p[along], q[along])) for p, q in ((a, b), (c, d))
                        )
                        assert min(high, end) <= max(low, start), (first.net, second.net)


def test_the_controller_fits_a_page_and_can_be_read(controller):
    drawing = draw_sheet(controller, make_sheet(controller), lambda block: "")
    scale = min(PAGE[0] / drawing.width, PAGE[1] / drawing.height)
    assert 9.5 * scale >= 6.0  # points: the size of a footnote


def test_ports_tell_what_follows_at_once_and_what_a_state_holds(controller):
    force_control = controller.child("force_control_l")
    held = {port.name for port in force_control.outputs if port.held}
    assert held == {"task_modification"}
    assert ("measured_wrench", "contact_wrench") in force_control.through
    assert ("gait_phase", "contact_wrench") not in force_control.through


def test_blocks_carry_description_equations_and_rate(controller):
    block = controller.child("com_dynamics_r")
    assert block.doc == "Integrates the force error of the stance foot into a motion of that foot."
    assert {18, 20} <= set(block.equations)
    assert block.period == 0.001 and block.states == (3,)


def test_svg_reads_in_light_and_dark_and_links_to_the_sources(simulation, tmp_path):
    path = save_diagram(simulation, tmp_path / "new" / "all.svg", depth=2)
    text = path.read_text()
    light, dark = text.split("@media screen and (prefers-color-scheme:dark)")
    assert "svg:root{background:#ffffff}" in light and "svg:root{background:#0d1117}" in dark
    tree = ElementTree.fromstring(text)
    links = {entry.get("href") for entry in tree.iter("{http://www.w3.org/2000/svg}a")}
    sources = {link for link in links if not link.startswith("https://")}
    assert len(sources) == 11
    assert all((path.parent / link).is_file() for link in sources)
    hints = [entry.text for entry in tree.iter("{http://www.w3.org/2000/svg}title")]
    assert any("eq. 18" in hint for hint in hints)
    assert any("lambda_f,d and its rate" in hint for hint in hints)


def test_other_formats(simulation, tmp_path):
    png = save_diagram(simulation, tmp_path / "a.png", system="imu")
    assert png.read_bytes().startswith(b"\x89PNG")
    pdf = save_diagram(simulation, tmp_path / "a.pdf", system="controller")
    assert pdf.read_bytes().startswith(b"%PDF")
    dot = save_diagram(simulation, tmp_path / "a.dot", system="controller", depth=1)
    assert re.search(r"^digraph .*ImuStabilizer", dot.read_text(), re.DOTALL)
    again = build_simulation(load_scenario("walk_flat"))
    other = save_diagram(again, tmp_path / "b.dot", system="controller", depth=1)
    assert other.read_bytes() == dot.read_bytes()


def test_what_cannot_be_drawn_is_said_in_one_line(simulation, tmp_path):
    with pytest.raises(OutputError, match="did you mean controller"):
        save_diagram(simulation, tmp_path / "a.svg", system="contrller")
    with pytest.raises(OutputError, match="must end in .svg"):
        save_diagram(simulation, tmp_path / "a.jpg")
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="cannot be written"):
        save_diagram(simulation, tmp_path / "file" / "a.svg")
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_any_diagram_of_drake_can_be_drawn():
    builder = DiagramBuilder()
    gain = builder.AddNamedSystem("gain", Gain(2.0, size=3))
    hold = builder.AddNamedSystem("hold", ZeroOrderHold(0.1, 3))
    alone = builder.AddNamedSystem("alone", Gain(1.0, size=1))
    builder.Connect(gain.get_output_port(), hold.get_input_port())
    builder.Connect(hold.get_output_port(), gain.get_input_port())
    builder.ExportOutput(alone.get_output_port(), "result")
    block = read_block(builder.Build())
    sheet = make_sheet(block)
    assert {box.content.name for box in sheet.boxes} == {"gain", "hold", "alone", "result"}
    feedback = next(wire for wire in sheet.wires if wire.net.source[0] == "hold")
    assert feedback.lines[0][0][0] > feedback.lines[0][-1][0]


def test_every_system_can_be_drawn_alone(simulation, tmp_path):
    names = {block.name for block in read_block(simulation).walk()}
    assert {"lola", "plant", "scene_graph", "controller", "imu"} <= names
    for name in names:
        path = save_diagram(simulation, tmp_path / f"{name}.svg", system=name, depth=0)
        assert name in path.read_text(encoding="utf-8")


def test_inputs_of_a_log_are_called_as_what_they_record(simulation):
    log = read_block(simulation, logging=True).child("log_multiplexer")
    names = [port.name for port in log.inputs]
    assert {"state", "contact", "desired_wrench", "walk_command"} <= set(names) and len(
        set(names)
    ) == len(names)
    assert not [name for name in names if re.fullmatch(r"[uy]\d+", name)]


def test_more_levels_than_there_are_cannot_be_opened(simulation):
    for system, levels in ((None, 2), ("controller", 1)):
        block_diagram(simulation, system=system, depth=levels)
        with pytest.raises(OutputError, match=f"depth {levels + 1}: .* no more than {levels}"):
            block_diagram(simulation, system=system, depth=levels + 1)
    block_diagram(simulation, system="imu", depth=1)


def test_names_can_be_read_on_paper_however_large_the_diagram_is(simulation, tmp_path):
    for system, depth, expected in (("controller", 1, 1), (None, 2, 2)):
        count, scale = sheets(block_diagram(simulation, system=system, depth=depth))
        assert count == expected and NAME * scale >= 6.0
        path = save_diagram(simulation, tmp_path / "d.pdf", system=system, depth=depth)
        assert len(re.findall(rb"/Type /Page\b", path.read_bytes())) == count


def test_a_block_between_two_sheets_is_whole_on_one_of_them(simulation):
    whole, controller = read_block(simulation), block_diagram(simulation, system="controller")
    drawing = block_diagram(simulation, depth=2)
    (start, middle), (again, end) = windows(drawing)
    assert start == 0.0 and end == pytest.approx(drawing.width)
    widest = max(make_box(block).width for block in whole.walk() if not block.children)
    assert middle - again > widest
    assert advice(drawing).endswith("as PDF it takes 2 sheets") and not advice(controller)
