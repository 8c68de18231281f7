"""Sensor noise as a pure function of seed and time.

A sensor's noise must not be state: then a run can be repeated from any moment, and a copied
context gives the same future. It is drawn in chunks that are kept in a memo.
"""

import numpy as np

CHUNK = 1024


class Noise:
    """White Gaussian noise of unit variance; sample k is the same whenever it is asked for."""

    def __init__(self, size: int, seed: int, stream: int):
        """Create the noise of one sensor.

        Args:
            size: entries per sample.
            seed: of the run.
            stream: number of the sensor; streams are independent.
        """
        self._size, self._key = size, (seed, stream)
        self._number, self._chunk = -1, np.empty((0, size))

    def __call__(self, k: int) -> np.ndarray:
        """Return sample k >= 0, shape (size,)."""
        number, row = divmod(k, CHUNK)
        if number != self._number:
            generator = np.random.default_rng([*self._key, number])
            self._chunk = generator.standard_normal((CHUNK, self._size))
            self._number = number
        return self._chunk[row]
