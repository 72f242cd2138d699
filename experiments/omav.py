"""Flight of the world `omav`: hover, a move without leaning, a tilted pose.

    .venv/bin/python experiments/omav.py [--quick] [--out DIR]

The hexacopter with tilting arms is commanded one pose after another. The page lists its error when
the next pose begins, its tilt while it moves level, and the directions of its arms; the picture
shows the flight. tests/python/test_arms_and_tilt.py tests the same in every commit.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import skybody
from numpy.typing import NDArray
from skybody.program import run_program
from throughput import (
    arguments,
    facts,
    machine_line,
    markdown_table,
    output_folder,
    page_data,
)

matplotlib.use("Agg")
import matplotlib.pyplot as plt

Reals = NDArray[np.float64]
ARMS = ("front_left", "left", "back_left", "back_right", "right", "front_right")
ARM_LENGTH = 0.3  # [m]
STEP = 0.001  # of the world's physics [s]
SAMPLE = 10  # physics steps


@dataclass(frozen=True)
class Leg:
    """A pose that is held for a time: a rotation about an axis of W at a position."""

    name: str
    place: tuple[float, float, float]  # [m]
    axis: tuple[float, float, float]
    angle: float  # [degrees]
    seconds: float

    @property
    def rotation(self) -> list[float]:
        half = math.radians(self.angle) / 2.0
        return [math.cos(half), *(math.sin(half) * a for a in self.axis)]


X, Y = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
LEGS = (
    Leg("hover", (0.0, 0.0, 2.0), X, 0.0, 2.0),
    Leg("level to (1, -0.5, 2.3) m", (1.0, -0.5, 2.3), X, 0.0, 5.0),
    Leg("rolled by 40 degrees", (1.0, -0.5, 2.3), X, 40.0, 5.0),
    Leg("the same, moved by 0.6 m", (1.0, 0.1, 2.3), X, 40.0, 5.0),
    Leg("pitched by 60 degrees", (1.0, 0.1, 2.3), Y, 60.0, 6.0),
)


def matrix(rotation: Reals) -> Reals:
    """Rotation matrix, W from B."""
    w, x, y, z = rotation
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def fly() -> list[dict[str, Any]]:
    """Samples of the whole flight, each with its leg."""
    sim = skybody.Simulation("omav", overrides=["randomization=[]"], seed=1)
    sim.reset()
    samples = []
    for number, leg in enumerate(LEGS):
        sim.command([*leg.place, *leg.rotation])
        for _ in range(round(leg.seconds / STEP / SAMPLE)):
            if not sim.advance(SAMPLE):
                raise RuntimeError(f"the physics gave up in leg `{leg.name}`")
            base = sim.base()
            rotation = np.array(base.rotation)
            left = abs(float(rotation @ np.array(leg.rotation)))
            samples.append(
                {
                    "leg": number,
                    "time": sim.time,
                    "position": np.array(base.position),
                    "rotation": rotation,
                    "off": float(np.linalg.norm(np.array(base.position) - leg.place)),
                    "turn": math.degrees(2.0 * math.acos(min(1.0, left))),
                    "tilt": math.degrees(math.acos(min(1.0, matrix(rotation)[2, 2]))),
                    "arms": np.degrees(
                        [sim.state(f"robots.omav.joints.{a}_tilt.position") for a in ARMS]
                    ).ravel(),
                }
            )
    return samples


def table(samples: list[dict[str, Any]]) -> str:
    """A row for each leg."""
    rows = [
        [
            "commanded pose",
            "seconds",
            "off at the end [mm]",
            "turned off at the end [deg]",
            "most turned off on the way [deg]",
            "arms at the end [deg]",
        ]
    ]
    for number, leg in enumerate(LEGS):
        own = [s for s in samples if s["leg"] == number]
        arms = own[-1]["arms"]
        rows.append(
            [
                leg.name,
                f"{leg.seconds:g}",
                f"{1e3 * own[-1]['off']:.2f}",
                f"{own[-1]['turn']:.3f}",
                f"{max(s['turn'] for s in own):.2f}",
                f"{arms.min():.0f} to {arms.max():.0f}",
            ]
        )
    return markdown_table(rows)


def draw_vehicle(axes: Any, sample: dict[str, Any]) -> None:
    """Arms and thrust directions of their rotors, from the side (x to the right)."""
    turn, place = matrix(sample["rotation"]), sample["position"]
    for k, angle in enumerate(sample["arms"]):
        azimuth = math.radians(30.0 + 60.0 * k)
        out = np.array([math.cos(azimuth), math.sin(azimuth), 0.0])
        side = np.cross(out, [0.0, 0.0, 1.0])  # t x n
        up = math.cos(math.radians(angle)) * np.array([0.0, 0.0, 1.0])
        up = turn @ (up + math.sin(math.radians(angle)) * side)
        hub = place + turn @ (ARM_LENGTH * out)
        axes.plot(*np.array([place, hub])[:, 1:].T, color="0.5", lw=2)
        disc = np.cross(up, [1.0, 0.0, 0.0])
        disc *= 0.11 / max(float(np.linalg.norm(disc)), 1e-9)
        axes.plot(*np.array([hub - disc, hub + disc])[:, 1:].T, color="tab:red", lw=1.5)
        axes.plot(*(hub + 0.25 * up)[1:], " ")  # for the axes' limits, which ignore arrows
        axes.annotate(
            "", xy=(hub + 0.25 * up)[1:], xytext=hub[1:], arrowprops={"arrowstyle": "->", "lw": 0.8}
        )


def write_picture(samples: list[dict[str, Any]], path: Path) -> None:
    figure, grid = plt.subplots(2, 2, figsize=(11, 7), constrained_layout=True)
    time = [s["time"] for s in samples]
    wished = np.array([LEGS[s["leg"]].place for s in samples])
    position = np.array([s["position"] for s in samples])
    for k, name in enumerate("xyz"):
        line = grid[0, 0].plot(time, position[:, k], label=name)[0]
        grid[0, 0].plot(time, wished[:, k], "--", lw=0.8, color=line.get_color())
    grid[0, 0].set(title="position, and where it should be (dashed)", ylabel="m")
    grid[0, 0].legend()
    grid[0, 1].plot(time, [s["tilt"] for s in samples], label="tilt of the base")
    grid[0, 1].plot(time, [LEGS[s["leg"]].angle for s in samples], "--", lw=0.8, label="asked for")
    grid[0, 1].set(title="tilt", ylabel="degrees")
    grid[0, 1].legend()
    for k, name in enumerate(ARMS):
        grid[1, 0].plot(time, [s["arms"][k] for s in samples], label=name.replace("_", " "))
    grid[1, 0].set(title="angles of the arms", xlabel="s", ylabel="degrees")
    grid[1, 0].legend(fontsize="small", ncols=2)
    for number in (1, 3):
        draw_vehicle(grid[1, 1], [s for s in samples if s["leg"] == number][-1])
    grid[1, 1].set(
        title="seen along x: level, and rolled by 40 degrees", xlabel="y [m]", ylabel="z [m]"
    )
    grid[1, 1].set_aspect("equal")
    figure.savefig(path, dpi=90)
    plt.close(figure)


def page(samples: list[dict[str, Any]], found: dict[str, Any]) -> str:
    return f"""# A hexacopter with tilting arms

{machine_line(found)}

    .venv/bin/python experiments/omav.py

World `omav` ([model](../../scenarios/models/omav/README.md)) under
[full_pose](../../controllers/full_pose/README.md) and
[tilt_allocation](../../controllers/tilt_allocation/README.md), from one commanded pose to the
next. On the level way it leans no more than its arms and rotors lag behind.

{table(samples)}

![Position, tilt, angles of the arms, and the vehicle from the side](images/omav.png)
"""


def is_good(samples: list[dict[str, Any]]) -> bool:
    """Whether poses are reached to 5 mm and 0.5 degrees, and the level move tilts <= 2 degrees."""
    ends = [[s for s in samples if s["leg"] == k][-1] for k in range(len(LEGS))]
    level = max(s["tilt"] for s in samples if LEGS[s["leg"]].angle == 0.0)
    return level < 2.0 and all(s["off"] < 5e-3 and s["turn"] < 0.5 for s in ends)


def main() -> int:
    parser = arguments(__doc__ or "")
    options = parser.parse_args()
    folder = output_folder(parser, options)
    found, samples = facts(), fly()
    text = page(samples, found)
    print(text)
    if folder is not None:
        page_data.write(folder / "omav.md", text)
        write_picture(samples, folder / "images/omav.png")
    return 0 if is_good(samples) else 1


if __name__ == "__main__":
    run_program(main)
