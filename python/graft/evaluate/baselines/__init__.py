"""Other ways to answer the same queries, each named for what it is."""

from graft.evaluate.baselines.chance import RandomPart, RandomPoint
from graft.evaluate.baselines.image_retrieval import ImageRetrieval, image_methods
from graft.evaluate.baselines.nearest_part import NearestDescriptor, NearestMoments
from graft.evaluate.baselines.spectral import FunctionalMap
from graft.evaluate.baselines.whole_object import WholeObject

__all__ = [
    "FunctionalMap",
    "ImageRetrieval",
    "NearestDescriptor",
    "NearestMoments",
    "RandomPart",
    "RandomPoint",
    "WholeObject",
    "image_methods",
]
