"""Frames that no page sends, for `fuzz.py frames`: python tests/fuzz_frames.py [COUNT] [SEED].

They come with the token, as from the user's own browser, while a simulation shows itself there. It
must go on and come to its end, and the page's own messages must still be heard.
"""

import base64
import os
import socket
import subprocess
import sys
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress

import msgpack
import numpy as np

from lola_drake.scenario import load_scenario
from lola_drake.simulation import simulate
from lola_drake.view3d.controls import IMPULSE, RATE
from lola_drake.view3d.door import Door
from lola_drake.view3d.live import LiveView
from lola_drake.view3d.scene import open_meshcat

TOGETHER = 100
"""Frames that one simulation gets."""

PATIENCE = 300.0

ODD = (
    *(None, True, "", "x", -1, 2**63, 1e300, float("nan"), float("inf"), [], {}, [1.0] * 16, b"x"),
    *({"index": 0}, {"index": "x", "axes": [1]}, {"index": 2**40, "axes": [float("nan")] * 99}),
    *({"index": 0, "axes": ["x"], "button_values": {}}, [[[[]]]] * 9, "y" * 70_000),
)


def connected(door: Door) -> socket.socket:
    """Return a WebSocket to a door, opened as a browser does."""
    client = socket.create_connection(("localhost", door.port), timeout=20)
    lines = (
        f"GET /?token={door.token} HTTP/1.1",
        f"Host: localhost:{door.port}",
        "Upgrade: websocket",
        "Connection: Upgrade",
        f"Sec-WebSocket-Key: {base64.b64encode(os.urandom(16)).decode()}",
        "Sec-WebSocket-Version: 13",
        "Sec-WebSocket-Extensions: permessage-deflate",
    )
    client.sendall("\r\n".join([*lines, "", ""]).encode())
    assert b" 101 " in client.recv(1024)
    return client


def frame(content: bytes, kind: int = 0x82, size: int | None = None) -> bytes:
    """Return a frame; one that lies about its size if that is given."""
    size = len(content) if size is None else size
    if size < 126:
        head = bytes([kind, 0x80 | size])
    elif size < 65536:
        head = bytes([kind, 0xFE]) + size.to_bytes(2, "big")
    else:
        head = bytes([kind, 0xFF]) + size.to_bytes(8, "big")
    return head + bytes(4) + content


def bad_frame(random: np.random.Generator) -> bytes:
    """Return what no page of Meshcat sends, or what it sends with something odd in it."""
    kinds = (_noise, _cut, _message, _message, _message, _another_kind, _another_size)
    return kinds[random.integers(len(kinds))](random)


def _noise(random: np.random.Generator) -> bytes:
    return frame(random.bytes(int(random.choice([0, 0, 1, 64, 1000, 66_000, 3_000_000]))))


def _cut(random: np.random.Generator) -> bytes:
    whole = msgpack.packb(_content(random))
    return frame(whole[: random.integers(len(whole))])


def _message(random: np.random.Generator) -> bytes:
    return frame(msgpack.packb(_content(random)))


def _content(random: np.random.Generator) -> object:
    names = ["nobody", "", RATE, IMPULSE, "v_x ↓↑ (m/s)", "g_a (-)", "x" * 1000]
    content = {
        "type": str(random.choice(["slider", "button", "gamepad", "camera_pose", "delete", ""])),
        "name": str(random.choice(names)),
        "value": ODD[random.integers(len(ODD))],
        "gamepad": ODD[random.integers(len(ODD))],
        "camera_pose": ODD[random.integers(len(ODD))],
        "is_perspective": bool(random.integers(2)),
    }
    changed = str(random.choice(list(content)))
    if random.integers(3) == 0:
        del content[changed]
    elif random.integers(3) == 0:
        content[changed] = ODD[random.integers(len(ODD))]
    return content if random.integers(8) else ODD[random.integers(len(ODD))]


def _another_kind(random: np.random.Generator) -> bytes:
    return frame(random.bytes(random.integers(100)), kind=int(random.integers(256)))


def _another_size(random: np.random.Generator) -> bytes:
    size = int(random.choice([0, 5, 125, 126, 70_000, 2**62]))
    return frame(random.bytes(random.integers(100)), size=size)


def send(door: Door, count: int, seed: int) -> None:
    """Send so many frames; whom the door has turned away comes again."""
    client = connected(door)
    for number in range(seed, seed + count):
        random = np.random.default_rng(number)
        with suppress(OSError):
            client.sendall(bad_frame(random))
            if random.integers(4):
                continue
        with suppress(OSError):
            client.close()
        client = connected(door)
    client.close()


def shown(count: int, seed: int) -> str:
    """Show a simulation to somebody who sends such frames; return what is wrong then."""
    meshcat = open_meshcat(hidden=True)
    door = Door("localhost", meshcat.web_url())
    scenario = load_scenario("stand", {"duration": 0.3})
    view, watching = LiveView(scenario, meshcat), connected(door)
    with ThreadPoolExecutor() as pool:
        sent: list[Future] = []

        def attend(run) -> float | None:
            if not sent and view._controls is not None:
                sent.append(pool.submit(send, door, count, seed))
            # It does not come to its end before all is sent.
            step = view(run)
            waits = run.time > 0.2 and not (sent and sent[0].done())
            return 0.0 if waits else step

        result = simulate(scenario, attend=attend)
        sent[0].result()
    meshcat.AddSlider("last", 0.0, 1.0, 0.01, 0.0)
    watching.sendall(frame(msgpack.packb({"type": "slider", "name": "last", "value": 0.5})))
    heard = _soon(lambda: meshcat.GetSliderValue("last") == 0.5)
    watching.close()
    door.close()
    if not heard:
        return "Meshcat hears nothing any more"
    return "" if result.completed else f"the run {result.end}"


def _soon(holds: Callable[[], bool]) -> bool:
    for _ in range(300):
        if holds():
            return True
        time.sleep(0.02)
    return False


def try_frames(count: int, seed: int = 0) -> int:
    """Send so many frames, some to each of several simulations; count those that they have ended.

    Each is a process of its own, since what a frame ends is the whole process.
    """
    wrong = 0
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    for first in range(seed, seed + count, TOGETHER):
        some = min(TOGETHER, seed + count - first)
        command = [sys.executable, __file__, str(some), str(first)]
        try:
            done = subprocess.run(
                command, env=environment, capture_output=True, text=True, timeout=PATIENCE
            )
            told = done.stdout.strip() if done.returncode == 0 else done.stderr[-400:]
        except subprocess.TimeoutExpired:
            told = "it does not come to its end"
        if told:
            wrong += 1
            print(f"{first} to {first + some - 1}: {told}", flush=True)
    return wrong


if __name__ == "__main__":
    print(shown(*map(int, sys.argv[1:])))
