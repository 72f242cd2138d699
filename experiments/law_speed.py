"""Cost of the evaluation of a flight law, compared with a step of hover.

    .venv/bin/python experiments/law_speed.py [--quick] [--out DIR]

bench_micro steps one group of 32 environments in lanes on one core: hover under a chain that begins
with the law, and under the same chain with `balance` (bench/plugins), which computes nothing,
instead. Times are processor times, which other load affects little. Then `skybody bench` steps
1,024 environments on one thread, in turns.
"""

from __future__ import annotations

import json
import statistics
import subprocess
from typing import Any

from skybody.program import run_program
from throughput import (
    ROOT,
    arguments,
    facts,
    machine_line,
    markdown_table,
    output_folder,
    write_report,
)

PROGRAM = ROOT / "build/release/bin/bench_micro"
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
SKYBODY = ROOT / "build/release/bin/skybody"
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
    done = subprocess.run(
        [
            *(str(SKYBODY), "bench", "hover", "--envs", str(ENVS), "--threads", "1", "--json"),
            *("--seconds", str(seconds), "--plugin-path", str(BENCH_PLUGINS)),
            *("--actions", actions, "--set", f"robots.quad.controllers=[{controllers}]"),
            *("--set", "randomization=[]"),
        ],
        capture_output=True,
        text=True,
        check=True,
    )
    return 1e9 / float(json.loads(done.stdout)["physics_steps_per_second"])


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


def pool_table(ns: dict[str, list[float]]) -> str:
    least = {name: min(times) for name, times in ns.items()}
    rows = [["law", "ns a step", "without the law", "the law itself", "of hover"]]
    for law in CHAINS:
        own = least[law] - least[f"{law} without"]
        numbers = [f"{least[law]:.1f}", f"{least[f'{law} without']:.1f}", f"{own:.1f}"]
        rows.append([f"`{law}`", *numbers, f"{100 * own / least['hover']:.0f} %"])
    return markdown_table(rows)


def nanoseconds(repetitions: int, least: float) -> dict[str, list[float]]:
    """Processor time of each row per environment and step, for each round."""
    found: dict[str, list[float]] = {}
    for trial in range(repetitions):
        done = subprocess.run(
            [
                PROGRAM,
                "--benchmark_filter=^law/",
                f"--benchmark_min_time={least}",
                "--benchmark_format=json",
            ],
            capture_output=True,
            text=True,
            check=True,
        )
        for row in json.loads(done.stdout)["benchmarks"]:
            name = row["name"].removeprefix("law/")
            found.setdefault(name, []).append(row["cpu_time"] / LANES)
        print(f"{trial + 1}/{repetitions}", flush=True)
    return found


def page(found: dict[str, Any]) -> str:
    median = {name: statistics.median(times) for name, times in found["ns"].items()}
    hover = median["hover"]
    rows = [["chain", "ns a step", "without the law", "the law itself", "of hover"]]
    for name, (without, words) in ROWS.items():
        own = median[name] - median[without]
        rows.append(
            [
                words,
                f"{median[name]:.1f}",
                f"{median[without]:.1f}",
                f"{own:.1f}",
                f"{100 * own / hover:.0f} %",
            ]
        )
    return f"""# Speed of laws of flight

{machine_line(found["facts"])}

    .venv/bin/python experiments/law_speed.py

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
    parser = arguments(__doc__ or "")
    options = parser.parse_args()
    folder = output_folder(parser, options)
    trials = 1 if options.quick else 3
    found: dict[str, Any] = {"facts": facts(), "trials": trials}
    found["ns"] = nanoseconds(trials, 0.1 if options.quick else 0.3)
    found["rounds"] = 1 if options.quick else 5
    found["pool"] = pool_nanoseconds(found["rounds"], 0.3 if options.quick else 1.0)
    write_report(folder, "law_speed", page(found), found)
    return 0


if __name__ == "__main__":
    run_program(main)
