"""Pictures and films of a trial. The trial is run again, with the same bits, in a scene that can be drawn."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from graft.errors import InputError, MissingExtraError
from graft.io.atomic import write_whole
from graft.objects import Floats
from graft.sim.compiled import CompiledScene
from graft.sim.engine import load_mujoco
from graft.sim.outcome import Trial
from graft.sim.prepare import PreparedObject
from graft.sim.trial import CHUNK, run_trial

Image = NDArray[np.uint8]

FRAMES_PER_SECOND = 30
"""Of a film, in the time of the simulation."""

PANELS = ("rest", "squeeze", "hold")
"""Phases whose last moment a strip shows: before the grasp, closed, lifted."""

SIDE = 480
"""Pixels."""

AZIMUTH, ELEVATION = 130.0, -22.0
"""Degrees, from where the camera looks."""


def save_trial(path: str | Path, prepared: PreparedObject, trial: Trial, *, size: int = SIDE) -> None:
    """Draw a trial: .png is a strip (before the grasp, closed, lifted or the end), .mp4 a film.

    Args:
        path: What to write.
        prepared: The object of the trial.
        trial: Of MuJoCo, with a grasp.
        size: Pixels of a side; even.

    Raises:
        InputError: Another suffix, an odd size, a trial without a grasp, or nothing can be drawn on this machine.
        MissingExtraError: mujoco, pillow or av is not installed.
    """
    path = Path(path)
    kinds: dict[str, Callable[[PreparedObject, Trial, int], bytes]] = {".png": _strip, ".mp4": _film}
    if path.suffix.lower() not in kinds:
        raise InputError(f"expected a file ending in {' or '.join(kinds)}", path=path)
    if size < 32 or size % 2:
        raise InputError(f"size: expected an even number of at least 32 pixels, got {size}")
    write_whole(path, kinds[path.suffix.lower()](prepared, trial, size))


def trial_panels(prepared: PreparedObject, trial: Trial, *, size: int = SIDE) -> tuple[Image, ...]:
    """Return images (size, size, 3) of a trial: before the grasp, closed, and lifted or as it ended."""
    taken: dict[str, Image] = {}
    with _drawn(prepared, trial, size) as (scene, shoot):

        def watch(state: CompiledScene, phase: str) -> None:
            if phase != watch_state[0]:
                if watch_state[0] in PANELS:
                    taken[watch_state[0]] = shoot()
                watch_state[0] = phase

        # A phase's last moment is seen when the next one begins, 10 ms later.
        watch_state = [""]
        _run_again(prepared, trial, scene, watch)
        panels = [taken[phase] for phase in PANELS[:2] if phase in taken]
        return (*panels, shoot())


def _strip(prepared: PreparedObject, trial: Trial, size: int) -> bytes:
    try:
        from PIL import Image as Pillow
    except ImportError:
        raise MissingExtraError("writing a PNG", package="pillow", extra="sim") from None
    buffer = io.BytesIO()
    Pillow.fromarray(np.hstack(trial_panels(prepared, trial, size=size))).save(buffer, "png")
    return buffer.getvalue()


def _film(prepared: PreparedObject, trial: Trial, size: int) -> bytes:
    try:
        import av
    except ImportError:
        raise MissingExtraError("writing an mp4", package="av", extra="sim") from None
    buffer = io.BytesIO()
    with _drawn(prepared, trial, size) as (scene, shoot), av.open(buffer, "w", format="mp4") as container:
        stream = container.add_stream("h264", rate=FRAMES_PER_SECOND)
        stream.width = stream.height = size
        stream.pix_fmt = "yuv420p"
        shown = [0]

        def watch(state: CompiledScene, phase: str) -> None:
            if state.data.time * FRAMES_PER_SECOND >= shown[0]:
                shown[0] += 1
                container.mux(stream.encode(av.VideoFrame.from_ndarray(shoot(), format="rgb24")))

        _run_again(prepared, trial, scene, watch)
        container.mux(stream.encode(av.VideoFrame.from_ndarray(shoot(), format="rgb24")))
        container.mux(stream.encode())
    return buffer.getvalue()


def _run_again(
    prepared: PreparedObject, trial: Trial, scene: CompiledScene, watch: Callable[[CompiledScene, str], None]
) -> Trial:
    if trial.grasp is None:
        raise InputError(f"trial of {trial.object_name!r}: it has no grasp to show ({trial.outcome.value})")
    return run_trial(prepared, trial.grasp, trial.config, pose=trial.T_world_object, watch=watch, scene=scene)


@contextmanager
def _drawn(prepared: PreparedObject, trial: Trial, size: int) -> Iterator[tuple[CompiledScene, Callable[[], Image]]]:
    """Give a scene with the object's own surfaces and a function that takes its picture."""
    if trial.grasp is None:
        raise InputError(f"trial of {trial.object_name!r}: it has no grasp to show ({trial.outcome.value})")
    scene = CompiledScene(prepared.body, trial.config, trial.grasp.gripper, looks=prepared.object)
    start = prepared.T_world_object if trial.T_world_object is None else trial.T_world_object
    camera = _camera(prepared, start, trial)
    renderer = _renderer(scene.model, size)
    try:

        def shoot() -> Image:
            renderer.update_scene(scene.data, camera)
            picture: Image = renderer.render().copy()
            return picture

        yield scene, shoot
    finally:
        # Left to the garbage collector, a renderer can outlive its context and crash.
        renderer.close()


def _renderer(model: Any, size: int) -> Any:
    mj = load_mujoco()
    model.vis.global_.offwidth = model.vis.global_.offheight = size
    try:
        return mj.Renderer(model, size, size)
    except Exception as error:
        raise InputError(
            "no picture can be drawn here: OpenGL without a display needs EGL (Debian: libegl1) or, with MUJOCO_GL="
            f"osmesa, OSMesa (Debian: libosmesa6); {type(error).__name__}: {error}"
        ) from error


def _camera(prepared: PreparedObject, start: Floats, trial: Trial) -> Any:
    """Return a camera that sees the object on the table and lifted, and the hand."""
    mj = load_mujoco()
    corners = prepared.body.hull @ start[:3, :3].T + start[:3, 3]
    low, high = corners.min(axis=0), corners.max(axis=0)
    high[2] += trial.config.lift_height + HAND_ROOM
    camera = mj.MjvCamera()
    camera.lookat[:] = (low + high) / 2
    camera.distance = 1.15 * float(np.linalg.norm(high - low)) + 0.1
    camera.azimuth, camera.elevation = AZIMUTH, ELEVATION
    return camera


HAND_ROOM = 0.08
"""Metres left above the lifted object for the hand in a picture."""


def view_trial(prepared: PreparedObject, trial: Trial) -> None:
    """Show a trial in MuJoCo's own viewer, in real time; returns when the window is closed.

    Raises:
        InputError: There is no display, or the trial has no grasp.
    """
    import os
    import sys
    import time

    load_mujoco()
    if trial.grasp is None:
        raise InputError(f"trial of {trial.object_name!r}: it has no grasp to show ({trial.outcome.value})")
    if sys.platform == "linux" and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        raise InputError("the viewer needs a display; write a .png or .mp4 instead")
    from mujoco import viewer

    scene = CompiledScene(prepared.body, trial.config, trial.grasp.gripper, looks=prepared.object)
    with viewer.launch_passive(scene.model, scene.data) as window:
        started = time.monotonic()

        def watch(state: CompiledScene, phase: str) -> None:
            window.sync()
            time.sleep(max(0.0, started + state.data.time - time.monotonic()))

        _run_again(prepared, trial, scene, watch)
        while window.is_running():
            window.sync()
            time.sleep(CHUNK * trial.config.timestep)
