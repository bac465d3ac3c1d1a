"""A mug on a table and hands around it."""

import numpy as np

from graft import zoo
from graft.grasp import Support, in_metres
from graft.objects import PartObject


def mug() -> tuple[PartObject, Support]:
    """A mug of the zoo in metres, and the table it stands on."""
    metric = in_metres(zoo.make("mug", 0))
    up = np.array([0.0, 0.0, 1.0]) if metric.up is None else metric.up
    return metric, Support(up, min(float((part.vertices @ up).min()) for part in metric.parts))


def down(position) -> np.ndarray:
    """A hand that looks down, TCP at `position`."""
    pose = np.diag([1.0, -1.0, -1.0, 1.0])
    pose[:3, 3] = position
    return pose


def beside(obj: PartObject, side: float, height: float = 0.12) -> np.ndarray:
    """A hand beside the object that looks down, far enough to touch nothing."""
    low, high = obj.bounds
    middle = (low + high) / 2
    return down([middle[0], (high if side > 0 else low)[1] + side * 0.15, high[2] + height - 0.08])
