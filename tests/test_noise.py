"""Noise: a pure function of seed, stream and time."""

import numpy as np

from lola_drake.blocks.noise import CHUNK, Noise

ONES = np.ones(3)


def samples(noise, count=4 * CHUNK):
    return np.array([noise(k) for k in range(count)])


def test_sample_does_not_depend_on_when_it_is_asked_for():
    noise = Noise(ONES, seed=1, stream=1)
    forward = samples(noise)
    for k in (3 * CHUNK + 5, 2, CHUNK, 2):
        np.testing.assert_array_equal(noise(k), forward[k])


def test_same_seed_gives_the_same_noise_and_another_seed_another():
    one = samples(Noise(ONES, seed=1, stream=1))
    np.testing.assert_array_equal(one, samples(Noise(ONES, seed=1, stream=1)))
    assert not np.any(one == samples(Noise(ONES, seed=2, stream=1)))


def test_entries_streams_and_chunks_are_independent():
    rows = [samples(Noise(ONES, seed=1, stream=stream)).T for stream in (1, 2)]
    chunks = [rows[0][:, n * CHUNK : (n + 1) * CHUNK] for n in range(4)]
    for independent in (np.vstack(rows), np.vstack(chunks)):
        correlation = np.corrcoef(independent) - np.eye(len(independent))
        assert np.abs(correlation).max() < 5 / np.sqrt(CHUNK)


def test_noise_is_white_and_has_the_wanted_deviation():
    noise = samples(Noise(np.array([0.5, 2.0]), seed=3, stream=1))
    np.testing.assert_allclose(noise.mean(axis=0), 0, atol=0.1)
    np.testing.assert_allclose(noise.std(axis=0), [0.5, 2.0], rtol=0.05)
    assert abs(np.corrcoef(noise[1:, 0], noise[:-1, 0])[0, 1]) < 0.05
