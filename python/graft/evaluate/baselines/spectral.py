"""A functional map between whole objects (Ovsjanikov et al. 2012) on the graph Laplacian of surface samples.

Wave kernel signatures (Aubry, Schlickewei and Cremers 2011) are the descriptors that the map is fitted to,
and their means over the surface retrieve the sources. The contact goes to the target sample whose spectral
coordinates are nearest to those that the map gives the contact's.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.random import Generator
from scipy.sparse import csr_array, diags_array, eye_array
from scipy.sparse.linalg import eigsh
from scipy.spatial import cKDTree
from scipy.spatial.distance import cdist

from graft.evaluate.baselines.moments import standardised
from graft.evaluate.methods import Graphs, Prediction
from graft.evaluate.metrics import sample_surface
from graft.evaluate.protocols import Benchmark, Query, Source
from graft.graph import PartGraph
from graft.objects import Floats, Ints, PartObject

SAMPLES = 512
"""Surface points whose graph stands for the surface."""

NEIGHBOURS = 8
"""Of each point in that graph; parts that touch are joined through it."""

MODES = 24
"""Eigenfunctions that span the functions of an object."""

ENERGIES = 32
"""Wave kernel signatures per point."""

SHIFT = 1e-2
"""Eigenvalues are sought from just below zero, where the shifted Laplacian has an inverse."""

COMMUTE = 1e-2
"""Weight of commuting with the Laplacians beside fitting the signatures."""


@dataclass(frozen=True)
class FunctionalMap:
    """Functional map between whole objects.

    Attributes:
        name: In tables.
        graphs: Not used.
        exchangeable: No.
    """

    name: str = "functional map"
    graphs: Graphs = field(default_factory=Graphs)
    exchangeable: bool = False

    def fit(self, benchmark: Benchmark, graphs: Sequence[PartGraph]) -> _Spectra:
        """Find the eigenfunctions and signatures of every object."""
        spectra = tuple(Spectrum.of(subject.object) for subject in benchmark.subjects)
        means = standardised(np.array([spectrum.signatures.mean(axis=0) for spectrum in spectra]))
        return _Spectra(benchmark.sources, spectra, means)


@dataclass(frozen=True, eq=False)
class Spectrum:
    """An object's surface as a graph of samples, by its eigenfunctions.

    Attributes:
        points: (s, 3) samples.
        part: (s,) part of each.
        values: (MODES,) eigenvalues of the normalised Laplacian, ascending, over their mean.
        functions: (s, MODES) eigenfunctions, orthonormal.
        signatures: (s, ENERGIES) wave kernel signatures.
    """

    points: Floats
    part: Ints
    values: Floats
    functions: Floats
    signatures: Floats

    @classmethod
    def of(cls, obj: PartObject) -> Spectrum:
        """Sample an object and decompose its graph's Laplacian."""
        surface = sample_surface(obj, SAMPLES)
        step = max(1, len(surface.points) // SAMPLES)
        points, part = surface.points[::step], surface.part[::step]
        near = min(NEIGHBOURS + 1, len(points))
        lengths, neighbours = map(np.asarray, cKDTree(points).query(points, k=near))
        width = max(float(np.median(lengths[:, -1])), np.finfo(float).tiny)
        rows, columns = np.repeat(np.arange(len(points)), near - 1), neighbours[:, 1:].ravel()
        kernel = np.exp(-np.square(lengths[:, 1:].ravel() / width))
        weights = csr_array((kernel, (rows, columns)), shape=(len(points),) * 2)
        weights = weights.maximum(weights.T)
        degree = diags_array(1.0 / np.sqrt(np.maximum(weights.sum(axis=1), np.finfo(float).tiny)))
        laplacian = eye_array(len(points)) - degree @ weights @ degree
        values, functions = eigsh(laplacian.tocsc(), min(MODES, len(points) - 1), sigma=-SHIFT, v0=np.ones(len(points)))
        order = np.argsort(values, kind="stable")
        values, functions = values[order], functions[:, order]
        values = np.maximum(values, 0.0) / max(float(values.mean()), np.finfo(float).tiny)
        return cls(points, part, values, functions, _signatures(values, functions))


def _signatures(values: Floats, functions: Floats) -> Floats:
    """Return the wave kernel signatures (s, ENERGIES): squared eigenfunctions through bands of log energy."""
    logs = np.log(np.maximum(values[1:], 1e-6))
    energies = np.linspace(logs.min(), logs.max(), ENERGIES)
    # Aubry et al. take seven steps of the energy for the width of a band.
    width = 7.0 * max(float(energies[1] - energies[0]), 1e-9)
    bands = np.exp(-np.square(energies[:, None] - logs) / (2.0 * width**2))
    bands /= bands.sum(axis=1, keepdims=True)
    signatures: Floats = len(functions) * np.square(functions[:, 1:]) @ bands.T
    return signatures


def functional_map(source: Spectrum, target: Spectrum) -> Floats:
    """Return C (m, n) that takes coefficients of functions on the source to those on the target.

    Minimises |C A - B|^2 + COMMUTE sum (C_ij (target value_i - source value_j))^2, row by row.
    """
    a, b = source.functions.T @ source.signatures, target.functions.T @ target.signatures
    scale = float(np.square(a).sum()) / len(a)
    gram = a @ a.T
    rows = []
    for i, value in enumerate(target.values):
        penalty = np.diag(COMMUTE * scale * np.square(value - source.values) + 1e-9 * scale)
        rows.append(np.linalg.solve(gram + penalty, a @ b[i]))
    return np.array(rows)


@dataclass(frozen=True, eq=False)
class _Spectra:
    """Spectra of every object and what they are retrieved by."""

    sources: tuple[Source, ...]
    spectra: tuple[Spectrum, ...]
    means: Floats

    def predict(self, query: Query, k: int, rng: Generator) -> list[Prediction]:
        """Return the contacts of the objects with the most similar signatures, through functional maps."""
        target = self.spectra[query.target]
        subjects = [self.sources[i].subject for i in query.sources]
        distances = np.linalg.norm(self.means[subjects] - self.means[query.target], axis=1)
        predictions = []
        for row in np.argsort(distances, kind="stable")[:k]:
            source = self.spectra[subjects[row]]
            contact = self.sources[query.sources[row]].demonstration.contact
            shown = int(np.square(source.points - contact.point).sum(axis=1).argmin())
            # Delta functions are compared as rows of the eigenbases, scaled to samples of unit mass.
            mapped = functional_map(source, target) @ source.functions[shown] * np.sqrt(len(source.points))
            there = target.functions * np.sqrt(len(target.points))
            best = int(cdist(mapped[None], there)[0].argmin())
            predictions.append(
                Prediction(target.points[best], int(target.part[best]), query.sources[row], -float(distances[row]))
            )
        return predictions
