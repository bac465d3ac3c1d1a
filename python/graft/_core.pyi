"""The compiled core. Arrays are C-contiguous; every function raises ValueError naming a bad argument."""

import numpy as np
from numpy.typing import NDArray

__version__: str

def describe_parts(
    vertices: NDArray[np.float64],
    faces: NDArray[np.int64],
    vertex_offsets: NDArray[np.int64],
    face_offsets: NDArray[np.int64],
    *,
    families: list[str],
    samples: int,
    seed: int,
    raw: bool = False,
) -> NDArray[np.float64]: ...
def descriptor_dim(families: list[str]) -> int: ...
