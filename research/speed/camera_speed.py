"""Frames per second of cameras: the renderer on one core, and batches from Python with physics.

    python -m research run camera_speed [--prototype FILE] [--quick] [--out DIR]

bench_render draws a fixed scene of 42 shapes and the ground. Its times are processor times, which
other load affects little. --prototype names a C++ file of a program for the same measurement, to
compare in the same run: PROGRAM SIZE FRAMES draws five times FRAMES images.
"""

from __future__ import annotations

import json
import resource
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from research.common.machine import facts, machine_line
from research.common.options import Options
from research.common.pages import head, markdown_table, thousands, write_page
from research.common.places import PROGRAMS
from research.common.programs import output_of
from research.common.throughput import QUICK, Case, Length, measure, summary

PAGE = "camera_speed"

ENVS = 128
LENGTH = Length(trials=3, warm_up=20, receives=100, seconds=1.0, most=3.0)
# Size of the image [pixels], images, frames of a round.
DRAWINGS = (
    (64, "depth", 3000),
    (64, "normal", 2000),
    (64, "rgb", 1000),
    (512, "depth", 60),
    (64, "mesh", 1000),
)
SCANS = 1000  # of a round
RAYS = 16 * 360
WORDS = {
    "depth": "depth, instances",
    "normal": "and normals",
    "rgb": "and colours with shadows",
    "mesh": "depth, instances of four meshes of 2,000 triangles",
}
# Words: outputs of the camera of `hover_camera`, and the columns that it observes.
BATCHES = {
    "depth": ("depth", "front.depth"),
    "depth, instances": ("depth, instance", "front.depth, front.instance"),
    "colours with shadows": ("rgb", "front.rgb"),
}


@dataclass(frozen=True)
class Drawing:
    """A row of bench_render."""

    size: int
    images: str
    rate: float  # frames per second of processor time

    def cells(self) -> list[str]:
        rays = self.rate * self.size**2 / 1e6
        return [
            f"{self.size} x {self.size}",
            WORDS[self.images],
            f"{self.rate:,.0f}",
            f"{rays:,.0f}",
        ]


def draw(program: Path, size: int, images: str, frames: int) -> Drawing:
    words = ("--size", str(size), "--images", images, "--frames", str(frames))
    found = json.loads(output_of([program, *words]))
    return Drawing(size, images, float(found["frames_per_second"]))


def prototype_rate(source: Path, size: int, frames: int) -> float:
    """Frames per second of processor time of another program, compiled for this machine."""
    with tempfile.TemporaryDirectory() as folder:
        program = Path(folder) / "prototype"
        flags = ("-O3", "-march=native", "-ffp-contract=off", "-Wno-psabi")
        subprocess.run(["g++", *flags, str(source), "-o", str(program)], check=True)
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        output_of([program, str(size), str(frames)])
        used = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    return 5 * frames / used


def batch_case(outputs: str, observe: str) -> Case:
    """Environments of which each step has a new frame."""
    overrides = (f"sensors.front.parameters.outputs=[{outputs}]", f"observe=[{observe}]")
    return Case("hover_camera", ENVS, ENVS, "hold", overrides)


def page(found: dict[str, Any]) -> str:
    rows = [head("image | content | frames/s | million rays/s")]
    rows += [Drawing(**row).cells() for row in found["drawings"]]
    scans = found["scans"]
    batches = [head("images of 64 x 64 | frames/s, thousands")]
    batches += [[words, thousands(rate)] for words, rate in found["batches"].items()]
    beside = ""
    if found["prototype"] is not None:
        share = found["drawings"][0]["rate"] / found["prototype"]
        beside = (
            f"\nThe prototype of the renderer draws {found['prototype']:,.0f} frames/s of its 64 x"
            f" 64 images in the same run: the renderer is {share:.1f} times as fast.\n"
        )
    return f"""# Speed of cameras

    .venv/bin/python -m research run camera_speed

{machine_line(found["facts"])}

## The renderer, on one core

`bench_render`: 42 shapes (ten trees, balls and boxes, three gates of four bars, four robots of five
boxes) and the ground, a field of view of 90 degrees. The eye moves from frame to frame. Processor
time, least of five rounds.

{markdown_table(rows)}
{beside}
A lidar of 16 rings of 360 rays, in a forest of 30 trees on the ground: {scans:,.0f} scans/s,
{scans * RAYS / 1e6:,.0f} million rays/s (`bench_render --images lidar`).

## From Python, with physics

`hover_camera`: {ENVS} environments in one batch of `make_pool`, a thread for each processor. A step
is 20 physics steps of 1 ms and a new frame of each camera, which sees 13 shapes of obstacles and
the ground.

{markdown_table(batches)}
"""


def main() -> int:
    options = (
        Options(__doc__, __name__, program=PROGRAMS / "bench_render")
        .add("--prototype", type=Path, metavar="FILE", help="another program's C++ file")
        .given()
    )
    fewer = 20 if options.quick else 1
    length = QUICK if options.quick else LENGTH
    found: dict[str, Any] = {"facts": facts(), "prototype": None}
    found["drawings"] = [
        vars(draw(options.program, size, images, max(1, frames // fewer)))
        for size, images, frames in DRAWINGS
    ]
    found["scans"] = draw(options.program, 0, "lidar", SCANS // fewer).rate
    if options.prototype is not None:
        found["prototype"] = prototype_rate(options.prototype, 64, 3000 // fewer)
    found["batches"] = {
        words: summary(measure(batch_case(*of_camera), length)).rate
        for words, of_camera in BATCHES.items()
    }
    write_page(options.out, PAGE, page(found), found)
    return 0
