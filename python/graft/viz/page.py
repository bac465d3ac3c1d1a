"""`save_scene`, `save_object_scene`, `save_grasp_scene`: pages that open from a file, without a network."""

from __future__ import annotations

import contextlib
import io
from collections.abc import Iterator, Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from graft.errors import MissingExtraError
from graft.io.atomic import write_whole
from graft.objects import Contact, Floats, PartObject
from graft.viz.colors import CONTACT
from graft.viz.files import check_output
from graft.viz.grippers import BEST, BOX_OPACITY
from graft.viz.layout import Cell, Placed, lay_out, place_alone, place_grasps
from graft.viz.meshes import quaternion, surface
from graft.viz.shapes import ARROW_LENGTH, BALL_RADIUS
from graft.viz.transfers import as_sequence

if TYPE_CHECKING:
    from graft.contact.transfer import TransferredContact
    from graft.grasp.grasps import GraspSet

FIELD_OF_VIEW = np.radians(32.0)
"""Of the page's camera, vertically; narrow, so that objects at the rim are not stretched."""

VIEW_DIRECTION = np.array([0.0, -0.84, 0.54])
"""From the middle of the scene to the camera."""

VISER_TITLE = "<title>Viser</title>"
"""What the page is called until it gets the name of what it shows."""

ASPECT = 1.5
"""Width to height of the window that a scene is framed for."""

LABEL_HEIGHT, NAME_HEIGHT = 0.06, 0.035
"""Heights of labels and of parts' names, in diagonals of an object."""


def save_scene(path: str | Path, transfers: TransferredContact | Sequence[TransferredContact]) -> None:
    """Write transfers as one self-contained HTML page.

    Sources stand to the left of their targets; parts have the colours of the match, lines join matched parts
    (stronger where more mass goes), contacts have a red ball and their frame's axes, the normal blue.

    Args:
        path: Ends in .html.
        transfers: One or several.

    Raises:
        InputError: No transfer, or the file cannot be written.
        MissingExtraError: viser (or fast-simplification, for large meshes) is not installed.
    """
    path = check_output(path, ".html")
    several = as_sequence(transfers)
    cells = lay_out(several)
    targets = dict.fromkeys(t.match.target.object.name for t in several)
    with _page(path, f"graft: {', '.join(targets)}") as server:
        for cell in cells:
            _add_cell(server.scene, cell)
        corners = [_extent(side) for cell in cells for side in (cell.source, cell.target)]
        corners += [cell.front[None] for cell in cells]
        _frame(server, np.concatenate(corners))


def save_object_scene(path: str | Path, obj: PartObject) -> None:
    """Write one object, its parts in colours and named, as one self-contained HTML page.

    Args:
        path: Ends in .html.
        obj: The object.

    Raises:
        InputError: The file cannot be written.
        MissingExtraError: viser (or fast-simplification, for large meshes) is not installed.
    """
    path = check_output(path, ".html")
    placed = place_alone(obj)
    with _page(path, f"graft: {obj.name}") as server:
        _add_object(server.scene, placed)
        beside = _add_names(server.scene, placed, obj)
        _frame(server, np.concatenate([_extent(placed), beside]))


def save_grasp_scene(path: str | Path, obj: PartObject, grasps: GraspSet, contact: Contact | None = None) -> None:
    """Write an object and grasps on it as one self-contained HTML page.

    The first grasp has the gripper's boxes, closed on the object, the others are sticks, greener where the score is
    higher; the contact has a red ball and its frame's axes.

    Args:
        path: Ends in .html.
        obj: The object, in its own unit.
        grasps: In metres, best first.
        contact: Where the object was to be taken, object units.

    Raises:
        InputError: There is no grasp, the object has no size in metres, or the file cannot be written.
        MissingExtraError: viser (or fast-simplification, for large meshes) is not installed.
    """
    path = check_output(path, ".html")
    placed, shapes = place_grasps(obj, grasps, contact)
    with _page(path, f"graft: grasps of {obj.name}") as server:
        _add_object(server.scene, placed)
        for shape in shapes:
            opacity = BOX_OPACITY if shape.name.startswith(BEST) else 1.0
            name = f"{placed.name}/grasps/{shape.name}"
            server.scene.add_mesh_trimesh(name, surface(shape, opacity))
        reach = np.concatenate([s.vertices for s in shapes]) @ placed.pose[:3, :3].T + placed.pose[:3, 3]
        _frame(server, np.concatenate([_extent(placed), reach]))


@contextlib.contextmanager
def _page(path: Path, title: str) -> Iterator[Any]:
    """Give a viser server to fill, and write what it shows; the server does not stay."""
    try:
        import viser
    except ImportError:
        raise MissingExtraError("writing pages", package="viser", extra="viz") from None
    # Port 0: any that is free, on this machine alone. viser's greeting is no part of the output.
    with contextlib.redirect_stdout(io.StringIO()):
        server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
        try:
            server.scene.set_up_direction("+z")
            server.scene.world_axes.visible = False
            yield server
            html = server.scene.as_html()
        finally:
            server.stop()
    write_whole(path, html.replace(VISER_TITLE, f"<title>{escape(title)}</title>", 1).encode())


def _add_cell(scene: Any, cell: Cell) -> None:
    """Add both objects of a transfer, the lines between them and the caption."""
    for placed in (cell.source, cell.target):
        _add_object(scene, placed)
    for i, link in enumerate(cell.links):
        faded = np.array(link.color) + (1.0 - link.strength) * 0.7 * (255.0 - np.array(link.color))
        scene.add_line_segments(
            f"{cell.name}/links/{i}",
            np.array([[link.start, link.end]], np.float32),
            np.round(np.tile(faded, (1, 2, 1))).astype(np.uint8),
            thickness=0.004 + 0.012 * link.strength,
        )
    _label(scene, f"{cell.name}/caption", cell.caption, cell.front)


def _add_object(scene: Any, placed: Placed) -> None:
    """Add an object's parts, its title above it, and its contact."""
    scene.add_frame(placed.name, show_axes=False, wxyz=quaternion(placed.pose), position=placed.pose[:3, 3])
    # A source that is shown several times is moved by its frame only, so that the page stores it once.
    for i, shape in enumerate(placed.shapes):
        name = f"{placed.name}/{i}_{shape.name.replace('/', '_')}"
        if len(shape.faces):
            scene.add_mesh_trimesh(name, surface(shape))
        else:
            scene.add_point_cloud(
                name,
                shape.vertices.astype(np.float32),
                shape.color,
                point_size=2 * shape.radius,
                point_shape="circle",
            )
    middle = np.append(_extent(placed)[:, :2].mean(axis=0), placed.height + 2.2 * LABEL_HEIGHT)
    _label(scene, f"{placed.name}_title", placed.title, middle)
    if placed.contact is None:
        return
    pose = placed.contact_pose(placed.contact)
    scene.add_icosphere(f"{placed.name}_contact/ball", BALL_RADIUS, CONTACT, position=pose[:3, 3])
    scene.add_frame(
        f"{placed.name}_contact/frame",
        wxyz=quaternion(pose),
        position=pose[:3, 3],
        axes_length=ARROW_LENGTH,
        axes_radius=0.006,
        origin_radius=0.0,
    )


def _add_names(scene: Any, placed: Placed, obj: PartObject) -> Floats:
    """Write the parts' names in a column beside an object, with lines; returns (n, 3) where they end."""
    order = np.argsort(-placed.centers[:, 2], kind="stable")
    step = 1.6 * NAME_HEIGHT
    spots = np.empty_like(placed.centers)
    spots[:, :2] = _extent(placed)[:, 0].max() + 0.2, 0.0
    tops = placed.height / 2 + step * ((len(order) - 1) / 2 - np.arange(len(order)))
    spots[order, 2] = np.maximum(tops, tops - tops.min())
    for i, (shape, center, spot) in enumerate(zip(placed.shapes, placed.centers, spots, strict=True)):
        points = shape.vertices @ placed.pose[:3, :3].T + placed.pose[:3, 3]
        nearest = points[int(np.argmin(np.linalg.norm(points - center, axis=1)))]
        color = np.tile(np.array(shape.color, np.uint8), (1, 2, 1))
        scene.add_line_segments(f"names/{i}/line", np.array([[nearest, spot]], np.float32), color, thickness=0.003)
        name = f"{shape.name} (graspable)" if i in obj.graspable else shape.name
        _label(scene, f"names/{i}/name", name, spot, height=NAME_HEIGHT, anchor="center-left")
    ends: Floats = spots + np.array([0.3, 0.0, 0.0])
    return ends


def _label(
    scene: Any,
    name: str,
    text: str,
    position: Floats,
    *,
    height: float = LABEL_HEIGHT,
    anchor: str = "center-center",
) -> None:
    scene.add_label(name, text, position=position, font_size_mode="scene", font_scene_height=height, anchor=anchor)


def _extent(placed: Placed) -> Floats:
    """Return (8, 3) corners of an object's box, world."""
    points = np.concatenate([s.vertices for s in placed.shapes]) @ placed.pose[:3, :3].T + placed.pose[:3, 3]
    low, high = points.min(axis=0), points.max(axis=0)
    return np.array([[(low, high)[i >> k & 1][k] for k in range(3)] for i in range(8)])


def _frame(server: Any, points: Floats) -> None:
    """Put the camera where all `points` (p, 3) are seen."""
    toward = VIEW_DIRECTION / np.linalg.norm(VIEW_DIRECTION)
    right = np.array([1.0, 0.0, 0.0])
    up = np.cross(toward, right)
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    offsets = points - middle
    half = np.tan(FIELD_OF_VIEW / 2)
    needed = np.maximum(np.abs(offsets @ up), np.abs(offsets @ right) / ASPECT) / half + offsets @ toward
    server.initial_camera.fov = float(FIELD_OF_VIEW)
    server.initial_camera.position = middle + 1.12 * float(needed.max()) * toward
    server.initial_camera.look_at = middle
    server.initial_camera.up = np.array([0.0, 0.0, 1.0])
