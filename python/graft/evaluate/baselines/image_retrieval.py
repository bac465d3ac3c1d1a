"""Retrieval by pictures and transfer by dense features, in the manner of ROBO-ABC (Ju et al. 2024).

ROBO-ABC retrieves the demonstrated object whose picture CLIP finds most alike and carries the contact pixel over by
the nearest of a diffusion model's dense features. No package ships either network. Here an ImageNet CNN does both, on
pictures of the bare geometry, and the same network with random weights is the control: what it scores is not owed to
what was learned.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from graft import _core
from graft.evaluate.baselines.efficientnet import PACKAGE, SIDE, features
from graft.evaluate.methods import Graphs, Prediction
from graft.evaluate.metrics import Surface, sample_surface
from graft.evaluate.protocols import Benchmark, Query, Source, Subject
from graft.graph import PartGraph
from graft.objects import Floats, PartObject
from graft.viz.camera import fit, look_from
from graft.viz.picture import draw_shapes
from graft.viz.shapes import object_shapes

VIEWS = tuple((float(azimuth), 20.0) for azimuth in range(0, 360, 45))
"""(azimuth, elevation) in degrees about the up axis: as people photograph objects, from eight sides."""

GREY = 180
"""Of every part: the network sees shape and shading, not what the parts are."""

SAMPLES = 1024
"""Surface points among which the contact lands."""

DRAWN = 128
"""Objects whose pictures are kept, so that the control looks at those that are there: about 1.5 MB each."""

CONTROL_SEED = 0
"""Of the control's weights."""

LIFT = 1e-3
"""A point is seen when a ray from so far above it, in diagonals, leaves the object towards the camera."""


def image_methods() -> list[ImageRetrieval]:
    """Return the trained network and its control, or nothing where the extra `vision` is not installed."""
    if not all(importlib.util.find_spec(name) for name in ("onnxruntime", "onnx", PACKAGE)):
        return []
    return [
        ImageRetrieval("image retrieval (ImageNet CNN)"),
        ImageRetrieval("image retrieval (random CNN)", seed=CONTROL_SEED),
    ]


@dataclass(frozen=True)
class ImageRetrieval:
    """Retrieval of whole objects by pictures, contact by the nearest dense feature.

    Attributes:
        name: In tables.
        seed: Of random weights; None for the weights trained on ImageNet.
        graphs: Not used.
        exchangeable: No.
    """

    name: str = "image retrieval"
    seed: int | None = None
    graphs: Graphs = field(default_factory=Graphs)
    exchangeable: bool = False

    def fit(self, benchmark: Benchmark, graphs: Sequence[PartGraph]) -> _Photographed:
        """Draw every object from all sides and keep what the network says of the pictures.

        Raises:
            MissingExtraError: onnxruntime, onnx or the weights are not installed.
        """
        albums = tuple(Album.of(subject, self.seed) for subject in benchmark.subjects)
        return _Photographed(benchmark.sources, albums)


@dataclass(frozen=True, eq=False)
class Album:
    """An object's pictures as a network sees them.

    Attributes:
        whole: (v, d) unit vectors, one per view.
        dense: (v, s, s, c) features on a grid over each picture.
        points: (p, 3) surface samples, object frame and units.
        part: (p,) part of each.
        places: (v, p, 2) column and row of each, in cells of the grid.
        seen: (v, p) whether the view shows it.
    """

    whole: Floats
    dense: NDArray[np.float32]
    points: Floats
    part: NDArray[np.int64]
    places: Floats
    seen: NDArray[np.bool_]

    @classmethod
    def of(cls, subject: Subject, seed: int | None) -> Album:
        """Draw an object and look at the pictures."""
        pictures = _drawn(subject)
        dense, whole = features(pictures.pixels, seed)
        places = pictures.columns_rows * (dense.shape[1] / SIDE) - 0.5
        surface = pictures.surface
        return cls(_unit(whole), dense.astype(np.float32), surface.points, surface.part, places, pictures.seen)

    def at(self, view: int, samples: NDArray[np.intp]) -> Floats:
        """Return the unit features (q, c) of surface samples in a view, interpolated between cells."""
        grid = self.dense[view]
        last = len(grid) - 1
        place = np.clip(self.places[view, samples], 0.0, last)
        low = np.minimum(place.astype(np.int64), last - 1)
        column, row = (place - low).T[..., None]
        (left, top) = low.T
        mixed = (1 - row) * ((1 - column) * grid[top, left] + column * grid[top, left + 1])
        mixed += row * ((1 - column) * grid[top + 1, left] + column * grid[top + 1, left + 1])
        return _unit(mixed)


def _unit(rows: Floats) -> Floats:
    lengths = np.linalg.norm(rows, axis=-1, keepdims=True)
    scaled: Floats = rows / np.maximum(lengths, np.finfo(np.float64).tiny)
    return scaled


@dataclass(frozen=True, eq=False)
class _Pictures:
    """An object from all sides.

    Attributes:
        pixels: (v, SIDE, SIDE, 3).
        surface: Samples of it.
        columns_rows: (v, p, 2) where each is in a picture, in pixels.
        seen: (v, p) whether the view shows it.
    """

    pixels: NDArray[np.uint8]
    surface: Surface
    columns_rows: Floats
    seen: NDArray[np.bool_]


@lru_cache(DRAWN)
def _drawn(subject: Subject) -> _Pictures:
    obj = subject.object
    shapes = object_shapes(obj, np.full((len(obj.parts), 3), GREY, np.uint8))
    corners = np.concatenate([shape.vertices for shape in shapes])
    rotations = [look_from(azimuth, elevation, obj.up) for azimuth, elevation in VIEWS]
    cameras = [fit(rotation, corners, SIDE, SIDE) for rotation in rotations]
    surface = sample_surface(obj, SAMPLES)
    return _Pictures(
        pixels=np.array([draw_shapes(shapes, camera, SIDE, SIDE) for camera in cameras]),
        surface=surface,
        columns_rows=np.array([surface.points @ camera[:2, :3].T + camera[:2, 3] for camera in cameras]),
        seen=_seen(obj, surface.points, -np.array(rotations)[:, 2], LIFT * subject.diagonal),
    )


def _seen(obj: PartObject, points: Floats, toward: Floats, lift: float) -> NDArray[np.bool_]:
    """Return (v, p) whether nothing hides a surface point from a camera; a cloud hides nothing."""
    if not obj.n_faces:
        return np.ones((len(toward), len(points)), np.bool_)
    vertices = np.concatenate([part.vertices for part in obj.parts])
    offsets = np.cumsum([0, *(len(part.vertices) for part in obj.parts)])
    faces = np.concatenate([part.faces + o for part, o in zip(obj.parts, offsets[:-1], strict=True)])
    directions = np.repeat(toward, len(points), axis=0)
    origins = np.tile(points, (len(toward), 1)) + lift * directions
    free = np.isinf(_core.cast_rays(vertices, np.ascontiguousarray(faces), origins, directions))
    shown: NDArray[np.bool_] = free.reshape(len(toward), len(points))
    return shown


@dataclass(frozen=True, eq=False)
class _Photographed:
    """Albums of all objects."""

    sources: tuple[Source, ...]
    albums: tuple[Album, ...]

    def predict(self, query: Query, k: int, rng: Generator) -> list[Prediction]:
        """Return the contacts of the objects that look most alike, where their dense features are nearest.

        Of a source only views that show its contact count, of all pairs of views the most alike.
        """
        target = self.albums[query.target]
        found = []
        for index in query.sources:
            source = self.sources[index]
            album = self.albums[source.subject]
            away = np.square(album.points - source.demonstration.contact.point).sum(axis=1)
            shown = int(away.argmin())
            likeness = album.whole @ target.whole.T
            if album.seen[:, shown].any():
                likeness = np.where(album.seen[:, shown, None], likeness, -np.inf)
            view, other = divmod(int(likeness.argmax()), likeness.shape[1])
            found.append((float(likeness[view, other]), index, view, other, shown))
        found.sort(key=lambda pair: -pair[0])  # stable: ties keep the order of the sources
        predictions = []
        for alike, index, view, other, shown in found[:k]:
            wanted = self.albums[self.sources[index].subject].at(view, np.array([shown]))
            there = np.flatnonzero(target.seen[other])
            there = there if len(there) else np.arange(len(target.points))
            best = there[int((target.at(other, there) @ wanted[0]).argmax())]
            predictions.append(Prediction(target.points[best], int(target.part[best]), index, alike))
        return predictions
