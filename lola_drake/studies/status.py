"""How far a study is, and its last runs."""

from datetime import datetime

from lola_drake.errors import ResultError, shown
from lola_drake.studies.row import OUTCOMES
from lola_drake.studies.store import Store


def status(store: Store) -> dict[str, object]:
    """Return how many runs there are, how they ended, and how far the last order is."""
    counts = dict(store.execute("SELECT outcome, count(*) FROM runs GROUP BY outcome"))
    runs = sum(counts.values())
    order = store.execute("SELECT * FROM orders ORDER BY id DESC LIMIT 1").fetchone()
    found: dict[str, object] = {
        "file": str(store.file),
        "runs": runs,
        "outcomes": {name: counts.get(name, 0) for name in OUTCOMES},
        "last_order": None,
        "runs_per_hour": None,
    }
    if order is None:
        return found
    _, wanted, there, before, began = order
    made, hours = runs - before, _hours(began, _last(store))
    last = {"began": began, "wanted": wanted, "done": there + made}
    rate = made / hours if made and hours > 0 else None
    return found | {"last_order": last, "runs_per_hour": rate}


def last_runs(store: Store, count: int, outcome: str | None = None) -> list[dict[str, object]]:
    """Return the last runs of a study, the last one first.

    Args:
        store: the study's file.
        count: the most of them.
        outcome: one of `OUTCOMES`, or None for all.
    """
    if outcome not in (None, *OUTCOMES):
        raise ResultError(f"outcome: {shown(outcome)}, there are {', '.join(OUTCOMES)}")
    where = ("outcome = ?", outcome) if outcome else ("1",)
    return [
        {
            "run": row.number,
            "scenario": row.summary["scenario"],
            "variant": row.summary["variant"],
            "seed": row.summary["seed"],
            "outcome": row.outcome,
            "fall_time_s": row.summary["fall_time_s"],
            "error": row.summary["error"],
            "tries": row.tries,
            "worker": row.worker,
            "finished": row.finished,
        }
        for row in store.rows(*where, order=f"id DESC LIMIT {count}")
    ]


def _last(store: Store) -> str:
    return store.execute("SELECT max(finished) FROM runs").fetchone()[0] or ""


def _hours(began: str, ended: str) -> float:
    if not ended:
        return 0.0
    taken = datetime.fromisoformat(ended) - datetime.fromisoformat(began)
    return taken.total_seconds() / 3600
