"""Reports: what is in the page, and how it behaves in a browser."""

import base64
import gzip
import json
import re

import numpy as np
import pytest
from browser import ask, needs_browser

from lola_drake.errors import OutputError
from lola_drake.reports.payload import NOTHING, events, payload
from lola_drake.reports.run_report import write_report
from lola_drake.scenario import Scenario, override
from lola_drake.signals import CONTACT, FEET, GAIT_PHASE

LATE = 0.2


def walk(make_result, variant, late=0.0):
    """Return a made-up walk in which a foot's pads close as planned, or all of them later."""
    scenario = override(Scenario(), {"name": "tested", "variant": variant})
    result = make_result(scenario, steps=2)
    result.signals["torso_pose"][:, 2] = 1.1
    result.signals["com_position"][:] = result.signals["torso_pose"][:, :3]
    support = result.signals["gait_phase"][:, GAIT_PHASE.slice("support")]
    for k, foot in enumerate(FEET):
        closed = np.roll(support[:, k], round(1000 * late)) * support[:, k]
        result.signals["contact"][:, CONTACT.slice(f"pads_{foot}")] = closed[:, None]
    return result


@pytest.fixture(scope="module")
def two(make_result):
    ref, dyn = (walk(make_result, variant, LATE) for variant in ("ref", "dyn"))
    ref.signals["torso_pose"][1200:1400, 3] = 0.02
    dyn.signals["torso_pose"][1200:1400, 3] = 0.01
    dyn.signals["torso_pose"][:, 0] += 0.3
    return [ref, dyn]


@pytest.fixture(scope="module")
def comparison(two, tmp_path_factory):
    return write_report(two, tmp_path_factory.mktemp("two") / "report.html")


@pytest.fixture(scope="module")
def report(two, tmp_path_factory):
    return write_report(two[1:], tmp_path_factory.mktemp("one") / "report.html")


def unpacked(text):
    return gzip.decompress(base64.b64decode(text))


def test_curves_come_back_as_they_were(two):
    packed = payload(two, ["ref", "dyn"])
    shape = json.loads(unpacked(packed["shape"]))
    assert [run["name"] for run in shape["runs"]] == ["ref", "dyn"]
    cell = shape["panels"][0]["cells"][0]
    assert [(curve["name"], curve["run"]) for curve in cell["curves"]] == [
        ("torso", 0),
        ("torso", 1),
    ]
    halves = np.frombuffer(unpacked(packed["numbers"]), np.uint8).astype(np.uint16).reshape(2, -1)
    start, count, low, step = cell["curves"][0]["y"]
    differences = (halves[0] + 256 * halves[1])[start : start + count]
    whole = np.cumsum(differences, dtype=np.uint16)
    assert (whole < NOTHING).all()
    roll = np.degrees(two[0].signals["torso_pose"][:, 3])
    assert low + step * whole == pytest.approx(roll, abs=step)


def test_late_contacts_are_the_papers_times(two):
    first, second = events(two)
    assert (first["name"], second["name"]) == ("t1", "t2")
    assert first["what"] == "left foot late" and second["what"] == "right foot late"
    assert first["planned"] < first["time"] == pytest.approx(1.8 + LATE, abs=0.01)


def test_a_page_needs_nothing_but_itself(comparison):
    page = comparison.read_text()
    assert not re.findall(r"""(?:src|href)=["']?https?:""", page)
    assert len(page) < 12e6 and page.count("</html>") == 1


def test_runs_are_called_as_one_likes(two, tmp_path):
    page = write_report(two, tmp_path / "named.html", names=["dyn", "my <law>"]).read_text()
    assert "<th>dyn</th><th>my &lt;law&gt;</th>" in page
    for names in (["dyn"], ["dyn", "dyn"]):
        with pytest.raises(OutputError, match="is not one name for each of 2 runs"):
            write_report(two, tmp_path / "named.html", names=names)


def test_after_a_fall_nothing_is_compared(make_result, tmp_path):
    ref = make_result(override(Scenario(), {"variant": "ref"}), steps=1)
    fallen = make_result(steps=1, completed=False, fall_time=1.5)
    page = write_report([ref, fallen], tmp_path / "fall.html").read_text()
    assert "dyn: fell at 1.50 s" in page
    assert "<th>change</th>" not in page and " %)" not in page


@needs_browser
def test_the_cursor_moves_the_robot(report):
    answer, complaints = ask(
        report,
        """
        await settled(() => document.documentElement.dataset.ready === "replay");
        const { viewer } = replay.frame.contentWindow;
        const robot = () => {
          const { object } = viewer.scene_tree.find(["world", "lola", "lola", "torso"]);
          return object.position.x;
        };
        const place = [];
        plots.drawn[0].emit("plotly_click", { points: [{ x: 0.5 }] });
        await settled(() => viewer.animator.time === 0.5);
        place.push(robot());
        const before = document.querySelector(".cursor").style.left;
        plots.drawn[0].emit("plotly_click", { points: [{ x: 2.5 }] });
        await settled(() => viewer.animator.time === 2.5);
        place.push(robot());
        const moved = before !== document.querySelector(".cursor").style.left;
        byId("play").click();
        await settled(() => now > 2.6);
        const sky = () => skyIn(replay.frame.contentWindow);
        const paper = () => getComputedStyle(document.querySelector(".diagram .page")).fill;
        const look = [[sky(), paper()]];
        byId("theme").click();
        await settled(() => sky() < 60);
        look.push([sky(), paper()]);
        return { place, moved, look, played: now > 2.6, plots: plots.drawn.length };
        """,
    )
    assert complaints == []
    assert answer["moved"] and answer["played"] and answer["plots"] >= 1
    assert answer["look"] == [[247, "rgb(255, 255, 255)"], [27, "rgb(13, 17, 23)"]]
    start, end = answer["place"]
    assert start == pytest.approx(0.3, abs=1e-6) and end == pytest.approx(0.3 + 0.75, abs=0.02)


@needs_browser
def test_time_axes_zoom_together_and_back(report):
    answer, complaints = ask(
        report,
        """
        await settled(() => document.documentElement.dataset.ready === "replay");
        for (const plot of document.querySelectorAll(".plot")) plots.draw(plot);
        const ranges = () => plots.drawn.filter(p => !p.panel.cells[0].across)
          .map(p => p.layout.xaxis.range.join());
        const [first] = plots.drawn, all = first.layout.xaxis.range.slice();
        await Plotly.relayout(first, { "xaxis.range[0]": 1, "xaxis.range[1]": 2 });
        const near = ranges();
        await Plotly.relayout(first, { "xaxis.range": all });
        const drawn = plot => plot.querySelector(".main-svg").clientHeight;
        const room = Math.min(...plots.drawn.map(plot => plot.offsetHeight - drawn(plot)));
        return { near, far: ranges(), all: all.join(), room };
        """,
    )
    assert complaints == []
    assert set(answer["near"]) == {"1,2"} and set(answer["far"]) == {answer["all"]}
    assert answer["room"] >= 0, "a plot sticks out into the next one"


@needs_browser
def test_the_first_run_is_a_ghost_in_the_scene_of_the_second(comparison):
    answer, complaints = ask(
        comparison,
        """
        await settled(() => document.documentElement.dataset.ready === "replay");
        const { children } = replay.frame.contentWindow.viewer.scene_tree.children.world;
        const materials = [];
        const look = () => {
          materials.length = 0;
          children.ghost.object.traverse(o => materials.push(...[].concat(o.material || [])));
          return materials.length > 5 && materials.every(m => m.ghost);
        };
        await settled(look);
        const ghost = materials.every(m => m.transparent && m.opacity < 0.5);
        const texts = plots.drawn[0].layout.annotations.map(a => a.text);
        const marks = texts.filter(t => t.includes("sub")), sky = skyIn(replay.frame.contentWindow);
        return { ghost, robot: !!children.lola, marks, sky, misfits: misfits() };
        """,
        width=390,
        dark=True,
    )
    assert complaints == [] and answer["misfits"] == [] and answer["sky"] < 60
    assert answer["ghost"] and answer["robot"]
    assert "<i>t<sub>1</sub></i>" in answer["marks"]
