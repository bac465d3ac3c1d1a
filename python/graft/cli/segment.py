"""`graft segment FILE`: cut a fused mesh or point cloud into parts."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro
from rich.table import Table

from graft.cli import EXIT_OK
from graft.cli.options import check_outputs, print_json, print_table, shown, stdout_console
from graft.documents import object_document
from graft.errors import InputError
from graft.graph import build_graph
from graft.io import load_object, save_object
from graft.objects import PartObject
from graft.parts import cut_hierarchy, cut_object
from graft.viz import save_object_scene, save_views
from graft.viz.ply import save_ply


@dataclass(frozen=True)
class Segment:
    """Cut a fused mesh or point cloud into parts; --out writes a picture, page, GLB or PLY."""

    object: tyro.conf.Positional[Path]
    """A mesh, scan, point cloud, or a folder of one."""
    out: tuple[Path, ...] = ()
    """Files to write; the suffix tells what: .png (views), .html (page), .glb, .ply (labelled and coloured)."""
    n_parts: Annotated[int | None, tyro.conf.arg(name="parts")] = None
    """How many parts; by default as many as people would make."""
    hierarchy: bool = False
    """Cut coarse to fine: one row and one set of files (FILE.1.png, FILE.2.png, ...) per level."""
    keep: bool = False
    """Keep the parts that the file has, if they are 2 to 32, rather than fuse them first."""
    seed: int = 0
    """Of the points at which the surface is measured."""
    up: tuple[float, float, float] | None = None
    """Direction against gravity in the object frame, instead of what the file says."""
    scale_to_metres: float | None = None
    """Metres per object unit, instead of what the file says (0.001 for millimetres)."""
    json: bool = False
    """Print one JSON document and nothing else."""

    def run(self) -> int:
        """Cut, print and draw; returns the exit code."""
        check_outputs(self.out, _WRITERS)
        if self.hierarchy and (self.n_parts is not None or self.keep):
            raise InputError("--hierarchy: cuts all levels of the fused surface; leave --parts and --keep out")
        if self.n_parts is not None and self.n_parts < 1:
            raise InputError(f"--parts: expected at least 1, got {self.n_parts}")
        if self.seed < 0:
            raise InputError(f"--seed: expected at least 0, got {self.seed}")
        obj = load_object(self.object, up=self.up, scale_to_metres=self.scale_to_metres)
        start = time.perf_counter()
        if self.hierarchy:
            levels, chosen = cut_hierarchy(obj, seed=self.seed)
        else:
            levels, chosen = (cut_object(obj, n_parts=self.n_parts, fuse=not self.keep, seed=self.seed),), 0
        seconds = time.perf_counter() - start
        written = [self._write(level, place) for place, level in enumerate(levels)]
        if self.json:
            documents = [object_document(level, build_graph(level, descriptor=None)) for level in levels]
            print_json({"chosen": chosen, "levels": documents} if self.hierarchy else documents[0])
            return EXIT_OK
        if self.hierarchy:
            _print_levels(levels, chosen)
        else:
            _print_parts(levels[0])
        print(f"{seconds:.2f} s")
        for paths in written:
            for path in paths:
                print(path)
        return EXIT_OK

    def _write(self, level: PartObject, place: int) -> list[Path]:
        """Write one level; the files of a hierarchy are numbered from 1."""
        paths = [p.with_suffix(f".{place + 1}{p.suffix}") if self.hierarchy else p for p in self.out]
        for path in paths:
            _WRITERS[path.suffix.lower()](path, level)
        return paths


_WRITERS: dict[str, Callable[[Path, PartObject], None]] = {
    ".png": save_views,
    ".html": save_object_scene,
    ".glb": save_object,
    ".ply": save_ply,
}


def _sizes(obj: PartObject) -> list[float]:
    """Return the share of the area (of the points of a cloud) of each part, in percent."""
    areas = build_graph(obj, descriptor=None).areas
    weights = [len(p.vertices) if p.is_point_cloud else float(a) for p, a in zip(obj.parts, areas, strict=True)]
    return [100.0 * w / max(sum(weights), 1e-300) for w in weights]


def _print_parts(obj: PartObject) -> None:
    console = stdout_console()
    console.print(f"[bold]{shown(obj.name)}[/]  {len(obj.parts)} part{'s' if len(obj.parts) > 1 else ''}")
    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("part")
    for column in ("faces", "area %"):
        table.add_column(column, justify="right")
    for part, size in zip(obj.parts, _sizes(obj), strict=True):
        amount = f"{len(part.vertices)} points" if part.is_point_cloud else str(len(part.faces))
        table.add_row(shown(part.name), amount, f"{size:.1f}")
    print_table(console, table)
    for note in obj.notes:
        console.print(f"[yellow]note[/] {shown(note)}")


def _print_levels(levels: tuple[PartObject, ...], chosen: int) -> None:
    console = stdout_console()
    console.print(f"[bold]{shown(levels[0].name)}[/]  {len(levels)} levels, coarse to fine")
    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("level", justify="right")
    table.add_column("parts", justify="right")
    table.add_column("area % of each")
    for place, level in enumerate(levels):
        number = f"{place + 1} *" if place == chosen else f"{place + 1}  "
        table.add_row(number, str(len(level.parts)), " ".join(f"{size:.1f}" for size in _sizes(level)))
    print_table(console, table)
    console.print("* what people would make")
    for note in levels[0].notes:
        console.print(f"[yellow]note[/] {shown(note)}")
