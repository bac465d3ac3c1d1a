"""Envelope gradients against finite differences of the solver's own minimum."""

import numpy as np
import pytest
from ufgw_problems import make_pair

from graft.errors import InputError
from graft.transport import ufgw, ufgw_gradients

TIGHT = {"tol": 1e-12, "max_outer": 5000}
STEP = 1e-5
CASES = [
    {},
    {"alpha": 0.2, "tau_s": 0.3, "tau_t": 4.0},
    {"em_rate": 0.4},
    {"loss": "absolute"},
    {"entropy": "unit"},
    {"entropy": "plain", "em_rate": 0.3},
    {"tau_s": np.inf},
    {"tau_t": np.inf},
]


def value(data, options):
    found = ufgw(*data, **options, **TIGHT)
    return found.objective + found.terms["prior"]


@pytest.mark.parametrize("options", CASES, ids=str)
@pytest.mark.parametrize("symmetric", [True, False])
def test_gradients_are_the_differences(options, symmetric):
    pair = make_pair(3, 4, 3, symmetric=symmetric)
    found = ufgw(*pair.data, **options, **TIGHT)
    prior = {"prior": pair.nu} if "em_rate" in options else {}
    gradients = ufgw_gradients(found, pair.A, pair.B, **options, **prior)
    rng = np.random.default_rng(0)
    for position, name in enumerate(("M", "A", "B", "mu", "nu")):
        direction = rng.normal(size=pair.data[position].shape)
        values = []
        for sign in (1, -1):
            data = [x.copy() for x in pair.data]
            data[position] = data[position] + sign * STEP * direction
            values.append(value(data, options))
        expected = (values[0] - values[1]) / (2 * STEP)
        assert (getattr(gradients, name) * direction).sum() == pytest.approx(expected, rel=2e-5, abs=2e-7), name


def test_massless_nodes_have_no_gradient_of_mass():
    pair = make_pair(4)
    mu = pair.mu.copy()
    mu[1] = 0.0
    found = ufgw(pair.M, pair.A, pair.B, mu, pair.nu)
    gradients = ufgw_gradients(found, pair.A, pair.B)
    assert gradients.mu[1] == 0
    assert np.isfinite(gradients.nu).all()


def test_shapes_are_checked():
    pair = make_pair(5)
    found = ufgw(*pair.data, em_rate=0.4)
    with pytest.raises(InputError, match=r"^A: expected numbers of shape \(5, 5\), got shape \(4, 4\)$"):
        ufgw_gradients(found, pair.B, pair.B)
    with pytest.raises(InputError, match=r"^prior: expected numbers of shape \(4,\), got shape \(0,\)$"):
        ufgw_gradients(found, pair.A, pair.B, em_rate=0.4)
