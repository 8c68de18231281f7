"""What is said of many runs: shares, medians, their intervals, and whether a change is chance."""

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.stats import binomtest, bootstrap, wilcoxon

from lola_drake.studies.row import survived

CONFIDENCE = 0.95


def share(summaries: Sequence[Mapping]) -> dict[str, float]:
    """Return the share of runs that came to their end, and its Wilson interval."""
    up = sum(map(survived, summaries))
    interval = binomtest(up, len(summaries)).proportion_ci(CONFIDENCE, method="wilson")
    return {"share": up / len(summaries), "low": interval.low, "high": interval.high}


def median(values: np.ndarray) -> float | None:
    """Return the median; None of nothing."""
    return float(np.median(values)) if len(values) else None


def interval(values: np.ndarray) -> list[float] | None:
    """Return the 95 % bootstrap interval of the median; None of fewer than two values."""
    if len(values) < 2:
        return None
    found = bootstrap((values,), np.median, method="percentile", rng=np.random.default_rng(0))
    return [float(bound) for bound in found.confidence_interval]


def paired_p(values: np.ndarray) -> float | None:
    """Return how likely changes so far from none are by chance (Wilcoxon); None of too few."""
    return float(wilcoxon(values).pvalue) if len(values) > 5 and values.any() else None


def quartiles(values: np.ndarray) -> list[float] | None:
    """Return the first and the third quartile; None of nothing."""
    return np.percentile(values, [25, 75]).tolist() if len(values) else None
