"""Sensor noise as a pure function of seed and time.

A sensor's noise must not be state: then a run can be repeated from any moment, and a copied
context gives the same future. It is drawn in chunks that are kept in a memo.
"""

import numpy as np

CHUNK = 1024


class Noise:
    """White Gaussian noise; sample k is the same whenever it is asked for."""

    def __init__(self, deviation: np.ndarray, seed: int, stream: int):
        """Create the noise of one sensor.

        Args:
            deviation: standard deviation of every entry, shape (size,).
            seed: of the run.
            stream: number of the sensor; streams are independent.
        """
        self._deviation, self._key = deviation, (seed, stream)
        self.size = len(deviation)
        self._number, self._chunk = -1, np.empty((0, len(deviation)))

    def __call__(self, k: int) -> np.ndarray:
        """Return sample k >= 0, shape (size,)."""
        number, row = divmod(k, CHUNK)
        if number != self._number:
            generator = np.random.default_rng([*self._key, number])
            sample = generator.standard_normal((CHUNK, len(self._deviation)))
            self._chunk = self._deviation * sample
            self._number = number
        return self._chunk[row]
