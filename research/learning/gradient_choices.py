"""Cost of a step of `gradient` by world, benefit of its value function, horizon needed for heavy
vehicles.

    python -m research run gradient_choices [--program BENCH_GRADIENT]

Every figure comes from bench_gradient, whose command is on the page. Costs: seconds of training by
steps, on one thread. The other two: the median error, failures and mean return of 100 held-out
episodes after a run's last update, for each seed. Writes gradient_choices.md and its JSON. Run it
on an otherwise idle machine.
"""

from __future__ import annotations

import re
import statistics
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from skybody import versions

from research.common.machine import machine_line, versions_line
from research.common.options import Options, heading
from research.common.pages import head, markdown_table, write_page
from research.common.places import PROGRAMS
from research.common.programs import RunError, output_of

PAGE = "gradient_choices"

PATIENCE = 300.0  # s, for one run
SEEDS = (1, 2, 3)
WORLDS = ("hover_learn", "windy_hover", "payload")
COST = ("threads=1", "envs=128", "updates=20", "every=20")
QUICK = ("updates=2", "every=2")
STEP_SIZES = ("learning_rate=6e-3", "max_grad_norm=1")
STATISTICS = ("normalization_steps=2e5", "averaging_steps=8e4")
ALONE = ("goal_weight=0", "reward_weight=1", "envs=128", "updates=215")
REWARD_ALONE = (*ALONE, *STEP_SIZES, *STATISTICS)
VEHICLES = ("envs=256", *STEP_SIZES)


@dataclass(frozen=True)
class Choice:
    """Settings of bench_gradient to compare."""

    name: str
    scenario: str
    settings: tuple[str, ...]


VALUE_CHOICES = [
    Choice("none", "hover_learn", REWARD_ALONE),
    *(
        Choice(
            f"weight {weight}, {epochs} value_epochs",
            "hover_learn",
            (*REWARD_ALONE, f"end_value_weight={weight}", f"value_epochs={epochs}"),
        )
        for weight, epochs in ((0.1, 10), (1, 2), (1, 10))
    ),
]
FAR = ("rollout_steps=64", "updates=293")
HORIZON_CHOICES = [
    Choice(name, "vehicles", (*VEHICLES, *settings))
    for name, settings in (
        ("32 actions (0.32 s), 3 m/s", ("rollout_steps=32", "updates=586")),
        ("64 actions (0.64 s), 3 m/s", FAR),
        ("64 actions (0.64 s), 1 m/s", (*FAR, "approach_speed=1")),
    )
]


# --- one run --------------------------------------------------------------------------------------


def bench(program: Path, scenario: str, settings: Sequence[str]) -> dict[str, float]:
    """Runs bench_gradient; the figures after its last update. Raises RunError."""
    return read_figures(output_of([program, scenario, *settings], PATIENCE))


def read_figures(output: str) -> dict[str, float]:
    """Figures of the last evaluation: steps, seconds of training, and of held-out episodes."""
    ready = re.search(r"^ready after ([\d.]+) s$", output, re.MULTILINE)
    looks = re.findall(
        r"^update +\d+ steps +(\d+) +([\d.]+) s of process .*\| median ([\d.]+) m "
        r"p90 ([\d.]+) m failures (\d+) of (\d+) return (-?[\d.]+)$",
        output,
        re.MULTILINE,
    )
    if ready is None or not looks:
        raise RunError(f"bench_gradient printed no figures, but\n{output}")
    names = ("steps", "seconds", "median", "worst_tenth", "failures", "episodes", "mean_return")
    figures = dict(zip(names, map(float, looks[-1]), strict=True))
    figures["seconds"] -= float(ready[1])
    return figures


def costs(program: Path, quick: bool) -> list[dict[str, Any]]:
    """Cost of a step of training in each world."""
    rows = []
    for world in WORLDS[:1] if quick else WORLDS:
        found = bench(program, world, (*COST, *(QUICK if quick else ())))
        rows.append({"scenario": world, "microseconds": 1e6 * found["seconds"] / found["steps"]})
    return rows


def compared(program: Path, choices: Sequence[Choice], quick: bool) -> list[dict[str, Any]]:
    """Each choice with the figures of its seeds."""
    more = QUICK if quick else ()
    return [
        {
            "choice": choice.name,
            "command": " ".join(["bench_gradient", choice.scenario, *choice.settings]),
            "runs": [
                bench(program, choice.scenario, [*choice.settings, *more, f"seed={seed}"])
                for seed in (SEEDS[:1] if quick else SEEDS)
            ],
        }
        for choice in (choices[:1] if quick else choices)
    ]


# --- the page -------------------------------------------------------------------------------------


def markdown(content: dict[str, Any]) -> str:
    """The whole page."""
    rows = "\n".join(
        f"| `{row['scenario']}` | {row['microseconds']:.1f} |" for row in content["costs"]
    )
    return f"""\
# What `gradient` costs, and two of its choices

    {content["command"]}

on {machine_line(content["machine"])}. Every figure is `bench_gradient`'s.

## A step of training

`bench_gradient SCENARIO {" ".join(COST)}`, one run each: flight, network and the way
back through four physics steps, on one thread. Quadrotors that are one free body without effects go
back in closed form, other worlds by an evaluation on dual numbers for each value of their motion.

| scenario | a step of one environment [us] |
| --- | ---: |
{rows}

## The value function, where the reward is all there is

`hover_learn` without the cost that follows from the goal, seeds {_seeds()}: 100 held-out episodes
after the last update. Held-out episodes are the same for all.

{_table(content["values"], "value function")}

## How far heavy vehicles look ahead

`vehicles`, with horizons and speeds of approach; the steps are about as many for all.

{_table(content["horizons"], "horizon, approach_speed")}

A failure is an episode that the task ends, or a fault.

Versions: {versions_line([content])}.
"""


def _seeds() -> str:
    return f"{', '.join(map(str, SEEDS[:-1]))} and {SEEDS[-1]}"


def _table(rows: Sequence[dict[str, Any]], title: str) -> str:
    table = [head(f"{title} | steps | mean return | least | median error [mm] | failures of 100")]
    for row in rows:
        runs = row["runs"]
        returns = [run["mean_return"] for run in runs]
        medians = [f"{1e3 * run['median']:.1f}" for run in runs]
        failures = [f"{run['failures']:.0f}" for run in runs]
        steps = f"{max(run['steps'] for run in runs):,.0f}"
        means = (f"{statistics.mean(returns):.0f}", f"{min(returns):.0f}")
        table.append([row["choice"], steps, *means, ", ".join(medians), ", ".join(failures)])
    commands = "\n".join(f"    {row['command']}" for row in rows)
    note = "A value for each seed; with `seed=1` and so on:"
    return f"{markdown_table(table, (0, 4, 5))}\n\n{note}\n\n{commands}"


# --- the command line -----------------------------------------------------------------------------


def main(arguments: list[str] | None = None) -> int:
    """Measures, writes; returns the exit code."""
    trial, bench_gradient = "the first row of each table, two updates", PROGRAMS / "bench_gradient"
    options = Options(__doc__, __name__, trial, bench_gradient).given(arguments)
    content: dict[str, Any] = {
        **heading("costs and choices of gradient", options),
        "versions": {name: str(version) for name, version in versions().items()},
        "costs": costs(options.program, options.quick),
        "values": compared(options.program, VALUE_CHOICES, options.quick),
        "horizons": compared(options.program, HORIZON_CHOICES, options.quick),
    }
    write_page(options.out, PAGE, markdown(content), content)
    return 0
