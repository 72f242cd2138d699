"""`render()` of environments. Modules that draw are imported when a picture is wanted."""

from __future__ import annotations

import importlib.util
import os
import sys
import time
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from . import _native
from .arguments import word_error

if TYPE_CHECKING:
    from .look.live import Pictures
    from .look.window import Window

MODES = ["human", "rgb_array"]
NO_MODE = 'render() draws nothing: give the environment render_mode="rgb_array" or "human"'
SIZE = (640, 360)
MOST_PIXELS = 4096  # of each edge
SHOWN = 1.0 / 30.0  # least time of flight between two pictures of a window [s]
MOST_LATE = 0.5  # a window that is later shows slow motion, rather than to catch up [s]


class Display:
    """The pictures of some environments, and for `human` a window."""

    def __init__(
        self,
        compiled: _native.CompiledScenario,
        mode: str | None,
        size: tuple[int, int],
        camera: str,
        allowed: Sequence[str] = MODES,
    ) -> None:
        """Checks the options.

        Args:
            mode: one of those that are allowed, or None: nothing is drawn.
            size: width and height [pixels].
            camera: of `skybody render`.

        Raises:
            ValueError: an unknown mode or camera, or a size out of range.
            Error: `human` without a display.
        """
        if mode is not None and mode not in allowed:
            raise word_error("render_mode", mode, ["None", *allowed])
        self.mode, self._size, self._camera = mode, _checked(size), camera
        fps = 1.0 / (compiled.dt * compiled.action_repeat)
        here = [m for m in allowed if m != "human" or mode == "human" or has_window()]
        self.metadata: dict[str, Any] = {"render_modes": here, "render_fps": fps}
        self._title = compiled.name
        self._pictures: Pictures | None = None
        self._window: Window | None = None
        self._begun = 0.0  # wall clock at the reset [s]
        self._shown = 0.0  # time of the last picture in the window [s]
        if mode is not None:
            from .look.cameras import CAMERAS

            if camera not in CAMERAS:
                raise word_error("render_camera", camera, list(CAMERAS))
        if mode == "human":
            from .look.window import tkinter

            tkinter()

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_pictures": None, "_window": None}

    def frames(self, pool: _native.Pool, envs: int = 1) -> list[NDArray[np.uint8]]:
        """Pictures of the first environments, each (height, width, 3) uint8."""
        if self._pictures is None:
            from .look.live import Pictures

            self._pictures = Pictures(pool, envs, self._size, self._camera)
        return self._pictures.draw()

    def show(self, pool: _native.Pool) -> None:
        """Shows the first environment in the window, at the speed of its own time at most.

        Raises:
            Error: the window cannot be opened.
        """
        if self._window is None:
            from .look.window import Window

            self._window = Window(self._title)
        flown = float(pool.state("time")[0])
        if 0.0 <= flown - self._shown < SHOWN and flown > 0.0:
            return
        self._window.show(self.frames(pool)[0])
        late = time.monotonic() - self._begun - flown
        if flown == 0.0 or late > MOST_LATE:
            self._begun += late
        time.sleep(max(-late, 0.0))
        self._shown = flown

    def forget(self) -> None:
        """The state was set: trails begin anew."""
        if self._pictures is not None:
            self._pictures.forget()

    def close(self) -> None:
        """Closes the window."""
        if self._window is not None:
            self._window.close()
        self._window = self._pictures = None


def has_display() -> bool:
    """Whether a window could be seen."""
    return not sys.platform.startswith("linux") or bool(os.environ.get("DISPLAY"))


def has_window() -> bool:
    """Whether `human` is possible here."""
    return has_display() and importlib.util.find_spec("tkinter") is not None


def _checked(size: tuple[int, int]) -> tuple[int, int]:
    width, height = (int(edge) for edge in size) if len(tuple(size)) == 2 else (0, 0)
    if not (1 <= width <= MOST_PIXELS and 1 <= height <= MOST_PIXELS):
        raise ValueError(
            f"render_size is {size}; it must be (width, height), each from 1 to {MOST_PIXELS}"
        )
    return width, height
