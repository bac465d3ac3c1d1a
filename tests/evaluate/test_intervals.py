import numpy as np
import pytest
from numpy.testing import assert_allclose

from graft.errors import InputError
from graft.evaluate.intervals import bootstrap_mean


def test_a_constant_has_no_width():
    estimate = bootstrap_mean([0.7] * 9, range(9))
    assert_allclose([estimate.value, estimate.low, estimate.high], 0.7)


def test_seed_decides():
    values, targets = list(np.random.default_rng(0).random(30)), list(range(30))
    assert bootstrap_mean(values, targets, seed=1) == bootstrap_mean(values, targets, seed=1)
    assert bootstrap_mean(values, targets, seed=1) != bootstrap_mean(values, targets, seed=2)


def test_width_is_the_standard_error():
    values = (np.arange(400) % 4 == 0).astype(float)
    estimate = bootstrap_mean(list(values), range(400))
    expected = 1.96 * np.sqrt(0.25 * 0.75 / 400)
    assert_allclose(estimate.high - estimate.value, expected, rtol=0.15)
    assert_allclose(estimate.value - estimate.low, expected, rtol=0.15)


def test_measuring_a_target_more_often_does_not_narrow_the_interval():
    values = list(np.random.default_rng(0).random(20))
    once = bootstrap_mean(values, range(20))
    often = bootstrap_mean(values * 50, list(range(20)) * 50)
    assert_allclose([often.value, often.low, often.high], [once.value, once.low, once.high])


def test_order_does_not_matter_to_the_value():
    values, targets = [1.0, 0.0, 0.5], ["a", "b", "a"]
    assert bootstrap_mean(values, targets).value == bootstrap_mean(values[::-1], targets[::-1]).value


@pytest.mark.parametrize(("values", "targets"), [([], []), ([1.0], [])])
def test_nothing_to_average_is_an_error(values, targets):
    with pytest.raises(InputError, match="values"):
        bootstrap_mean(values, targets)
