"""Films and pictures of flights."""

from __future__ import annotations

import contextlib
import importlib
import os
import shutil
import subprocess
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from skybody import InputError
from skybody._native import Renderer
from skybody.whole_output import not_written

from .cameras import Camera, camera
from .scene import Scene
from .shapes import Shapes

if TYPE_CHECKING:  # environments draw without it
    from PIL import Image

HDTV = (  # conversion of colours, and its name in the file
    "scale=out_color_matrix=bt709:out_range=tv,"
    "setparams=colorspace=bt709:color_primaries=bt709:color_trc=bt709:range=tv"
)
FAST = "bframes=0:subme=1"  # half the time, and a tenth to a third more bytes
PIPE_SIZE = 1 << 20  # to ffmpeg [bytes]
FARTHEST = 500.0  # of surfaces that are seen [m]
MOST_TRIANGLES = 60_000  # of a picture: the renderer numbers them by 16 bits
Frame = NDArray[np.uint8]  # (height, width, 3)


@dataclass(frozen=True)
class Size:
    """Size, rate and lens of a film."""

    width: int = 1920  # [pixels]
    height: int = 1080  # [pixels]
    rate: float = 30.0  # frames per second
    field_of_view: float = 1.05  # horizontal [rad]
    quality: int = 80  # of WebP, up to 100


@dataclass(frozen=True)
class Panel:
    """A part of the picture: a world by a camera."""

    scenes: tuple[Scene, ...]  # drawn into one world, at least one
    camera: str  # of skybody.look.cameras.CAMERAS
    left: int  # of the picture, as all that follow [pixels]
    top: int
    width: int
    height: int


class Film:
    """Draws the frames of some panels."""

    def __init__(self, panels: Sequence[Panel], size: Size) -> None:
        self.size = size
        self.duration = max(p.scenes[0].flight.duration for p in panels)
        self._panels = [(p, *_prepare(p, size)) for p in panels]

    def frame(self, time: float) -> Frame:
        """The picture at a time since the reset [s]. Threads may draw at the same time."""
        picture = np.full((self.size.height, self.size.width, 3), 255, np.uint8)
        for panel, renderer, eye in self._panels:
            rows = slice(panel.top, panel.top + panel.height)
            part = picture[rows, panel.left : panel.left + panel.width]
            now = min(time, panel.scenes[0].flight.duration)
            shapes = Shapes()
            for scene in panel.scenes:
                scene.add_to(shapes, min(time, scene.flight.duration))
            view = eye(now)
            rgb = np.ascontiguousarray(part)  # itself, if it has the picture's width
            shapes.draw(renderer, view.eye, view.axes, rgb)
            if not np.shares_memory(rgb, part):
                part[:] = rgb
        return picture

    def frames(
        self, times: Sequence[float], finish: Callable[[Frame, float], Frame] | None = None
    ) -> Iterator[Frame]:
        """The pictures at some times in order, drawn on all processors, a few ahead."""

        def one(time: float) -> Frame:
            drawn = self.frame(time)
            return finish(drawn, time) if finish else drawn

        threads = os.cpu_count() or 1
        with ThreadPoolExecutor(threads) as pool:
            waiting: list[Future[Frame]] = []
            rest = iter(times)
            waiting += [pool.submit(one, t) for t in islice(rest, 2 * threads)]
            while waiting:
                yield waiting.pop(0).result()
                waiting += [pool.submit(one, t) for t in islice(rest, 1)]


def _prepare(panel: Panel, size: Size) -> tuple[Renderer, Camera]:
    focal = 0.5 * panel.width / np.tan(0.5 * size.field_of_view)  # [pixels]
    shapes = sum(scene.most for scene in panel.scenes)
    triangles = sum(scene.triangles for scene in panel.scenes)
    if triangles > MOST_TRIANGLES:
        raise InputError(
            f"there are {triangles} triangles to draw; allowed: at most {MOST_TRIANGLES}; use "
            "simpler meshes"
        )
    renderer = Renderer(panel.width, panel.height, focal, shapes, triangles, FARTHEST)
    aspect = panel.height / panel.width
    return renderer, camera(panel.camera, panel.scenes, size.field_of_view, aspect)


# --- files --------------------------------------------------------------------------------------


def write(path: Path, size: Size, frames: Iterable[Frame]) -> None:
    """Writes frames by the file's ending; nothing is left of a film that could not be finished.

    Args:
        path: .mp4, .gif, .webp, .png, or without ending a folder of numbered PNG files.

    Raises:
        InputError: unknown ending, no ffmpeg, or a folder that cannot be written.
    """
    kind = KINDS.get(path.suffix)
    if kind is None:
        raise InputError(
            f"{path}: unknown ending `{path.suffix}`; allowed: .mp4, .gif, .webp, .png, or none "
            "for a folder of PNG files"
        )
    part = path.with_name(f".{path.stem}.part{path.suffix}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        kind(part if path.suffix else path, size, frames)
        if path.suffix:
            part.replace(path)
    except OSError as error:
        raise InputError(not_written(path, error)) from None
    finally:
        if path.suffix:
            with contextlib.suppress(OSError):  # of a folder that cannot be written
                part.unlink(missing_ok=True)


def write_video(path: Path, size: Size, frames: Iterable[Frame]) -> None:
    """An MP4, H.264 with the colours of HDTV, by ffmpeg; the same frames give the same bytes."""
    command = [
        ffmpeg(), "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24",
        "-s", f"{size.width}x{size.height}", "-r", f"{size.rate:g}", "-i", "-",
        "-vf", HDTV,
        "-c:v", "libx264", "-preset", "veryfast", "-x264-params", FAST, "-crf", "20",
        "-pix_fmt", "yuv420p", "-threads", "1", "-fflags", "+bitexact", "-flags:v", "+bitexact",
        "-movflags", "+faststart", str(path),
    ]  # fmt: skip
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stderr=pipe, pipesize=PIPE_SIZE) as process:
        assert process.stdin is not None
        try:
            for frame in frames:
                process.stdin.write(frame.data)
        except BrokenPipeError:
            pass  # ffmpeg has ended, and says why
        _, message = process.communicate()
    if process.returncode != 0:
        raise OSError(f"ffmpeg: {message.decode().strip()}")


def write_animation(path: Path, size: Size, frames: Iterable[Frame]) -> None:
    """An animated GIF or WebP, or one PNG."""
    from PIL import Image

    images: Iterator[Image.Image] = (Image.fromarray(frame) for frame in frames)
    if path.suffix == ".gif":
        images = with_palette(images)
    first = next(images)
    if path.suffix == ".png":
        first.save(path)
        return
    pause = round(1000 / size.rate)  # [ms]
    first.save(
        path, save_all=True, append_images=images, duration=pause, loop=0,
        quality=size.quality, method=4, kmin=9, kmax=12,  # a whole picture among 12
    )  # fmt: skip


def write_folder(path: Path, size: Size, frames: Iterable[Frame]) -> None:
    """Numbered PNG files."""
    from PIL import Image

    path.mkdir(exist_ok=True)
    for number, frame in enumerate(frames):
        Image.fromarray(frame).save(path / f"frame_{number:06d}.png")


KINDS: dict[str, Callable[[Path, Size, Iterable[Frame]], None]] = {
    ".mp4": write_video,
    ".gif": write_animation,
    ".webp": write_animation,
    ".png": write_animation,
    "": write_folder,
}


def with_palette(images: Iterator[Image.Image]) -> Iterator[Image.Image]:
    """The images in 200 colours of the first one, so that colours stay."""
    from PIL import Image

    palette: Image.Image | None = None
    for image in images:
        palette = palette or image.quantize(200, Image.Quantize.MEDIANCUT)
        yield image.quantize(palette=palette, dither=Image.Dither.NONE)


def ffmpeg() -> str:
    """The program: the system's, or that of the package imageio-ffmpeg.

    Raises:
        InputError: there is none.
    """
    if found := shutil.which("ffmpeg"):
        return found
    try:
        return str(importlib.import_module("imageio_ffmpeg").get_ffmpeg_exe())
    except (ImportError, RuntimeError):
        raise InputError(
            "an MP4 needs ffmpeg: `pip install imageio-ffmpeg` or `apt install ffmpeg`; or write "
            ".gif, .webp, or a folder of PNG files, which need nothing more"
        ) from None
