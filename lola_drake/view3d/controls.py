"""Meshcat's control panel of a running simulation: sliders, buttons, keys and gamepad."""

from dataclasses import dataclass

import numpy as np
from pydrake.geometry import Meshcat

from lola_drake.run import Gain, Run

RATE = "rate (0: max)"
PAUSE, STOP, STAND = "pause, go on [P]", "stop [Esc]", "stand still [X]"
REPLAY, KEEP = "replay the last 20 s [R]", "keep the last 20 s [O]"
IMPULSE = "push (Ns)"
PUSHES = {
    "push forward [I]": ("KeyI", (1.0, 0.0)),
    "push back [K]": ("KeyK", (-1.0, 0.0)),
    "push left [J]": ("KeyJ", (0.0, 1.0)),
    "push right [L]": ("KeyL", (0.0, -1.0)),
}

DEAD = 0.12
"""A gamepad's stick within this of its middle is at rest."""


@dataclass(frozen=True)
class Steering:
    """One part of the walk command: its slider, its keys, and the gamepad's axis.

    Attributes:
        label: Of the slider, with keys and unit.
        doc: What it does.
        limit: Greatest value.
        step: Of the slider and of one key press.
        less, more: Key codes.
        axis: Of the gamepad; forward and left are negative there.
    """

    label: str
    doc: str
    limit: float
    step: float
    less: str
    more: str
    axis: int


_AHEAD, _ASIDE, _ROUND = (
    ("v_x ↓↑ (m/s)", "back and forward; left stick"),
    ("v_y DA (m/s)", "right and left; left stick"),
    ("turn →← (rad/s)", "right and left; right stick"),
)
STEERING = (
    Steering(*_AHEAD, 0.5, 0.05, "ArrowDown", "ArrowUp", 1),
    Steering(*_ASIDE, 0.12, 0.02, "KeyD", "KeyA", 0),
    Steering(*_ROUND, 0.3, 0.05, "ArrowRight", "ArrowLeft", 2),
)


class Controls:
    """Sliders and buttons, and what was done with them since they were last looked at."""

    def __init__(
        self, meshcat: Meshcat, *, steering: bool, pushes: bool = True, keeping: bool = False
    ):
        """Show the controls; a panel that was there before is replaced.

        Args:
            meshcat: Where.
            steering: Whether the robot follows the panel's walk command.
            pushes: Whether the robot can be pushed.
            keeping: Whether what just happened can be kept.
        """
        meshcat.DeleteAddedControls()
        self._meshcat, self._steering = meshcat, steering
        self._clicks: dict[str, int] = {}
        self._add_button(PAUSE, "KeyP")
        self._add_button(STOP, "Escape")
        self._add_button(REPLAY, "KeyR")
        if keeping:
            self._add_button(KEEP, "KeyO")
        self._values: dict[str, tuple[float, float, float]] = {}
        self._add_slider(RATE, 0.0, 2.0, 0.05, 1.0)
        if steering:
            for part in STEERING:
                ends = -part.limit, part.limit
                self._add_slider(part.label, *ends, part.step, 0.0, part.less, part.more)
            self._add_button(STAND, "KeyX")
        if pushes:
            for name, (key, _) in PUSHES.items():
                self._add_button(name, key)
            self._add_slider(IMPULSE, 1.0, 30.0, 1.0, 8.0)
        self._gains: dict[str, float] = {}

    def _add_button(self, name: str, key: str) -> None:
        self._meshcat.AddButton(name, key)
        self._clicks[name] = 0

    def _add_slider(self, label: str, low: float, high: float, *more) -> float:
        """Add a slider with step, value and keys; return its value, which it rounds."""
        value = self._meshcat.AddSlider(label, low, high, *more)
        self._values[label] = low, high, value
        return value

    def _value(self, label: str) -> float:
        """Return a slider's value; what a page sends need be no number within its ends."""
        low, high, last = self._values[label]
        sent = self._meshcat.GetSliderValue(label)
        value = min(max(sent, low), high) if np.isfinite(sent) else last
        self._values[label] = low, high, value
        return value

    def show_gains(self, run: Run) -> None:
        """Add a slider for every gain, at its value in the run."""
        for gain in run.gains():
            slider = (_label(gain), *gain.field.metadata["slider"], run.gain(gain))
            # The slider rounds: only what a user moves away from here counts.
            self._gains[_label(gain)] = self._add_slider(*slider)

    def told(self, run: Run) -> dict[str, list[tuple[str, str]]]:
        """Return what buttons, keys and sliders there are, for a page to tell."""
        buttons = [_split(name) for name in self._clicks]
        if self._steering:
            buttons = [*((part.label, part.doc) for part in STEERING), *buttons]
        sliders = [(RATE, "simulated over real time")]
        if IMPULSE in self._values:
            sliders.append((IMPULSE, "of a push, in 0.12 s at the torso"))
        gains = [(_label(g), f"{g.block}.{g.name}: {g.field.metadata['doc']}") for g in run.gains()]
        return {"keys": buttons, "sliders": sliders, "gains": gains}

    def apply_gains(self, run: Run) -> bool:
        """Give the run the gains whose sliders have been moved; return whether any has."""
        moved = False
        for gain in run.gains():
            value = self._value(_label(gain))
            if value != self._gains[_label(gain)]:
                run.set_gain(gain, value)
                self._gains[_label(gain)], moved = value, True
        return moved

    def clicked(self, name: str) -> bool:
        """Return whether a button was clicked since the last time this was asked."""
        count = self._meshcat.GetButtonClicks(name)
        before, self._clicks[name] = self._clicks[name], count
        return count > before

    @property
    def rate(self) -> float:
        """Return the wanted real-time rate; 0 means as fast as possible."""
        return self._value(RATE)

    def pushes(self) -> list[np.ndarray]:
        """Return the pushes asked for: forward and left (Ns)."""
        asked = [way for name, (_, way) in PUSHES.items() if self.clicked(name)]
        return [self._value(IMPULSE) * np.array(way) for way in asked]

    def command(self) -> np.ndarray:
        """Return the walk command, from the gamepad if one is in use, or from the sliders."""
        if self.clicked(STAND):
            for part in STEERING:
                self._meshcat.SetSliderValue(part.label, 0.0)
        pad = self._meshcat.GetGamepad()
        axes = np.clip(np.nan_to_num(pad.axes), -1.0, 1.0).tolist()
        if pad.index is not None and np.abs(axes).max(initial=0.0) > DEAD:
            return gamepad_command(axes)
        return np.array([self._value(part.label) for part in STEERING])


def _label(gain: Gain) -> str:
    """Return a slider's name: short, since the panel is narrow."""
    symbol = gain.field.metadata["symbol"] or gain.name.replace("_", " ")
    unit = gain.field.metadata["unit"]
    return f"{symbol} ({unit})" if unit else symbol


def _split(name: str) -> tuple[str, str]:
    """Return the key of a button and what it does, from its name."""
    what, _, key = name.rstrip("]").partition(" [")
    return key, what


def gamepad_command(axes: list[float]) -> np.ndarray:
    """Return the walk command that the sticks of a gamepad ask for."""
    command = np.zeros(len(STEERING))
    for i, part in enumerate(STEERING):
        value = axes[part.axis] if part.axis < len(axes) else 0.0
        if abs(value) > DEAD:
            command[i] = -np.sign(value) * part.limit * (abs(value) - DEAD) / (1 - DEAD)
    return command
