"""Cost of evaluating controllers relative to a step of hover.

    python -m research run law_speed [--quick] [--out DIR]

bench_micro steps one group of 32 environments in lanes on one core: hover under a chain that begins
with the law, and under the same chain with `balance` (research/bench/plugins) instead, which
computes nothing. Times are processor times, which other load affects little. Then `skybody bench`
steps 1,024 environments on one thread, in turns.
"""

from __future__ import annotations

import json
import statistics
from pathlib import Path
from typing import Any

from research.common.machine import facts, machine_line
from research.common.options import Options
from research.common.pages import head, markdown_table, write_page
from research.common.places import PROGRAMS, ROOT
from research.common.programs import output_of, run_bench

PAGE = "law_speed"

LANES = 32
# Row of the law: row without it, the chain in words.
ROWS = {
    "geometric_to_ctbt": ("nothing_to_ctbt", "`geometric`, then ctbt"),
    "geometric_to_ctbr": ("nothing_to_ctbr", "`geometric` (output: ctbr), then ctbr"),
    "lqr_to_ctbt": ("nothing_to_ctbt", "`lqr`, then ctbt"),
    "sliding_mode_to_ctbt": ("nothing_to_ctbt", "`sliding_mode`, then ctbt"),
    "position_to_rates": ("nothing_to_rates", "`position` (trajectory), then attitude, ctbr"),
    "flatness_to_rates": ("nothing_to_rates", "`flatness`, then attitude, ctbr"),
    "force_to_attitude": ("nothing_to_attitude", "`force`, then attitude, ctbr"),
    "indi_to_rotors": ("nothing_to_rotors", "`indi`, then rotor_speed"),
}

ENVS = 1024
BENCH_PLUGINS = ROOT / "build/release/lib/skybody/bench_plugins"
CTBT, ATTITUDE = "{plugin: ctbt}", "{plugin: attitude}, {plugin: ctbr}"
ROTORS = "{plugin: rotor_speed}"
BALANCE = "{{plugin: balance, parameters: {{takes: {}, gives: {}}}}}"
# Law: chain with it, and with `balance` instead.
CHAINS = {
    "geometric": ("{plugin: geometric}", BALANCE.format("trajectory", "ctbt"), CTBT),
    "force": ("{plugin: force}", BALANCE.format("force", "attitude"), ATTITUDE),
    "indi": ("{plugin: indi}", BALANCE.format("trajectory", "rotor_speed"), ROTORS),
}


def pool_step(controllers: str, seconds: float) -> float:
    """Time of a step of one environment [ns]. Nothing is drawn, so that no episode ends early."""
    actions = "hold" if controllers == ROTORS else "zero"  # the hover actions
    words = ("--plugin-path", str(BENCH_PLUGINS), "--actions", actions)
    overrides = (f"robots.quad.controllers=[{controllers}]", "randomization=[]")
    found = run_bench("hover", seconds, *words, envs=ENVS, overrides=overrides)
    return 1e9 / float(found["physics_steps_per_second"])


def pool_nanoseconds(rounds: int, seconds: float) -> dict[str, list[float]]:
    """Step times of hover, and of each law's chain with it and without it, in turns."""
    found: dict[str, list[float]] = {}

    def add(name: str, controllers: str) -> None:
        found.setdefault(name, []).append(pool_step(controllers, seconds))

    for _ in range(rounds):
        for law, (own, balance, rest) in CHAINS.items():
            add("hover", ROTORS)
            add(law, f"{own}, {rest}")
            add(f"{law} without", f"{balance}, {rest}")
    return found


def numbers(whole: float, without: float, hover: float) -> list[str]:
    """Cells of a law: times with it, without it and of itself [ns], and its share of hover."""
    own = whole - without
    return [f"{whole:.1f}", f"{without:.1f}", f"{own:.1f}", f"{100 * own / hover:.0f} %"]


def pool_table(ns: dict[str, list[float]]) -> str:
    least = {name: min(times) for name, times in ns.items()}
    rows = [head("law | ns a step | without the law | the law itself | of hover")]
    for law in CHAINS:
        found = numbers(least[law], least[f"{law} without"], least["hover"])
        rows.append([f"`{law}`", *found])
    return markdown_table(rows)


def nanoseconds(program: Path, repetitions: int, least: float) -> dict[str, list[float]]:
    """Processor time of each row per environment and step, for each round."""
    found: dict[str, list[float]] = {}
    for trial in range(repetitions):
        options = ("--benchmark_filter=^law/", f"--benchmark_min_time={least}")
        printed = output_of([program, *options, "--benchmark_format=json"])
        for row in json.loads(printed)["benchmarks"]:
            name = row["name"].removeprefix("law/")
            found.setdefault(name, []).append(row["cpu_time"] / LANES)
        print(f"{trial + 1}/{repetitions}", flush=True)
    return found


def page(found: dict[str, Any]) -> str:
    median = {name: statistics.median(times) for name, times in found["ns"].items()}
    hover = median["hover"]
    rows = [head("chain | ns a step | without the law | the law itself | of hover")]
    for name, (without, words) in ROWS.items():
        rows.append([words, *numbers(median[name], median[without], hover)])
    return f"""# Speed of laws of flight

{machine_line(found["facts"])}

    .venv/bin/python -m research run law_speed

Processor time for one environment and physics step, in ns, medians of {found["trials"]} rounds.
`bench_micro` steps {LANES} environments in lanes, in steady flight: their command is a place, at
which they have arrived. The law itself is the difference to the same chain with `balance` in the
law's place, which takes the same command and computes nothing. Of hover: over a step of `hover`
in the same program, with the speeds at which rotors hover as actions, {hover:.1f} ns.

{markdown_table(rows)}

## A pool of {ENVS:,} environments

Time by the clock of one thread, least of {found["rounds"]} rounds in turns. Commands are the
middle of their ranges, and nothing is drawn. Of hover: over a step of `hover` with rotor_speed in
the same run, {min(found["pool"]["hover"]):.1f} ns.

{pool_table(found["pool"])}
"""


def main() -> int:
    options = Options(__doc__, __name__, program=PROGRAMS / "bench_micro").given()
    trials = 1 if options.quick else 3
    found: dict[str, Any] = {"facts": facts(), "trials": trials}
    found["ns"] = nanoseconds(options.program, trials, 0.1 if options.quick else 0.3)
    found["rounds"] = 1 if options.quick else 5
    found["pool"] = pool_nanoseconds(found["rounds"], 0.3 if options.quick else 1.0)
    write_page(options.out, PAGE, page(found), found)
    return 0
