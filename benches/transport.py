"""UFGW by graft, by POT and by the paper's algorithm in NumPy, on the same problems in one run.

    python benches/transport.py [--pairs 64] [--save benches/results/DATE-transport.txt]

Times are microseconds a pair, the best of three rounds, everything to tolerance 1e-6. `F` is the mean of this
package's objective (EM off, so that all minimise over the plan alone) at each solver's plan. POT's
`fused_unbalanced_gromov_wasserstein` minimises another objective (its marginals enter squared), so its F
says how far apart the two problems are, not how well POT solves its own.
"""

from __future__ import annotations

import argparse
import platform
import time
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np

from graft.objects import Floats
from graft.transport import ufgw, ufgw_batch

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import ot

SIZES = (3, 6, 10, 20, 50)
ALPHA, TAU, EPS, TOL = 0.5, 1.0, 0.05, 1e-6
ROUNDS = 3
PEER_PAIRS = 6
"""The peers take milliseconds a pair; so many of the pairs are timed."""

Pair = tuple[Floats, Floats, Floats, Floats, Floats]


def make_pair(rng: np.random.Generator, n: int) -> Pair:
    """Return M, A, B, mu, nu of two random n-part graphs."""

    def lengths() -> Floats:
        points = rng.random((n, 3))
        x = np.linalg.norm(points[:, None] - points[None], axis=-1)
        return x / (1 + x)

    mu, nu = rng.random(n) + 0.1, rng.random(n) + 0.1
    return rng.random((n, n)), lengths(), lengths(), mu / mu.sum(), nu / nu.sum()


def structure_gradient(A: Floats, B: Floats, T: Floats) -> Floats:
    """Return C_GW for the square loss and symmetric structures."""
    return (A**2 @ T.sum(1))[:, None] + (B**2 @ T.sum(0))[None] - 2 * A @ T @ B


def kl(p: Floats, q: Floats) -> float:
    """Return sum p log(p/q) - p + q."""
    return float(np.sum(np.where(p > 0, p * np.log(np.maximum(p, 1e-300) / q), 0.0) - p + q))


def objective(pair: Pair, T: Floats) -> float:
    """Return F(T)."""
    M, A, B, mu, nu = pair
    value = (1 - ALPHA) / 2 * float((structure_gradient(A, B, T) * T).sum()) + ALPHA * float((M * T).sum())
    return value + TAU * (kl(T.sum(1), mu) + kl(T.sum(0), nu)) + EPS * kl(T, np.outer(mu, nu))


def nested_numpy(pair: Pair) -> Floats:
    """Solve as the paper does: linearise, run unbalanced Sinkhorn to convergence, repeat."""
    M, A, B, mu, nu = pair
    rate = TAU / (TAU + EPS)
    T = np.outer(mu, nu)
    b = np.ones(len(nu))
    for _ in range(200):
        K = np.exp(-((1 - ALPHA) * structure_gradient(A, B, T) + ALPHA * M) / EPS)
        for _ in range(2000):
            a = (K @ (nu * b)) ** -rate
            before, b = b, (K.T @ (mu * a)) ** -rate
            if np.abs(np.log(b / before)).max() < TOL:
                break
        before, T = T, (mu * a)[:, None] * K * (nu * b)[None]
        if np.abs(T - before).sum() < TOL * T.sum():
            break
    return T


def pot(pair: Pair) -> Floats:
    """Solve POT's nearest problem; its alpha weighs the structure, and its quadratic has no 1/2."""
    M, A, B, mu, nu = pair
    plan, _ = ot.gromov.fused_unbalanced_gromov_wasserstein(
        A, B, mu, nu, reg_marginals=TAU, epsilon=EPS, divergence="kl", unbalanced_solver="sinkhorn",
        alpha=ALPHA, M=M, tol=TOL, max_iter=200, tol_ot=TOL, max_iter_ot=2000,
    )  # fmt: skip
    return np.asarray(plan)


def best(work: Callable[[], list[Floats]]) -> tuple[float, list[Floats]]:
    """Return the least wall time of some rounds, and the plans."""
    times = []
    for _ in range(ROUNDS):
        start = time.perf_counter()
        plans = work()
        times.append(time.perf_counter() - start)
    return min(times), plans


def measure(n: int, count: int) -> list[tuple[str, float, float]]:
    """Return (solver, microseconds a pair, mean F) for one size."""
    rng = np.random.default_rng(n)
    pairs = [make_pair(rng, n) for _ in range(count)]
    columns = [list(column) for column in zip(*pairs, strict=True)]
    options = {"alpha": ALPHA, "tau_s": TAU, "tau_t": TAU, "eps": EPS, "tol": TOL}

    def batch(threads: int, em_rate: float | None = None) -> list[Floats]:
        return [t.plan for t in ufgw_batch(*columns, **options, em_rate=em_rate, threads=threads)]

    jobs: list[tuple[str, int, Callable[[], list[Floats]]]] = [
        ("graft, a call a pair", count, lambda: [ufgw(*pair, **options).plan for pair in pairs]),
        ("graft, batch, 1 thread", count, lambda: batch(1)),
        ("graft, batch, 2 threads", count, lambda: batch(2)),
        ("graft, batch, 1 thread, EM", count, lambda: batch(1, 0.4)),
        ("NumPy, nested loops", PEER_PAIRS, lambda: [nested_numpy(pair) for pair in pairs[:PEER_PAIRS]]),
        ("POT fused unbalanced GW", PEER_PAIRS, lambda: [pot(pair) for pair in pairs[:PEER_PAIRS]]),
    ]
    rows = []
    for name, done, work in jobs:
        seconds, plans = best(work)
        # Over the pairs that every solver did.
        shared = zip(pairs[:PEER_PAIRS], plans, strict=False)
        rows.append((name, 1e6 * seconds / done, float(np.mean([objective(p, T) for p, T in shared]))))
    return rows


def main() -> None:
    """Measure, print, save."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--pairs", type=int, default=64)
    parser.add_argument("--save", type=Path)
    arguments = parser.parse_args()
    if arguments.pairs < PEER_PAIRS:
        parser.error(f"--pairs: expected at least {PEER_PAIRS}")
    tables = {n: measure(n, arguments.pairs) for n in SIZES}
    lines = [
        f"microseconds a pair (F at the plan); n x n, alpha {ALPHA} tau {TAU} eps {EPS} tol {TOL}, "
        f"{arguments.pairs} pairs, {platform.machine()}, POT {ot.__version__}",
        "".join([f"{'':28}", *(f"{f'n = {n}':>20}" for n in SIZES)]),
    ]
    for k, (name, _, _) in enumerate(tables[SIZES[0]]):
        cells = (f"{us:11.1f} ({value:.4f})" for us, value in (tables[n][k][1:] for n in SIZES))
        lines.append("".join([f"{name:28}", *(f"{cell:>20}" for cell in cells)]))
    text = "\n".join(lines)
    print(text)
    if arguments.save:
        arguments.save.parent.mkdir(parents=True, exist_ok=True)
        arguments.save.write_text(text + "\n")


if __name__ == "__main__":
    main()
