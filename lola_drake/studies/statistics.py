"""What is said of many runs: shares, medians, their intervals, and whether a change is chance."""

from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np
from scipy.stats import binomtest, bootstrap, wilcoxon

from lola_drake.studies.row import survived

CONFIDENCE = 0.95

RESAMPLES = 9999
"""Of a bootstrap, unless there are many to make."""

UNEXPLAINED = "nothing that is known"


def share(summaries: Sequence[Mapping]) -> dict[str, float]:
    """Return the share of runs that came to their end, and its Wilson interval."""
    up = sum(map(survived, summaries))
    interval = binomtest(up, len(summaries)).proportion_ci(CONFIDENCE, method="wilson")
    return {
        "share": up / len(summaries),
        "low": float(interval.low),
        "high": float(interval.high),
    }


def median(values: np.ndarray) -> float | None:
    """Return the median; None of nothing."""
    return float(np.median(values)) if len(values) else None


def interval(values: np.ndarray, resamples: int = RESAMPLES) -> list[float] | None:
    """Return the 95 % bootstrap interval of the median; None of fewer than two values."""
    if len(values) < 2:
        return None
    found = bootstrap(
        (values,),
        np.median,
        n_resamples=resamples,
        confidence_level=CONFIDENCE,
        method="percentile",
        rng=np.random.default_rng(0),
    )
    return [float(bound) for bound in found.confidence_interval]


def paired_p(values: np.ndarray) -> float | None:
    """Return how likely changes so far from none are by chance (Wilcoxon); None of too few."""
    return float(wilcoxon(values).pvalue) if len(values) > 5 and values.any() else None


def quartiles(values: np.ndarray) -> list[float] | None:
    """Return the first and the third quartile; None of nothing."""
    return np.percentile(values, [25, 75]).tolist() if len(values) else None


def spread(values: np.ndarray, resamples: int = 1000) -> dict[str, object]:
    """Return median, quartiles, and the interval of the median."""
    return {
        "median": median(values),
        "quartiles": quartiles(values),
        "interval_95": interval(values, resamples),
    }


def causes(summaries: Sequence[Mapping]) -> dict[str, int]:
    """Return how often what came first before a fall, the most frequent one first.

    Of a limit of a joint it is told which; of runs without a fall nothing.
    """
    fallen = [summary for summary in summaries if summary["fell"]]
    first = (summary.get("fall_events") or [{"event": UNEXPLAINED}] for summary in fallen)
    return dict(Counter(events[0]["event"] for events in first).most_common())
