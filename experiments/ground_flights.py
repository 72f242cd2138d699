#!/usr/bin/env python3
"""Takes off, lands, and lets two robots collide; writes the pictures.

    .venv/bin/python experiments/ground_flights.py [--program PROGRAM] [--docs docs/results]

Each flight is one `skybody run` under the hold baseline, seed 1. The pictures show the first
episode, with times of contact shaded. Exit code 1 if a flight does not end as expected: at its
goal, at rest on the ground, or on its back after the collision.
"""

from __future__ import annotations

import argparse
import shlex
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
from policy_flight import PICTURE
from skybody.program import run_program
from throughput import page_data

ROOT = Path(__file__).resolve().parent.parent
FOUR_SECONDS = ("randomization=[]", "stepping.horizon=4000")
LEG = 0.06  # height of a resting vehicle's origin above the ground [m]
BACK = 0.03  # of a vehicle that lies on its back [m]


@dataclass(frozen=True)
class Flight:
    """One flight: its arguments, and its expected final state."""

    name: str
    says: str
    scenario: str
    overrides: tuple[str, ...]
    end_heights: tuple[float, ...]  # of every robot's origin, any of these [m]

    def command(self) -> list[str]:
        """Arguments of `skybody run`."""
        settings = [part for override in self.overrides for part in ("--set", override)]
        return ["run", self.scenario, "--policy", "hold", "--seed", "1", *settings]


FLIGHTS = (
    Flight(
        "take_off",
        "Take-off from the ground to 1.5 m",
        "hover",
        (
            *FOUR_SECONDS,
            "robots.quad.pose.position=[0,0,0.06]",
            "task.parameters.target=[0,0,1.5,0]",
        ),
        (1.5,),
    ),
    Flight(
        "landing",
        "Landing from 1.5 m: the goal lies on the ground",
        "hover",
        (*FOUR_SECONDS, "robots.quad.pose.position=[0,0,1.5]", "task.parameters.target=[0,0,0,0]"),
        (LEG,),
    ),
    Flight(
        "collision",
        "Two robots that fly to each other's place collide, tumble and fall; in the shaded time "
        "something touches",
        "collision",
        (),
        (LEG, BACK),
    ),
)
NEAR = 0.02  # of the end height [m]: a goal on the ground is not reached exactly
AT_REST = 0.05  # [m/s]: the take-off still approaches its goal at a fifth of this at the end


def fly(program: Path, flight: Flight, picture: Path) -> tuple[str, bool]:
    """Flies; returns a description, and whether the flight ended as expected."""
    with tempfile.TemporaryDirectory() as folder:
        command = [str(program), *flight.command(), "--out", folder]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            sys.exit(f"{shlex.join(command)}\n{done.stderr}")
        shutil.copyfile(Path(folder) / PICTURE, picture)
        with h5py.File(Path(folder) / "flight.h5") as log:
            episode = log["episodes/0001"]
            touching = episode["touching"][:]
            names = [str(name) for name in log.attrs["bodies"]]
            bodies = episode["bodies"][:].reshape(len(touching), len(names), 13)
            time = episode["time"][-1]
    heights, speeds = bodies[-1, :, 2], np.linalg.norm(bodies[-1, :, 7:10], axis=1)
    share = float(touching.mean())
    off = np.min([abs(heights - height) for height in flight.end_heights], axis=0)
    good = bool(np.all(off < NEAR)) and speeds.max() < AT_REST
    ends = ", ".join(f"{height:.3f}" for height in heights)
    return (
        f"After {time:g} s: height of the origin {ends} m, speed at most {speeds.max():.2g} m/s; "
        f"{100 * share:.2g} % of the rows have something that touches."
    ), good


def main() -> int:
    """Flies all three; writes docs/results/ground_flights.md if all ended as expected."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--program", type=Path, default=ROOT / "build/release/bin/skybody")
    parser.add_argument("--docs", type=Path, default=ROOT / "docs/results", help="output folder")
    parser.add_argument("--quick", action="store_true", help="a trial: only the first flight")
    options = parser.parse_args()
    (options.docs / "images").mkdir(parents=True, exist_ok=True)
    parts = [
        "# On the ground, off it, and into each other\n\n"
        "Written by `experiments/ground_flights.py`.\n"
    ]
    all_good = True
    for flight in FLIGHTS[:1] if options.quick else FLIGHTS:
        words, good = fly(options.program, flight, options.docs / f"images/{flight.name}.png")
        print(f"{flight.name}: {words}{'' if good else ' NOT AS IT SHOULD BE'}")
        all_good &= good
        parts.append(
            f"## {flight.says}\n\n    skybody {shlex.join(flight.command())}\n\n{words}\n\n"
            f"![{flight.name}](images/{flight.name}.png)\n"
        )
    if not all_good:
        return 1
    page_data.write(options.docs / "ground_flights.md", "\n".join(parts))
    return 0


if __name__ == "__main__":
    run_program(main)
