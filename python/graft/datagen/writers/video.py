"""Frames as mp4 (h264) and back, one at a time."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from graft.datagen.durable import drafted
from graft.datagen.episode import Image
from graft.errors import InputError, MissingExtraError

QUALITY = 20
"""x264's constant rate factor: 18 cannot be told from the source by eye, 23 is its default."""

KEY_EVERY = 2
"""Every second frame is coded by itself, as LeRobot does, for trainers jump about."""

PIXELS = "yuv420p"
"""The one format of pixels that every decoder of h264 knows; it halves colour's resolution."""


def load_av() -> Any:
    """Return PyAV."""
    try:
        import av
    except ImportError:
        raise MissingExtraError("reading and writing videos", package="av", extra="data") from None
    return av


def video_info(shape: tuple[int, ...], fps: int) -> dict[str, Any]:
    """Return what LeRobot says of a video among its features."""
    return {
        "video.height": shape[0],
        "video.width": shape[1],
        "video.codec": "h264",
        "video.pix_fmt": PIXELS,
        "video.is_depth_map": False,
        "video.fps": fps,
        "video.channels": 3,
        "has_audio": False,
    }


def write_video(path: Path, frames: Iterable[Image], fps: int) -> None:
    """Write frames as a video, whole or absent, in the memory of one frame; the same bytes for the same frames.

    Args:
        path: Ends in .mp4.
        frames: (h, w, 3) uint8 each, all of one shape, height and width even.
        fps: Frames per second.

    Raises:
        InputError: An odd size, or the system refuses.
    """
    av = load_av()
    with drafted(path) as draft, draft.open("xb") as file:
        try:
            with av.open(file, "w", format="mp4") as container:
                stream = None
                for frame in frames:
                    stream = stream or _stream(container, frame.shape, fps, path)
                    picture = av.VideoFrame.from_ndarray(frame, format="rgb24").reformat(format=PIXELS, threads=1)
                    container.mux(stream.encode(picture))
                if stream is not None:
                    container.mux(stream.encode(None))
        except av.error.FFmpegError as error:
            raise InputError(f"cannot be written: {error.strerror or error}", path=path) from error


def _stream(container: Any, shape: tuple[int, ...], fps: int, path: Path) -> Any:
    height, width = shape[:2]
    if height % 2 or width % 2:
        raise InputError(f"h264 needs an even height and width, got {height} x {width}", path=path)
    stream = container.add_stream("libx264", rate=fps, options={"crf": str(QUALITY), "g": str(KEY_EVERY)})
    stream.height, stream.width, stream.pix_fmt = height, width, PIXELS
    stream.codec_context.thread_count = 1  # the number of threads changes the bytes
    return stream


class VideoFrames:
    """The frames of a video, decoded one by one each time they are iterated. h264 loses detail."""

    def __init__(self, path: Path, count: int) -> None:
        self.path, self.count = path, count

    def __iter__(self) -> Iterator[Image]:
        av = load_av()
        if not self.path.is_file():
            raise InputError("no such video", path=self.path)
        found = 0
        try:
            with av.open(str(self.path)) as container:
                for frame in container.decode(video=0):
                    found += 1
                    yield np.asarray(frame.to_ndarray(format="rgb24"), np.uint8)
        except av.error.FFmpegError as error:
            raise InputError(f"not a video, or a broken one: {error.strerror or error}", path=self.path) from None
        if found != self.count:
            raise InputError(f"expected {self.count} frames, got {found}", path=self.path)
