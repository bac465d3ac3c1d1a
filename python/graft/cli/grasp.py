"""`graft grasp TARGET`: gripper poses that hold an object, near a transferred or given contact."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
import tyro
from rich.table import Table

from graft.cli import EXIT_FAILED, EXIT_OK
from graft.cli.options import (
    Loading,
    LoadingFlags,
    Matching,
    MatchingFlags,
    check_outputs,
    print_json,
    print_table,
    shown,
    stdout_console,
)
from graft.contact import VOTERS, agree, transfer_contact
from graft.documents import grasps_document
from graft.errors import InputError
from graft.grasp import AnyGraspPlanner, FilePlanner, GraspSet, Support, find_gripper, in_metres, save_grasps
from graft.grasp.files import GRASP_SUFFIXES
from graft.grasp.planner import AntipodalPlanner, plan_grasps
from graft.library import Library
from graft.marking import closest_surface_point
from graft.objects import Contact, PartObject
from graft.viz import save_grasp_glb, save_grasp_scene, save_grasp_sheet

if TYPE_CHECKING:
    from graft.grasp.planner import GraspPlanner

OFF_SURFACE = 0.05
"""Diagonals of the object from its surface beyond which a point on the command line is no contact of it."""

CHECKPOINT_SUFFIXES = (".tar", ".pth", ".pt")
"""Of AnyGrasp's weights."""

_PICTURES: dict[str, Callable[[Path, PartObject, GraspSet, Contact | None], None]] = {
    ".png": save_grasp_sheet,
    ".html": save_grasp_scene,
    ".glb": save_grasp_glb,
}


@dataclass(frozen=True)
class GraspCommand:
    """Plan grasps of an object with a parallel gripper, near a contact, on a part, or anywhere.

    Exits with 1 when there is no grasp; the reasons are printed.
    """

    target: tyro.conf.Positional[Path]
    """The object to be grasped."""
    library: Path | None = None
    """A folder of demonstrations whose contact is transferred to the object, as `graft transfer` does."""
    contact: tuple[float, float, float] | None = None
    """A point on the object, in its frame and unit, instead of a library."""
    part: str | None = None
    """A part by name or label that is grasped, instead of a library or a contact."""
    gripper: str = "panda_hand"
    """panda_hand, robotiq_2f85, or a .toml, .xml (MJCF) or .urdf file."""
    planner: str = "antipodal"
    """antipodal; or a file of grasps (.npz, .npy, .json); or the weights of AnyGrasp (.tar), whose SDK is needed."""
    support: Literal["auto", "none"] = "auto"
    """auto: the object stands on a plane below it, along its up axis, and the gripper stays above it."""
    k: Annotated[int, tyro.conf.arg(aliases=["-k"])] = 20
    """How many grasps to give at most."""
    seed: int = 0
    """Of everything that is drawn by lot."""
    json: bool = False
    """Print one JSON document and nothing else."""
    out: tuple[Path, ...] = ()
    """Files to write; the suffix tells what: .npz, .npy (GraspNet), .json (GraspGen), .png, .html (page), .glb."""
    loading: LoadingFlags = Loading()
    matching: MatchingFlags = Matching()

    def run(self) -> int:
        """Load, transfer, plan, print, write; returns the exit code."""
        if self.k < 1:
            raise InputError(f"-k: expected at least 1, got {self.k}")
        places = {"--library": self.library, "--contact": self.contact, "--part": self.part}
        given = [flag for flag, value in places.items() if value is not None]
        if len(given) > 1:
            raise InputError(f"{' and '.join(given)}: expected one of them, they each say where to grasp")
        check_outputs(self.out, (*GRASP_SUFFIXES, *_PICTURES))
        gripper, planner = find_gripper(self.gripper, packages=self.loading.packages()), self._planner()
        target = self.loading.load(self.target)
        part = None if self.part is None else target.part_index(self.part)
        contact = self._contact(target)
        grasps = plan_grasps(
            target,
            contact,
            gripper,
            part=part,
            support=Support.below(in_metres(target)) if self.support == "auto" else None,
            planner=planner,
            k=self.k,
            seed=self.seed,
        )
        grasps = replace(grasps, metadata={"object": target.name, "seed": self.seed, **grasps.metadata})
        if self.json:
            print_json(grasps_document(target, grasps, contact))
        else:
            _print_grasps(target, grasps, contact)
        for path in self.out if len(grasps) else ():
            if path.suffix.lower() in GRASP_SUFFIXES:
                save_grasps(path, grasps)
            else:
                _PICTURES[path.suffix.lower()](path, target, grasps, contact)
        return EXIT_OK if len(grasps) else EXIT_FAILED

    def _planner(self) -> GraspPlanner:
        """Return the planner that is asked for, by name or by the suffix of its file."""
        if self.planner == "antipodal":
            return AntipodalPlanner()
        suffix = Path(self.planner).suffix.lower()
        if suffix in GRASP_SUFFIXES:
            return FilePlanner(self.planner)
        if suffix in CHECKPOINT_SUFFIXES:
            return AnyGraspPlanner(self.planner)
        raise InputError(
            f"--planner: expected antipodal, a file of grasps ({', '.join(GRASP_SUFFIXES)}) or weights of AnyGrasp "
            f"({', '.join(CHECKPOINT_SUFFIXES)}), got {self.planner!r}"
        )

    def _contact(self, target: PartObject) -> Contact | None:
        """Return where the object is to be taken; None for anywhere."""
        if self.library is not None:
            library = Library.open(self.library, solver=self.matching.solver(), descriptor=self.matching.described())
            return agree([transfer_contact(match) for match in library.retrieve(target, k=VOTERS)])[0].contact
        if self.contact is None:
            return None
        found = [closest_surface_point(part, self.contact) for part in target.parts]
        index = int(np.argmin([distance for _, _, distance in found]))
        point, normal, distance = found[index]
        size = float(np.linalg.norm(np.ptp(target.bounds, axis=0)))
        if distance > OFF_SURFACE * size:
            raise InputError(
                f"--contact: {list(self.contact)} is {distance:.3g} off the surface of {target.name!r}, which is "
                f"{size:.3g} across; expected a point on it, in its frame and unit"
            )
        return Contact(point, normal, index)


def _print_grasps(target: PartObject, grasps: GraspSet, contact: Contact | None) -> None:
    """Print one row per grasp, or why there is none."""
    console = stdout_console()
    where = "" if contact is None else f" near a contact on {shown(target.part_names[contact.part])}"
    console.print(f"[bold]{shown(target.name)}[/]{where}, {shown(grasps.gripper.name)}")
    if not len(grasps):
        console.print("no grasp")
        for reason, count in sorted(grasps.rejected.items(), key=lambda item: -item[1]):
            console.print(f"  {count} rejected: {shown(reason)}")
        return
    table = Table(box=None, pad_edge=False, header_style="bold")
    for column in ("", "score", "width mm", "distance mm", "TCP (m)", "approach", "closing"):
        table.add_column(column, justify="right")
    for i, grasp in enumerate(grasps):
        table.add_row(
            str(i + 1),
            f"{grasp.score:.3f}",
            f"{1000 * grasp.width:.1f}",
            "-" if contact is None else f"{1000 * grasp.distance:.1f}",
            " ".join(f"{x:.3f}" for x in grasp.pose[:3, 3]),
            *(" ".join(f"{x + 0.0:.2f}" for x in np.round(grasp.pose[:3, axis], 2)) for axis in (2, 1)),
        )
    print_table(console, table)
