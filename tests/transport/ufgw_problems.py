"""Random problems and slow oracles that the transport tests share."""

from dataclasses import dataclass, replace

import numpy as np
from hypothesis import strategies as st

from graft.objects import Floats


@dataclass(frozen=True, eq=False)
class Pair:
    M: Floats
    A: Floats
    B: Floats
    mu: Floats
    nu: Floats

    @property
    def data(self) -> tuple[Floats, ...]:
        return self.M, self.A, self.B, self.mu, self.nu

    def replaced(self, **changes) -> "Pair":
        return replace(self, **changes)


def _lengths(rng, n, symmetric):
    points = rng.random((n, 3))
    x = np.linalg.norm(points[:, None] - points[None], axis=-1)
    lengths = x / (1 + x)
    return lengths if symmetric else lengths + rng.random((n, n))


def make_pair(seed=0, n=5, m=4, *, scale=1.0, mass=1.0, symmetric=True):
    """Return a random pair with edge lengths times `scale` and both total masses `mass`."""
    rng = np.random.default_rng(seed)
    mu, nu = rng.random(n) + 0.1, rng.random(m) + 0.1
    return Pair(
        M=rng.random((n, m)),
        A=scale * _lengths(rng, n, symmetric),
        B=scale * _lengths(rng, m, symmetric),
        mu=mass * mu / mu.sum(),
        nu=mass * nu / nu.sum(),
    )


def four_loops(A, B, T, loss):
    """Return sum loss(A_ii', B_jj') T_ij T_i'j', one term at a time."""
    total = 0.0
    n, m = T.shape
    for i in range(n):
        for k in range(n):
            for j in range(m):
                for q in range(m):
                    gap = A[i, k] - B[j, q]
                    total += (gap * gap if loss == "square" else abs(gap)) * T[i, j] * T[k, q]
    return total


def kl(p, q):
    """Return sum p log(p/q) - p + q, with 0 log 0 = 0."""
    p, q = np.broadcast_arrays(p, q)
    positive = p > 0
    return float((p[positive] * np.log(p[positive] / q[positive])).sum() - p.sum() + q.sum())


def objective(pair, T, nu=None, *, alpha=0.5, tau_s=1.0, tau_t=1.0, eps=0.05, loss="square", entropy="relative"):
    """Return F(T), straight from its definition."""
    nu = pair.nu if nu is None else nu
    reference = {
        "relative": lambda: kl(T, np.outer(pair.mu, nu)),
        "plain": lambda: float((T[T > 0] * np.log(T[T > 0])).sum()),
        "unit": lambda: kl(T, np.ones_like(T)),
    }[entropy]()
    value = (1 - alpha) * four_loops(pair.A, pair.B, T, loss) / 2 + alpha * float((pair.M * T).sum())
    value += tau_s * kl(T.sum(1), pair.mu) if np.isfinite(tau_s) else 0.0
    value += tau_t * kl(T.sum(0), nu) if np.isfinite(tau_t) else 0.0
    return value + eps * reference


def linearised(pair, T, *, alpha=0.5, loss="square"):
    """Return C = (1-alpha) C_GW(T) + alpha M, C_GW by central differences of the four loops (exact:
    quadratic)."""
    gradient = np.empty_like(T)
    for index in np.ndindex(T.shape):
        step = np.zeros_like(T)
        step[index] = 0.5
        gradient[index] = four_loops(pair.A, pair.B, T + step, loss)
        gradient[index] -= four_loops(pair.A, pair.B, T - step, loss)
    return (1 - alpha) * gradient / 2 + alpha * pair.M


prices = st.sampled_from([0.0, 1e-3, 0.1, 1.0, 30.0, np.inf])


@st.composite
def pairs(draw, largest=6):
    """Draw pairs over shapes, scales, masses and symmetry."""
    return make_pair(
        draw(st.integers(0, 2**20)),
        draw(st.integers(1, largest)),
        draw(st.integers(1, largest)),
        scale=draw(st.sampled_from([0.0, 1.0, 10.0, 100.0])),
        mass=draw(st.sampled_from([1e-3, 1.0, 1e3])),
        symmetric=draw(st.booleans()),
    )
