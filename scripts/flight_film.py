"""Makes an animated picture of flights, side by side, from flight logs; or a still of one instant.

    .venv/bin/python scripts/flight_film.py OUT.gif LOG[:EPISODE]... [--seconds 6] [--quick]
    .venv/bin/python scripts/flight_film.py OUT.png LOG[:EPISODE]... --seconds 3

`skybody run SCENARIO --policy shipped --out FOLDER` writes such a log (FOLDER/flight.h5). Vehicles
are drawn larger where they would be small, and leave a trail. README.md has this film:

    for name in racing payload_learn formation_learn; do
      skybody run $name --policy shipped --episodes 1 --out flights/film/$name
    done
    .venv/bin/python scripts/flight_film.py docs/results/images/flights.gif \
      flights/film/racing/flight.h5 flights/film/payload_learn/flight.h5 \
      flights/film/formation_learn/flight.h5

The stills of its table of tasks (docs/results/images/tasks) come from the same kind of logs:
SCENARIO is `hover`, `trajectory`, ... or TASK_learn.

    .venv/bin/python scripts/flight_film.py docs/results/images/tasks/TASK.png \
      flights/film/SCENARIO/flight.h5 --seconds 2
"""

from __future__ import annotations

import argparse
import io
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import h5py
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection
from PIL import Image
from plot_flight_data import Flight, drawn_of, read_flight, rotation_of
from plot_flight_scene import draw_obstacles, limits_of, parents

FRAMES_PER_SECOND = 15
TRAIL = 1.2  # [s]
CIRCLE = np.linspace(0.0, 2.0 * np.pi, 17)
VEHICLE_SHARE = 0.08  # least radius of a drawn vehicle, relative to its panel's box
MOST_SCALE = 4.0  # by which vehicles are drawn larger
LEAST_ROTOR = 0.05  # least radius of a drawn rotor [m]


@dataclass
class Robot:
    """One robot of a flight."""

    color: object
    bodies: np.ndarray  # instants x bodies x 13
    hubs: np.ndarray  # of the rotors, in the base's frame [m]
    parents: list[int]  # of the bodies but the base
    centers: np.ndarray  # of mass of the bodies, in their own frames [m]


@dataclass
class Shot:
    """One flight and the box that its panel shows."""

    title: str
    flight: Flight
    robots: list[Robot]
    low: np.ndarray
    high: np.ndarray


def hubs_of(drawn: dict[str, float], robot: str) -> np.ndarray:
    """Positions of a robot's rotors; none: an empty array."""
    found = []
    while f"robots.{robot}.rotors[{len(found)}].position[0]" in drawn:
        path = f"robots.{robot}.rotors[{len(found)}].position"
        found.append([drawn[f"{path}[{k}]"] for k in range(3)])
    return np.array(found).reshape(-1, 3)


def centers_of(drawn: dict[str, float], bodies: list[str], robot: str) -> np.ndarray:
    """Centres of mass of a robot's bodies in their own frames [m]."""
    links = [name.split(".", 1)[1] for name in bodies if name.split(".")[0] == robot]
    paths = [f"robots.{robot}.links.{link}.com" for link in links]
    return np.array([[drawn.get(f"{path}[{k}]", 0.0) for k in range(3)] for path in paths])


def read_shot(argument: str) -> Shot:
    """Reads `LOG` or `LOG:EPISODE`. Raises SystemExit where there is no such episode."""
    file, _, number = argument.partition(":")
    with h5py.File(file) as log:
        name = f"{int(number or 1):04d}"
        if name not in log["episodes"]:
            raise SystemExit(f"{file}: has no episode {name}; it has {list(log['episodes'])}")
        flight = read_flight(log, name)
        drawn = drawn_of(log, log["episodes"][name])
        title = str(log.attrs["scenario"])
    names = [body.split(".")[0] for body in flight.body_names]
    robots = []
    for robot, track in zip(dict.fromkeys(names), flight.tracks, strict=False):
        bodies = flight.bodies[:, [k for k, body in enumerate(names) if body == robot]]
        hubs, centers = hubs_of(drawn, robot), centers_of(drawn, flight.body_names, robot)
        robots.append(Robot(track.color, bodies, hubs, parents(bodies), centers))
    return Shot(title, flight, robots, *limits_of(flight))


def scale_of(shot: Shot) -> float:
    """Factor by which vehicles are drawn larger."""
    radii = [np.linalg.norm(robot.hubs, axis=1).max() for robot in shot.robots if len(robot.hubs)]
    wanted = VEHICLE_SHARE * float((shot.high - shot.low).max())
    return float(np.clip(wanted / max(radii, default=wanted), 1.0, MOST_SCALE))


def draw_floor(panel, shot: Shot) -> None:
    """The lower face of the panel's box."""
    (x, y, z), (far_x, far_y, _) = shot.low, shot.high
    corners = [[x, y, z], [far_x, y, z], [far_x, far_y, z], [x, far_y, z]]
    panel.add_collection3d(
        Poly3DCollection(
            [np.array(corners)],
            zorder=-1,
            facecolor=(0.93, 0.94, 0.96),
            edgecolor="silver",
            linewidth=0.6,
        )
    )


def discs(robot: Robot, row: int, scale: float) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """A robot's arms and rotor discs in W at an instant."""
    origin, rotation = robot.bodies[row, 0, :3], rotation_of(robot.bodies[row, 0, 3:7])
    hubs = scale * robot.hubs
    if not len(hubs):
        return [], []
    gaps = np.linalg.norm(hubs[:, None] - hubs[None], axis=-1) + 9e9 * np.eye(len(hubs))
    radius = max(0.45 * float(gaps.min()) if len(hubs) > 1 else 0.0, scale * LEAST_ROTOR)
    circle = radius * np.stack([np.cos(CIRCLE), np.sin(CIRCLE), 0 * CIRCLE], axis=1)
    arms = [np.stack([origin, origin + rotation @ hub]) for hub in hubs]
    return arms, [origin + (hub + circle) @ rotation.T for hub in hubs]


def draw_frame(panel, shot: Shot, time: float) -> None:
    """One instant of one flight."""
    panel.clear()
    panel.set_axis_off()
    panel.computed_zorder = False  # else the floor may lie over everything
    flight = shot.flight
    row = int(np.searchsorted(flight.time, min(time, flight.time[-1])))
    first = int(np.searchsorted(flight.time, flight.time[row] - TRAIL))
    draw_floor(panel, shot)
    draw_obstacles(panel, flight.obstacles, shot.low, shot.high)
    for robot in shot.robots:
        trail = robot.bodies[first : row + 1, 0, :3]
        panel.plot(*trail.T, color=robot.color, linewidth=1.2, alpha=0.7)
        for k, parent in enumerate(robot.parents, start=1):
            origin, rotation = robot.bodies[row, k, :3], rotation_of(robot.bodies[row, k, 3:7])
            center = origin + rotation @ robot.centers[k]
            link = np.stack([robot.bodies[row, parent, :3], origin, center])
            panel.plot(*link.T, color="dimgrey", linewidth=1.2)
            panel.scatter(*center, color="black", s=16, depthshade=False)
        arms, circles = discs(robot, row, scale_of(shot))
        if not arms:  # a load or a deck
            panel.scatter(*robot.bodies[row, 0, :3], color=robot.color, s=30, depthshade=False)
            continue
        panel.add_collection3d(Line3DCollection(arms, colors="black", linewidths=1.4))
        panel.add_collection3d(
            Poly3DCollection(
                circles, facecolor=robot.color, alpha=0.55, edgecolor="black", linewidth=0.4
            )
        )
    for track in flight.tracks:
        if track.goal is not None and not track.follows():
            panel.scatter(*track.goal[row, :3], color="black", marker="+", s=40, linewidths=1.0)
    for axis, limits in enumerate((panel.set_xlim, panel.set_ylim, panel.set_zlim)):
        limits(shot.low[axis], shot.high[axis])
    panel.set_box_aspect(shot.high - shot.low, zoom=0.95)
    panel.view_init(elev=28, azim=-58 + 4 * time)
    panel.set_title(f"{shot.title}   {min(time, flight.time[-1]):4.1f} s", fontsize=10, y=0.93)


def pictures(shots: list[Shot], times: Iterable[float]) -> Iterator[Image.Image]:
    """The flights side by side at each of the times [s]."""
    figure = plt.figure(figsize=(3.6 * len(shots), 2.9), dpi=80)
    panels = [figure.add_subplot(1, len(shots), k + 1, projection="3d") for k in range(len(shots))]
    figure.subplots_adjust(left=0, right=1, bottom=0, top=1, wspace=0)
    for time in times:
        for panel, shot in zip(panels, shots, strict=True):
            draw_frame(panel, shot, float(time))
        memory = io.BytesIO()
        figure.savefig(memory, format="png")
        yield Image.open(memory).convert("RGB")
    plt.close(figure)


def film(shots: list[Shot], seconds: float, rate: int) -> list[Image.Image]:
    """All frames, with the palette of the first, so that colours stay."""
    frames: list[Image.Image] = []
    palette: Image.Image | None = None
    for picture in pictures(shots, np.arange(0.0, seconds, 1.0 / rate)):
        palette = palette or picture.quantize(colors=128, method=Image.Quantize.MEDIANCUT)
        frames.append(picture.quantize(palette=palette, dither=Image.Dither.NONE))
    return frames


def main(arguments: list[str] | None = None) -> int:
    """Writes the film."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("out", type=Path, help="film, *.gif, or still, *.png")
    parser.add_argument("logs", nargs="+", metavar="LOG[:EPISODE]")
    parser.add_argument(
        "--seconds", type=float, default=6.0, help="duration, or time of the still [s]"
    )
    parser.add_argument("--quick", action="store_true", help="a trial: four frames")
    options = parser.parse_args(arguments)
    rate = FRAMES_PER_SECOND
    seconds = 4 / rate if options.quick else options.seconds
    shots = [read_shot(log) for log in options.logs]
    options.out.parent.mkdir(parents=True, exist_ok=True)
    if options.out.suffix == ".png":
        frames = [*pictures(shots, [options.seconds])]
    else:
        frames = film(shots, seconds, rate)
    frames[0].save(
        options.out,
        save_all=len(frames) > 1,
        append_images=frames[1:],
        duration=1000 // rate,
        loop=0,
    )
    print(f"{options.out}: {len(frames)} frames, {options.out.stat().st_size / 1e6:.1f} MB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
