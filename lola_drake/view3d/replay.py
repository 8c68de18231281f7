"""A run as one page that plays in any browser, made from its record."""

import base64
import gzip
from html import escape

from pydrake.geometry import Meshcat

from lola_drake.figures.footprints import planned_footsteps
from lola_drake.results import Result
from lola_drake.view3d.frames import frame_samples, frames_at
from lola_drake.view3d.markers import Markers
from lola_drake.view3d.scene import Puppet, follow, open_meshcat, shown_in

FRAMES_PER_SECOND = 32.0

UNPACK = """
async function unpack(text) {
  const bytes = Uint8Array.from(atob(text), c => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).text();
}
"""
"""JavaScript: what `packed_replay` has compressed."""

LOADER = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>TITLE</title></head>
<body><p id="note">Unpacking the replay …</p>
<script id="packed" type="text/plain">PACKED</script>
<script>UNPACK
const title = document.title;
unpack(document.getElementById("packed").textContent).then(page => {
  document.open(); document.write(page); document.close(); document.title = title;
}).catch(() => {
  document.getElementById("note").textContent =
    "This browser cannot unpack the replay; any browser from 2023 on can.";
});
</script></body></html>
"""


def loading_page(title: str, replay: str) -> str:
    """Return a page that unpacks and shows what `packed_replay` made."""
    page = LOADER.replace("UNPACK", UNPACK).replace("TITLE", escape(title))
    return page.replace("PACKED", replay)


def packed_replay(result: Result) -> str:
    """Return a run as a page of Meshcat's, compressed, as text.

    Meshcat itself and the robot's meshes are most of it, and shrink well.
    """
    page = replay_page(result)
    return base64.b64encode(gzip.compress(page.encode(), 6, mtime=0)).decode()


def replay_page(result: Result) -> str:
    """Return the run as Meshcat's own static page, uncompressed."""
    meshcat = open_meshcat()
    record(result, meshcat)
    return meshcat.StaticHtml()


def record(result: Result, meshcat: Meshcat) -> None:
    """Play a run into a Meshcat scene as a recording."""
    puppet, markers = Puppet(result.scenario, shown_in(meshcat)), Markers(meshcat)
    markers.set_footsteps(planned_footsteps(result))
    samples = frame_samples(result.times, FRAMES_PER_SECOND)
    scene = frames_at(result, samples)
    meshcat.StartRecording(frames_per_second=FRAMES_PER_SECOND)
    joints = result.signals["joint_position"][samples]
    for sample, frame, q in zip(samples, scene, joints, strict=True):
        time = float(result.times[sample])
        puppet.pose(frame.torso, q, time)
        markers.show(frame, time)
        follow(meshcat, frame.torso, time)
    meshcat.StopRecording()
    meshcat.PublishRecording()
