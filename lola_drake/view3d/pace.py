"""How fast a running simulation goes on, and how fast it could."""

import time


class Clock:
    """Keeps simulated time from running ahead of real time."""

    def __init__(self) -> None:
        self._start: tuple[float, float] | None = None
        self._rate = 0.0

    def stop(self) -> None:
        """Let the time that passes now not count."""
        self._start = None

    def wait(self, now: float, rate: float) -> None:
        """Sleep until the simulated time is due."""
        if self._start is None or rate != self._rate:
            self._start, self._rate = (now, time.perf_counter()), rate
        if rate > 0.0:
            began, real = self._start
            ahead = (now - began) / rate - (time.perf_counter() - real)
            if ahead > 0.0:
                time.sleep(ahead)
            elif ahead < -0.2:
                # Too slow for the rate: lost time is not made up for later.
                self._start = (now, time.perf_counter())


class Pace:
    """How fast a simulation could run: without waiting, drawing and telling."""

    def __init__(self) -> None:
        self._began: tuple[float, float] | None = None
        self.possible = 0.0

    def begin(self, now: float) -> None:
        """Begin to compute at a simulated time (s)."""
        self._began = now, time.perf_counter()

    def computed(self, now: float) -> None:
        """Note that it is computed until a simulated time (s)."""
        if self._began is not None:
            began, real = self._began
            pace = (now - began) / max(time.perf_counter() - real, 1e-6)
            # Smoothed: a new plan takes longer than what lies between.
            self.possible += 0.05 * (pace - self.possible) if self.possible else pace
            self._began = None
