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

FORMAT = 1
"""Version of the cache files; another one is another key."""


@dataclass(frozen=True)
class DecompositionConfig:
    """How CoACD cuts; its names. Coarser than its defaults where that made no difference to grasps but to the time.

    Attributes:
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
        for name in ("preprocess_resolution", "resolution", "mcts_nodes", "mcts_iterations", "mcts_max_depth"):
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
    except ImportError:
        raise MissingExtraError(f"cutting the concave part {what!r}", package="coacd", extra="sim") from None
    shown = sys.stderr.isatty()
    if shown:
        print(f"cutting {what!r} ({len(faces)} faces) into convex pieces ...", end="", file=sys.stderr, flush=True)  # noqa: T201
    start = time.perf_counter()
    coacd.set_log_level("off")
    pieces = coacd.run_coacd(coacd.Mesh(*capped(vertices, faces)), **asdict(config))
    if shown:
        print(f" {len(pieces)} in {time.perf_counter() - start:.1f} s", file=sys.stderr)  # noqa: T201
    return tuple(np.asarray(corners, np.float64) for corners, _ in pieces)


def capped(vertices: Floats, faces: Ints) -> tuple[Floats, Ints]:
    """Return the surface with its holes closed, each by a fan around the middle of its rim.

    A part cut out of a solid's surface is open where it was cut; left so, CoACD takes it for a thin shell and cuts it
    into hundreds of flakes.
    """
    _, first, same = np.unique(vertices, axis=0, return_index=True, return_inverse=True)
    corners = same.reshape(-1)[faces]
    edges = np.vstack([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    known = set(map(tuple, edges.tolist()))
    # A hole is walked against the faces around it.
    following: dict[int, list[int]] = {}
    for a, b in known:
        if (b, a) not in known:
            following.setdefault(b, []).append(a)
    for ends in following.values():
        ends.sort()
    points = [vertices[first]]
    fans = [corners]
    count = len(first)
    while following:
        start = min(following)
        rim = [start]
        while rim[-1] in following:
            ends = following[rim[-1]]
            rim.append(ends.pop())
            if not ends:
                del following[rim[-2]]
            if rim[-1] == start:
                break
        if rim[-1] != start:
            continue  # not a loop: a fold of a broken mesh, left open
        loop = np.array(rim[:-1])
        points.append(vertices[first][loop].mean(axis=0, keepdims=True))
        fans.append(np.stack([loop, np.roll(loop, -1), np.full(len(loop), count)], axis=1))
        count += 1
    return np.vstack(points), np.vstack(fans)
