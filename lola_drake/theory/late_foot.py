"""A foot that finds no ground where it is planned: how late it is, and how it seeks it.

The paper says nothing of it; all here is our own choice.
"""

from lola_drake.signals import PERIOD

TOUCHED = -1.0
"""Instead of how long a foot is overdue: it has touched the ground since its last swing."""


def overdue_time(overdue, planned, closed):
    """Return how long a foot has been overdue on the ground, in the next tick (s).

    `TOUCHED` holds from the first touch to the next swing, whatever the switches do: a foot that is
    unloaded, or that bounces, is not late.

    Args:
        overdue: the same in this tick.
        planned: 1 where the plan has the foot on the ground, 0 in its swing.
        closed: number of the foot's closed switches.
    """
    if planned < 0.5:
        return 0.0
    if closed > 0 or overdue < 0:
        return TOUCHED
    return overdue + PERIOD


def seeking_rate(rate, overdue, onset, ramp, speed):
    """Return the rate of a foot's height (m/s): a late foot goes down at least at a landing speed.

    Own choice. It ends where the foot touches, or at the limit of Delta w. The load moves on to the
    foot as planned; nothing waits for it.

    Args:
        rate: by eq. 16 and 21.
        overdue: how long the foot has been overdue (s), or `TOUCHED`.
        onset: how long it may be (s).
        ramp: duration in which the search reaches its speed (s).
        speed: of the search (m/s), downward.
    """
    late = min(max((overdue - onset) / ramp, 0.0), 1.0)
    return rate + late * min(-speed - rate, 0.0)
