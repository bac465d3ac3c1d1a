"""`graft show OBJECT`: read an object, print its parts, draw it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import tyro
from rich.table import Table

from graft.cli import EXIT_OK
from graft.cli.options import Loading, LoadingFlags, check_outputs, print_json, print_table, shown, stdout_console
from graft.documents import object_document
from graft.graph import PartGraph, build_graph
from graft.io import save_object
from graft.objects import PartObject
from graft.viz import save_object_scene, save_views


@dataclass(frozen=True)
class Show:
    """Read an object and print its parts; --out writes a picture, page or GLB."""

    object: tyro.conf.Positional[Path]
    """A mesh, scene, MJCF, URDF, labelled mesh or point cloud, or a folder of one."""
    json: bool = False
    """Print one JSON document and nothing else."""
    out: tuple[Path, ...] = ()
    """Files to write; the suffix tells what: .png (views), .html (page), .glb."""
    loading: LoadingFlags = Loading()

    def run(self) -> int:
        """Print and draw; returns the exit code."""
        check_outputs(self.out, _WRITERS)
        obj = self.loading.load(self.object)
        graph = build_graph(obj, descriptor=None)
        for path in self.out:
            _WRITERS[path.suffix.lower()](path, obj)
        if self.json:
            print_json(object_document(obj, graph))
        else:
            _print_parts(obj, graph)
        return EXIT_OK


_WRITERS: dict[str, Callable[[Path, PartObject], None]] = {
    ".png": save_views,
    ".html": save_object_scene,
    ".glb": save_object,
}


def _print_parts(obj: PartObject, graph: PartGraph) -> None:
    """Print what was read: one row per part, then joints and notes."""
    console = stdout_console()
    scale = obj.scale_to_metres
    size = "unknown scale" if scale is None else f"{graph.diagonal * scale * 100:.4g} cm across"
    up = "none" if obj.up is None else " ".join(f"{round(x, 4) + 0.0:g}" for x in obj.up)
    console.print(
        f"[bold]{shown(obj.name)}[/]  {shown(obj.category or 'no category')}, {size}, up {up}, {obj.n_faces} faces"
    )
    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column("part")
    for column in ("faces", "extents", "area %", "touches"):
        table.add_column(column, justify="right")
    table.add_column("flags")
    for i, part in enumerate(obj.parts):
        touches = [shown(obj.parts[j].name) for j in graph.adjacency[i].nonzero()[0]]
        table.add_row(
            f"[green]{shown(part.name)}[/]" if i in obj.graspable else shown(part.name),
            f"{len(part.vertices)} points" if part.is_point_cloud else str(len(part.faces)),
            " x ".join(f"{2 * e:.3g}" for e in graph.half_extents[i]),
            f"{100 * graph.areas[i] / max(graph.areas.sum(), 1e-300):.0f}",
            ", ".join(touches) or "-",
            ", ".join(f.name.lower() for f in graph.flags[i] if f.name),
        )
    print_table(console, table)
    for joint in obj.joints:
        parent, child = shown(obj.parts[joint.parent].name), shown(obj.parts[joint.child].name)
        console.print(f"joint {shown(joint.name)}: {joint.kind}, {parent} to {child}")
    for note in obj.notes:
        console.print(f"[yellow]note[/] {shown(note)}")
