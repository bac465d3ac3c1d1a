"""Objects to run on: parametric household objects, and real scans with their parts.

`make` and `demonstration` give variants of twenty-two categories by seed.
`ycb_object` and `ycb_demonstration` give eighteen scans of the YCB set (extra `demo`).
"""

from graft.zoo.catalogue import categories, demonstrated, demonstration, make, more, unseen
from graft.zoo.ycb import ycb_demonstration, ycb_names, ycb_object

__all__ = [
    "categories",
    "demonstrated",
    "demonstration",
    "make",
    "more",
    "unseen",
    "ycb_demonstration",
    "ycb_names",
    "ycb_object",
]
