"""What transports are ranked by, from the solver's terms."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from graft.errors import InputError
from graft.objects import Floats

Cost = Literal["sharp", "objective", "paper", "debiased"]
"""What `Transport.cost` is: "sharp", F without the entropy, comparable across sizes; "objective", F; "paper", the
paper's equation 2, sharp + eps sum T log T; "debiased", F(s,t) - F(s,s)/2 - F(t,t)/2 + eps/2 (sum mu - sum nu)^2."""

SelfFeatures = Sequence[tuple[ArrayLike, ArrayLike]]
"""Per pair: M of the source with itself (n, n) and of the target with itself (m, m)."""


def check(cost: str) -> None:
    """Refuse a word that is no cost.

    Raises:
        InputError: It is none.
    """
    if cost not in get_args(Cost):
        raise InputError(f"cost: expected one of {', '.join(get_args(Cost))}, got {cost}")


def plain(cost: Cost, terms: Floats, plans: Sequence[Floats], eps: float) -> Floats:
    """Return the costs (k,) other than "debiased" of terms (k, 6) and, for "paper", plans."""
    sharp: Floats = terms[:, :4].sum(axis=1)
    if cost == "sharp":
        return sharp
    if cost == "objective":
        return sharp + terms[:, 4]
    return sharp + eps * np.array([negative_entropy(plan) for plan in plans])


def negative_entropy(plan: Floats) -> float:
    """Return sum T log T with 0 log 0 = 0."""
    positive = plan[plan > 0]
    return float(positive @ np.log(positive))


def self_sides(self_features: SelfFeatures | None, count: int, entropy: str) -> tuple[list[ArrayLike], list[ArrayLike]]:
    """Return the self costs of sources and targets.

    Raises:
        InputError: There are not as many as pairs, or the entropy is not relative.
    """
    if self_features is None or len(self_features) != count:
        got = "none" if self_features is None else len(self_features)
        raise InputError(f"self_features: cost='debiased' needs {count} pairs of matrices, got {got}")
    if entropy != "relative":
        raise InputError(f"entropy: cost='debiased' needs relative, got {entropy}")
    return [f[0] for f in self_features], [f[1] for f in self_features]
