"""What the evaluation of a law of flight costs beside a step of hover.

    .venv/bin/python experiments/law_speed.py [--quick] [--out DIR]

bench_micro steps one group of 32 environments in lanes on one core: hover under a chain that begins
with the law, and under the same chain with `balance` (bench/plugins), which computes nothing, in
its place. Times are those of the processor, which others' work does not lengthen much.
"""

from __future__ import annotations

import json
import statistics
import subprocess
from typing import Any

from program_bench import Case, run
from skybody.program import run_program
from throughput import (
    ROOT,
    arguments,
    facts,
    machine_line,
    markdown_table,
    output_folder,
    write_json,
)

PROGRAM = ROOT / "build/release/bin/bench_micro"
LANES = 32
ENVS = 1024
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


def nanoseconds(repetitions: int, least: float) -> dict[str, list[float]]:
    """Processor time of each row for an environment and step, round after round."""
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
    hover, whole = median["hover"], found["hover_in_pool"]
    rows = [["chain", "ns a step", "without the law", "the law itself", "of hover", "in a pool"]]
    for name, (without, words) in ROWS.items():
        own = median[name] - median[without]
        rows.append(
            [
                words,
                f"{median[name]:.1f}",
                f"{median[without]:.1f}",
                f"{own:.1f}",
                f"{100 * own / hover:.0f} %",
                f"{100 * own / whole:.0f} %",
            ]
        )
    return f"""# Speed of laws of flight

{machine_line(found["facts"])}

    .venv/bin/python experiments/law_speed.py

Processor time for one environment and physics step, in ns, medians of {found["trials"]} rounds.
`bench_micro` steps {LANES} environments in lanes; their command is a place in the middle of the
box, at which they fly from where they start. The law itself is the difference to the same
chain with `balance` in the law's place, which takes the same command and computes nothing: its
own evaluation, and what its torques cost more in the allocation behind it than none do.

- of hover: over a step of `hover` in the same program with rotors' speeds as actions,
  {hover:.1f} ns.
- in a pool: over a step of `hover` as `skybody bench hover --envs {ENVS} --threads 1` has it,
  {whole:.1f} ns of wall-clock time (the quickest of the trials).

{markdown_table(rows)}
"""


def main() -> int:
    parser = arguments(__doc__ or "")
    options = parser.parse_args()
    folder = output_folder(parser, options)
    trials = 1 if options.quick else 5
    found: dict[str, Any] = {"facts": facts(), "trials": trials}
    found["ns"] = nanoseconds(trials, 0.1 if options.quick else 0.5)
    case = Case("hover", "hover", envs=ENVS)
    found["hover_in_pool"] = min(1e9 / run(case, 1.0)["rate"] for _ in range(trials))
    text = page(found)
    print(text)
    if folder is None:
        return 0
    (folder / "law_speed.md").write_text(text)
    write_json(folder / "data/law_speed.json", found)
    return 0


if __name__ == "__main__":
    run_program(main)
