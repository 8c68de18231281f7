"""Runs as one page that plays in any browser, made from their records."""

import base64
import gzip
from html import escape

import numpy as np
from pydrake.geometry import Meshcat

from lola_drake.figures.footprints import planned_footsteps
from lola_drake.pad_forces import pad_forces
from lola_drake.results import Result
from lola_drake.scenario import Ground
from lola_drake.view3d.assets import asset, with_script
from lola_drake.view3d.frames import frame_samples, frames_at
from lola_drake.view3d.markers import Markers, PressureMarkers
from lola_drake.view3d.scene import WORLD, Puppet, follow, open_meshcat, shown_in

FRAMES_PER_SECOND = 32.0

GHOST = f"{WORLD}/ghost"
"""Where the robots lie in the scene that the last run is compared with; `clock.js` makes them
ghosts, since a mesh takes no colour before the browser has read it."""


def packed(text: str | bytes) -> str:
    """Return something compressed, as text; `unpack.js` is the way back."""
    content = text.encode() if isinstance(text, str) else text
    return base64.b64encode(gzip.compress(content, 6, mtime=0)).decode()


def loading_page(title: str, replay: str) -> str:
    """Return a page that unpacks and shows what `packed_replay` made."""
    page = asset("loader.html").replace("UNPACK", asset("unpack.js"))
    return page.replace("TITLE", escape(title)).replace("PACKED", replay)


def packed_replay(*results: Result) -> str:
    """Return runs as a page of Meshcat's, compressed, as text.

    Meshcat itself and the robot's meshes are most of it, and shrink well.
    """
    return packed(replay_page(*results))


def replay_page(*results: Result) -> str:
    """Return runs as Meshcat's own static page, uncompressed; see `record`."""
    meshcat = open_meshcat()
    record(meshcat, *results)
    return with_script(meshcat.StaticHtml(), "sky.js", "clock.js")


def record(meshcat: Meshcat, *results: Result) -> None:
    """Play runs into a Meshcat scene as a recording: the last one whole, the others as ghosts.

    A robot whose run ends before the others stays as it was at its end.
    """
    main, ghosts = results[-1], results[:-1]
    longest = max(results, key=lambda result: result.duration)
    times = longest.times[frame_samples(longest.times, FRAMES_PER_SECOND)]
    meshcat.StartRecording(frames_per_second=FRAMES_PER_SECOND)
    for i, ghost in enumerate(ghosts):
        # What it walks on is there already.
        _record_robot(ghost, Ground(), times, meshcat, f"{GHOST}/{i}")
    samples = _record_robot(main, main.scenario.terrain, times, meshcat, f"{WORLD}/lola")
    _record_markers(main, samples, times, meshcat)
    meshcat.StopRecording()
    meshcat.PublishRecording()


def _record_robot(
    result: Result, ground: Ground, times: np.ndarray, meshcat: Meshcat, path: str
) -> np.ndarray:
    """Record how the robot moves; returns which samples of its run are the frames."""
    samples = np.searchsorted(result.times, times - 1e-9).clip(max=len(result.times) - 1)
    puppet = Puppet(ground, shown_in(meshcat, path))
    torsos = result.signals["torso_pose"][samples]
    joints = result.signals["joint_position"][samples]
    for time, torso, q in zip(times, torsos, joints, strict=True):
        puppet.pose(torso, q, float(time))
    return samples


def _record_markers(
    result: Result, samples: np.ndarray, times: np.ndarray, meshcat: Meshcat
) -> None:
    frames, forces = frames_at(result, samples), pad_forces(result, samples)
    most = max(len(frame.pushes) for frame in frames)
    markers, pressure = Markers(meshcat, most), PressureMarkers(meshcat)
    markers.set_footsteps(planned_footsteps(result))
    poses = np.stack([result.signals[f"foot_pose_{foot}"][samples] for foot in "lr"], axis=1)
    for time, frame, feet, force in zip(times, frames, poses, forces, strict=True):
        markers.show(frame, float(time))
        pressure.show(feet, force, float(time))
        follow(meshcat, frame.torso, float(time))
