"""Machine code for laws: what is compiled again, what is refused, and where it is kept."""

import types

import numpy as np
import pytest

from lola_drake import compiled as module
from lola_drake.block_system import BlockSystem, sample_arguments
from lola_drake.blocks.imu_stabilizer import ImuStabilizer, ImuStabilizerParams
from lola_drake.compiled import (
    NotCompilable,
    cache_folder,
    compiled,
    compiled_text,
    compiling,
    digest,
    is_kept,
)
from lola_drake.fused import FusedSystem

pytest.importorskip("numba")

TEXT = """
FACTOR = 2.0
TABLE = np.array([1.0, 2.0])
PAIR = (1.0, TABLE)

def inner(x):
    return x + 1.0

def helper(x):
    return FACTOR * inner(x)

def law(x):
    return helper(x) + TABLE[0] + PAIR[0] + settings.offset

def other(x):
    return x
"""


def space(text=TEXT, **settings):
    """Return the names of a program text; it sees a module called settings."""
    names = {"np": np, "settings": types.ModuleType("settings"), "__name__": "a_users_module"}
    vars(names["settings"]).update({"offset": 0.25, "unused": 1.0} | settings)
    exec(text, names)
    return names


def changed(old, new):
    assert old in TEXT
    return space(TEXT.replace(old, new))


def test_the_same_code_has_the_same_digest():
    assert digest(space()["law"]) == digest(space()["law"])


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("return helper(x)", "return 1.0 + helper(x)"),
        ("FACTOR * inner(x)", "inner(x) * FACTOR"),
        ("x + 1.0", "x + 1.5"),
        ("FACTOR = 2.0", "FACTOR = 3.0"),
        ("FACTOR = 2.0", "FACTOR = np.float64(3.0)"),
        ("np.array([1.0, 2.0])", "np.array([1.0, 2.5])"),
        ("np.array([1.0, 2.0])", "np.array([1, 2])"),
        ("PAIR = (1.0,", "PAIR = (2.0,"),
        ("helper(x):", "helper(x, y=2.0):"),
    ],
)
def test_digest_changes_with_all_that_a_law_refers_to(old, new):
    assert digest(changed(old, new)["law"]) != digest(space()["law"])


def test_digest_changes_with_the_module_that_what_is_kept_names():
    law, moved = space()["law"], space()["law"]
    moved.__module__ = "elsewhere"
    assert digest(moved) != digest(law)


def test_digest_changes_with_a_constant_in_a_module():
    assert digest(space(offset=0.5)["law"]) != digest(space()["law"])


@pytest.mark.parametrize(("old", "new"), [("return x\n", "return 2 * x\n"), ("other", "another")])
def test_digest_does_not_change_with_what_it_does_not_refer_to(old, new):
    assert digest(changed(old, new)["law"]) == digest(space()["law"])
    assert digest(space(unused=2.0)["law"]) == digest(space()["law"])


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("x + 1.0", "x + 1.0", 10.25),
        ("x + 1.0", "x + 2.0", 12.25),
        ("FACTOR = 2.0", "FACTOR = 3.0", 14.25),
        ("np.array([1.0, 2.0])", "np.array([4.0, 2.0])", 13.25),
    ],
)
def test_a_changed_law_is_compiled_anew(old, new, expected):
    law = changed(old, new)["law"]
    assert compiled(law, (1.0,))(3.0) == law(3.0) == expected


def test_a_law_and_its_helpers_stay_plain_python():
    names = space()
    law = names["law"]
    compiled(law, (1.0,))
    assert isinstance(law, types.FunctionType)
    assert names["helper"] is law.__globals__["helper"]
    assert isinstance(names["helper"], types.FunctionType)


def test_integers_and_arrays_have_code_of_their_own():
    def law(x, n):
        return x[0] / n

    assert compiled(law, (np.zeros(1), 2))(np.array([3.0]), 2) == 1.5
    assert compiled(law, (np.zeros(1), 2.0))(np.array([3.0]), 4.0) == 0.75


def test_a_closure_is_refused():
    factor = 2.0

    def law(x):
        return factor * x

    with pytest.raises(NotCompilable, match="law is a closure"):
        compiled(law, (1.0,))


def test_a_helper_that_is_a_closure_is_refused():
    def scaling(factor):
        return lambda x: factor * x

    law = space()["law"]
    law.__globals__["helper"] = scaling(2.0)
    with pytest.raises(NotCompilable, match="is a closure"):
        compiled(law, (1.0,))


def with_an_import(x):
    import math

    return math.fsum([x, 1.0])


def with_itself(x):
    return 1.0 if x < 1.0 else x * with_itself(x - 1.0)


def with_an_object(x):
    return x + ImuStabilizerParams().stiffness


def with_a_wrong_kind(x):
    return x["one"]


@pytest.mark.parametrize("law", [with_an_import, with_itself, with_an_object, with_a_wrong_kind])
def test_what_numba_does_not_know_is_refused_in_one_line(law):
    with pytest.raises(NotCompilable) as caught:
        compiled(law, (1.0,))
    assert str(caught.value) and "\n" not in str(caught.value)


def test_a_division_by_zero_is_no_error_in_machine_code():
    def law(x):
        return 1.0 / x

    assert compiled(law, (1.0,))(0.0) == np.inf


def test_a_program_text_calls_its_laws():
    text = "def tick(v):\n    v[0] = law_0(v[1])\n"
    function = compiled_text("tick", text, {"law_0": space()["law"]})
    v = np.array([0.0, 3.0])
    function(v)
    assert v[0] == 10.25


@pytest.fixture
def fresh_folder(tmp_path, monkeypatch):
    """Let machine code be kept in a folder of the test's own, and forget what is in memory."""

    def use(folder):
        monkeypatch.setenv("XDG_CACHE_HOME", str(folder))
        for cached in (cache_folder, module._twin):
            cached.cache_clear()
        return cache_folder()

    yield use
    cache_folder.cache_clear()
    module._twin.cache_clear()
    module._called.cache_clear()


def test_machine_code_is_kept_in_the_users_cache(fresh_folder, tmp_path):
    folder = fresh_folder(tmp_path)
    assert folder == tmp_path / "lola_drake"
    law = space()["law"]
    twin = compiled(law, (1.0,))
    assert is_kept(twin) and list(folder.rglob("law_*.nbi"))
    assert twin.stats.cache_misses
    module._twin.cache_clear()
    module._called.cache_clear()
    again = compiled(law, (1.0,))
    assert again.stats.cache_hits and not again.stats.cache_misses
    assert again(3.0) == 10.25
    assert not list(folder.glob("*.tmp"))


def test_a_program_is_kept_after_it_was_compiled(fresh_folder, tmp_path):
    fresh_folder(tmp_path)
    text = "def tick(v):\n    v[0] = law_0(v[1])\n"
    laws = {"law_0": space()["law"]}
    function = compiled_text("tick", text, laws)
    assert not is_kept(function)
    function(np.zeros(2))
    assert is_kept(compiled_text("tick", text, laws))
    assert not is_kept(compiled_text("tick", text, {"law_0": space(offset=1.0)["law"]}))


def test_a_changed_helper_compiles_itself_and_what_calls_it_again_and_no_more(
    fresh_folder, tmp_path
):
    folder = fresh_folder(tmp_path)
    compiled(space()["law"], (1.0,))
    compiled(changed("FACTOR * inner(x)", "3.0 * inner(x)")["law"], (1.0,))
    stubs = [path.name.rsplit("_", 1)[0] for path in folder.glob("*.py")]
    called = ["call_law", "call_law"]
    assert sorted(stubs) == [*called, "helper", "helper", "inner", "law", "law"]


def test_without_a_place_for_a_cache_a_temporary_one_is_used(fresh_folder, tmp_path):
    (tmp_path / "file").write_text("")
    folder = fresh_folder(tmp_path / "file")
    assert folder.is_dir() and tmp_path not in folder.parents
    assert compiled(space()["law"], (1.0,))(3.0) == 10.25


def test_with_a_read_only_cache_a_temporary_one_is_used(fresh_folder, tmp_path, monkeypatch):
    monkeypatch.setattr(module.os, "access", lambda path, mode: tmp_path not in path.parents)
    folder = fresh_folder(tmp_path)
    assert folder.is_dir() and tmp_path not in folder.parents
    assert compiled(space()["law"], (1.0,))(3.0) == 10.25


def test_compiling_can_be_switched_off(monkeypatch):
    monkeypatch.delenv("LOLA_COMPILE", raising=False)
    assert compiling()
    monkeypatch.setenv("LOLA_COMPILE", "0")
    assert not compiling()


def test_without_numba_nothing_is_compiled(monkeypatch):
    monkeypatch.setattr(module.importlib.util, "find_spec", lambda name: None)
    assert not compiling()


@pytest.mark.parametrize("switch", ["0", "1"])
def test_a_switch_decides_whether_systems_compile(monkeypatch, switch):
    """Patched is what compiles: it tells, and refuses."""
    asked = []

    def refuse(*args):
        asked.append(args)
        raise NotCompilable("not here")

    monkeypatch.setenv("LOLA_COMPILE", switch)
    monkeypatch.setattr("lola_drake.block_system.compiled", refuse)
    monkeypatch.setattr("lola_drake.fused.compiled", refuse)
    monkeypatch.setattr("lola_drake.fused.compiled_text", refuse)
    block = ImuStabilizer(ImuStabilizerParams(height_stiffness=1500.0))
    system = BlockSystem(block)
    assert bool(asked) == (switch == "1")
    asked.clear()
    fused = FusedSystem({"imu_stabilizer": block})
    assert bool(asked) == (switch == "1")
    # Refused or not asked for: the laws run as they are.
    expected = np.array([1.0, 1.0, 1.0 + 1500.0 * 2, 1.0 - 120.0, 1.0 - 120.0, 1.0])
    found = output(system, "modified_wrench"), output(fused, "tick")
    assert np.array_equal(found[0], expected)
    assert np.array_equal(found[1][fused.layout.signals["modified_wrench"]], expected)
    asked.clear()
    FusedSystem({"imu_stabilizer": block}, compile_laws=False)
    assert not asked


def output(system, name):
    """Return an output with all inputs at 1."""
    context = system.CreateDefaultContext()
    for i in range(system.num_input_ports()):
        system.get_input_port(i).FixValue(context, np.ones(system.get_input_port(i).size()))
    return system.GetOutputPort(name).Eval(context)


def test_sample_arguments_are_of_the_kinds_a_law_gets():
    block = ImuStabilizer(ImuStabilizerParams(height_stiffness=1500.0))
    samples = sample_arguments(block, "modified_wrench")
    kinds = [type(sample) for sample in samples]
    assert kinds == [np.ndarray] * 6 + [float] * 4
