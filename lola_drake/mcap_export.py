"""A run as an MCAP file, for Foxglove and PlotJuggler.

Every signal is a topic of JSON messages with its fields' names; the schema of a topic tells units
and frames. The poses of all links are there too, as Foxglove's frame transforms.
"""

import heapq
import json
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from pydrake.math import RollPitchYaw
from pydrake.multibody.plant import MultibodyPlant

from lola_drake.atomic_file import OutputError, whole_file
from lola_drake.logged import LOGGED
from lola_drake.results import Result
from lola_drake.robot import add_lola
from lola_drake.scenario import dump_scenario
from lola_drake.signals import Signal

if TYPE_CHECKING:
    from mcap.writer import Writer

SAMPLES_PER_SECOND, POSES_PER_SECOND = 1000.0, 50.0

_NUMBER = {"type": "number"}
_TIME = {"type": "object", "properties": {"sec": {"type": "integer"}, "nsec": {"type": "integer"}}}


def export_mcap(result: Result, path: str | Path, *, rate: float = 1000.0) -> Path:
    """Write a run's signals and link poses into an MCAP file.

    Args:
        result: The run.
        path: Of the file.
        rate: Messages per second and signal (Hz): 1000, as the record has, over a whole number.

    Raises:
        OutputError: If the package mcap is missing, the rate is another one, or the file cannot
            be written.
    """
    every = stride(rate)
    try:
        from mcap.writer import CompressionType, Writer
    except ImportError:
        raise OutputError("MCAP needs a package: pip install 'lola_drake[mcap]'") from None
    with whole_file(path) as file, file.open("wb") as stream:
        writer = Writer(stream, compression=CompressionType.ZSTD)
        writer.start(library="lola_drake")
        writer.add_metadata(
            "run",
            {
                "scenario": dump_scenario(result.scenario),
                "seed": str(result.scenario.seed),
                "versions": json.dumps(result.versions),
            },
        )
        # In the order of time, so that readers need no more than one chunk at a time.
        messages = heapq.merge(
            _signals(writer, result, every), _poses(writer, result), key=lambda message: message[0]
        )
        for time, channel, text in messages:
            writer.add_message(channel, time, text.encode(), time)
        writer.finish()
    return Path(path)


def stride(rate: float) -> int:
    """Return every which sample makes so many messages per second; OutputError if none does."""
    every = round(SAMPLES_PER_SECOND / rate) if 1e-3 <= rate <= SAMPLES_PER_SECOND else 0
    if not every or abs(every * rate / SAMPLES_PER_SECOND - 1) > 1e-6:
        rates = ", ".join(f"{SAMPLES_PER_SECOND / k:.7g}" for k in (1, 2, 3, 4, 5, 8, 10, 20, 100))
        raise OutputError(f"a rate of {rate:g} Hz is not exact, there are {rates} and so on")
    return every


_Message = tuple[int, int, str]
"""Time (ns), channel, and JSON."""


def _signals(writer: "Writer", result: Result, every: int) -> Iterator[_Message]:
    times = np.round(1e9 * result.times[::every]).astype(int).tolist()
    topics = []
    for name, values in result.signals.items():
        signal = LOGGED[name]
        schema = writer.register_schema(
            f"lola.{signal.name}", "jsonschema", json.dumps(message_schema(signal)).encode()
        )
        channel = writer.register_channel(f"/{name}", "json", schema)
        topics.append((channel, message_template(signal), _json_rows(values[::every])))
    for i, time in enumerate(times):
        for channel, template, rows in topics:
            yield time, channel, template % tuple(rows[i])


def _json_rows(values: np.ndarray) -> list[list[object]]:
    """Return rows of numbers that are written exactly; JSON knows neither NaN nor infinity."""
    rows = values.tolist()
    for i, k in np.argwhere(~np.isfinite(values)).tolist():
        rows[i][k] = "null"
    return rows


def message_template(signal: Signal) -> str:
    """Return the JSON of a signal's message, with a %s for each entry."""
    fields = []
    for field in signal.fields:
        if field.entries == ("",):
            fields.append(f'"{field.name}":%s')
        else:
            entries = ",".join(f'"{entry}":%s' for entry in field.entries)
            fields.append(f'"{field.name}":{{{entries}}}')
    return f"{{{','.join(fields)}}}"


def message_schema(signal: Signal) -> dict:
    """Return the JSON schema of a signal's message; it carries meaning, units and frames."""
    properties = {}
    for field in signal.fields:
        frame = f" in {field.frame}" if field.frame else ""
        entries = {
            entry: _NUMBER | {"description": f"{unit}{frame}"}
            for entry, unit in zip(field.entries, field.units, strict=True)
        }
        whole = {"type": "object", "properties": entries}
        properties[field.name] = entries[""] if field.entries == ("",) else whole
    return {"type": "object", "description": signal.doc, "properties": properties}


def _poses(writer: "Writer", result: Result) -> Iterator[_Message]:
    vector = {"type": "object", "properties": dict.fromkeys("xyz", _NUMBER)}
    quaternion = {"type": "object", "properties": dict.fromkeys("xyzw", _NUMBER)}
    text = {"type": "string"}
    transform = {
        "timestamp": _TIME,
        "parent_frame_id": text,
        "child_frame_id": text,
        "translation": vector,
        "rotation": quaternion,
    }
    items = {"type": "object", "properties": transform}
    content = {"transforms": {"type": "array", "items": items}}
    schema = writer.register_schema(
        "foxglove.FrameTransforms",
        "jsonschema",
        json.dumps({"type": "object", "properties": content}).encode(),
    )
    channel = writer.register_channel("/tf", "json", schema)
    for time, transforms in link_poses(result):
        yield time, channel, json.dumps({"transforms": transforms})


def link_poses(result: Result) -> Iterator[tuple[int, list[dict]]]:
    """Return times (ns) and where every link was in the world."""
    plant = MultibodyPlant(time_step=0.0)
    instance = add_lola(plant)
    plant.Finalize()
    context = plant.CreateDefaultContext()
    links = [plant.get_body(index) for index in plant.GetBodyIndices(instance)]
    every = max(round(SAMPLES_PER_SECOND / POSES_PER_SECOND), 1)
    torso, joints = (result.signals[name][::every] for name in ("torso_pose", "joint_position"))
    for seconds, pose, q in zip(result.times[::every], torso, joints, strict=True):
        quaternion = RollPitchYaw(pose[3:]).ToQuaternion().wxyz()
        plant.SetPositions(context, np.r_[quaternion, pose[:3], q])
        time = round(1e9 * seconds)
        stamp = {"sec": time // 10**9, "nsec": time % 10**9}
        yield time, [_transform(plant, context, link, stamp) for link in links]


def _transform(plant, context, link, stamp: dict) -> dict:
    pose = plant.EvalBodyPoseInWorld(context, link)
    w, x, y, z = pose.rotation().ToQuaternion().wxyz().tolist()
    position = pose.translation().tolist()
    return {
        "timestamp": stamp,
        "parent_frame_id": "world",
        "child_frame_id": link.name(),
        "translation": dict(zip("xyz", position, strict=True)),
        "rotation": {"x": x, "y": y, "z": z, "w": w},
    }
