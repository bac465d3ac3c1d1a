"""Flags that several verbs share, and how they print."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import tyro
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from graft.contact import TransferredContact
from graft.errors import InputError, printable
from graft.features import Descriptor, GeometricDescriptor
from graft.io import load_object
from graft.objects import PartObject
from graft.transport import UFGW
from graft.viz import save_glb, save_scene, save_sheet


@dataclass(frozen=True)
class Loading:
    """How object files are read."""

    package: Annotated[tuple[str, ...], tyro.conf.UseAppendAction] = ()
    """name=path of a ROS package that package:// refers to; may be repeated."""
    missing: Literal["error", "skip"] = "error"
    """What to do about mesh files that are missing: stop, or leave them out with one warning."""
    parts: Literal["auto", "segment", "bodies", "geoms", "links", "visuals"] = "auto"
    """auto: as the file has them. segment: cut what is one part. MJCF: bodies or geoms. URDF: links or visuals."""
    up: tuple[float, float, float] | None = None
    """Direction against gravity in the object frame, instead of what the file says."""
    scale_to_metres: float | None = None
    """Metres per object unit, instead of what the file says (0.001 for millimetres)."""

    def packages(self) -> dict[str, Path]:
        """Return the folders that files may be named in, by their names."""
        packages = {}
        for entry in self.package:
            name, equals, where = entry.partition("=")
            if not (name and equals and where):
                raise InputError(f"--package: expected name=path, got {entry!r}")
            packages[name] = Path(where)
        return packages

    def load(self, path: Path) -> PartObject:
        """Read an object with these options."""
        return load_object(
            path,
            parts=self.parts,
            packages=self.packages(),
            missing=self.missing,
            up=self.up,
            scale_to_metres=self.scale_to_metres,
        )


LoadingFlags = Annotated[Loading, tyro.conf.OmitArgPrefixes]


def print_json(document: dict[str, Any]) -> None:
    """Print one JSON document on stdout; NaN and infinity, which JSON lacks, are errors."""
    json.dump(document, sys.stdout, indent=1, allow_nan=False)
    sys.stdout.write("\n")


PIPE_WIDTH = 10_000
"""Characters of a line that no terminal limits: files and pipes get tables in their own width."""


def stdout_console() -> Console:
    """Return the console for tables; in names, neither emoji codes nor numbers are special."""
    console = Console(emoji=False, highlight=False)
    if not console.is_terminal:
        console.width = PIPE_WIDTH
    return console


def fits(console: Console, table: Table) -> bool:
    """Tell whether a table is no wider than the console."""
    return Console(width=PIPE_WIDTH).measure(table).maximum <= console.width


def print_table(console: Console, table: Table) -> None:
    """Print a table; on a narrow terminal cells go on in the next line, nothing is cut off."""
    for column in table.columns:
        column.overflow = "fold"
    console.print(table)


def shown(name: str) -> str:
    """Return a name from a file so that neither rich nor the terminal takes it for a command."""
    return escape(printable(name))


@dataclass(frozen=True)
class Matching:
    """Parameters of the matching that are worth changing by hand; the others are in `graft.UFGW`."""

    alpha: float = UFGW.alpha
    """Weight of the features; 1 - alpha is the structure's (the paper's alpha, POT's is the opposite)."""
    eps: float = UFGW.eps
    """Entropic regularisation."""
    tau: float = UFGW.tau_s
    """Price of mass that is not transported, on both sides."""
    descriptor: Literal["geometric", "none"] = "geometric"
    """What parts are compared by, beside their boxes."""

    def solver(self) -> UFGW:
        """Return the solver with these parameters."""
        return UFGW(alpha=self.alpha, eps=self.eps, tau_s=self.tau, tau_t=self.tau)

    def described(self) -> Descriptor | None:
        """Return the descriptor chosen."""
        return GeometricDescriptor() if self.descriptor == "geometric" else None


MatchingFlags = Annotated[Matching, tyro.conf.OmitArgPrefixes]

_WRITERS = {".png": save_sheet, ".html": save_scene, ".glb": save_glb}


def check_outputs(paths: tuple[Path, ...], kinds: Iterable[str] = _WRITERS) -> None:
    """Refuse a suffix that no writer knows, before anything is computed."""
    for path in paths:
        if path.suffix.lower() not in kinds:
            raise InputError(f"--out: expected a file ending in {', '.join(kinds)}, got {str(path)!r}")


def write_outputs(paths: tuple[Path, ...], transfers: TransferredContact | Sequence[TransferredContact]) -> None:
    """Write a picture, a page or a model of the transfers, by suffix."""
    for path in paths:
        _WRITERS[path.suffix.lower()](path, transfers)
