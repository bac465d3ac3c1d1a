"""The compiled core. Arrays are C-contiguous; every function raises ValueError naming a bad argument."""

import numpy as np
from numpy.typing import NDArray

__version__: str

def render_scene(
    *,
    vertices: NDArray[np.float64],
    faces: NDArray[np.int64],
    face_groups: NDArray[np.int64],
    centers: NDArray[np.float64],
    radii: NDArray[np.float64],
    center_groups: NDArray[np.int64],
    colors: NDArray[np.uint8],
    camera: NDArray[np.float64],
    width: int,
    height: int,
) -> NDArray[np.uint8]: ...
def cast_rays(
    vertices: NDArray[np.float64],
    faces: NDArray[np.int64],
    origins: NDArray[np.float64],
    directions: NDArray[np.float64],
) -> NDArray[np.float64]: ...
