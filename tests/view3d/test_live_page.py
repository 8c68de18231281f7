"""The page around a running simulation: what it is told, and how it looks in a browser."""

import dataclasses
import json
import urllib.error
import urllib.request
import xml.etree.ElementTree as ElementTree
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from browser import ask, needs_browser

from lola_drake.errors import OutputError
from lola_drake.scenario import load_scenario
from lola_drake.simulation import simulate, start
from lola_drake.view3d.controls import KEEP, REPLAY, Controls
from lola_drake.view3d.diagram_view import live_diagram
from lola_drake.view3d.door import Door
from lola_drake.view3d.frames import frames_of
from lola_drake.view3d.live import LiveView, pad_forces_now, signals_now
from lola_drake.view3d.live_page import LivePage
from lola_drake.view3d.readout import Readout
from lola_drake.view3d.scene import open_meshcat


@pytest.fixture(scope="module")
def stand():
    return load_scenario("stand")


@pytest.fixture(scope="module")
def meshcat():
    return open_meshcat(hidden=True)


@pytest.fixture(scope="module")
def door(meshcat):
    door = Door("localhost", meshcat.web_url())
    yield door
    door.close()


@pytest.fixture
def page(door):
    page = LivePage("localhost", "a <test>", door)
    yield page
    page.close()


@pytest.fixture
def run(stand):
    run = start(stand)
    run.advance(0.05)
    return run


def events(stream, count):
    """Return so many events of a stream: their kinds and contents."""
    found = []
    while len(found) < count:
        kind, data = (stream.readline().decode().strip() for _ in range(2))
        stream.readline()
        found.append((kind.removeprefix("event: "), json.loads(data.removeprefix("data: "))))
    return found


def test_who_comes_later_is_told_the_last_of_each_kind(page):
    page.tell("about", {"n": 1})
    page.tell("now", {"n": 2})
    page.tell("now", {"n": 3})
    with urllib.request.urlopen(page.url.replace("/?", "/events?")) as stream:
        assert events(stream, 2) == [("about", {"n": 1}), ("now", {"n": 3})]
        assert page.watched
        page.tell("now", {"n": 4})
        assert events(stream, 1) == [("now", {"n": 4})]


def test_there_is_one_page_and_nothing_else(page):
    with urllib.request.urlopen(page.url) as answer:
        assert "a &lt;test&gt;" in answer.read().decode()
        # Only the page itself may read what it is told.
        assert answer.headers["Access-Control-Allow-Origin"] is None
    for path, status in ("", "403"), ("events", "403"), ("../etc/passwd", "404"):
        with pytest.raises(urllib.error.HTTPError, match=status):
            urllib.request.urlopen(page.url.split("?")[0] + path)
    with pytest.raises(urllib.error.HTTPError, match="501"):
        urllib.request.urlopen(page.url, data=b"stop")


def test_a_host_that_is_not_here_is_one_line(door):
    with pytest.raises(OutputError, match="no page can be shown at '8.8.8.8'"):
        LivePage("8.8.8.8", "", door)


class Told:
    """A page that somebody looks at, and what it was told."""

    watched = True

    def __init__(self):
        self.said = {}

    def tell(self, kind, content):
        self.said[kind] = json.loads(json.dumps(content, allow_nan=False))


def test_a_page_is_told_the_truth(run, stand, meshcat):
    page = Told()
    readout = Readout(page, run, Controls(meshcat, steering=True))
    (frame,) = frames_of(signals_now(run), stand.ground)
    readout.tell(run, frame, "runs", 3.0)
    about, now = page.said["about"], page.said["now"]
    keys = dict(about["controls"]["keys"])
    assert keys["P"] == "pause, go on" and keys["R"] == "replay the last 20 s"
    assert any(name.startswith("v_x") for name in keys)
    assert any(text.startswith("com_dynamics.gain: ") for _, text in about["controls"]["gains"])
    entries, values = about["signals"]["contact_wrench_l"]["entries"], now["signals"]
    wrench = dict(zip(entries, values["contact_wrench_l"], strict=True))
    assert wrench["wrench.F_z"] == pytest.approx(run.signal("contact_wrench_l")[2], rel=1e-4)
    assert now["position"] == pytest.approx(frame.torso[:2]) and now["time"] == run.time
    assert now["possible"] == 3.0 and now["speed"] == 0.0


def test_pads_bear_the_robot(run):
    forces = pad_forces_now(run)
    assert forces.shape == (8,) and (forces > 0).all()
    assert forces.sum() == pytest.approx(60 * 9.81, rel=0.02)


def test_the_diagram_says_which_signal_is_where(stand, run):
    groups = ElementTree.fromstring(live_diagram(stand)).iter("{http://www.w3.org/2000/svg}g")
    names = {group.get("data-signal") for group in groups} - {None}
    # Each foot's own, also where the port of a foot's block has no foot in its name.
    assert {"contact_wrench_l", "contact_wrench_r", "desired_wrench", "measured_wrench"} <= names
    for name in names:
        assert np.isfinite(run.signal(name)).all(), name


def test_the_last_seconds_begin_with_zero(run):
    run.advance(0.4)
    recent = run.recent(0.1)
    assert recent.times[0] == 0.0 and recent.duration == pytest.approx(0.1, abs=2e-3)
    whole = run.result(wall_time=0.0)
    forces = whole.signals["contact_wrench_l"][-len(recent.times) :]
    np.testing.assert_array_equal(recent.signals["contact_wrench_l"], forces)


def test_what_is_forgotten_leaves_the_last_samples(run):
    whole = []
    for k in range(1, 8):
        run.advance(0.05 + 0.05 * k)
        whole.append(run.signal("desired_wrench").copy())
        run.forget(100)
    recent = run.recent(0.1)
    assert len(recent.times) in (100, 101)
    steps = np.diff(recent.times)
    assert steps == pytest.approx(np.full(len(steps), 0.001))
    assert run.result(wall_time=0.0).times[-1] == pytest.approx(run.time, abs=2e-3)


def asked_while_it_runs(scenario, meshcat, page, url, question, keep=None, **look):
    """Ask a page while a simulation shows itself there; return answer, complaints and view.

    The simulation is in the main thread, where it listens to signals.
    """
    view = LiveView(scenario, meshcat, page, keep)
    with ThreadPoolExecutor() as pool:
        asked = pool.submit(ask, url, question, **look)

        def attend(run):
            view.stopped |= asked.done()
            return view(run)

        result = simulate(dataclasses.replace(scenario, duration=3600.0), attend=attend)
    assert result.error is None
    return *asked.result(), view


@needs_browser
def test_a_page_shows_values_at_the_ports(stand, meshcat, door):
    page = LivePage("localhost", "stand", door, live_diagram(stand))
    answer, complaints, _ = asked_while_it_runs(
        stand,
        meshcat,
        page,
        f"{page.url}#diagram",
        """
            const told = () => Number(document.documentElement.dataset.told || 0);
            await settled(() => told() > 8);
            const port = name => document.querySelector(`g[data-signal=${name}]`);
            port("desired_wrench").dispatchEvent(new MouseEvent("click"));
            await settled(() => byId("port").querySelectorAll("tr").length === 12);
            const rows = [...byId("port").querySelectorAll("tr")];
            const load = rows.map(row => row.children[1].textContent);
            rows[2].click();
            return {
              load, value: port("desired_wrench").querySelector(".value").textContent,
              line: port("desired_wrench").querySelector(".spark").getAttribute("d"),
              scene: !!document.querySelector("iframe"), keys: byId("keys").textContent,
              time: byId("time").textContent, misfits: misfits(),
            };
        """,
        width=390,
    )
    page.close()
    assert complaints == [] and answer["misfits"] == []
    assert answer["scene"] and "pause, go on" in answer["keys"] and answer["time"].endswith(" s")
    left, right = (float(answer["load"][i].removesuffix(" N")) for i in (2, 5))
    assert left + right == pytest.approx(60 * 9.81, rel=0.02)
    assert answer["value"].startswith("F_z ") and answer["value"].endswith(" N")
    assert answer["line"].count("L") > 5


@needs_browser
def test_a_slider_changes_a_gain_and_the_last_seconds_are_kept(stand, meshcat, door):
    kept = []
    answer, complaints, view = asked_while_it_runs(
        stand,
        meshcat,
        None,
        door.url,
        f"""
            const control = name => viewer.gui.__controllers.find(c => c.property === name);
            await settled(() => control("g_a (-)") && control({json.dumps(KEEP)}));
            const before = control("g_a (-)").getValue();
            control("g_a (-)").setValue(0.3);
            control({json.dumps(REPLAY)}).getValue()();
            await new Promise(done => setTimeout(done, 4000));
            control({json.dumps(KEEP)}).getValue()();
            await new Promise(done => setTimeout(done, 4000));
            return {{ before, sky: skyIn(window) }};
        """,
        keep=lambda result: kept.append(result) or "here",
        dark=True,
    )
    assert complaints == [] and answer["before"] == pytest.approx(1.0) and answer["sky"] < 60
    assert view.interfered and view._controls._gains["g_a (-)"] == pytest.approx(0.3)
    assert len(kept) == 1 and kept[0].times[0] == 0.0 and kept[0].duration > 0.02
