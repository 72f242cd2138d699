"""A window that shows pictures."""

from __future__ import annotations

import importlib
from typing import Any

from skybody import Error
from skybody.display import has_display

from .film import Frame

REMEDY = 'or use render_mode="rgb_array", which needs no window'


class Window:
    """A window of Tk. After the user has closed it, pictures are not shown any more."""

    def __init__(self, title: str) -> None:
        """Opens it.

        Raises:
            Error: there is no display, or Python is without Tk.
        """
        self._tk = tkinter()
        try:
            self._root: Any = self._tk.Tk()
        except self._tk.TclError as error:
            raise Error(f"no window can be opened ({error}): start a display, {REMEDY}") from None
        self._root.title(title)
        self._root.resizable(False, False)
        self._label = self._tk.Label(self._root, borderwidth=0)
        self._label.pack()
        self._root.protocol("WM_DELETE_WINDOW", self.close)

    def show(self, frame: Frame) -> None:
        """Shows a picture, and handles the window's events."""
        if self._root is None:
            return
        header = f"P6 {frame.shape[1]} {frame.shape[0]} 255\n".encode()
        image = self._tk.PhotoImage(data=header + frame.tobytes(), format="PPM")
        self._label.configure(image=image)
        self._label.image = image  # Tk itself does not keep it
        self._root.update()

    def close(self) -> None:
        """Closes it."""
        if self._root is not None:
            self._root.destroy()
            self._root = None


def tkinter() -> Any:
    """The module.

    Raises:
        Error: there is no display, or Python is without Tk.
    """
    if not has_display():
        raise Error(f"there is no display (DISPLAY is not set): start one, {REMEDY}")
    try:
        return importlib.import_module("tkinter")
    except ImportError:
        raise Error(f"this Python is without Tk: `apt install python3-tk`, {REMEDY}") from None
