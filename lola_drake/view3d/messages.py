"""What a page may say to Meshcat: whole messages of sliders, buttons and gamepads, nothing else.

Meshcat ends the whole process at a message that is cut off, or at a camera's pose that is none.
"""

import math
from collections.abc import Iterator
from io import BufferedIOBase

import msgpack

LONGEST = 65536
"""A page that sends more than this at once (bytes) is no page of Meshcat."""

_BINARY, _CLOSE, _PING, _PONG = 0x82, 0x88, 0x89, 0x8A
_NO_MASK = bytes(4)


def sound_frames(source: BufferedIOBase) -> Iterator[bytes]:
    """Yield what may be passed on of a page's WebSocket, until it ends or breaks the rules.

    Args:
        source: gives the bytes of the page, behind its handshake.
    """
    for kind, content in _frames(source):
        if kind == _BINARY:
            message = sound_message(content)
            if message is None:
                continue
            content = msgpack.packb(message)
        yield _frame(kind, content)


def sound_message(content: bytes) -> dict | None:
    """Return what a message says, without what nobody has asked for; None if it is none."""
    try:
        message = msgpack.unpackb(content)
    except (ValueError, msgpack.UnpackException, TypeError):
        return None
    match message:
        case {"type": "button", "name": str(name)}:
            return {"type": "button", "name": name}
        case {"type": "slider", "name": str(name), "value": int() | float() as value}:
            return {"type": "slider", "name": name, "value": float(value)} if _fits(value) else None
        case {"type": "gamepad", "gamepad": {"index": int(index), "axes": list(axes)} as pad}:
            buttons = pad.get("button_values", [])
            if not isinstance(buttons, list) or not all(map(_fits, [index, *axes, *buttons])):
                return None
            values = {"button_values": list(map(float, buttons)), "axes": list(map(float, axes))}
            return {"type": "gamepad", "name": "", "gamepad": {"index": int(index), **values}}
        case {"type": "gamepad", "gamepad": dict(pad)} if not pad:
            return {"type": "gamepad", "name": "", "gamepad": {}}
    return None


def _fits(value: object) -> bool:
    """Return whether a value is a number of reasonable size."""
    return isinstance(value, (int, float)) and math.isfinite(value) and abs(value) < 2**31


def _frames(source: BufferedIOBase) -> Iterator[tuple[int, bytes]]:
    """Yield kind and content of the frames of a page: whole, masked, and not too long."""
    while len(head := source.read(2)) == 2:
        kind, size = head[0], head[1] & 0x7F
        masked = head[1] & 0x80
        if size > 125:
            size = int.from_bytes(source.read(2 if size == 126 else 8), "big")
        if not masked or kind not in (_BINARY, _CLOSE, _PING, _PONG) or size > LONGEST:
            return
        mask, content = source.read(4), source.read(size)
        if len(mask) < 4 or len(content) < size:
            return
        yield kind, bytes(byte ^ mask[i % 4] for i, byte in enumerate(content))


def _frame(kind: int, content: bytes) -> bytes:
    """Return a frame as a page sends it."""
    size = len(content)
    if size <= 125:
        head = bytes([kind, 0x80 | size])
    elif size < 65536:
        head = bytes([kind, 0x80 | 126]) + size.to_bytes(2, "big")
    else:
        head = bytes([kind, 0x80 | 127]) + size.to_bytes(8, "big")
    return head + _NO_MASK + content
