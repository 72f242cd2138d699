"""Golden hashes: the trajectory of every shipped scenario, and of one with all sensors, pinned.

    .venv/bin/python tests/golden/golden.py            # compares, and says which moved
    .venv/bin/python tests/golden/golden.py --write    # rewrites the files, and says which moved

One file a flight, `tests/golden/NAME.json`. A flight has several ways: as the scenario is shipped,
and each dynamics that its world can have with each fixed-step integrator. Each way has two hashes:
`words` is the trajectory hash over state words, observation, privileged row, images, reward and
status, `motion` has q, u and rotor speeds in place of all state words (`skybody hash --motion`). A
version that keeps other words moves the first, one that moves the vehicle otherwise moves both.
Every way is flown on each instruction set that the processor has, and all must give the same.
Ways on Simbody are compared only on the make of processor and the distribution of the pinned ones.

`tests/golden/trees.txt` (`--flights trees`) pins random worlds on the tree engine and random scenes
of the renderer, one hash each (`tests/portable/tree_flights.cpp`). Exit status 0: as pinned, 1:
some moved, 2: a process failed.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
FOLDER = Path(__file__).resolve().parent
PROGRAM = ROOT / "build/release/bin/skybody"
TREES = FOLDER / "trees.txt"
SEED = 7
ENVS = 12
STEPS = 250  # of one environment with one robot
LEAST_STEPS = 20
EPISODES = 4  # at least, so that resets are among what is pinned
DYNAMICS = ("tree", "simbody", "auto")
INTEGRATORS = ("semi_implicit_euler", "midpoint", "rk4")
INSTRUCTION_SETS = re.findall(r"X\((v\d)", (ROOT / "core/base/simd/isa_sets.h").read_text())
TIMEOUT = 600.0  # s, of one process on a machine that does much else

Hashes = dict[str, str]  # "words" and "motion"


class FlightError(RuntimeError):
    """A process that failed; the text is the whole message."""


@dataclass(frozen=True)
class Flight:
    """A shipped scenario, a variant of one, or a scenario file of this folder."""

    name: str
    scenario: str
    robots: int = 1
    overrides: tuple[str, ...] = ()
    most_steps: int = STEPS

    @property
    def steps(self) -> int:
        """Of each environment: fewer where a step takes longer."""
        return max(LEAST_STEPS, self.most_steps // self.robots)

    @property
    def source(self) -> str:
        """The scenario as programs take it: a name, or a path."""
        return str(FOLDER / self.scenario) if self.scenario.endswith(".yaml") else self.scenario

    @property
    def file(self) -> Path:
        """Where its hashes are pinned."""
        return FOLDER / f"{self.name}.json"

    def options(self, envs: int = ENVS) -> list[str]:
        """For `skybody hash` and research/determinism/hash_run.py alike."""
        horizon = f"stepping.horizon={max(2, self.steps // EPISODES)}"
        options = [self.source, f"--envs={envs}", f"--steps={self.steps}", f"--seed={SEED}"]
        for override in (*self.overrides, horizon):
            options += ["--set", override]
        return options


NEAR_THE_GROUND = (
    "randomization[0].parameters.position_min=[-5,-5,0.02]",
    "randomization[0].parameters.position_max=[5,5,0.06]",
)
# Within the short episodes of these flights.
FAILS_EARLY = ("effects[0].parameters.earliest=0.1", "effects[0].parameters.latest=0.4")
REACHES_EARLY = tuple(f"randomization[{k}].parameters.time=[0.1,0.4]" for k in range(2))
# Taut ropes move as rods do, and in episodes this short they stay taut. These are slack at first.
SLACK = tuple(f"couplings.{name}_rod.length=1.04" for name in ("alpha", "bravo", "charlie"))
# All images of a camera that is late and not in step with the actions.
ALL_IMAGES = (
    "sensors.front.parameters.outputs=[depth, range, instance, class, normal, rgb]",
    "sensors.front.parameters.period=7",
    "sensors.front.parameters.phase=3",
    "sensors.front.parameters.latency=11",
    "observe=[front.depth, front.range, front.instance, front.class, front.normal, front.rgb]",
)
FLIGHTS = (
    Flight("hover", "hover"),
    Flight("hover_camera", "hover_camera"),
    Flight("hover_camera_late", "hover_camera", overrides=ALL_IMAGES),
    Flight("hover_crazyflie", "hover_crazyflie"),
    Flight("hover_firefly", "hover_firefly"),
    Flight("hover_hummingbird", "hover_hummingbird"),
    Flight("hover_learn", "hover_learn"),
    Flight("hover_on_ground", "hover", overrides=NEAR_THE_GROUND),
    Flight("hover_sensors", "hover_sensors"),
    Flight("every_sensor", "every_sensor.yaml"),
    Flight("payload", "payload"),
    Flight("payload_paper", "payload_paper"),
    Flight("payload_1khz", "payload_1khz"),
    Flight("payload_modular", "payload_modular"),
    Flight("payload_modular_1khz", "payload_modular_1khz"),
    Flight("payload_modular_paper", "payload_modular_paper"),
    Flight("pendulum", "pendulum"),
    Flight("pendulum_randomized", "pendulum_randomized"),
    Flight("pendulum_paper", "pendulum_paper"),
    Flight("payload_learn", "payload_learn"),
    Flight("payload_modular_learn", "payload_modular_learn"),
    Flight("pendulum_learn", "pendulum_learn"),
    Flight("pendulum_learn_randomized", "pendulum_learn_randomized"),
    Flight("formation", "formation", robots=5),
    Flight("formation_2", "formation_2", robots=2),
    Flight("formation_10", "formation_10", robots=10),
    Flight("formation_20", "formation_20", robots=20),
    Flight("formation_learn", "formation_learn", robots=5),
    Flight("formation_learn_2", "formation_learn_2", robots=2),
    Flight("formation_obstacles", "formation_obstacles", robots=3),
    Flight("chase", "chase", robots=4),
    Flight("chase_agents", "chase_agents", robots=4),
    Flight("collision", "collision", robots=2),
    Flight("hard_landing", "hard_landing"),
    Flight("cooperative_payload", "cooperative_payload", robots=4),
    Flight("cooperative_payload_learn", "cooperative_payload_learn", robots=4),
    Flight("cooperative_payload_ropes", "cooperative_payload_ropes", robots=4),
    Flight("cooperative_payload_slack", "cooperative_payload_ropes", robots=4, overrides=SLACK),
    Flight("forest", "forest"),
    Flight("gates", "gates"),
    Flight("platform_landing", "platform_landing", robots=2),
    Flight("landing", "landing", robots=2),
    Flight("landing_vision", "landing_vision", robots=2),
    Flight("racing", "racing"),
    Flight("racing_drawn", "racing_drawn"),
    Flight("racing_duel", "racing_duel", robots=2),
    Flight("racing_figure", "racing_figure"),
    Flight("racing_split_s", "racing_split_s"),
    Flight("racing_vision", "racing_vision"),
    Flight("four_bar", "four_bar"),
    Flight("windy_hover", "windy_hover"),
    Flight("downwash_pair", "downwash_pair", robots=2),
    Flight("low_battery", "low_battery"),
    Flight("rotor_out", "rotor_out", overrides=FAILS_EARLY),
    Flight("arm", "arm", overrides=REACHES_EARLY),
    Flight("obstacles", "obstacles"),
    Flight("obstacles_rays", "obstacles_rays"),
    Flight("obstacles_vision", "obstacles_vision"),
    Flight("omav", "omav"),
    Flight("tricopter", "tricopter"),
    Flight("vehicles", "vehicles"),
    Flight("trajectory_training", "trajectory_training"),
    Flight("trajectory_flights", "trajectory_flights"),
    Flight("trajectory", "trajectory", most_steps=100),
    Flight("trajectory_modular", "trajectory_modular", most_steps=100),
    Flight("trajectory_ctbr", "trajectory_ctbr", most_steps=100),
    Flight("trajectory_compact", "trajectory_compact", most_steps=100),
    Flight("vehicles_trajectory", "vehicles_trajectory", most_steps=100),
    Flight("trajectory_paper", "trajectory_paper", most_steps=100),
    Flight("trajectory_modular_paper", "trajectory_modular_paper", most_steps=100),
    Flight("boom", "boom", most_steps=LEAST_STEPS),  # cvode, and midpoint's fast spins, take long
)


# --- flying -------------------------------------------------------------------------------------


def ways(program: Path, flight: Flight) -> dict[str, list[str]]:
    """Options of each way of a flight, by the way's name."""
    all_ways: dict[str, list[str]] = {"as shipped": []}
    for dynamics in DYNAMICS:
        chosen = ["--set", f"stepping.dynamics={dynamics}"]
        if dynamics == "tree" and not can_fly(program, flight, chosen):
            continue
        for integrator in INTEGRATORS:
            way = [*chosen, "--set", f"stepping.integrator={integrator}"]
            way += ["--set", "stepping.solver=null"]
            all_ways[f"{dynamics}, {integrator}"] = way
    return all_ways


def can_fly(program: Path, flight: Flight, options: list[str]) -> bool:
    """Whether the scenario's world can have what the options ask for."""
    command = [str(program), "check", flight.source, *options]
    return finished(command).returncode == 0


def finished(command: list[str], **variables: str) -> subprocess.CompletedProcess[str]:
    """A process that has ended. Raises FlightError if there is no such program, or no end."""
    environment = {**os.environ, **variables}
    try:
        return subprocess.run(
            command, capture_output=True, text=True, check=False, timeout=TIMEOUT, env=environment
        )
    except OSError as error:
        raise FlightError(f"{command[0]}: {error.strerror}; build it, or give --program") from None
    except subprocess.TimeoutExpired:
        raise FlightError(f"{' '.join(command)}: no result after {TIMEOUT:g} s") from None


def output_of(command: list[str], instruction_set: str) -> str:
    """What a process prints. Raises FlightError where it fails."""
    done = finished(command, SKYBODY_ISA=instruction_set)
    if done.returncode != 0:
        raise FlightError(f"{' '.join(command)}: exit status {done.returncode}\n{done.stderr}")
    return done.stdout


def fly(program: Path, flight: Flight, way: list[str], instruction_set: str) -> Hashes:
    """The two hashes of one way, from a process of its own."""
    command = [str(program), "hash", "--motion", *flight.options(), *way]
    words, motion = output_of(command, instruction_set).split()
    return {"words": words, "motion": motion}


def instruction_sets() -> list[str]:
    """Those that this processor has."""
    flags = set(Path("/proc/cpuinfo").read_text().split("flags", 1)[-1].split("\n", 1)[0].split())
    needs = {"v2": set(), "v3": {"avx2", "fma", "bmi2"}, "v4": {"avx512f", "avx512dq", "avx512vl"}}
    return [name for name in INSTRUCTION_SETS if needs[name] <= flags]


def fly_way(program: Path, flight: Flight, way: list[str]) -> Hashes:
    """The hashes that all instruction sets give. Raises FlightError where they do not agree."""
    found = {isa: fly(program, flight, way, isa) for isa in instruction_sets()}
    first = next(iter(found.values()))
    if any(hashes != first for hashes in found.values()):
        raise FlightError(f"{flight.name}, {' '.join(way)}: instruction sets differ: {found}")
    return first


def fly_all(program: Path, flight: Flight) -> dict[str, Hashes]:
    """Hashes by the way; one process for each processor at a time."""
    options = ways(program, flight)
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        flown = pool.map(lambda way: fly_way(program, flight, way), options.values())
        return dict(zip(options, flown, strict=True))


def fly_trees(program: Path) -> str:
    """The lines of all random worlds. Raises FlightError where instruction sets do not agree."""
    found = {isa: output_of([str(program)], isa) for isa in instruction_sets()}
    first = next(iter(found.values()))
    for isa, lines in found.items():
        if lines != first:
            raise FlightError("\n".join([f"{program.name}, {isa}:", *lines_moved(first, lines)]))
    return first


# --- files --------------------------------------------------------------------------------------


def pinned(flight: Flight) -> dict[str, Any]:
    """What the flight's file holds; nothing where there is none."""
    return json.loads(flight.file.read_text()) if flight.file.is_file() else {"hashes": {}}


def shipped_hash(flight: Flight) -> str:
    """The pinned trajectory hash of the scenario as it is shipped."""
    return str(pinned(flight)["hashes"]["as shipped"]["words"])


def write(flight: Flight, flown: dict[str, Hashes]) -> None:
    """Pins what was flown."""
    content = {
        "flight": f"skybody hash --motion {' '.join(flight.options())}".replace(f"{ROOT}/", ""),
        **machine(),
        "hashes": flown,
    }
    flight.file.write_text(json.dumps(content, indent=2) + "\n")


def machine() -> dict[str, str]:
    """The processor's make and the distribution: the bits of Simbody and of libm depend on them."""
    try:
        release = platform.freedesktop_os_release()
    except OSError:
        return {"processor": processor(), "system": "unknown"}
    system = f"{release['NAME']} {release.get('VERSION_ID', '')}".strip()
    return {"processor": processor(), "system": system}


def processor() -> str:
    """The make of this machine's processor."""
    names = [x for x in Path("/proc/cpuinfo").read_text().splitlines() if x.startswith("vendor_id")]
    return names[0].split(":")[1].strip() if names else "unknown"


def portable_ways(hashes: dict[str, Hashes]) -> set[str]:
    """Ways that no machine changes: those on the tree engine, and those with the hash of one."""
    on_tree = [found for way, found in hashes.items() if way.startswith("tree")]
    return {way for way, found in hashes.items() if found in on_tree}


def moves(flight: Flight, flown: dict[str, Hashes], *, all_ways: bool) -> list[str]:
    """One line for each hash that is not the pinned one: of all ways, or of those that must be."""
    found = pinned(flight)
    old = found["hashes"]
    if not all_ways and any(found.get(key, here) != here for key, here in machine().items()):
        others = set(old) - portable_ways(old)
        flown = {way: hashes for way, hashes in flown.items() if way not in others}
        old = {way: hashes for way, hashes in old.items() if way not in others}
    lines = [f"{flight.name}, {way}: no longer flown" for way in old if way not in flown]
    for way, hashes in flown.items():
        for kind, value in hashes.items():
            before = old.get(way, {}).get(kind, "not pinned")
            if value != before:
                lines.append(f"{flight.name}, {way}: {kind} {before} -> {value}")
    return lines


def lines_moved(before: str, after: str) -> list[str]:
    """One line for each random world whose hash is not as before."""
    old, new = (dict(line.split() for line in text.splitlines()) for text in (before, after))
    return [
        f"trees, {world}: {old.get(world, 'not pinned')} -> {new.get(world, 'no longer flown')}"
        for world in {**old, **new}
        if old.get(world) != new.get(world)
    ]


def compare_trees(program: Path, *, rewrite: bool) -> list[str]:
    """The random worlds that moved; with `rewrite` they are pinned."""
    lines = fly_trees(program)
    moved = lines_moved(TREES.read_text() if TREES.is_file() else "", lines)
    if rewrite:
        TREES.write_text(lines)
    return moved


def parse(arguments: list[str] | None) -> argparse.Namespace:
    """The command line's values, checked."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    names = [*(flight.name for flight in FLIGHTS), TREES.stem]
    parser.add_argument("--flights", nargs="+", metavar="NAME", help="default: all")
    parser.add_argument("--program", type=Path, default=PROGRAM, help="skybody")
    parser.add_argument("--write", action="store_true", help="rewrite the files")
    options = parser.parse_args(arguments)
    options.flights = options.flights or names
    for name in options.flights:
        if name not in names:
            parser.error(f"--flights {name}: there are {', '.join(names)}")
    return options


def main(arguments: list[str] | None = None) -> int:
    """Flies, compares, writes if asked; returns the exit status."""
    options = parse(arguments)
    moved = []
    try:
        for flight in (f for f in FLIGHTS if f.name in options.flights):
            flown = fly_all(options.program, flight)
            moved += moves(flight, flown, all_ways=options.write)
            if options.write:
                write(flight, flown)
        if TREES.stem in options.flights:
            program = options.program.with_name("tree_flights")
            moved += compare_trees(program, rewrite=options.write)
    except FlightError as error:
        print(f"golden: {error}", file=sys.stderr)
        return 2
    print("\n".join(moved) if moved else "nothing moved")
    return 1 if moved and not options.write else 0


if __name__ == "__main__":
    sys.exit(main())
