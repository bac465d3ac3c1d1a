"""What is checked in an MJCF model before MuJoCo opens it: the files it names and the copies it asks for.

MuJoCo opens whatever path a model holds and repeats bodies as often as it is told. So every include, attached
model and asset must lie inside the asset root (`packages.asset_root`), includes must not loop, and counts are
bounded.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from graft.errors import InputError
from graft.io.guards import MAX_FILE_BYTES, existing_file
from graft.io.packages import asset_root, is_inside
from graft.io.robot_xml import at_line, read_description

MAX_COPIES = 100_000
"""Most bodies that <replicate>, <composite> or <flexcomp> may make: far more than a household has."""

MAX_COUNT = 10_000_000
"""Largest element count that a model may reserve (height field cells, user data)."""

COPYING = ("replicate", "composite", "flexcomp")
RESERVING = {"hfield": ("nrow", "ncol"), "numeric": ("size",)}
FOLDER_OF = {"mesh": "meshdir", "hfield": "meshdir", "skin": "meshdir", "flexcomp": "meshdir"}
"""Which compiler attribute names the folder of an element's file."""

NAMING = ("name", "class", "childclass")
"""Attributes in which "nan" may be a word."""


@dataclass(frozen=True)
class _Model:
    """One model, that is a file and all that it includes, while it is walked."""

    file: Path
    roots: tuple[Path, ...]
    folders: dict[str, str] = field(default_factory=dict)
    seen: list[Path] = field(default_factory=list)


def check_model(path: Path, folders: Sequence[Path] = ()) -> None:
    """Refuse a model that is unsafe to open.

    Args:
        path: The model.
        folders: Where it may name files in, beside its asset root.

    Raises:
        InputError: Not an MJCF file; a DOCTYPE; a file that is missing, too large or outside the asset root;
            an include loop; counts beyond bounds; NaN. The message has file and line.
    """
    _check(path, (asset_root(path), *folders), chain=())


def _check(path: Path, roots: tuple[Path, ...], chain: tuple[Path, ...]) -> None:
    model = _Model(path, roots)
    elements = list(_walk(model, path, (*chain, path.resolve())))
    for _, element in elements:
        if element.tag == "compiler":
            for name in ("assetdir", "meshdir", "texturedir"):
                if element.get(name) is not None:
                    model.folders[name] = element.get(name)
            if element.get("strippath") is not None:
                model.folders["strippath"] = element.get("strippath")
    for file, element in elements:
        _check_counts(file, element)
        _check_numbers(file, element)
        _check_reference(model, file, element, (*chain, path.resolve()))


def _walk(model: _Model, file: Path, chain: tuple[Path, ...]) -> Iterator[tuple[Path, Any]]:
    """Yield the elements of `file` and of the files it includes, each with its file."""
    document = read_description(file)
    if document.tag == "mujocoinclude" and file == model.file:
        raise at_line(file, document, "is a fragment (<mujocoinclude>): load the model that includes it")
    if document.tag not in ("mujoco", "mujocoinclude") or (file == model.file and document.tag != "mujoco"):
        raise at_line(file, document, f"root element: expected <mujoco>, got <{document.tag}>")
    for element in document.iter():
        if not isinstance(element.tag, str):
            continue
        if element.tag != "include":
            yield file, element
            continue
        included = _inside(model, file, element, model.file.parent, element.get("file", ""))
        if included in chain:
            names = " -> ".join(link.name for link in (*chain[chain.index(included) :], included))
            raise at_line(file, element, f"includes itself: {names}")
        if included in model.seen:
            raise at_line(file, element, f"{element.get('file')!r} is included twice, which MuJoCo refuses")
        model.seen.append(included)
        # MuJoCo takes every include's path from the folder of the main file.
        yield from _walk(model, included, (*chain, included))


def _check_reference(model: _Model, file: Path, element: Any, chain: tuple[Path, ...]) -> None:
    for attribute, reference in element.attrib.items():
        if not attribute.startswith("file") or not reference:
            continue
        if element.tag == "model":
            attached = _inside(model, file, element, model.file.parent, reference)
            if attached in chain:
                raise at_line(file, element, f"attaches itself: {reference!r}")
            _check(attached, model.roots, chain)
        elif element.tag == "texture":
            continue  # textures are dropped before MuJoCo looks for them
        else:
            folder = model.folders.get(FOLDER_OF.get(element.tag, ""), model.folders.get("assetdir", ""))
            if model.folders.get("strippath") == "true":
                reference = reference.replace("\\", "/").rpartition("/")[2]
            _inside(model, file, element, model.file.parent / folder.replace("\\", "/"), reference)


def _inside(model: _Model, file: Path, element: Any, base: Path, reference: str) -> Path:
    """Return the existing file of bounded size that `reference` leads to, inside the root."""
    cleaned = reference.replace("\\", "/")
    if not cleaned.strip() or "\0" in cleaned:
        raise at_line(file, element, f"<{element.tag}>: expected a file, got {reference!r}")
    target = base / cleaned
    if not any(is_inside(target, root) for root in model.roots):
        where = f"<{element.tag}> {reference!r} (in {base}) leaves the asset root {model.roots[0]}"
        raise at_line(file, element, f"{where}; name its folder as a package (--package NAME=FOLDER) to allow it")
    target = target.resolve()
    try:
        existing_file(target)
    except InputError as error:
        message = str(error).removeprefix(f"{error.path}: ")
        raise at_line(file, element, f"<{element.tag}> {reference!r}: {message}") from None
    if target.stat().st_size > MAX_FILE_BYTES:
        size = target.stat().st_size
        raise at_line(file, element, f"{reference!r} has {size} bytes, more than the {MAX_FILE_BYTES} that are read")
    return target


def _check_counts(file: Path, element: Any) -> None:
    if element.tag in COPYING:
        copies = 1
        for around in (element, *element.iterancestors()):
            if around.tag in COPYING:
                copies *= _product(around.get("count", "1"))
        if copies > MAX_COPIES:
            raise at_line(file, element, f"<{element.tag}> makes {copies} copies, more than the {MAX_COPIES} allowed")
    names = element.attrib if element.tag == "size" else RESERVING.get(element.tag, ())
    reserved = 1
    for name in names:
        if name != "memory":
            count = _product(element.get(name, "1"))
            reserved = max(reserved, count) if element.tag == "size" else reserved * count
    if reserved > MAX_COUNT:
        raise at_line(file, element, f"<{element.tag}> reserves {reserved} elements, more than the {MAX_COUNT} allowed")


def _check_numbers(file: Path, element: Any) -> None:
    """Refuse NaN, which MuJoCo lets pass, and reversed ranges of joints, which it takes for no range."""
    for name, text in element.attrib.items():
        if name not in NAMING and "nan" in text.lower().split():
            raise at_line(file, element, f"<{element.tag}> {name}: expected finite numbers, got {text[:80]!r}")
    if element.tag == "joint" and element.get("range") is not None:
        try:
            lower, upper = (float(word) for word in element.get("range").split())
        except ValueError:
            return  # for MuJoCo to refuse
        if lower > upper:
            where = f"joint {element.get('name', '')!r} range"
            raise at_line(file, element, f"{where}: expected lower <= upper, got {lower:g} > {upper:g}")


def _product(text: str) -> int:
    """Return the product of the numbers in `text`; what is not one is left for MuJoCo to refuse."""
    product = 1.0
    for word in text.split():
        try:
            product *= max(1.0, float(word))
        except ValueError:
            continue
    return int(min(product, 1e18)) if product == product else 1
