"""What a page says to Meshcat is passed on as it is, or not at all."""

import io

import msgpack
import pytest
from fuzz_frames import ODD, frame

from lola_drake.view3d.messages import LONGEST, sound_frames, sound_message

SLIDER = {"type": "slider", "name": "g_a (-)", "value": 0.3}
PAD = {"index": 0, "button_values": [0.0, 1.0], "axes": [0.5, -1.0]}
GOOD = (
    SLIDER,
    {"type": "button", "name": "stop [Esc]"},
    {"type": "gamepad", "name": "", "gamepad": PAD},
    {"type": "gamepad", "name": "", "gamepad": {}},
)


def passed(*frames):
    return list(sound_frames(io.BytesIO(b"".join(frames))))


@pytest.mark.parametrize("message", GOOD, ids=str)
def test_what_the_controls_say_is_passed_on(message):
    assert sound_message(msgpack.packb(message)) == message
    assert passed(frame(msgpack.packb(message))) == [frame(msgpack.packb(message))]


def test_what_is_masked_is_read():
    content = msgpack.packb(SLIDER)
    mask = b"\x01\x80\xff\x37"
    masked = bytes(c ^ mask[i % 4] for i, c in enumerate(content))
    assert passed(bytes([0x82, 0x80 | len(content)]) + mask + masked) == [frame(content)]


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"\xc1",
        msgpack.packb(SLIDER)[:-4],
        msgpack.packb(SLIDER) + b"\x00",
        b"\x91" * 5000,
        msgpack.packb([SLIDER]),
        msgpack.packb({"type": "camera_pose", "camera_pose": [1.0] * 16, "is_perspective": True}),
        msgpack.packb({"type": "gamepad", "gamepad": PAD | {"axes": [float("nan")]}}),
        msgpack.packb({"type": "gamepad", "gamepad": PAD | {"index": 2**40}}),
        msgpack.packb({"type": "button", "name": b"stop [Esc]"}),
        *(msgpack.packb(SLIDER | {"value": v}) for v in ODD if v is not True and v != -1),
    ],
)
def test_what_meshcat_has_not_asked_for_is_passed_over(content):
    assert sound_message(content) is None
    good = frame(msgpack.packb(SLIDER))
    assert passed(frame(content), good) == ([good] if len(content) <= LONGEST else [])


def test_what_is_passed_over_does_not_end_the_page():
    assert passed(frame(b""), frame(msgpack.packb(SLIDER))) == [frame(msgpack.packb(SLIDER))]
    assert passed(frame(b"ok", kind=0x89)) == [frame(b"ok", kind=0x89)]


@pytest.mark.parametrize(
    "bad",
    [
        frame(bytes(LONGEST + 1)),
        frame(b"", size=2**62),
        frame(b"text", kind=0x81),
        frame(b"a part", kind=0x02),
        frame(b"squeezed", kind=0xC2),
        b"\x82\x00",
        b"\x82\x85\x00\x00",
    ],
)
def test_what_breaks_the_rules_ends_the_page(bad):
    assert passed(bad, frame(msgpack.packb(SLIDER))) == []
