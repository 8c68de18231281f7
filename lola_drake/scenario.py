"""One reproducible experiment: its parameters, its YAML file, its variants.

A `Scenario` is a tree of frozen dataclasses with a default for everything, so that a file names
only what it changes. Every number carries its unit and range (`lola_drake.parameters`).
"""

import dataclasses
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from lola_drake import typed_yaml
from lola_drake.blocks.com_dynamics import ComDynamicsParams
from lola_drake.blocks.contact_switches import ContactSwitchesParams
from lola_drake.blocks.foot_force_sensor import FootForceSensorParams
from lola_drake.blocks.force_distribution import ForceDistributionParams
from lola_drake.blocks.hybrid_force_control import HybridForceControlParams
from lola_drake.blocks.imu import ImuParams
from lola_drake.blocks.imu_stabilizer import ImuStabilizerParams
from lola_drake.blocks.inverse_kinematics import InverseKinematicsParams
from lola_drake.blocks.joint_servos import JointServosParams
from lola_drake.blocks.walking_pattern import WalkingPatternParams
from lola_drake.parameters import ParameterError, parameter, validate
from lola_drake.paths import scenario_paths

VARIANTS = ("ref", "dyn", "original")


class ScenarioError(ValueError):
    """A scenario that cannot be used; the message is one line that says where and why."""


@dataclass(frozen=True)
class StartPose:
    """Where the robot stands at t = 0, in W."""

    x: float = parameter(0.0, "midpoint between the feet, x", "m")
    y: float = parameter(0.0, "midpoint between the feet, y", "m")
    heading_deg: float = parameter(0.0, "direction it faces", "deg")

    def __post_init__(self):
        validate(self)


@dataclass(frozen=True)
class StepGroup:
    """A number of equal steps; each moves the robot's frame once by length, sideways and turn."""

    count: int = parameter(1, "how many such steps", "", minimum=1)
    length: float = parameter(0.0, "forward per step", "m", minimum=-0.8, maximum=0.8)
    sideways: float = parameter(0.0, "to the left per step", "m", minimum=-0.3, maximum=0.3)
    turn_deg: float = parameter(0.0, "to the left per step", "deg", minimum=-45, maximum=45)

    def __post_init__(self):
        validate(self)


@dataclass(frozen=True)
class TimedCommand:
    """What the user asks for from one time on, until the next command."""

    time: float = parameter(0.0, "from when on, simulated time", "s", minimum=0.0)
    v_x: float = parameter(0.0, "forward", "m/s")
    v_y: float = parameter(0.0, "to the left", "m/s")
    turn_rate: float = parameter(0.0, "to the left", "rad/s")

    def __post_init__(self):
        validate(self)


@dataclass(frozen=True)
class Walk:
    """Where to walk: planned steps, or a user's commands over time; neither means stand.

    Attributes:
        start_time: When the first of the planned steps begins.
        steps: Groups of steps, one after the other.
        command: Commands in the order of their times; before the first one the robot stands.
    """

    start_time: float = parameter(1.0, "when the planned steps begin", "s", minimum=0.0)
    steps: tuple[StepGroup, ...] = ()
    command: tuple[TimedCommand, ...] = ()

    def __post_init__(self):
        validate(self)
        times = [command.time for command in self.command]
        if self.steps and self.command:
            raise ParameterError("command", times, "empty where there are steps (give one of both)")
        if any(later <= earlier for earlier, later in zip(times, times[1:], strict=False)):
            raise ParameterError("command", times, "in the order of strictly increasing times")


@dataclass(frozen=True)
class Sensors:
    """The sensors; `ideal` makes them exact: no noise, bias, delay or filter."""

    ideal: bool = parameter(False, "exact sensors, without noise, bias, delay or filter")
    imu: ImuParams = field(default_factory=ImuParams)
    foot_force: FootForceSensorParams = field(default_factory=FootForceSensorParams)
    contact: ContactSwitchesParams = field(default_factory=ContactSwitchesParams)

    def __post_init__(self):
        validate(self)


@dataclass(frozen=True)
class Control:
    """The controller behind the walking pattern, block by block."""

    stabilizer: ImuStabilizerParams = field(default_factory=ImuStabilizerParams)
    distribution: ForceDistributionParams = field(default_factory=ForceDistributionParams)
    force: HybridForceControlParams = field(default_factory=HybridForceControlParams)
    com_dynamics: ComDynamicsParams = field(default_factory=ComDynamicsParams)
    inverse_kinematics: InverseKinematicsParams = field(default_factory=InverseKinematicsParams)
    servos: JointServosParams = field(default_factory=JointServosParams)


@dataclass(frozen=True)
class Obstacle:
    """A board or platform that lies on the floor."""

    name: str = parameter("board", "what it is called in the model and in plots")
    position: tuple[float, float] = parameter((0.0, 0.0), "x and y of its centre in W", "m")
    heading_deg: float = parameter(0.0, "direction of its length", "deg")
    size: tuple[float, float] = parameter((0.4, 1.0), "length and width", "m", above=0.0)
    height: float = parameter(0.04, "height of its top over the floor", "m", above=0.0)
    free_shift: tuple[float, float] = parameter(
        (0.0, 0.0), "how far it may be moved along its length without another experiment", "m"
    )

    def __post_init__(self):
        validate(self)
        if self.free_shift[0] > self.free_shift[1]:
            raise ParameterError("free_shift", self.free_shift, "from the least to the greatest")

    def shifted(self, distance: float) -> "Obstacle":
        """Return it moved along its length (m)."""
        heading = math.radians(self.heading_deg)
        x, y = self.position
        moved = (x + distance * math.cos(heading), y + distance * math.sin(heading))
        return dataclasses.replace(self, position=moved)

    def covers(self, x: float, y: float) -> bool:
        """Return whether a point of W lies over it."""
        heading = math.radians(self.heading_deg)
        c, s = math.cos(heading), math.sin(heading)
        d_x, d_y = x - self.position[0], y - self.position[1]
        along, across = c * d_x + s * d_y, c * d_y - s * d_x
        return abs(along) <= self.size[0] / 2 and abs(across) <= self.size[1] / 2


@dataclass(frozen=True)
class Ground:
    """The floor at z = 0 and what lies on it, all of one material."""

    stiffness: float = parameter(3e5, "vertical, of one whole foot on it", "N/m", above=0.0)
    dissipation: float = parameter(2.5, "Hunt-Crossley dissipation", "s/m", minimum=0.0)
    friction: float = parameter(0.8, "Coulomb friction coefficient", "", minimum=0.0)
    friction_speed: float = parameter(
        1e-3,
        "at which friction is full; below it the pads creep (own choice, for speed: a tenth of it "
        "makes a step of the plant half again as costly)",
        "m/s",
        above=0.0,
    )
    obstacles: tuple[Obstacle, ...] = ()

    def __post_init__(self):
        validate(self)
        names = [obstacle.name for obstacle in self.obstacles]
        if len(set(names)) < len(names):
            raise ParameterError("obstacles", names, "a list in which every name differs")

    def height_at(self, x: float, y: float) -> float:
        """Return the height of the ground at a point of W (m)."""
        return max((o.height for o in self.obstacles if o.covers(x, y)), default=0.0)


@dataclass(frozen=True)
class Scenario:
    """One experiment, complete: a run depends on nothing else but the versions of the software.

    Attributes:
        variant: `dyn` is the controller with integrated CoM dynamics, `ref` the one without;
            `original` is the predecessor [23] of both, see `configuration_force_control`.
    """

    name: str = parameter("unnamed", "the name of its file, unless the file says otherwise")
    description: str = parameter("", "one line for the list of scenarios")
    duration: float = parameter(10.0, "simulated time", "s", above=0.0)
    seed: int = parameter(0, "of all random numbers", "", minimum=0)
    variant: str = parameter("dyn", "of the controller", choices=VARIANTS)
    start: StartPose = field(default_factory=StartPose)
    walk: Walk = field(default_factory=Walk)
    pattern: WalkingPatternParams = field(default_factory=WalkingPatternParams)
    sensors: Sensors = field(default_factory=Sensors)
    control: Control = field(default_factory=Control)
    ground: Ground = field(default_factory=Ground)

    def __post_init__(self):
        validate(self)
        if self.name in ("", ".", "..") or set(self.name) & set("/\\\0"):
            raise ParameterError("name", self.name, "usable as the name of a folder")

    def active_control(self) -> Control:
        """Return what the controller runs with in this variant: `ref` is the gain 0."""
        if self.variant == "dyn":
            return self.control
        com_dynamics = dataclasses.replace(self.control.com_dynamics, gain=0.0)
        return dataclasses.replace(self.control, com_dynamics=com_dynamics)


Overrides = Mapping[str, object] | Iterable[str]


def load_scenario(name_or_path: str | Path, overrides: Overrides = ()) -> Scenario:
    """Return a scenario from a file, checked.

    Args:
        name_or_path: The name of a scenario that comes with the package, or a path to YAML.
        overrides: Changes to it, see `override`.

    Raises:
        ScenarioError: If there is no such file, or anything in it cannot be used.
    """
    path = _find(name_or_path)
    try:
        data = typed_yaml.parse(path.read_text(encoding="utf-8"))
        if isinstance(data, dict):
            data.setdefault("name", path.stem)
        scenario = typed_yaml.build(Scenario, data)
    except UnicodeDecodeError:
        raise ScenarioError(f"{path}: not a text file in UTF-8") from None
    except OSError as error:
        raise ScenarioError(f"{path}: {error.strerror}") from None
    except ValueError as error:
        raise ScenarioError(f"{path}: {error}") from None
    return override(scenario, overrides)


def _find(name_or_path: str | Path) -> Path:
    path, known = Path(name_or_path), scenario_paths()
    if path.suffix in (".yaml", ".yml") or len(path.parts) != 1:
        return path
    if path.name not in known:
        raise ScenarioError(f"{path}: no such scenario{typed_yaml.suggestion(path, known)}")
    return known[path.name]


def override(scenario: Scenario, overrides: Overrides) -> Scenario:
    """Return the scenario with some values changed.

    Args:
        scenario: Where to start from.
        overrides: Dotted keys and their values, either a mapping such as
            `{"control.com_dynamics.gain": 0}` or texts such as `"ground.obstacles.0.height=0.05"`.

    Raises:
        ScenarioError: If a key does not exist or the result cannot be used.
    """
    data = typed_yaml.plain(scenario)
    try:
        for key, value in _pairs(overrides):
            typed_yaml.set_at(data, key, typed_yaml.plain(value))
        return typed_yaml.build(Scenario, data)
    except ValueError as error:
        raise ScenarioError(f"override of {scenario.name}: {error}") from None


def _pairs(overrides: Overrides) -> Iterable[tuple[str, object]]:
    if isinstance(overrides, Mapping):
        yield from overrides.items()
        return
    for text in overrides:
        key, equals, value = text.partition("=")
        if not equals or not key:
            raise ValueError(f"{text!r} is not of the form key=value")
        yield key, typed_yaml.parse(value)


def dump_scenario(scenario: Scenario) -> str:
    """Return the whole scenario, defaults included, as YAML text that loads to an equal one."""
    return typed_yaml.dump(scenario)


def differences(scenario: Scenario, base: Scenario | None = None) -> dict[str, object]:
    """Return what differs from `base` (the defaults, unless given) as dotted keys and values.

    As overrides of `base`, they make the scenario again.
    """
    old = typed_yaml.leaves(typed_yaml.plain(base or Scenario()))
    new = typed_yaml.leaves(typed_yaml.plain(scenario))
    return {key: value for key, value in new.items() if value != old[key]}
