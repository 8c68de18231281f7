"""The arena and what is said of a law in it, with a stand-in for the simulation."""

import json
import math

import pytest
from browser import ask, needs_browser

from lola_drake.blocks.force_laws import FORCE_LAWS
from lola_drake.reports.evaluation_page import evaluation_page
from lola_drake.results import ResultError
from lola_drake.scenario import ScenarioError, dump_scenario
from lola_drake.studies import evaluation as module
from lola_drake.studies.arena import FIRST_SEED, QUICK, TRIALS, Trial
from lola_drake.studies.evaluation import (
    bisecting,
    chosen,
    evaluate,
    half,
    law_name,
    law_settings,
    loop_margins,
)
from lola_drake.studies.ranking import (
    best,
    evaluation_table,
    half_rows,
    load_evaluation,
    margin_rows,
    with_others,
)

MARGINS = {"force_loop": {"stable": True, "disk": 0.5, "phase_deg": 40.0, "delay_s": None}}

BOARD = next(trial for trial in TRIALS if trial.title == "board")


class Falling:
    """Stands for a study: ref falls from 8 cm on, dyn from 12 cm on in the worlds of even seed."""

    def run(self, scenarios, progress):
        return [self._summary(scenario) for scenario in scenarios]

    @staticmethod
    def _summary(scenario):
        height = scenario.ground.footholds[0].height
        fell = (
            height > 0.07 if scenario.variant == "ref" else height > 0.11 and not scenario.seed % 2
        )
        return {
            "fell": fell,
            "max_inclination_deg": {"x": 3.0, "y": 4.0},
            "rms_torque_error_Nm": {"x": 0.0, "y": 2.0},
            "max_foot_force_N": 100.0 * height,
            "drive_work_J": 7.0,
        }


@pytest.fixture(scope="module")
def content():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "loop_margins", lambda settings, variant: MARGINS)
        return evaluate("hybrid", Falling(), 4, trials=[BOARD])


def other(content, law, by):
    """Return an evaluation of another law, which comes so much less far."""
    text = json.loads(json.dumps(content))
    text["law"] = law
    for trial in text["trials"].values():
        trial["half"] = {variant: by for variant in trial["half"]}
    return text


@pytest.mark.parametrize("trial", TRIALS, ids=lambda trial: trial.title)
def test_every_size_can_be_walked_and_differs(trial):
    worlds = [trial.world(size, FIRST_SEED, {"variant": "ref"}) for size in trial.sizes]
    assert list(trial.sizes) == sorted(trial.sizes)
    assert len({dump_scenario(world) for world in worlds}) == len(worlds)
    for world in worlds:
        last = world.walk.start_time + 0.8 * trial.steps
        assert world.duration > last + 1.0 and world.variant == "ref"


@pytest.mark.parametrize("law", FORCE_LAWS)
def test_every_law_takes_part(law):
    scenario = BOARD.world(6, FIRST_SEED, {**law_settings(law), "variant": "dyn"})
    assert (scenario.control.law, scenario.variant) == (law, "dyn")


def test_the_quick_trials_are_some_of_them():
    for trial in QUICK:
        (whole,) = (each for each in TRIALS if each.title == trial.title)
        assert set(trial.sizes) < set(whole.sizes)


def test_pushes_come_from_all_sides():
    pushes = [trial for trial in TRIALS if trial.direction_deg is not None]
    assert [push.direction_deg for push in pushes] == list(range(0, 360, 45))
    (push,) = pushes[2].world(12, FIRST_SEED, {}).pushes
    assert push.direction == pytest.approx([0.0, 1.0, 0.0]) and push.impulse == 12


def test_a_slope_is_as_steep_as_it_says_and_goes_where_it_says():
    slopes = {trial.title: trial for trial in TRIALS if trial.title.startswith("slope")}
    grounds = {name: slope.world(8, 0, {}).ground for name, slope in slopes.items()}
    gradient = math.tan(math.radians(8))

    def rise(ground, *way):
        (x, y), (to_x, to_y) = way
        return ground.height_at(to_x, to_y) - ground.height_at(x, y)

    assert rise(grounds["slope, up"], (1, 0), (2, 0)) == pytest.approx(gradient)
    assert rise(grounds["slope, down"], (1, 0), (2, 0)) == pytest.approx(-gradient)
    assert rise(grounds["slope, across"], (2, 0), (2, 0.3)) == pytest.approx(0.3 * gradient)
    for ground in grounds.values():
        before, behind = (ground.height_at(0.5 + side, 0) for side in (-1e-6, 1e-6))
        assert before == pytest.approx(behind, abs=1e-6)


def test_shares_and_medians_are_of_each_size_and_variant(content):
    trial = content["trials"]["board"]
    # What is beyond two sizes at which all fall is spared.
    assert [point["size"] for point in trial["curves"]["ref"]] == [4, 6, 8, 10]
    assert [point["share"] for point in trial["curves"]["ref"]] == [1, 1, 0, 0]
    assert [point["size"] for point in trial["curves"]["dyn"]] == [4, 6, 8, 10, 12, 14]
    assert [point["share"] for point in trial["curves"]["dyn"]] == [1, 1, 1, 1, 0.5, 0.5]
    standing, fallen = trial["curves"]["ref"][1], trial["curves"]["ref"][2]
    assert standing["inclination_deg"] == 5.0 and standing["torque_error_Nm"] == 2.0
    assert standing["foot_force_N"] == pytest.approx(6.0) and standing["drive_work_J"] == 7.0
    assert fallen["inclination_deg"] is None
    assert trial["half"] == {"ref": 7.0, "dyn": 12.0}


def test_half_lies_between_the_sizes_where_it_is_crossed():
    def curve(*shares):
        return [{"size": 2.0 * k, "share": share} for k, share in enumerate(shares)]

    assert half(curve(1.0, 0.75, 0.25)) == pytest.approx(3.0)
    assert half(curve(1.0, 0.6, 0.55)) is None
    assert half(curve(0.5, 1.0, 0.0)) == 0.0
    assert half(curve(1.0, 0.0, 1.0, 0.0)) == pytest.approx(1.0)


def test_a_law_is_known_or_a_file():
    assert law_settings("damping") == {"control.law": "damping"}
    ((own,),) = law_settings("laws/my.py:Mine").values()
    assert own["name"] == "force_control" and own["law"].endswith("/laws/my.py:Mine")
    assert law_name("laws/my.py:Mine") == "Mine" and law_name("damping") == "damping"
    with pytest.raises(ScenarioError, match=r"law 'dampin'.*damping"):
        law_settings("dampin")


def test_a_law_may_have_other_settings(monkeypatch):
    changes = ["pattern.step_adaptation=true", "control.delta=0.03"]
    monkeypatch.setattr(module, "loop_margins", lambda settings, variant: MARGINS)
    changed = law_settings("damping", changes[:1])
    assert changed == {"control.law": "damping", "pattern.step_adaptation": True}
    scenario = BOARD.world(6, FIRST_SEED, changed)
    assert scenario.pattern.step_adaptation and scenario.control.law == "damping"
    found = evaluate("hybrid", Falling(), 1, trials=[BOARD], changes=changes[:1])
    assert found["law"] == "hybrid pattern.step_adaptation=true"
    with pytest.raises(ScenarioError, match="delta"):
        law_settings("damping", changes)


def test_a_variant_may_go_alone(monkeypatch):
    monkeypatch.setattr(module, "loop_margins", lambda settings, variant: MARGINS)
    found = evaluate("hybrid", Falling(), 2, trials=[BOARD], variants=["dyn"])
    assert list(found["margins"]) == ["dyn"] == list(found["trials"]["board"]["half"])
    ((_, _, texts, _),) = half_rows([found])
    assert texts == ["12"]
    with pytest.raises(ScenarioError, match="variant 'original': must be one of ref, dyn"):
        evaluate("hybrid", Falling(), 2, trials=[BOARD], variants=["original"])


def test_half_may_be_found_with_few_sizes(monkeypatch, content):
    monkeypatch.setattr(module, "loop_margins", lambda settings, variant: MARGINS)
    found = evaluate("hybrid", Falling(), 4, trials=[BOARD], following=bisecting)["trials"]["board"]
    assert found["half"] == content["trials"]["board"]["half"]
    assert [point["size"] for point in found["curves"]["ref"]] == [4, 6, 8]


def test_bisecting_ends_beside_the_half_and_at_both_ends():
    sizes = (1.0, 2.0, 3.0, 4.0, 5.0)

    def tried(falls_from):
        curve = []
        while (size := bisecting(sizes, curve)) is not None:
            curve = sorted([*curve, {"size": size, "share": float(size < falls_from)}], key=str)
        return [point["size"] for point in curve], half(curve)

    assert tried(3.5) == ([3.0, 4.0], 3.5)
    assert tried(0.0) == ([1.0, 3.0], 1.0)
    assert tried(9.0) == ([3.0, 4.0, 5.0], None)


def test_progress_counts_what_is_spared_too(monkeypatch):
    class Counting(Falling):
        def run(self, scenarios, progress):
            progress(len(scenarios))
            return super().run(scenarios, progress)

    monkeypatch.setattr(module, "loop_margins", lambda settings, variant: MARGINS)
    told = []
    evaluate("hybrid", Counting(), 3, told.append, [BOARD])
    assert told == sorted(told) and told[-1] == 3 * 2 * len(BOARD.sizes)


def test_trials_are_chosen_by_how_their_titles_begin():
    assert chosen(TRIALS, []) == list(TRIALS)
    assert len(chosen(TRIALS, ["push"])) == 8
    titles = [trial.title for trial in chosen(TRIALS, ["slope, up", "edge"])]
    assert titles == ["edge, down", "slope, up"]
    with pytest.raises(ScenarioError, match=r"trial 'pull': none begins so.*'edge, down'"):
        chosen(TRIALS, ["push", "pull"])


def test_margins_are_those_of_the_worst_loop(monkeypatch):
    from lola_drake.linear.studies.analyses import analyse
    from lola_drake.scenario import load_scenario

    monkeypatch.setattr(module, "MARGINS", {"stabilizer": "stand"})
    found = loop_margins({}, "ref")["stabilizer"]
    model = analyse("stabilizer", load_scenario("stand", {"variant": "ref"}), locus=False)
    each = [margins for loop in model.loops for margins in loop.margins]
    assert found["phase_deg"] == min(margins.phase for margins in each)
    assert found["delay_s"] == min(margins.delay for margins in each)
    assert found["disk"] <= min(margins.disk for margins in each)


def test_the_best_of_a_trial_comes_farthest(content):
    near, far = other(content, "damping", 5.0), other(content, "two_dof", None)
    ((title, unit, texts, numbers),) = half_rows([content, near, far])
    assert (title, unit) == ("board", "cm")
    assert texts == ["7", "12", "5", "5", "> 10", "> 14"]
    # Beyond the last size the share there decides.
    assert best(numbers) == {5}
    assert best([(3.0, 0.0), (3.0, 0.0), None]) == set()


def test_a_trial_may_have_been_done_in_one_variant_alone(content):
    alone = json.loads(json.dumps(content))
    del alone["trials"]["board"]["half"]["ref"], alone["trials"]["board"]["curves"]["ref"]
    ((_, _, texts, _),) = half_rows([content, alone])
    assert texts == ["7", "12", "", "12"]
    assert "board" in evaluation_page([content, {**alone, "law": "damping"}])


def test_what_lies_beyond_the_sizes_of_one_record_is_not_ranked_by_them(content):
    """A record of few sizes says "< 12" of what another one finds at 10.5."""
    (_, _, _, (within, _)) = next(half_rows([other(content, "damping", 10.5)]))
    few = json.loads(json.dumps(content))
    for variant in ("ref", "dyn"):
        few["trials"]["board"]["curves"][variant] = [{"size": 12, "share": 0.0}]
        few["trials"]["board"]["half"][variant] = 12.0
    (_, _, (text, _), (below, _)) = next(half_rows([few]))
    assert text == "< 12" and best([within, below]) == {0}


def test_an_evaluation_stands_beside_others_of_other_laws(content):
    kept = [other(content, "hybrid", 1.0), other(content, "damping", 2.0)]
    assert [each["law"] for each in with_others(content, kept)] == ["hybrid", "damping"]
    table = evaluation_table(with_others(content, kept))
    assert len(table.columns) == 5 and table.row_count == 2
    assert "hybrid 4, damping 4" in str(table.title)


def test_margins_that_may_be_any_and_loops_that_are_unstable(content):
    rows = margin_rows([content])
    assert rows[0] == ["hybrid, ref: force_loop", "0.50", "40", "any"]
    broken = {"force_loop": {**MARGINS["force_loop"], "stable": False}}
    assert margin_rows([{**content, "margins": {"ref": broken}}])[0][1] == "unstable"


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"law": "x", "trials": {}}', "nonsense"])
def test_what_is_no_evaluation_is_refused(text, tmp_path):
    file = tmp_path / "other.json"
    file.write_text(text)
    with pytest.raises(ResultError, match="not an evaluation"):
        load_evaluation(file)
    with pytest.raises(ResultError, match="cannot be read"):
        load_evaluation(tmp_path / "nothing.json")


def test_what_was_written_is_read_again(content, tmp_path):
    file = tmp_path / "evaluation.json"
    file.write_text(json.dumps(content))
    assert load_evaluation(file)["trials"] == content["trials"]


@pytest.fixture
def page(content, tmp_path):
    pushes = {}
    for direction in (0.0, 90.0, 180.0, 270.0):
        trial = {**content["trials"]["board"], "direction_deg": direction, "unit": "Ns"}
        pushes[f"push, {direction:g}°"] = trial
    whole = {**content, "trials": content["trials"] | pushes}
    file = tmp_path / "evaluation.html"
    text = evaluation_page([whole, other(whole, "<my law>", 5.0)])
    file.write_text(text, encoding="utf-8")
    return file


def test_names_are_no_markup(page):
    text = page.read_text(encoding="utf-8")
    assert "&lt;my law&gt;" in text and "<my law>" not in text


@needs_browser
def test_the_page_draws_every_trial_and_hides_what_is_clicked(page):
    answer, complaints = ask(
        page,
        """
        await settled(() => document.documentElement.dataset.ready);
        const plots = [...document.querySelectorAll("#trials .plot")];
        const lines = () => plots[0].data.filter(trace => trace.name).map(trace => trace.name);
        const before = lines(), pushes = byId("pushes").data;
        byId("names").children[0].click();
        byId("what").value = "foot_force_N";
        byId("what").dispatchEvent(new Event("change"));
        return { count: plots.length, before, after: lines(), y: plots[0].data[0].y,
                 reach: pushes[0].r, theta: pushes[0].theta, misfits: misfits() };
        """,
        width=390,
        dark=True,
    )
    assert complaints == [] and answer["misfits"] == []
    assert answer["count"] == 5
    assert answer["before"] == ["hybrid, ref", "hybrid, dyn", "<my law>, ref", "<my law>, dyn"]
    assert answer["after"] == answer["before"][1:]
    assert answer["y"] == pytest.approx([4.0, 6.0, 8.0, 10.0, 12.0, 14.0])
    assert answer["reach"] == [7, 7, 7, 7, 7] and answer["theta"] == [0, 90, 180, 270, 0]


def test_a_trial_of_ones_own_is_a_function_of_its_size():
    trial = Trial("later", "s", (1.0, 2.0), lambda size: {"walk.start_time": size}, steps=2)
    assert trial.world(2.0, 3, {"variant": "ref"}).walk.start_time == 2.0
