"""Sensor noise as a pure function of seed and time.

A sensor's noise must not be state: then a run can be repeated from any moment, and a copied
context gives the same future. It is drawn in chunks that are kept in a memo.
"""

from collections.abc import Iterable

import numpy as np

CHUNK = 1024


class Chunked:
    """Samples that are made in chunks, of which the last one is kept."""

    def __init__(self):
        self._number, self._chunk = -1, np.empty((0, 0))

    def __call__(self, k: int) -> np.ndarray:
        """Return sample k >= 0, shape (size,)."""
        number, row = divmod(k, CHUNK)
        if number != self._number:
            self._number, self._chunk = number, self.chunk(number)
        return self._chunk[row]

    def chunk(self, number: int) -> np.ndarray:
        """Return a chunk, shape (CHUNK, size)."""
        raise NotImplementedError


class Noise(Chunked):
    """White Gaussian noise about what drifts; sample k is the same whenever it is asked for."""

    def __init__(
        self,
        deviation: np.ndarray,
        seed: int,
        stream: int,
        *,
        bias: np.ndarray | float = 0.0,
        drift: np.ndarray | float = 0.0,
    ):
        """Create the noise of one sensor.

        Args:
            deviation: standard deviation of every entry, shape (size,).
            seed: of the run.
            stream: number of the sensor; streams are independent.
            bias: mean at the start, shape (size,) or a number.
            drift: by how much the mean grows in every period, shape (size,) or a number.
        """
        super().__init__()
        self._deviation, self._key = deviation, (seed, stream)
        self._bias, self._drift = bias, drift
        self.size = len(deviation)

    def chunk(self, number: int) -> np.ndarray:
        """Return a chunk, shape (CHUNK, size)."""
        generator = np.random.default_rng([*self._key, number])
        ticks = CHUNK * number + np.arange(CHUNK)[:, None]
        mean = self._bias + ticks * self._drift
        return mean + self._deviation * generator.standard_normal((CHUNK, self.size))


class Noises(Chunked):
    """Several noises, their samples end to end."""

    def __init__(self, parts: Iterable[Noise]):
        super().__init__()
        self._parts = list(parts)

    def chunk(self, number: int) -> np.ndarray:
        """Return a chunk, shape (CHUNK, size of all)."""
        return np.hstack([np.empty((CHUNK, 0)), *(part.chunk(number) for part in self._parts)])
