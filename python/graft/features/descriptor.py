"""What a descriptor is."""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from graft.objects import Floats, PartObject


@runtime_checkable
class Descriptor(Protocol):
    """Anything that describes the parts of an object by vectors whose cosine says how alike they are."""

    @property
    def name(self) -> str:
        """Model, version and options: vectors are comparable only when their descriptors' names are equal."""
        ...

    @property
    def dim(self) -> int:
        """Length of a vector."""
        ...

    def describe(self, obj: PartObject) -> Floats:
        """Return (n, dim) finite vectors, one row per part."""
        ...
