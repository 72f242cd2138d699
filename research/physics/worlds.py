"""Pictures of each world of tasks, contact, couplings and air, and success rates of its baseline.

    python -m research run worlds [WORLD ...] [--quick] [--out DIR]

`hold` flies each world in 100 drawn episodes with `skybody run`, which draws the picture of the
first one. An episode succeeds if nothing failed and it ends as stated in the head of the world's
file. If worlds are named, only those are flown, and the page keeps its results of the others.
tests/python/test_worlds.py tests the same in every commit.
"""

from __future__ import annotations

import re
import tempfile
from collections.abc import Callable
from pathlib import Path

import h5py
import matplotlib.image
import numpy as np
from skybody._native import scenario_file

from research.common.machine import facts, machine_line
from research.common.options import Options
from research.common.pages import head, markdown_table, write_page
from research.common.programs import RunError, run_skybody

PAGE = "worlds"

EPISODES = 100
COARSER = 2  # factor between the pixels of a flight's picture and those of the page


def near_the_goals(most: float) -> Callable[[h5py.Group], bool]:
    """Every vehicle is within `most` [m] of its goal at the end."""

    def is_success(episode: h5py.Group) -> bool:
        goals = episode["goal"][-1, :, :3]
        return bool(
            (np.linalg.norm(episode["bodies"][-1, : len(goals), :3] - goals, axis=1) < most).all()
        )

    return is_success


def on_the_deck(episode: h5py.Group) -> bool:
    """0.06 m above the deck's face, and within 0.2 m of its position sideways."""
    quad, deck = episode["bodies"][-1, 0, :3], episode["bodies"][-1, 1, :3]
    aside = float(np.linalg.norm(quad[:2] - episode["goal"][-1, 0, :2]))
    return aside < 0.2 and abs(quad[2] - deck[2] - 0.03 - 0.06) < 0.005


def tool_in_place(episode: h5py.Group) -> bool:
    """Gripper within 0.01 m of its point; vehicle from 3 s on within 0.05 m of its position."""
    later = episode["time"][:] >= 3.0
    vehicle = episode["bodies"][:][later, 0, :3] - np.array([0.0, 0.0, 2.0])
    # The goal is the forearm's frame with its current rotation: its error equals the gripper's.
    tool = episode["bodies"][-1, 2, :3] - episode["goal"][-1, 0, :3]
    return bool(np.linalg.norm(vehicle, axis=1).max() < 0.05 and np.linalg.norm(tool) < 0.01)


def says_so(episode: h5py.Group) -> bool:
    """The task's own info `success` at the end."""
    columns = list(episode["info"].attrs["columns"])
    return bool(episode["info"][-1, columns.index("success")])


def on_the_path(most: float) -> Callable[[h5py.Group], bool]:
    """From 3 s on the vehicle's mean distance from its moving goal is below `most` [m]."""

    def is_success(episode: h5py.Group) -> bool:
        error = episode["bodies"][:, 0, :3] - episode["goal"][:, 0, :3]
        return bool(np.linalg.norm(error[episode["time"][:] > 3.0], axis=1).mean() < most)

    return is_success


def at_rest(*heights: float) -> Callable[[h5py.Group], bool]:
    """Every robot rests at one of these heights at the end [m]."""

    def is_success(episode: h5py.Group) -> bool:
        robots = episode["bodies"][-1]
        off = np.min([abs(robots[:, 2] - height) for height in heights], axis=0)
        return bool((off < 0.02).all() and np.linalg.norm(robots[:, 7:10], axis=1).max() < 0.05)

    return is_success


LEG, BACK = 0.06, 0.03  # height of a vehicle on its legs, and on its back [m]
FOUR_SECONDS = ["randomization=[]", "stepping.horizon=4000"]
TAKE_OFF = [*FOUR_SECONDS, "robots.quad.pose.position=[0,0,0.06]"]
TAKE_OFF += ["task.parameters.target=[0,0,1.5,0]"]
TOUCH_DOWN = [*FOUR_SECONDS, "robots.quad.pose.position=[0,0,1.5]"]
TOUCH_DOWN += ["task.parameters.target=[0,0,0,0]"]
ROTOR_SPEEDS = ["robots.quad.controllers=[{plugin: rotor_speed, parameters: {max_speed: 2300}}]"]
SINGLE_THRUSTS = ["robots.quad.controllers=[{plugin: srt}]"]
SHORTER = ["stepping.horizon=1000"]  # 10 s of 30: every figure once or twice
LONGER = ["stepping.horizon=500"]  # 10 s for 7: `hold` flies at most at 1.5 m/s, from 11 m away
WORLDS = {
    "cooperative_payload": ([], says_so),
    "cooperative_payload_learn": ([], says_so),
    "cooperative_payload_ropes": ([], says_so),
    "formation_learn": ([], says_so),
    "formation_learn_2": ([], says_so),
    "formation_obstacles": ([], says_so),
    "forest": ([], near_the_goals(0.1)),
    "gates": ([], near_the_goals(0.1)),
    "platform_landing": ([], on_the_deck),
    "windy_hover": ([], near_the_goals(0.5)),
    "downwash_pair": ([], near_the_goals(0.35)),
    "low_battery": ([], near_the_goals(0.2)),
    "rotor_out": ([], near_the_goals(0.5)),
    "arm": ([], tool_in_place),
    "omav": ([], near_the_goals(0.05)),
    "tricopter": ([], near_the_goals(0.05)),
    "vehicles": ([], near_the_goals(0.3)),
    "landing": ([], says_so),
    "landing_vision": ([], says_so),
    "racing": ([], says_so),
    "racing by rotor speeds": (ROTOR_SPEEDS, says_so),
    "racing by single thrusts": (SINGLE_THRUSTS, says_so),
    "racing_drawn": ([], says_so),
    "racing_duel": ([], says_so),
    "racing_figure": ([], says_so),
    "racing_split_s": ([], says_so),
    "racing_vision": ([], says_so),
    "obstacles": ([], says_so),
    "obstacles_rays": ([], says_so),
    "obstacles_vision": ([], says_so),
    "chase": ([], says_so),
    "chase_agents": ([], says_so),
    "trajectory": (SHORTER, on_the_path(0.1)),
    "trajectory_modular": (SHORTER, on_the_path(0.1)),
    "trajectory_ctbr": (SHORTER, on_the_path(0.1)),
    "trajectory_compact": (SHORTER, on_the_path(0.05)),
    "vehicles_trajectory": (SHORTER, on_the_path(0.6)),
    "trajectory_paper": (SHORTER, on_the_path(0.1)),
    "trajectory_modular_paper": (SHORTER, on_the_path(0.1)),
    "payload": ([], says_so),
    "payload_paper": ([], says_so),
    "payload_1khz": ([], says_so),
    "payload_modular": ([], says_so),
    "payload_modular_1khz": ([], says_so),
    "payload_modular_paper": ([], says_so),
    "pendulum": ([], says_so),
    "pendulum_randomized": ([], says_so),
    "pendulum_paper": ([], says_so),
}
# Only for the page: like worlds above, with another reward or more of the same robots.
VARIANTS: dict[str, tuple[list[str], Callable[[h5py.Group], bool]]] = {
    "payload_learn": ([], says_so),
    "payload_modular_learn": ([], says_so),
    "pendulum_learn": ([], says_so),
    "pendulum_learn_randomized": ([], says_so),
    "hover": ([], says_so),
    "hover from the ground": (TAKE_OFF, at_rest(1.5)),
    "hover onto the ground": (TOUCH_DOWN, at_rest(LEG)),
    "collision": ([], at_rest(LEG, BACK)),
    "hover_camera": ([], says_so),
    "hover_crazyflie": ([], says_so),
    "hover_firefly": ([], says_so),
    "hover_hummingbird": ([], says_so),
    "hover_learn": (LONGER, says_so),
    "hover_sensors": ([], says_so),
    "boom": ([], says_so),
    "trajectory_training": (SHORTER, on_the_path(0.1)),
    "trajectory_flights": (SHORTER, on_the_path(0.1)),
    "formation": ([], says_so),
    "formation_2": ([], says_so),
    "formation_10": ([], says_so),
    "formation_20": ([], says_so),
}
ALL_WORLDS = WORLDS | VARIANTS
DEMONSTRATIONS = {"four_bar", "hard_landing"}  # the baseline has no goal


def fly(world: str, episodes: int, folder: Path, picture: bool = False) -> list[bool]:
    """Flies a world by its baseline. @returns for each episode whether it succeeded"""
    overrides, is_success = ALL_WORLDS[world]
    words = ["run", world.split()[0], "--episodes", str(episodes), "--out", folder]
    run_skybody(*words, *([] if picture else ["--no-picture"]), overrides=overrides)
    with h5py.File(folder / "flight.h5") as log:
        # A task that defines success itself may end the episode by it.
        return [
            bool((e["status"][-1] == 2 or is_success is says_so) and is_success(e))
            for e in log["episodes"].values()
        ]


def head_of(world: str) -> str:
    """The comment at the beginning of the world's file, as one paragraph."""
    text = Path(scenario_file(world.split()[0])).read_text()
    lines = []
    for line in text.splitlines():
        if not line.startswith("#"):
            break
        lines.append(line.removeprefix("#").strip())
    return " ".join(lines)


def save_smaller(picture: Path, to: Path) -> None:
    """Reduces a picture by averaging blocks of pixels."""
    pixels = matplotlib.image.imread(picture)[..., :3]
    height, width = (size - size % COARSER for size in pixels.shape[:2])
    blocks = pixels[:height, :width].reshape(
        height // COARSER, COARSER, width // COARSER, COARSER, 3
    )
    to.parent.mkdir(parents=True, exist_ok=True)
    matplotlib.image.imsave(to, np.round(blocks.mean(axis=(1, 3)) * 31.0) / 31.0)  # fewer colours


def section(world: str, episodes: int, out: Path) -> str:
    """Flies one world and describes it."""
    with tempfile.TemporaryDirectory() as folder:
        successes = fly(world, episodes, Path(folder) / "log", picture=True)
        line = f"`hold` succeeds in {sum(successes)} of {len(successes)} episodes."
        print(f"{world}: {line}", flush=True)
        image = f"images/worlds/{world.replace(' ', '_')}.png"
        save_smaller(Path(folder) / "log/flight-0001.png", out / image)
        picture = f"![A flight of {world} by hold]({image})"
    return "\n\n".join([f"## {world}", head_of(world), line, picture])


def sections_of(page: Path) -> dict[str, str]:
    """The page's sections by world; empty if there is no page."""
    text = page.read_text() if page.is_file() else ""
    parts = [part.strip() for part in text.split("\n## ")[1:]]
    return {part.split("\n", 1)[0]: f"## {part}" for part in parts}


def table(sections: dict[str, str]) -> str:
    """One line per world: the share of its successful episodes."""
    rows = [head("world | succeeded | of")]
    for world, text in sections.items():
        if found := re.search(r"succeeds in (\d+) of (\d+)", text):
            rows.append([f"[{world}](#{world.replace(' ', '-')})", found[1], found[2]])
    return markdown_table(rows)


def page(line: str, sections: dict[str, str]) -> str:
    """The page; `line`: the machine."""
    return f"""# Worlds

{line}

    .venv/bin/python -m research run worlds

Each world is flown by `hold` in {EPISODES} drawn episodes, as by
`skybody run WORLD --episodes {EPISODES}`; the picture shows the first one. The
head of the world's file, repeated here, defines success. The machine is that of the worlds that
were flown last.

{table(sections)}

hover_learn is flown for 10 s here. In its own 7 s a policy can reach every target; `hold`, which
flies at 1.5 m/s at most, comes too late to those farther than about 8 m.

{(chr(10) * 2).join(sections.values())}
"""


def main() -> int:
    options = (
        Options(__doc__, __name__)
        .add("worlds", nargs="*", metavar="WORLD", help="worlds; default: all")
        .given()
    )
    if unknown := [world for world in options.worlds if world not in ALL_WORLDS]:
        raise RunError(f"no world `{unknown[0]}`: there are {', '.join(ALL_WORLDS)}")
    out, episodes = options.out, 3 if options.quick else EPISODES
    line = machine_line(facts())
    flown = {world: section(world, episodes, out) for world in options.worlds or ALL_WORLDS}
    known = sections_of(out / f"{PAGE}.md") | flown
    sections = {world: known[world] for world in ALL_WORLDS if world in known}
    write_page(out, PAGE, page(line, sections), keeps=set(sections) != set(flown))
    return 0
