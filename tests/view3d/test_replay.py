"""Replays, reports and films made from the record of a run."""

import base64
import gzip
import re
import sys

import numpy as np
import pytest
from PIL import Image

from lola_drake.atomic_file import OutputError
from lola_drake.figures.run_figures import FIGURES
from lola_drake.reports.run_report import write_pictures, write_report
from lola_drake.scenario import Scenario, override
from lola_drake.signals import GROUND_FORCE
from lola_drake.view3d.frames import frame_samples, frames_at
from lola_drake.view3d.replay import packed_replay, replay_page
from lola_drake.view3d.video import camera_pose, save_video


@pytest.fixture(scope="module", autouse=True)
def few_figures():
    """Let pages hold two figures; all of them have tests of their own."""
    with pytest.MonkeyPatch.context() as patch:
        for name in list(FIGURES)[2:]:
            patch.delitem(FIGURES, name)
        yield


@pytest.fixture(scope="module")
def run(make_result):
    result = make_result(override(Scenario(), {"name": "tested", "duration": 4.0}), steps=2)
    result.signals["torso_pose"][:, 2] = 1.1
    return result


@pytest.fixture(scope="module")
def folder(run, tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    write_pictures(run, folder)
    return folder


def test_a_run_has_figures_a_replay_and_a_report(folder):
    assert {path.name for path in folder.iterdir()} == {"figures", "replay.html", "report.html"}
    figures = {path.name for path in (folder / "figures").iterdir()}
    assert figures == {f"{name}.{kind}" for name in FIGURES for kind in ("svg", "png")}


def test_the_replay_is_small_and_complete(folder, run):
    page = (folder / "replay.html").read_text()
    assert len(page) <= 1e6 * run.duration
    assert not re.findall(r"""(?:src|href)=["']?https?:""", page)
    packed = re.search(r'<script id="packed"[^>]*>([^<]+)<', page)[1]
    scene = gzip.decompress(base64.b64decode(packed)).decode()
    assert "MeshCat" in scene and scene.rstrip().endswith("</html>")
    messages = [base64.b64decode(m) for m in re.findall(r"base64,([A-Za-z0-9+/=]+)", scene)]
    (recording,) = [message for message in messages if b"set_animation" in message]
    for sign in (b"ground force/left", b"ZMP", b"CoM", b"inclination", b"lola/torso"):
        assert sign in recording
    assert any(b"planned footsteps" in message for message in messages)


def test_the_same_run_gives_the_same_replay(make_result):
    short = make_result(steps=0)
    assert len(replay_page(short)) == len(replay_page(short))
    assert packed_replay(short) == packed_replay(short)


def test_frames_are_evenly_spaced_samples():
    times = np.arange(2001) / 1000
    samples = frame_samples(times, 25.0)
    assert samples[0] == 0 and samples[-1] == 2000 and set(np.diff(samples)) == {40}


def test_moments_carry_the_ground_forces(run):
    run.signals["ground_force"][:, GROUND_FORCE.slice("F_r")] = (1.0, 2.0, 300.0)
    (frame,) = frames_at(run, np.array([100]))
    assert frame.forces[1] == pytest.approx([1.0, 2.0, 300.0])
    assert frame.torso == pytest.approx(run.signals["torso_pose"][100])


def test_the_report_of_one_run_tells_what_was_run(folder, run):
    page = (folder / "report.html").read_text().replace("<wbr>", "")
    assert "max_inclination_deg.x" in page and f"drake {run.versions['drake']}" in page
    assert re.search(r"<td>duration</td><td>10.0</td><td>4.0</td>", page)
    assert page.count("<svg ") == 1
    assert not re.findall(r"""(?:src|href)=["']?https?:""", page)


def test_the_report_of_two_runs_compares_them(make_result, tmp_path):
    ref, dyn = (make_result(override(Scenario(), {"variant": v}), steps=1) for v in ("ref", "dyn"))
    dyn.signals["torso_pose"][:] = ref.signals["torso_pose"] + [0, 0, 0, 0.01, 0, 0]
    ref.signals["torso_pose"][:, 3] += 0.02
    page = write_report([ref, dyn], tmp_path / "new" / "report.html").read_text()
    page = page.replace("<wbr>", "")
    assert re.search(r"max_inclination_deg.x</td><td>1.146</td><td>0.573</td><td>-50 %", page)
    assert re.search(r"<td>variant</td><td>dyn</td><td>ref</td><td>dyn</td>", page)
    assert "1.15 → 0.573 ° (-50 %)" in page
    assert page.count('class="replay"') == 1 and "ghost: ref; robot: dyn" in page


def test_a_page_that_cannot_be_written_leaves_nothing(run, tmp_path, monkeypatch):
    def full(self, *_, **__):
        with self.open("w") as file:
            file.write("half")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("pathlib.Path.write_text", full)
    monkeypatch.setattr("pathlib.Path.write_bytes", full)
    with pytest.raises(OutputError, match=r"cannot be written, No space left on device$"):
        write_pictures(run, tmp_path)
    assert not [path for path in tmp_path.rglob("*") if path.is_file()]


def test_a_film_shows_the_robot(make_result, tmp_path):
    short = make_result(steps=0)
    for name, values in short.signals.items():
        short.signals[name] = values[:101]
    object.__setattr__(short, "times", short.times[:101])
    short.signals["torso_pose"][:, 2] = 1.1
    film = Image.open(save_video(short, tmp_path / "film.webp"))
    assert film.n_frames == 3 and film.size == (864, 480)
    picture = np.asarray(film.convert("L"))
    assert picture[:, 380:480].min() < 60 < 200 < picture.max()


def test_the_camera_looks_at_the_robot_and_stands_upright():
    pose = camera_pose(np.array([2.0, 3.0, 1.1, 0, 0, 0]))
    x, y, z = pose.inverse() @ np.array([2.0, 3.0, 0.88])
    assert (x, y) == pytest.approx((0.0, 0.0), abs=1e-9) and z > 2.0
    assert (pose.inverse() @ np.array([2.0, 3.0, 1.8]))[1] < 0


def test_films_are_webp_or_with_ffmpeg_mp4(run, tmp_path, monkeypatch):
    with pytest.raises(OutputError, match="must end in .webp or .mp4"):
        save_video(run, tmp_path / "film.avi")
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(OutputError, match="pip install"):
        save_video(run, tmp_path / "film.mp4")
    assert not list(tmp_path.iterdir())
