"""A strip of plots below a film, with a line at the time of the frame."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from .flight import Flight
from .palette import ROBOTS
from .shapes import Color

CURSOR = np.array([214, 39, 40], np.uint8)
DPI = 100
MOST = 20_000  # points of a curve


class Strip:
    """Curves of named values of one or several flights."""

    def __init__(
        self, flights: Sequence[Flight], names: Sequence[str], width: int, height: int
    ) -> None:
        """Draws the curves.

        Args:
            names: columns of the log, see Flight.series().
            width, height: [pixels]

        Raises:
            InputError: a flight has no such column.
        """
        figure = Figure(figsize=(width / DPI, height / DPI), dpi=DPI, layout="constrained")
        axes = figure.subplots(1, len(names), squeeze=False)[0]
        self._last = max(flight.duration for flight in flights)
        for axis, name in zip(axes, names, strict=True):
            for k, flight in enumerate(flights):
                values, unit = flight.series(name)
                step = -(-len(values) // MOST)
                axis.plot(flight.time[::step], values[::step], color=tint(k), linewidth=1.4)
            axis.set_title(f"{name} [{unit}]" if unit else name, fontsize=10)
            axis.set_xlim(0.0, max(self._last, 1e-6))
            axis.tick_params(labelsize=8)
            axis.grid(alpha=0.3)
        canvas = FigureCanvasAgg(figure)
        canvas.draw()  # type: ignore[no-untyped-call]
        drawn = np.asarray(canvas.buffer_rgba())  # type: ignore[no-untyped-call]
        self._picture = drawn[:height, :width, :3].copy()
        self._spans = [_span(axis, height) for axis in axes]

    def at(self, time: float) -> NDArray[np.uint8]:
        """The strip with its lines at a time [s]."""
        picture = self._picture.copy()
        share = min(time / self._last, 1.0) if self._last > 0.0 else 0.0
        for left, right, top, bottom in self._spans:
            column = int(left + share * (right - left))
            picture[top:bottom, max(column - 1, 0) : column + 1] = CURSOR
        return picture


def tint(number: int) -> Color:
    """Colour of one of several flights, from 0; last those of goals (green) and gates."""
    order = (0, 3, 5, 4, 2, 1)
    return ROBOTS[order[number % len(order)]]


def _span(axis: object, height: int) -> tuple[float, float, int, int]:
    """Left, right, top and bottom of a plot's inside [pixels]."""
    box = axis.get_window_extent()  # type: ignore[attr-defined]
    return box.x0, box.x1, int(height - box.y1), int(height - box.y0)
