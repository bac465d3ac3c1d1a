"""Concave parts cut into convex pieces by CoACD, once: the result is kept in the user's cache folder.

Wei, Liu, Xiong, Ling, Su: Approximate Convex Decomposition for 3D Meshes with Collision-Aware Concavity and Tree
Search, ACM Transactions on Graphics 41(4), 2022.
"""

from __future__ import annotations

import hashlib
import io
import os
import sys
import time
import zipfile
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from graft.errors import InputError, MissingExtraError
from graft.io.atomic import write_whole
from graft.objects import Floats, Ints
from graft.sim.capping import capped, enclosed

FORMAT = 1
"""Version of the cache files; another one is another key."""


@dataclass(frozen=True)
class DecompositionConfig:
    """How CoACD cuts; its names. Coarser than its defaults where that made no difference to grasps but to the time.

    Attributes:
        faces: A finer surface is simplified to so many triangles first.
        threshold: Largest concavity of a piece, in units of the part scaled to [-1, 1].
        preprocess_resolution: Voxels across when an open surface is closed first.
        resolution: Samples that concavity is measured by.
        mcts_nodes: Cuts tried at each level.
        mcts_iterations: Iterations of the tree search for each cut.
        mcts_max_depth: Depth of the search.
        max_convex_hull: Most pieces of a part.
        max_ch_vertex: Most corners of a piece.
        seed: Of its samples.
    """

    faces: int = 4000
    threshold: float = 0.05
    preprocess_resolution: int = 40
    resolution: int = 1000
    mcts_nodes: int = 10
    mcts_iterations: int = 40
    mcts_max_depth: int = 2
    max_convex_hull: int = 32
    max_ch_vertex: int = 64
    seed: int = 0

    def __post_init__(self) -> None:
        # CoACD's own range; outside it prints and goes on with another value.
        if not 0.01 <= self.threshold <= 1.0:
            raise InputError(f"decomposition threshold: expected 0.01 to 1, got {self.threshold:g}")
        for name in ("faces", "preprocess_resolution", "resolution", "mcts_nodes", "mcts_iterations", "mcts_max_depth"):
            if getattr(self, name) < 1:
                raise InputError(f"decomposition {name}: expected at least 1, got {getattr(self, name)}")


def cache_folder() -> Path:
    """Return the folder of decompositions: GRAFT_CACHE, or `graft` in the user's cache folder."""
    if chosen := os.environ.get("GRAFT_CACHE"):
        return Path(chosen)
    home = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    return Path(home) / "graft"


def decompose(
    vertices: Floats, faces: Ints, config: DecompositionConfig, *, cache: Path | None = None, what: str = "part"
) -> tuple[Floats, ...]:
    """Return the corners (v, 3) of convex pieces that cover a surface.

    Args:
        vertices: (v, 3).
        faces: (f, 3).
        config: How to cut.
        cache: Folder to keep the result in; the user's when None. A folder that cannot be written is done without.
        what: Name of the part, for the progress on a terminal.

    Raises:
        MissingExtraError: coacd is needed, not in the cache, and not installed.
    """
    folder = cache_folder() if cache is None else cache
    path = folder / "pieces" / f"{_key(vertices, faces, config)}.npz"
    kept = _read(path)
    if kept is not None:
        return kept
    pieces = _run_coacd(vertices, faces, config, what)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, _packed(pieces))
    except (OSError, InputError) as error:
        print(f"graft: the pieces of {what!r} are not kept: {error}", file=sys.stderr)  # noqa: T201
    return pieces


def _key(vertices: Floats, faces: Ints, config: DecompositionConfig) -> str:
    digest = hashlib.sha256(f"{FORMAT} {sorted(asdict(config).items())} {vertices.shape} {faces.shape}".encode())
    digest.update(np.ascontiguousarray(vertices).tobytes())
    digest.update(np.ascontiguousarray(faces).tobytes())
    return digest.hexdigest()


def _packed(pieces: tuple[Floats, ...]) -> bytes:
    buffer = io.BytesIO()
    np.savez(buffer, corners=np.vstack(pieces), counts=np.array([len(piece) for piece in pieces]))
    return buffer.getvalue()


def _read(path: Path) -> tuple[Floats, ...] | None:
    """Return what a cache file holds, or None when it is absent or not what we write (it is then made anew)."""
    try:
        with np.load(path, allow_pickle=False) as file:
            corners, counts = file["corners"], file["counts"]
        if corners.ndim != 2 or corners.shape[1] != 3 or counts.sum() != len(corners) or not np.isfinite(corners).all():
            return None
        return tuple(np.split(corners.astype(np.float64), np.cumsum(counts)[:-1]))
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
        return None


def _run_coacd(vertices: Floats, faces: Ints, config: DecompositionConfig, what: str) -> tuple[Floats, ...]:
    try:
        import coacd
        import fast_simplification
    except ImportError as error:
        package = (error.name or "coacd").replace("_", "-")
        raise MissingExtraError(f"cutting the concave part {what!r}", package=package, extra="sim") from None
    shown = sys.stderr.isatty()
    if shown:
        print(f"cutting {what!r} ({len(faces)} faces) into convex pieces ...", end="", file=sys.stderr, flush=True)  # noqa: T201
    start = time.perf_counter()
    coacd.set_log_level("off")
    options = asdict(config)
    most = options.pop("faces")
    solid = capped(vertices, faces)
    if enclosed(*solid) > 0:  # else the surface is that of a cavity, and CoACD's own closing has to do
        vertices, faces = solid
    if len(faces) > most:
        vertices, faces = fast_simplification.simplify(
            vertices.astype(np.float32), faces.astype(np.int32), target_count=most
        )
    pieces = coacd.run_coacd(coacd.Mesh(vertices, faces), **options)
    if shown:
        print(f" {len(pieces)} in {time.perf_counter() - start:.1f} s", file=sys.stderr)  # noqa: T201
    return tuple(np.asarray(corners, np.float64) for corners, _ in pieces)
