"""Objects and demonstrations, from files and to files.

One module per format; `load_object` finds out which is meant. Everything that is read is checked in
`graft.io.guards`.
"""

from graft.io.demonstrations import load_demonstration, load_demonstrations, save_demonstration
from graft.io.load import ObjectLike, as_object, load_object
from graft.io.save import save_object
from graft.io.segmenting import segment, segment_hierarchy

__all__ = [
    "ObjectLike",
    "as_object",
    "load_demonstration",
    "load_demonstrations",
    "load_object",
    "save_demonstration",
    "save_object",
    "segment",
    "segment_hierarchy",
]
