"""Global descriptors: one vector per part, compared by cosine."""

from __future__ import annotations

from graft.features.descriptor import Descriptor
from graft.features.geometric import FAMILIES, Family, GeometricDescriptor

__all__ = ["FAMILIES", "Descriptor", "Family", "GeometricDescriptor"]
