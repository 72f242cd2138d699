"""A flight in a notebook: a small film inside of the page."""

from __future__ import annotations

import html
import tempfile
from base64 import b64encode
from pathlib import Path

import numpy as np

from skybody import InputError

from .film import Film, Panel, Size, ffmpeg, write
from .flight import Flight
from .motion import Array
from .scene import Scene

SIZE = Size(width=480, height=270, rate=25.0)
LONGEST = 10.0  # of the film [s]
FASTEST = 4.0  # times as fast as the flight
FRAME = "margin: 0; max-width: {width}px; font-family: sans-serif; font-size: 90%"


def html_of(flight: Flight) -> str:
    """A figure: a film of at most 10 s, and the flight's name; instead of it the error."""
    speed = float(np.clip(flight.duration / LONGEST, 1.0, FASTEST))
    shown = min(flight.duration, speed * LONGEST)
    name = f"{flight.scenario}, episode {flight.episode}, {flight.duration:.4g} s"
    if speed > 1.0:
        name += f"; {speed:.2g} times as fast"
    if shown < flight.duration:
        name += f"; the first {shown:.3g} s"
    try:
        film = film_of(flight, np.arange(0.0, shown + 0.5 * speed / SIZE.rate, speed / SIZE.rate))
    except InputError as error:
        film = f"<pre>{html.escape(str(error))}</pre>"
    style = FRAME.format(width=SIZE.width)
    caption = f"<figcaption>{html.escape(name)}</figcaption>"
    return f'<figure style="{style}">{film}{caption}</figure>'


def film_of(flight: Flight, times: Array) -> str:
    """An element with the film inside: an MP4, or where there is no ffmpeg a WebP.

    Raises:
        InputError: the flight cannot be drawn.
    """
    film = Film([Panel((Scene(flight),), "orbit", 0, 0, SIZE.width, SIZE.height)], SIZE)
    place = f'width="{SIZE.width}" height="{SIZE.height}"'
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / ("film.mp4" if has_ffmpeg() else "film.webp")
        write(path, SIZE, film.frames(times.tolist()))
        data = b64encode(path.read_bytes()).decode()
    if path.suffix == ".webp":
        return f'<img {place} alt="" src="data:image/webp;base64,{data}">'
    return (
        f'<video {place} controls autoplay loop muted src="data:video/mp4;base64,{data}"></video>'
    )


def has_ffmpeg() -> bool:
    """Whether an MP4 can be made."""
    try:
        ffmpeg()
    except InputError:
        return False
    return True
