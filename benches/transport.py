"""UFGW by graft, POT, ott-jax and the paper's algorithm in NumPy, on the same problems in one run.

    python benches/transport.py [--sizes 3 6 10 20 50 100 200] [--save benches/results/DATE-transport.txt]

Times are microseconds a pair, the least of nine rounds (two for the slow peers), as other work on the machine only
adds; to tolerance 1e-6, single precision to 1e-5. What runs in one thread is timed by that thread's processor time
(NumPy's and POT's BLAS threads are not counted, in their favour), two threads and ott-jax by the clock on the wall.
`F` is the mean of this package's objective without EM at each solver's plan, over the first pairs. POT's
`fused_unbalanced_gromov_wasserstein` minimises another objective (its marginals enter squared) and ott-jax has the unit
entropy, so their F says how far apart the problems are, not how well they solve their own. ott-jax is timed where it is
installed, compiled, in its best form: vmap over all pairs in single precision.
"""

from __future__ import annotations

import argparse
import importlib.util
import os
import platform
import time
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np

from graft.objects import Floats
from graft.transport import Pairs, ufgw, ufgw_batch, ufgw_packed
from graft.transport.solver import Precision

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    import ot

PAIRS = {3: 4096, 6: 4096, 10: 2048, 20: 512, 50: 64, 100: 16, 200: 4}
"""Pairs in a batch, by size."""
ALPHA, TAU, EPS, TOL, TOL_F32, EM_RATE = 0.5, 1.0, 0.05, 1e-6, 1e-5, 0.4
ROUNDS = 9
PEER_PAIRS = 4
"""The peers take milliseconds a pair; so many of the pairs are timed."""
SINGLE_CALLS = 64
"""Pairs that are solved by a call each."""

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


def ott_batch(pairs: list[Pair]) -> Callable[[], list[Floats]]:
    """Return ott-jax's solution of all pairs at once, compiled.

    Its linearised cost is C_GW + M where ours is half of that, so that eps and tau double.
    """
    import jax
    import jax.numpy as jnp
    from ott.geometry import geometry
    from ott.problems.quadratic import quadratic_problem
    from ott.solvers.linear import sinkhorn
    from ott.solvers.quadratic import gromov_wasserstein

    share = TAU / (TAU + EPS)
    solver = gromov_wasserstein.GromovWasserstein(
        linear_solver=sinkhorn.Sinkhorn(threshold=TOL_F32, max_iterations=2000, recenter_potentials=True),
        epsilon=2 * EPS, threshold=TOL_F32, max_iterations=200,
    )  # fmt: skip

    def one(M: object, A: object, B: object, mu: object, nu: object) -> object:
        problem = quadratic_problem.QuadraticProblem(
            geometry.Geometry(A), geometry.Geometry(B), geometry.Geometry(M), fused_penalty=1.0, a=mu, b=nu,
            tau_a=share, tau_b=share, gw_unbalanced_correction=False,
        )  # fmt: skip
        return solver(problem).matrix

    columns = [jnp.asarray(np.stack(column), jnp.float32) for column in zip(*pairs, strict=True)]
    solve = jax.jit(jax.vmap(one))
    solve(*columns).block_until_ready()
    return lambda: list(np.asarray(solve(*columns).block_until_ready(), np.float64))


def timed(work: Callable[[], list[Floats]], rounds: int, clock: Callable[[], float]) -> tuple[float, list[Floats]]:
    """Return the least time of some rounds by a clock, and the plans."""
    times = []
    for _ in range(rounds):
        start = clock()
        plans = work()
        times.append(clock() - start)
    return min(times), plans


def measure(n: int) -> list[tuple[str, float, float]]:
    """Return (solver, microseconds a pair, mean F) for one size."""
    rng = np.random.default_rng(n)
    count = PAIRS[n]
    pairs = [make_pair(rng, n) for _ in range(count)]
    packed = Pairs.pack(*(list(column) for column in zip(*pairs, strict=True)))
    columns = [list(column) for column in zip(*pairs, strict=True)]
    options = {"alpha": ALPHA, "tau_s": TAU, "tau_t": TAU, "eps": EPS}
    few = pairs[:SINGLE_CALLS]

    def batch(precision: Precision, threads: int, em_rate: float | None) -> list[Floats]:
        found = ufgw_packed(
            packed, **options, tol=TOL if precision == "f64" else TOL_F32, precision=precision, threads=threads,
            em_rate=em_rate,
        )  # fmt: skip
        return [found[k].plan for k in range(PEER_PAIRS)]

    def lists() -> list[Floats]:
        found = ufgw_batch(*columns, **options, tol=TOL, threads=1, em_rate=EM_RATE)
        return [transport.plan for transport in found]

    jobs: list[tuple[str, int, int, Callable[[], list[Floats]]]] = [
        ("graft f64, 1 thread", count, ROUNDS, lambda: batch("f64", 1, None)),
        ("graft f64, 1 thread, EM", count, ROUNDS, lambda: batch("f64", 1, EM_RATE)),
        ("graft f64, 2 threads, EM", count, ROUNDS, lambda: batch("f64", 2, EM_RATE)),
        ("graft f32, 1 thread, EM", count, ROUNDS, lambda: batch("f32", 1, EM_RATE)),
        ("graft f32, 2 threads, EM", count, ROUNDS, lambda: batch("f32", 2, EM_RATE)),
        ("graft f64, lists to objects", count, ROUNDS, lists),
        (
            "graft f64, a call a pair",
            len(few),
            ROUNDS,
            lambda: [ufgw(*p, **options, em_rate=EM_RATE).plan for p in few],
        ),
        ("NumPy, nested loops", PEER_PAIRS, 2, lambda: [nested_numpy(pair) for pair in pairs[:PEER_PAIRS]]),
        ("POT fused unbalanced GW", PEER_PAIRS, 2, lambda: [pot(pair) for pair in pairs[:PEER_PAIRS]]),
    ]
    if importlib.util.find_spec("ott") is not None:
        # Half a gigabyte of plans at n = 200 would be no help to it.
        some = pairs[: min(count, 512)]
        jobs.append(("ott-jax vmap f32", len(some), 3, ott_batch(some)))
    rows = []
    for name, done, rounds, work in jobs:
        spread = "2 threads" in name or "jax" in name
        seconds, plans = timed(work, rounds, time.perf_counter if spread else time.thread_time)
        shared = zip(pairs[:PEER_PAIRS], plans, strict=False)
        rows.append((name, 1e6 * seconds / done, float(np.mean([objective(p, T) for p, T in shared]))))
    return rows


def main() -> None:
    """Measure, print, save."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--sizes", type=int, nargs="+", default=list(PAIRS), choices=list(PAIRS))
    parser.add_argument("--save", type=Path)
    arguments = parser.parse_args()
    tables = {n: measure(n) for n in arguments.sizes}
    lines = [
        f"microseconds a pair (F at the plan); n x n, alpha {ALPHA} tau {TAU} eps {EPS}, {platform.machine()}, "
        f"POT {ot.__version__}, load {os.getloadavg()[0]:.1f}",
        "".join([f"{'':28}", *(f"{f'n = {n}':>20}" for n in arguments.sizes)]),
    ]
    for k, (name, _, _) in enumerate(tables[arguments.sizes[0]]):
        cells = (f"{us:11.2f} ({value:.4f})" for us, value in (tables[n][k][1:] for n in arguments.sizes))
        lines.append("".join([f"{name:28}", *(f"{cell:>20}" for cell in cells)]))
    text = "\n".join(lines)
    print(text)
    if arguments.save:
        arguments.save.parent.mkdir(parents=True, exist_ok=True)
        arguments.save.write_text(text + "\n")


if __name__ == "__main__":
    main()
