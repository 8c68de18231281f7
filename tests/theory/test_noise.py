"""Sensor noise: a function of seed, stream and time alone, white and of unit variance."""

import numpy as np
import pytest

from lola_drake.theory.noise import CHUNK, Noise

LONG = 20 * CHUNK


def samples(seed=0, stream=1, count=LONG, deviation=(1.0, 1.0)):
    noise = Noise(np.array(deviation), seed, stream)
    return np.array([noise(k) for k in range(count)])


def test_a_sample_is_the_same_whenever_it_is_asked_for():
    order = np.random.default_rng(0).permutation(3 * CHUNK)
    noise, forward = Noise(np.ones(2), 0, 1), samples(count=3 * CHUNK)
    shuffled = {k: noise(k).copy() for k in order[:200].tolist()}
    assert all(np.array_equal(sample, forward[k]) for k, sample in shuffled.items())
    for k in (0, CHUNK, 2 * CHUNK + 5):
        assert np.array_equal(Noise(np.ones(2), 0, 1)(k), forward[k])


def test_another_instance_gives_the_same_samples():
    assert np.array_equal(samples(seed=4, count=100), samples(seed=4, count=100))


@pytest.mark.parametrize("other", [{"seed": 1}, {"stream": 2}, {"seed": 1, "stream": 0}])
def test_other_seeds_and_streams_are_independent(other):
    one, two = samples(), samples(**other)
    correlation = np.corrcoef(one.T, two.T)[:2, 2:]
    assert np.abs(correlation).max() < 5 / np.sqrt(LONG)


def test_variance_is_one_and_mean_is_zero():
    drawn = samples()
    assert drawn.var(axis=0) == pytest.approx(np.ones(2), abs=0.05)
    assert drawn.mean(axis=0) == pytest.approx(np.zeros(2), abs=5 / np.sqrt(LONG))


def test_entries_and_neighbours_are_uncorrelated():
    drawn = samples()
    assert abs(np.corrcoef(drawn.T)[0, 1]) < 5 / np.sqrt(LONG)
    assert abs(np.corrcoef(drawn[1:, 0], drawn[:-1, 0])[0, 1]) < 5 / np.sqrt(LONG)


def test_chunks_do_not_repeat():
    drawn = samples(count=2 * CHUNK)
    assert not np.array_equal(drawn[:CHUNK], drawn[CHUNK:])


def test_deviation_scales_every_entry():
    assert samples(count=10, deviation=(3.0, 0.0)) == pytest.approx(
        samples(count=10) * [3.0, 0.0], abs=1e-12
    )
