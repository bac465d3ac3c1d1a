"""Bad arguments: one line that names the argument, what was expected and what came."""

import numpy as np
import pytest
from ufgw_problems import make_pair

from graft.errors import InputError
from graft.transport import ufgw, ufgw_batch

NAN = np.full((5, 4), np.nan)
BAD = [
    ({"alpha": 1.5}, r"^alpha: expected a number in \[0, 1\], got 1.5$"),
    ({"alpha": np.nan}, r"^alpha: .* got NaN$"),
    ({"tau_s": -1.0}, r"^tau_s: .* >= 0 .* got -1$"),
    ({"tau_t": np.nan}, r"^tau_t: .* got NaN$"),
    ({"eps": 0.0}, r"^eps: expected a finite number of at least 1e-9, got 0$"),
    ({"eps": 1e-300}, r"^eps: expected a finite number of at least 1e-9, got 0\.0+1$|at least 1e-9, got 1e-300$"),
    ({"eps": np.inf}, r"^eps: .* got inf$"),
    ({"tol": 0.0}, r"^tol: .* > 0, got 0$"),
    ({"max_outer": 0}, r"^max_outer: expected at least 1, got 0$"),
    ({"em_rate": 1.0}, r"^em_rate: expected None or a number in \[0, 1\), got 1$"),
    ({"loss": "cubic"}, r"^loss: expected one of square, absolute, got cubic$"),
    ({"entropy": "none"}, r"^entropy: expected one of relative, plain, unit, got none$"),
    ({"cost": "blunt"}, r"^cost: expected one of sharp, objective, paper, debiased, got blunt$"),
    ({"cost": "debiased"}, r"^self_features: cost='debiased' needs 1 pairs of matrices, got none$"),
    ({"M": np.zeros((4, 5))}, r"^M: expected numbers of shape \(5, 4\), got shape \(4, 5\)$"),
    ({"M": NAN}, r"^M: expected finite numbers, got NaN at flat index 0$"),
    ({"M": -np.ones((5, 4))}, r"^M: expected costs >= 0, got -1 at flat index 0$"),
    ({"M": [[1, 2], [3]]}, r"^M: expected numbers of shape \(5, 4\), got list$"),
    ({"A": np.zeros((5, 4))}, r"^A: expected numbers of shape \(5, 5\), got shape \(5, 4\)$"),
    ({"B": np.full((4, 4), np.inf)}, r"^B: expected finite numbers, got inf at flat index 0$"),
    ({"mu": [1, 1, -1, 1, 1]}, r"^mu: expected finite numbers >= 0, got -1 at flat index 2$"),
    ({"mu": np.zeros(5)}, r"^mu: expected a positive total mass, got 0$"),
    ({"mu": np.zeros((5, 1))}, r"^mu: expected a vector of numbers, got shape \(5, 1\)$"),
    ({"mu": [], "M": np.zeros((0, 4)), "A": np.zeros((0, 0))}, r"^mu: expected at least one node, got 0$"),
    ({"nu": [1, np.nan, 1, 1]}, r"^nu: expected finite numbers >= 0, got NaN at flat index 1$"),
    ({"nu": "heavy"}, r"^nu: expected a vector of numbers, got str$"),
    ({"prior": np.ones(3), "em_rate": 0.4}, r"^prior: expected numbers of shape \(4,\), got shape \(3,\)$"),
    ({"prior": -np.ones(4), "em_rate": 0.4}, r"^prior: expected finite numbers >= 0, got -1"),
    ({"start": -np.ones((5, 4))}, r"^start: expected finite numbers >= 0, got -1"),
    (
        {"nu": np.ones(4), "tau_s": np.inf, "tau_t": np.inf},
        r"^nu: expected mu's total .* both tau are inf, got",
    ),
]


@pytest.mark.parametrize(("changes", "message"), BAD, ids=lambda x: x if isinstance(x, str) else "")
def test_names_argument_expectation_and_value(changes, message):
    pair = make_pair()
    arguments = dict(zip(("M", "A", "B", "mu", "nu"), pair.data, strict=True)) | changes
    with pytest.raises(InputError, match=message):
        ufgw(**arguments)


def test_a_batch_names_the_pair():
    pairs = [make_pair(k) for k in range(3)]
    columns = [list(column) for column in zip(*(pair.data for pair in pairs), strict=True)]
    columns[3][2] = -columns[3][2]
    with pytest.raises(InputError, match=r"^mu: expected .* \(pair 2\)$"):
        ufgw_batch(*columns)
    columns[0][1] = np.zeros((2, 2))
    with pytest.raises(InputError, match=r"^M: .* got shape \(2, 2\) \(pair 1\)$"):
        ufgw_batch(*columns)
    with pytest.raises(InputError, match=r"^A: expected 3 arrays, one per M, got 2$"):
        ufgw_batch(columns[0], columns[1][:2], *columns[2:])
