"""Pairs packed for the solver: ragged sequences of matrices checked once and laid end to end."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from graft.errors import InputError
from graft.objects import Floats


@dataclass(frozen=True, eq=False)
class Pairs:
    """k pairs of graphs end to end; make them with `pack`, or directly from arrays that lie like that already.

    Attributes:
        sizes: (k, 2) int64, nodes of source and target.
        M: Feature costs, n_k m_k numbers each, row by row.
        A: Source structures, n_k n_k numbers each.
        B: Target structures, m_k m_k numbers each.
        mu: Source masses, n_k numbers each.
        nu: Target masses, m_k numbers each.
        prior: Priors, m_k numbers each, or None.
        start: Plans to start from, n_k m_k numbers each, or None.
        start_g: Target potentials to start from, m_k numbers each, or None.
    """

    sizes: NDArray[np.int64]
    M: Floats
    A: Floats
    B: Floats
    mu: Floats
    nu: Floats
    prior: Floats | None = None
    start: Floats | None = None
    start_g: Floats | None = None

    def __len__(self) -> int:
        return len(self.sizes)

    @classmethod
    def pack(
        cls,
        M: Sequence[ArrayLike],
        A: Sequence[ArrayLike],
        B: Sequence[ArrayLike],
        mu: Sequence[ArrayLike],
        nu: Sequence[ArrayLike],
        prior: Sequence[ArrayLike] | None = None,
        start: Sequence[ArrayLike] | None = None,
        start_g: Sequence[ArrayLike] | None = None,
    ) -> Pairs:
        """Lay sequences of matrices, one per pair, end to end.

        Raises:
            InputError: Sequences of different lengths, or an array of the wrong shape; the message names
                argument and pair.
        """
        count = len(M)
        named = {"A": A, "B": B, "mu": mu, "nu": nu, "prior": prior, "start": start, "start_g": start_g}
        for name, sequence in named.items():
            if sequence is not None and len(sequence) != count:
                raise InputError(f"{name}: expected {count} arrays, one per M, got {len(sequence)}")
        if not count:
            none = np.empty(0)
            return cls(np.empty((0, 2), np.int64), none, none, none, none, none)
        mus = [array("mu", x, None, k, count) for k, x in enumerate(mu)]
        nus = [array("nu", x, None, k, count) for k, x in enumerate(nu)]
        n, m = [len(x) for x in mus], [len(x) for x in nus]
        shapes: dict[str, list[tuple[int, ...]]] = {
            "M": list(zip(n, m, strict=True)),
            "A": list(zip(n, n, strict=True)),
            "B": list(zip(m, m, strict=True)),
            "prior": [(k,) for k in m],
            "start": list(zip(n, m, strict=True)),
            "start_g": [(k,) for k in m],
        }

        def flat(name: str, arrays: Sequence[ArrayLike]) -> Floats:
            checked = [array(name, x, s, k, count) for k, (x, s) in enumerate(zip(arrays, shapes[name], strict=True))]
            return np.concatenate(checked, axis=None)

        return cls(
            np.array(shapes["M"], np.int64),
            flat("M", M),
            flat("A", A),
            flat("B", B),
            np.concatenate(mus),
            np.concatenate(nus),
            None if prior is None else flat("prior", prior),
            None if start is None else flat("start", start),
            None if start_g is None else flat("start_g", start_g),
        )


def array(name: str, value: ArrayLike, shape: tuple[int, ...] | None, pair: int = 0, pairs: int = 1) -> Floats:
    """Return `value` as a C-contiguous float64 array of the given shape (None: any vector).

    Raises:
        InputError: It is none; the message names the argument and, among several, the pair.
    """
    if type(value) is np.ndarray and value.dtype == np.float64 and value.flags.c_contiguous:
        found: Floats = value
    else:
        try:
            found = np.asarray(value, np.float64, order="C")
        except (TypeError, ValueError):
            raise InputError(_wrong(name, shape, type(value).__name__, pair, pairs)) from None
    if found.ndim != 1 if shape is None else found.shape != shape:
        raise InputError(_wrong(name, shape, f"shape {found.shape}", pair, pairs))
    return found


def _wrong(name: str, shape: tuple[int, ...] | None, got: str, pair: int, pairs: int) -> str:
    expected = "a vector of numbers" if shape is None else f"numbers of shape {shape}"
    return f"{name}: expected {expected}, got {got}" + (f" (pair {pair})" if pairs > 1 else "")
