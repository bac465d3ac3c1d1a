"""The compiled core. Arrays are C-contiguous; every function raises ValueError naming a bad argument."""

__version__: str

import numpy as np
from numpy.typing import NDArray

def ufgw_batch(
    sizes: NDArray[np.int64],
    features: NDArray[np.float64],
    source: NDArray[np.float64],
    target: NDArray[np.float64],
    source_mass: NDArray[np.float64],
    target_mass: NDArray[np.float64],
    prior: NDArray[np.float64] | None,
    start: NDArray[np.float64] | None,
    *,
    alpha: float,
    tau_s: float,
    tau_t: float,
    eps: float,
    loss: str,
    entropy: str,
    em_rate: float | None,
    tol: float,
    max_outer: int,
    threads: int,
) -> tuple[
    NDArray[np.float64],
    NDArray[np.float64],
    NDArray[np.float64],
    NDArray[np.float64],
    NDArray[np.float64],
    NDArray[np.float64],
    NDArray[np.int64],
    NDArray[np.int64],
    NDArray[np.int64],
    NDArray[np.bool_],
]: ...
def feature_costs(
    source_extents: NDArray[np.float64],
    source_descriptors: NDArray[np.float64] | None,
    target_extents: NDArray[np.float64],
    target_descriptors: NDArray[np.float64] | None,
    *,
    lambda_obb: float,
    lambda_global: float,
    variant: str,
) -> NDArray[np.float64]: ...
