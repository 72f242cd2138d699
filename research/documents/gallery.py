"""Writes the gallery: a film and a still of every shipped scenario.

    python -m research run gallery [--scenarios NAME...] [--quick] [--out FOLDER]

Flies each scenario with its shipped policy, or with the policy `hold` if it has none, and draws the
episodes that end in success, if there are any. Also writes the film of README.md, and the page.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from textwrap import fill

import numpy as np
from skybody import InputError
from skybody._native import scenario_file, shipped_policies
from skybody.look.film import Film, Frame, Panel, Size, write
from skybody.look.flight import Flight
from skybody.look.scene import Scene, Style

from research.common.pages import markdown_table
from research.common.places import FLIGHTS, ROOT
from research.common.programs import run_skybody
from research.documents.scenario_index import files, summary

PAGE = "docs/gallery/README.md"

FOLDER = ROOT / "docs/gallery"
SIZE = Size(480, 270, rate=12.0, quality=55)
LEAST, MOST = 6.0, 8.0  # duration of a film [s]
PAUSE = 0.5  # after an episode [s]
EPISODES = 8  # flown where one is too short, or fails
OVERVIEW = ("racing", "payload_learn", "formation_learn")  # of README.md, side by side
OVERVIEW_SIZE = Size(960, 270, rate=12.0, quality=55)


@dataclass(frozen=True)
class Shot:
    """How a scenario is filmed."""

    camera: str = "orbit"
    speed: float = 1.0  # of the film, relative to the flight
    trail: float = 2.0  # [s]
    goal: bool = True
    still: float = 0.4  # share of the film

    @property
    def style(self) -> Style:
        """The parts that are drawn."""
        return Style(trail=self.trail, goal=self.goal, reference=self.goal)


# By scenario, else by task.
SHOTS = {
    "chase": Shot("fixed", speed=0.5),
    "forest": Shot("chase"),
    "formation": Shot("fixed"),
    "formation_10": Shot("fixed", speed=1.5),
    "formation_20": Shot("fixed", speed=2.0),
    "formation_obstacles": Shot("orbit", still=0.15),
    "gates": Shot("fixed"),
    "hover_camera": Shot("chase"),
    "landing": Shot("orbit", speed=0.5),
    "obstacles": Shot("chase", goal=False),
    "racing": Shot("orbit", goal=False),
    "racing_drawn": Shot("fixed", goal=False),
    "racing_figure": Shot("fixed", goal=False),
    "racing_split_s": Shot("fixed", goal=False),
    "racing_vision": Shot("fixed", goal=False),
    "trajectory": Shot("fixed", speed=1.5, trail=5.0, still=0.85),
    "trajectory_flights": Shot("fixed", speed=1.5, trail=5.0, still=0.85),
    "trajectory_training": Shot("fixed", speed=1.5, trail=5.0, still=0.85),
}


def scenarios() -> list[str]:
    """All shipped scenarios, by task."""
    return [file.stem for file in files()]


def shot_of(name: str) -> Shot:
    """A scenario's shot."""
    task = Path(scenario_file(name)).parent.name
    return SHOTS.get(name) or SHOTS.get(task) or Shot()


def policy_of(name: str) -> str:
    """`shipped` or `hold`."""
    return "shipped" if name in shipped_policies() else "hold"


# --- films ----------------------------------------------------------------------------------------


def fly(name: str, folder: Path) -> list[Flight]:
    """Episodes of a scenario: enough for a film, successes first."""
    shot, episodes = shot_of(name), 1
    while True:
        words = ("--policy", policy_of(name), "--episodes", str(episodes), "--no-picture")
        run_skybody("run", name, *words, "--out", folder / name)
        log = folder / name
        flights = [Flight(log, episode) for episode in Flight(log).episodes]
        good = [flight for flight in flights if has_success(flight)] or flights
        seconds = sum(flight.duration / shot.speed + PAUSE for flight in good)
        if episodes > 1 or (seconds >= LEAST and has_success(flights[0])):
            return good
        episodes = EPISODES


def has_success(flight: Flight) -> bool:
    """Whether an episode ends in success; also if its task does not know."""
    known = [name for name, _ in flight.columns("info")]
    return "success" not in known or bool(flight.series("success")[0][-1] > 0.0)


def frames(flights: Sequence[Flight], shot: Shot, size: Size) -> Iterator[Frame]:
    """Pictures of episodes one after another, without end."""
    while True:
        for flight in flights:
            scene = Scene(flight, shot.style)
            film = Film([Panel((scene,), shot.camera, 0, 0, size.width, size.height)], size)
            yield from film.frames(times_of(flight, shot, size))


def times_of(flight: Flight, shot: Shot, size: Size) -> list[float]:
    """Times of an episode's pictures [s], the last one held for the pause."""
    step = shot.speed / size.rate
    moving = np.arange(0.0, min(flight.duration, MOST * shot.speed) + 0.5 * step, step)
    return [*moving.tolist(), *[flight.duration] * round(PAUSE * size.rate)]


def count_of(flights: Sequence[Flight], shot: Shot, size: Size) -> int:
    """Number of a film's pictures: of whole episodes, if they fit."""
    count, most = 0, round(MOST * size.rate)
    for flight in flights:
        more = len(times_of(flight, shot, size))
        if count + more > most:
            return max(count, most) if count < LEAST * size.rate else count
        count += more
    return count


def film(name: str, flights: Sequence[Flight], out: Path, quick: bool) -> None:
    """Writes the film and the still of a scenario."""
    shot = shot_of(name)
    count = 4 if quick else count_of(flights, shot, SIZE)
    drawn = list(islice(frames(flights, shot, SIZE), count))
    write(out / f"{name}.webp", SIZE, iter(drawn))
    write(out / f"stills/{name}.webp", SIZE, iter([drawn[int(shot.still * count)]]))
    kilobytes = (out / f"{name}.webp").stat().st_size // 1000
    print(f"{name}: {count / SIZE.rate:.1f} s, {kilobytes} KB", flush=True)


def overview(flights: Sequence[Flight], out: Path, quick: bool) -> None:
    """Writes the film of README.md: some flights side by side."""
    size, width = OVERVIEW_SIZE, OVERVIEW_SIZE.width // len(flights)
    panels = []
    for k, flight in enumerate(flights):
        shot = shot_of(flight.scenario)
        scene = Scene(flight, shot.style)
        panels.append(Panel((scene,), shot.camera, k * width, 0, width, size.height))
    last = 4 / size.rate if quick else MOST
    times = np.arange(0.0, last - 0.5 / size.rate, 1.0 / size.rate).tolist()
    write(out / "overview.webp", size, Film(panels, size).frames(times))


# --- page -----------------------------------------------------------------------------------------


ABOUT = (
    "A film of every scenario that comes with Skybody: click on a picture. A scenario flies with "
    "its trained policy if it has one, else with the baseline `hold`, a controller. Episodes that "
    "end in success are shown, if there are any."
)
MADE_BY = (
    "`python -m research run gallery` makes them with the renderer of `skybody render` "
    "([films.md](../films.md)); `--scenarios NAME...`: some of them. Speed 0.5 is half as fast as "
    "the flight."
)


def page(names: Sequence[str]) -> str:
    """The page: a table for each task."""
    by_task: dict[str, list[str]] = {}
    for name in names:
        by_task.setdefault(Path(scenario_file(name)).parent.name, []).append(name)
    parts = ["# Gallery", fill(ABOUT, 100), fill(MADE_BY, 100)]
    for task, members in by_task.items():
        rows: list[Sequence[str]] = [("film", "scenario", "content", "policy", "speed")]
        rows += [row_of(name, task) for name in members]
        parts += [f"## {task}", markdown_table(rows, text=range(5))]
    return "\n\n".join(parts) + "\n"


def row_of(name: str, task: str) -> Sequence[str]:
    """A scenario's row."""
    file = Path(scenario_file(name))
    policy = policy_of(name)
    return (
        f'[<img src="stills/{name}.webp" width="240">]({name}.webp)',
        f"[`{name}`](../../scenarios/{task}/{file.name})",
        summary(file),
        "trained" if policy == "shipped" else f"`{policy}`",
        f"{shot_of(name).speed:g}",
    )


def main() -> int:
    """Writes the films, the stills and the page."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--quick", action="store_true", help="a trial: three films of 4 frames")
    parser.add_argument("--scenarios", nargs="+", metavar="NAME", help="default: all")
    parser.add_argument(
        "--out", type=Path, help="default: docs/gallery, of a trial flights/gallery"
    )
    options = parser.parse_args()
    out = options.out or (FLIGHTS / "gallery" if options.quick else FOLDER)
    every = scenarios()
    names = options.scenarios or (list(OVERVIEW) if options.quick else every)
    if unknown := sorted({*names} - {*every}):
        raise InputError(f"--scenarios {unknown[0]}: no such scenario; allowed: {', '.join(every)}")
    with tempfile.TemporaryDirectory() as folder:
        flown = {}
        for name in names:
            flown[name] = fly(name, Path(folder))
            film(name, flown[name], out, options.quick)
        if {*OVERVIEW} <= {*names}:
            overview([flown[name][0] for name in OVERVIEW], out, options.quick)
    made = [name for name in every if (out / f"{name}.webp").is_file()]
    target = out / Path(PAGE).name
    target.write_text(page(made), encoding="utf-8")
    return 0
