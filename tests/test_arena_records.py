"""The evaluations of laws that come with the package."""

from lola_drake.blocks.force_laws import FORCE_LAWS
from lola_drake.paths import arena_records
from lola_drake.studies.arena import FIRST_SEED, TRIALS
from lola_drake.studies.ranking import evaluation_table, load_evaluation


def test_every_law_of_the_package_has_been_in_the_arena():
    kept = [load_evaluation(file) for file in arena_records()]
    assert {evaluation["law"] for evaluation in kept} == set(FORCE_LAWS)
    assert {evaluation["worlds"] for evaluation in kept} == {6}
    assert {evaluation["first_seed"] for evaluation in kept} == {FIRST_SEED}
    assert evaluation_table(kept).row_count == 6


def test_what_is_kept_are_sizes_of_todays_trials():
    sizes = {trial.title: set(trial.sizes) for trial in TRIALS}
    for file in arena_records():
        for title, trial in load_evaluation(file)["trials"].items():
            for curve in trial["curves"].values():
                assert {point["size"] for point in curve} <= sizes[title]
