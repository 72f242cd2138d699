"""Pictures of a flight from a camera, for formats that carry images."""

from __future__ import annotations

import io
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from PIL import Image

from skybody.look.cameras import View, camera
from skybody.look.film import Film, Panel, Size
from skybody.look.scene import Scene

from .table import Table

RATE = 10.0  # pictures per second
SIZE = Size(640, 360)
QUALITY = 90  # of JPEG
FOCAL = 0.5 * SIZE.width / float(np.tan(0.5 * SIZE.field_of_view))  # [pixels]


@dataclass(frozen=True)
class Picture:
    """An image and the place of its camera."""

    jpeg: bytes
    view: View


def pictures(table: Table, name: str | None) -> Iterator[tuple[float, Picture]]:
    """Draws pictures between the first row and the last one, with their times [s].

    Args:
        table: the rows.
        name: of skybody.look.cameras.CAMERAS; None: no pictures.
    """
    if name is None:
        return
    scene = Scene(table.flight)
    film = Film([Panel((scene,), name, 0, 0, SIZE.width, SIZE.height)], SIZE)
    eye = camera(name, [scene], SIZE.field_of_view)
    first, last = table.ends
    for time in np.arange(first, np.nextafter(last, np.inf), 1.0 / RATE).tolist():
        file = io.BytesIO()
        Image.fromarray(film.frame(time)).save(file, "JPEG", quality=QUALITY)
        yield time, Picture(file.getvalue(), eye(time))
