"""A run as a film, rendered without a display."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont
from pydrake.geometry import (
    Box,
    ClippingRange,
    ColorRenderCamera,
    LightParameter,
    MakeRenderEngineVtk,
    RenderCameraCore,
    RenderEngineVtkParams,
)
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.systems.sensors import CameraInfo

from lola_drake.atomic_file import OutputError, whole_file
from lola_drake.figures.style import FOOT_COLOURS, PUSHED
from lola_drake.results import Result
from lola_drake.signals import FEET
from lola_drake.view3d.frames import Frame, frame_samples, frames_at
from lola_drake.view3d.markers import LEAST_FORCE, METRES_PER_NEWTON
from lola_drake.view3d.scene import Puppet

FRAMES_PER_SECOND = 25
WIDTH, HEIGHT, VIEW = 864, 480, np.deg2rad(32.0)
"""Size of the picture (pixels) and its angle from top to bottom (rad)."""

CAMERA, EYE_HEIGHT = np.array([2.2, -2.9, 0.45]), 0.88
"""Where the camera stands, seen from what it looks at, and how high that is (m)."""

BACKGROUND, FLOOR, LINES = (0.94, 0.95, 0.97), (0.86, 0.87, 0.89, 1.0), (0.70, 0.72, 0.75, 1.0)
REACH = 12.0
"""How far the lines on the floor reach (m)."""

ENDINGS = (".webp", ".mp4")


def save_video(result: Result, path: str | Path) -> Path:
    """Write a film of the run: .webp, which browsers show, or .mp4, for which ffmpeg is needed.

    Raises:
        OutputError: If the file's ending is another one, ffmpeg is missing, or the file cannot
            be written.
    """
    path = Path(path)
    if path.suffix not in ENDINGS:
        raise OutputError(f"{path}: the name of a film must end in {' or '.join(ENDINGS)}")
    write = _write_mp4 if path.suffix == ".mp4" else _write_webp
    with whole_file(path) as file:
        write(file, frames(result))
    return path


def frames(result: Result) -> Iterator[Image.Image]:
    """Return the pictures of a run, one after the other."""
    samples = frame_samples(result.times, FRAMES_PER_SECOND)
    puppet = Puppet(result.scenario.terrain, _furnish)
    camera = _camera()
    for sample, frame in zip(samples, frames_at(result, samples), strict=True):
        puppet.pose(frame.torso, result.signals["joint_position"][sample])
        X_WC = camera_pose(frame.torso)
        rendered = puppet.query().RenderColorImage(
            camera, puppet.scene_graph.world_frame_id(), X_WC
        )
        picture = Image.fromarray(rendered.data[:, :, :3])
        _annotate(picture, camera.core().intrinsics(), X_WC, frame, result.times[sample])
        yield picture


def camera_pose(torso: np.ndarray) -> RigidTransform:
    """Return X_WC of a camera that follows the robot; its z axis looks, its y axis is down."""
    target = np.array([torso[0], torso[1], EYE_HEIGHT])
    z = -CAMERA / np.linalg.norm(CAMERA)
    x = np.cross(z, [0.0, 0.0, 1.0])
    x /= np.linalg.norm(x)
    rotation = RotationMatrix(np.column_stack([x, np.cross(z, x), z]))
    return RigidTransform(rotation, target + CAMERA)


def _furnish(builder, plant, scene_graph) -> None:
    floor = Box(80.0, 80.0, 0.1)
    world = plant.world_body()
    below = RigidTransform([0.0, 0.0, -0.053])
    plant.RegisterVisualGeometry(world, below, floor, "seen_floor", np.array(FLOOR))
    for i, mark in enumerate(np.arange(-REACH, REACH + 0.1, 0.5)):
        for axis, size in ((0, (0.01, 2 * REACH)), (1, (2 * REACH, 0.01))):
            place = np.array([0.0, 0.0, -0.0025])
            place[axis] = mark
            line, name = Box(*size, 0.0005), f"floor_line_{'xy'[axis]}_{i}"
            plant.RegisterVisualGeometry(world, RigidTransform(place), line, name, np.array(LINES))
    sun = LightParameter(type="directional", direction=[0.3, 0.6, -1.0], frame="world")
    lamp = LightParameter(type="directional", direction=[0.0, 0.0, 1.0], frame="camera")
    sun.intensity, lamp.intensity = 0.9, 0.8
    params = RenderEngineVtkParams(
        default_clear_color=np.array(BACKGROUND), lights=[sun, lamp], cast_shadows=True
    )
    scene_graph.AddRenderer("film", MakeRenderEngineVtk(params))


def _camera() -> ColorRenderCamera:
    info = CameraInfo(WIDTH, HEIGHT, VIEW)
    core = RenderCameraCore("film", info, ClippingRange(0.1, 60.0), RigidTransform())
    return ColorRenderCamera(core, False)


def _annotate(picture, camera: CameraInfo, X_WC, frame: Frame, time: float) -> None:
    """Draw ground forces and pushes as arrows, and write the time."""
    draw = ImageDraw.Draw(picture)
    arrows = [
        (origin, origin + METRES_PER_NEWTON * force, FOOT_COLOURS[foot])
        for foot, force, origin in zip(FEET, frame.forces, frame.origins, strict=True)
        if np.linalg.norm(force) > LEAST_FORCE and np.isfinite(origin).all()
    ]
    arrows += [(p - METRES_PER_NEWTON * force, p, PUSHED) for p, force in frame.pushes]
    for tail, tip, colour in arrows:
        start, end = (camera.intrinsic_matrix() @ (X_WC.inverse() @ p) for p in (tail, tip))
        _draw_arrow(draw, start[:2] / start[2], end[:2] / end[2], colour)
    font = ImageFont.load_default(18)
    roll, pitch = np.degrees(frame.torso[3:5])
    text = f"{time:6.2f} s    inclination {roll:+.1f}°, {pitch:+.1f}°"
    draw.text((16, 12), text, fill="#222222", font=font)


def _draw_arrow(draw, start: np.ndarray, end: np.ndarray, colour: str) -> None:
    along = (end - start) / max(np.linalg.norm(end - start), 1e-9)
    across = np.array([-along[1], along[0]])
    draw.line([tuple(start), tuple(end)], fill=colour, width=4)
    head = (end + 9 * along, end + 6 * across, end - 6 * across)
    draw.polygon([tuple(corner) for corner in head], fill=colour)


def _write_webp(path: Path, pictures: Iterator[Image.Image]) -> None:
    first = next(pictures)
    first.save(
        path,
        save_all=True,
        append_images=pictures,
        duration=round(1000 / FRAMES_PER_SECOND),
        loop=0,
        quality=70,
        method=2,
    )


def _write_mp4(path: Path, pictures: Iterator[Image.Image]) -> None:
    try:
        import imageio_ffmpeg
    except ImportError:
        raise OutputError(
            "mp4 needs ffmpeg: pip install 'lola_drake[video]', or use webp"
        ) from None
    writer = imageio_ffmpeg.write_frames(
        str(path), (WIDTH, HEIGHT), fps=FRAMES_PER_SECOND, quality=7, ffmpeg_log_level="error"
    )
    writer.send(None)
    for picture in pictures:
        writer.send(np.ascontiguousarray(picture))
    writer.close()
