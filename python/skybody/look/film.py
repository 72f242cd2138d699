"""Films and pictures of flights."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from skybody import InputError
from skybody._native import Renderer

from .cameras import Camera, camera
from .scene import Scene, Shapes

FARTHEST = 500.0  # of surfaces that are seen [m]
Frame = NDArray[np.uint8]  # (height, width, 3)


@dataclass(frozen=True)
class Size:
    """Of a film."""

    width: int = 1920  # [pixels]
    height: int = 1080
    rate: float = 30.0  # frames per second
    field_of_view: float = 1.05  # horizontal [rad]


@dataclass(frozen=True)
class Panel:
    """A part of the picture: a world by a camera."""

    scenes: tuple[Scene, ...]  # drawn into one world; the camera is the first one's
    camera: str
    left: int
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
        picture = np.zeros((self.size.height, self.size.width, 3), np.uint8)
        for panel, renderer, eye in self._panels:
            now = min(time, panel.scenes[0].flight.duration)
            shapes = Shapes()
            for scene in panel.scenes:
                scene.add_to(shapes, min(time, scene.flight.duration))
            view = eye(now)
            rgb = np.empty((panel.height, panel.width, 3), np.uint8)
            shapes.draw(renderer, view.eye, view.axes, rgb)
            rows = slice(panel.top, panel.top + panel.height)
            picture[rows, panel.left : panel.left + panel.width] = rgb
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
    focal = 0.5 * size.width / np.tan(0.5 * size.field_of_view) * panel.width / size.width
    shapes = sum(scene.most for scene in panel.scenes)
    triangles = sum(scene.triangles for scene in panel.scenes)
    renderer = Renderer(panel.width, panel.height, focal, shapes, triangles, FARTHEST)
    return renderer, camera(panel.camera, panel.scenes[0], size.field_of_view)


# --- files --------------------------------------------------------------------------------------


class Writer(Protocol):
    """Takes frames, one after another."""

    def add(self, frame: Frame) -> None: ...

    def close(self) -> None: ...


class VideoWriter:
    """An MP4 by ffmpeg, H.264; the same frames give the same bytes."""

    def __init__(self, path: Path, size: Size) -> None:
        self.path = path
        self._part = path.with_name(f".{path.stem}.part{path.suffix}")
        command = [
            ffmpeg(), "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24",
            "-s", f"{size.width}x{size.height}", "-r", f"{size.rate:g}", "-i", "-",
            "-c:v", "libx264", "-preset", "veryfast", "-crf", "20", "-pix_fmt", "yuv420p",
            "-threads", "1", "-fflags", "+bitexact", "-flags:v", "+bitexact",
            "-movflags", "+faststart", str(self._part),
        ]  # fmt: skip
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE)

    def add(self, frame: Frame) -> None:
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(frame.tobytes())
        except BrokenPipeError:
            self.close()

    def close(self) -> None:
        _, message = self._process.communicate()
        if self._process.returncode != 0:
            self._part.unlink(missing_ok=True)
            raise InputError(f"{self.path}: ffmpeg failed: {message.decode().strip()}")
        self._part.replace(self.path)


class PictureWriter:
    """An animated GIF or WebP, or a folder or file of PNG."""

    def __init__(self, path: Path, size: Size) -> None:
        self.path, self._size = path, size
        self._frames: list[Image.Image] = []
        self._palette: Image.Image | None = None

    def add(self, frame: Frame) -> None:
        image = Image.fromarray(frame)
        if self.path.suffix == ".gif":
            self._palette = self._palette or image.quantize(200, Image.Quantize.MEDIANCUT)
            image = image.quantize(palette=self._palette, dither=Image.Dither.NONE)
        self._frames.append(image)

    def close(self) -> None:
        part = self.path.with_name(f".{self.path.stem}.part{self.path.suffix}")
        more = {"quality": 80, "method": 4} if self.path.suffix == ".webp" else {}
        self._frames[0].save(
            part,
            save_all=len(self._frames) > 1,
            append_images=self._frames[1:],
            duration=round(1000 / self._size.rate),
            loop=0,
            **more,
        )
        part.replace(self.path)


class FolderWriter:
    """Numbered PNG files in a folder."""

    def __init__(self, path: Path, size: Size) -> None:
        self.path = path
        path.mkdir(parents=True, exist_ok=True)
        self._next = 0

    def add(self, frame: Frame) -> None:
        Image.fromarray(frame).save(self.path / f"frame_{self._next:06d}.png")
        self._next += 1

    def close(self) -> None:
        pass


def writer(path: Path, size: Size) -> Writer:
    """A writer by the file's ending.

    Raises:
        InputError: unknown ending, no ffmpeg, or a folder that cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.suffix == "":
            return FolderWriter(path, size)
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror})") from None
    if not os.access(path.parent, os.W_OK):
        raise InputError(f"{path}: the folder {path.parent} cannot be written; choose another")
    if path.suffix == ".mp4":
        return VideoWriter(path, size)
    if path.suffix in (".gif", ".webp", ".png"):
        return PictureWriter(path, size)
    raise InputError(
        f"{path}: unknown ending `{path.suffix}`; allowed: .mp4, .gif, .webp, .png, or none for a "
        "folder of PNG files"
    )


def ffmpeg() -> str:
    """The program's path.

    Raises:
        InputError: it is not installed.
    """
    found = shutil.which("ffmpeg")
    if found is None:
        raise InputError(
            "an MP4 needs the program ffmpeg: `apt install ffmpeg`; or write .gif, .webp, or a "
            "folder of PNG files, which need nothing more"
        )
    return found
