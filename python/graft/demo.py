"""The main job on objects that everyone has: contacts from demonstrated objects to objects nobody demonstrated.

The library holds the zoo's demonstrated categories (one variant each, as in the paper) and every second YCB scan;
the targets are the zoo's other categories and the other scans. Which scans are demonstrated is fixed by their place
in the list, not chosen.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from graft import zoo
from graft.contact import VOTERS, TransferredContact, agree, transfer_contact
from graft.documents import Document, transfer_document
from graft.errors import InputError
from graft.io import save_object
from graft.io.atomic import write_whole
from graft.library import Library
from graft.objects import Demonstration, PartObject
from graft.viz import save_glb, save_scene, save_sheet

Progress = Callable[[str, int, int], None]
"""Called with what is being done, how many are done, how many there are."""


@dataclass(frozen=True, eq=False)
class DemoRow:
    """One target's result.

    Attributes:
        transferred: The contact that the best `VOTERS` matches agree on.
        seconds: Wall time from the loaded object to the contact: part graph, retrieval, transfer.
        in_mask: Whether the contact lies on a part that a person takes.
    """

    transferred: TransferredContact
    seconds: float
    in_mask: bool

    @property
    def same_category(self) -> bool:
        """Whether the source is of the target's own category."""
        match = self.transferred.match
        return match.demonstration.object.category == match.target.object.category


def demonstrations(seed: int = 0) -> list[Demonstration]:
    """Return what the demo's library is made of."""
    scans = [zoo.ycb_demonstration(name) for name in zoo.ycb_names()[::2]]
    return [zoo.demonstration(category, seed) for category in zoo.demonstrated()] + scans


def targets(seed: int = 0) -> list[PartObject]:
    """Return the objects that nobody demonstrated."""
    scans = [zoo.ycb_object(name) for name in zoo.ycb_names()[1::2]]
    return [zoo.make(category, seed) for category in zoo.unseen()] + scans


def transfer_all(
    library: Library, objects: Sequence[PartObject], progress: Progress = lambda *_: None
) -> list[DemoRow]:
    """Transfer the contact that the best matches agree on to each object."""
    rows = []
    for done, obj in enumerate(objects):
        progress(obj.name, done, len(objects))
        start = time.perf_counter()
        matches = library.retrieve(obj, k=VOTERS)
        transferred = agree([transfer_contact(match) for match in matches])[0]
        seconds = time.perf_counter() - start
        rows.append(DemoRow(transferred, seconds, transferred.target_part in obj.graspable))
    return rows


def _save_objects(objects: Sequence[PartObject], folder: Path) -> None:
    """Write every object as a GLB of its own."""
    for obj in objects:
        save_object(folder / f"{obj.name}.glb", obj)


def demo_document(rows: Sequence[DemoRow], seed: int) -> Document:
    """Describe the demo's results."""
    return {
        "seed": seed,
        "targets": len(rows),
        "in_mask": sum(row.in_mask for row in rows),
        "other_category": sum(not row.same_category for row in rows),
        "in_mask_other_category": sum(row.in_mask for row in rows if not row.same_category),
        "results": [
            {**transfer_document(row.transferred), "in_mask": row.in_mask, "seconds": round(row.seconds, 6)}
            for row in rows
        ],
    }


def run_demo(
    out: Path, *, seed: int = 0, progress: Progress = lambda *_: None
) -> tuple[list[DemoRow], dict[str, Path]]:
    """Run the demo and write its results.

    Args:
        out: Folder to write into; made when missing.
        seed: Chooses the zoo's variants.
        progress: Told what is being done.

    Returns:
        One row per target, and what was written: name -> path.

    Raises:
        InputError: `out` is a file, or cannot be written.
        MissingExtraError: The `demo` extra is not installed.
    """
    if out.exists() and not out.is_dir():
        raise InputError("expected a folder to write into, it is a file", path=out)
    out.mkdir(parents=True, exist_ok=True)
    library = Library()
    shown = demonstrations(seed)
    for done, demonstration in enumerate(shown):
        progress(demonstration.name, done, len(shown))
        library.add(demonstration)
    objects = targets(seed)
    rows = transfer_all(library, objects, progress)

    written = {
        "picture": out / "contacts.png",
        "page": out / "scene.html",
        "model": out / "scene.glb",
        "results": out / "demo.json",
        "library": out / "library",
        "targets": out / "targets",
    }
    transfers = [row.transferred for row in rows]
    drawing: list[tuple[str, Callable[[], object]]] = [
        ("picture", lambda: save_sheet(written["picture"], transfers)),
        ("page", lambda: save_scene(written["page"], transfers)),
        ("model", lambda: save_glb(written["model"], transfers)),
        ("library", lambda: library.save(written["library"])),
        ("targets", lambda: _save_objects(objects, written["targets"])),
        ("results", lambda: write_whole(written["results"], json.dumps(demo_document(rows, seed), indent=1).encode())),
    ]
    for done, (name, draw) in enumerate(drawing):
        progress(f"writing the {name}", done, len(drawing))
        draw()
    return rows, written
