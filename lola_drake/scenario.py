"""One reproducible experiment: its parameters, its YAML file, its variants.

A `Scenario` is a tree of frozen dataclasses with a default for everything, so that a file names
only what it changes. Every number carries its unit and range (`lola_drake.parameters`).
"""

import dataclasses
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from lola_drake import typed_yaml
from lola_drake.blocks.com_dynamics import ComDynamicsParams
from lola_drake.blocks.contact_switches import ContactSwitchesParams
from lola_drake.blocks.damping_force_control import DampingForceControlParams
from lola_drake.blocks.foot_force_sensor import FootForceSensorParams
from lola_drake.blocks.force_distribution import ForceDistributionParams
from lola_drake.blocks.force_laws import FORCE_LAWS
from lola_drake.blocks.hybrid_force_control import HybridForceControlParams
from lola_drake.blocks.imu import ImuParams
from lola_drake.blocks.imu_stabilizer import ImuStabilizerParams
from lola_drake.blocks.inverse_kinematics import InverseKinematicsParams
from lola_drake.blocks.joint_servos import JointServosParams
from lola_drake.blocks.second_order_force_control import SecondOrderForceControlParams
from lola_drake.blocks.two_dof_force_control import TwoDofForceControlParams
from lola_drake.blocks.walking_pattern import WalkingPatternParams
from lola_drake.bus import MissedCycles
from lola_drake.errors import LolaError, short, shown
from lola_drake.feasibility import check_command, check_start, check_steps, footprints
from lola_drake.ground import Ground
from lola_drake.model_errors import ModelErrors
from lola_drake.obstacles import Obstacle as Obstacle  # part of the schema
from lola_drake.parameters import ParameterError, listing, parameter, validate
from lola_drake.paths import scenario_paths
from lola_drake.pushes import Push
from lola_drake.walk import StartPose, Walk
from lola_drake.worlds import Worlds

VARIANTS = ("ref", "dyn", "original")

PLANTS = ("drake", "mujoco")

PREDECESSOR = "configuration_space"
"""The force law of the variant `original`."""

SWITCHES = ("sensed_area", "exact_angles")
"""Of the section `control.force`: they are of the paper's law alone."""

PATH = 1000
"""Greatest length of a path."""

DESCRIPTION = 240
"""Greatest length of a description."""


class ScenarioError(LolaError):
    """A scenario that cannot be used; the message is one line that says where and why."""


@dataclass(frozen=True)
class Sensors:
    """The sensors; `ideal` makes them exact: no noise, bias, delay or filter."""

    ideal: bool = parameter(False, "exact sensors, without noise, bias, delay or filter")
    imu: ImuParams = field(default_factory=ImuParams)
    foot_force: FootForceSensorParams = field(default_factory=FootForceSensorParams)
    contact: ContactSwitchesParams = field(default_factory=ContactSwitchesParams)
    missed: tuple[MissedCycles, ...] = listing("faults: bus cycles without their values", 1000)

    def __post_init__(self):
        validate(self)


@dataclass(frozen=True)
class Control:
    """The controller behind the walking pattern, block by block.

    Attributes:
        force: Of the paper's force law, and of what is the same for all of them.
    """

    law: str = parameter("hybrid", "of the feet's forces", choices=tuple(FORCE_LAWS))
    stabilizer: ImuStabilizerParams = field(default_factory=ImuStabilizerParams)
    distribution: ForceDistributionParams = field(default_factory=ForceDistributionParams)
    force: HybridForceControlParams = field(default_factory=HybridForceControlParams)
    damping: DampingForceControlParams = field(default_factory=DampingForceControlParams)
    second_order: SecondOrderForceControlParams = field(
        default_factory=SecondOrderForceControlParams
    )
    two_dof: TwoDofForceControlParams = field(default_factory=TwoDofForceControlParams)
    com_dynamics: ComDynamicsParams = field(default_factory=ComDynamicsParams)
    inverse_kinematics: InverseKinematicsParams = field(default_factory=InverseKinematicsParams)
    servos: JointServosParams = field(default_factory=JointServosParams)

    def __post_init__(self):
        validate(self)
        for name in SWITCHES:
            if self.law != "hybrid" and getattr(self.force, name):
                allowed = f"false with the force law {self.law}"
                raise ParameterError(f"force.{name}", True, allowed)

    def of_law(self) -> Any:
        """Return the parameters of the force law: the section that its block takes."""
        kind = FORCE_LAWS[self.law].Params
        return next(section for section in vars(self).values() if type(section) is kind)


@dataclass(frozen=True)
class OwnLaw:
    """A law of your own in place of a block; it is Python code that will be run."""

    name: str = parameter("", "of the block; without its foot it means both feet")
    law: str = parameter("", "where it is: FILE.py:CLASS", longest=PATH)

    def __post_init__(self):
        validate(self)
        file, _, name = self.law.rpartition(":")
        if not file.endswith(".py") or not name.isidentifier():
            raise ParameterError("law", self.law, "of the form FILE.py:CLASS")


@dataclass(frozen=True, repr=False)
class Scenario:
    """One experiment, complete: a run depends on nothing else but the versions of the software.

    Attributes:
        variant: `dyn` is the controller with integrated CoM dynamics, `ref` the one without, both
            with the force law `control.law`; `original` is `ref` with the law
            `configuration_space`, the predecessor [23] of both.
    """

    name: str = parameter(
        "unnamed", "the name of its file, unless the file says otherwise", longest=50
    )
    description: str = parameter("", "one line for the list of scenarios", longest=DESCRIPTION)
    duration: float = parameter(10.0, "simulated time", "s", minimum=0.001, maximum=3600)
    seed: int = parameter(0, "of all random numbers", "", minimum=0, maximum=1_000_000_000)
    variant: str = parameter("dyn", "of the controller", choices=VARIANTS)
    plant: str = parameter("drake", "the engine of the robot and its ground", choices=PLANTS)
    start: StartPose = field(default_factory=StartPose)
    walk: Walk = field(default_factory=Walk)
    pattern: WalkingPatternParams = field(default_factory=WalkingPatternParams)
    sensors: Sensors = field(default_factory=Sensors)
    control: Control = field(default_factory=Control)
    ground: Ground = field(default_factory=Ground)
    model_errors: ModelErrors = field(default_factory=ModelErrors)
    worlds: Worlds = field(default_factory=Worlds)
    pushes: tuple[Push, ...] = listing("forces from outside on the robot", 100)
    blocks: tuple[OwnLaw, ...] = listing("laws of your own in place of blocks", 32)

    def __post_init__(self):
        validate(self)
        if self.name[:1] in ("", ".", "-") or set(self.name) & set("/\\"):
            raise ParameterError("name", self.name, "usable as the name of a folder")
        if self.variant == "original":
            self._check_predecessor()
        if self.pattern.height_adaptation and self.active_control().law == PREDECESSOR:
            key, allowed = "pattern.height_adaptation", f"false with the law {PREDECESSOR}"
            raise ParameterError(key, True, allowed)
        self._check_servos()
        width = self.pattern.step_width
        check_start(self.start, width, self.terrain)
        check_steps(self.walk.steps)
        check_command(self.walk.command, self.pattern.step_time)

    def __repr__(self):
        return f"<Scenario {self.name} ({self.variant}): {self.duration:g} s, seed {self.seed}>"

    def _check_predecessor(self) -> None:
        """Raise ParameterError where the variant original is given another law, or its switches."""
        if self.control.law not in ("hybrid", PREDECESSOR):
            allowed = f"{PREDECESSOR} in the variant original, or left as it is"
            raise ParameterError("control.law", self.control.law, allowed)
        for name in SWITCHES:
            if getattr(self.control.force, name):
                raise ParameterError(f"control.force.{name}", True, "false in the variant original")

    def _check_servos(self) -> None:
        """Raise ParameterError where the error of the servos makes them too stiff or too soft."""
        try:
            self.real_servos()
        except ParameterError as error:
            allowed = f"such that control.servos.position_gain times it is {error.allowed}"
            key, factor = "model_errors.servo_gain", self.model_errors.servo_gain
            raise ParameterError(key, factor, allowed) from None

    def active_sensors(self) -> Sensors:
        """Return what the sensors run with: where they are ideal, nothing disturbs them."""
        if not self.sensors.ideal:
            return self.sensors
        names = ("imu", "foot_force", "contact")
        exact = {name: getattr(self.sensors, name).ideal() for name in names}
        return dataclasses.replace(self.sensors, **exact)

    @cached_property
    def terrain(self) -> Ground:
        """Return the ground as it lies there, with what is under the planned footholds."""
        if not self.ground.footholds:
            return self.ground
        last = max(foothold.step + foothold.count for foothold in self.ground.footholds)
        feet = footprints(self.start, self.walk.planned(last), self.pattern.step_width)
        try:
            return self.ground.laid(feet)
        except ParameterError as error:
            raise error.under("ground") from None

    def real_servos(self) -> JointServosParams:
        """Return the servos as they are, and not as the controller takes them."""
        servos, error = self.control.servos, self.model_errors.servo_gain
        return dataclasses.replace(servos, position_gain=error * servos.position_gain)

    def active_control(self) -> Control:
        """Return what the controller runs with in this variant: `ref` is the gain 0."""
        if self.variant == "dyn":
            return self.control
        com_dynamics = dataclasses.replace(self.control.com_dynamics, gain=0.0)
        law = PREDECESSOR if self.variant == "original" else self.control.law
        return dataclasses.replace(self.control, com_dynamics=com_dynamics, law=law)


Overrides = Mapping[str, object] | Iterable[str] | str

LARGEST = 1_000_000
"""Greatest size of a scenario's file (bytes)."""


def as_scenario(scenario: "Scenario | str | Path") -> Scenario:
    """Return the scenario that is meant by itself, by its name, or by the path of its file."""
    return scenario if isinstance(scenario, Scenario) else load_scenario(scenario)


def load_scenario(name_or_path: str | Path, overrides: Overrides = ()) -> Scenario:
    """Return a scenario from a file, checked.

    Args:
        name_or_path: The name of a scenario that comes with the package, or a path to YAML.
        overrides: Changes to it, see `override`.

    Raises:
        ScenarioError: If there is no such file, or anything in it cannot be used.
    """
    if not isinstance(name_or_path, (str, Path)):
        raise ScenarioError(f"{shown(name_or_path)}: neither a scenario nor a name nor a path")
    path = _find(name_or_path)
    try:
        # An empty file is a scenario, too: everything has a default.
        data = typed_yaml.parse(_read(path))
        data = {} if data is None else data
        if isinstance(data, dict):
            data.setdefault("name", path.stem)
        scenario = _with_laws_beside(path, typed_yaml.build(Scenario, data))
    except UnicodeDecodeError:
        raise ScenarioError(f"{path}: not a text file in UTF-8") from None
    except OSError as error:
        raise ScenarioError(f"{short(str(path), 100)}: {error.strerror}") from None
    except ValueError as error:
        raise ScenarioError(f"{path}: {error}{_more(error)}") from None
    return override(scenario, overrides)


def _with_laws_beside(path: Path, scenario: Scenario) -> Scenario:
    """Return the scenario of a file with its laws' files, which may be given relative to it."""
    laws = tuple(
        dataclasses.replace(own, law=str(path.absolute().parent / own.law))
        for own in scenario.blocks
    )
    return dataclasses.replace(scenario, blocks=laws)


def _read(path: Path) -> str:
    with path.open("rb") as file:
        content = file.read(LARGEST + 1)
    if len(content) > LARGEST:
        raise ValueError(f"larger than {LARGEST / 1e6:g} MB, not a scenario")
    return content.decode("utf-8")


def _find(name_or_path: str | Path) -> Path:
    path, known = Path(name_or_path), scenario_paths()
    if path.suffix in (".yaml", ".yml") or len(path.parts) != 1:
        return path
    if path.name not in known:
        name = short(str(path), 60)
        raise ScenarioError(f"{name}: no such scenario{typed_yaml.suggestion(name, known)}")
    return known[path.name]


def _more(error: ValueError) -> str:
    """Return where to read more about the section of the key that an error is about."""
    key = re.split(r"[^a-z_.]", getattr(error, "key", ""))[0].rstrip(".")
    is_section = isinstance(error, typed_yaml.KeyPathError)
    section = key if is_section else key.rpartition(".")[0] or key
    return f"; see: lola keys {section}".rstrip() if hasattr(error, "key") else ""


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
        raise ScenarioError(f"override of {scenario.name}: {error}{_more(error)}") from None


def _pairs(overrides: Overrides) -> Iterable[tuple[str, object]]:
    pairs: Iterable[tuple[str, object]]
    if isinstance(overrides, Mapping):
        pairs = overrides.items()
    else:
        texts = [overrides] if isinstance(overrides, str) else overrides
        pairs = map(_pair, texts)
    for key, value in pairs:
        if not isinstance(key, str):
            raise ValueError(f"{shown(key)} is not a key, such as 'control.force.time_constant'")
        yield key, value


def _pair(text: object) -> tuple[str, object]:
    key, equals, value = text.partition("=") if isinstance(text, str) else ("", "", "")
    if not equals or not key:
        raise ValueError(f"{shown(text)} is not of the form key=value")
    return key, typed_yaml.parse(value)


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
