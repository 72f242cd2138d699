"""Whether vehicles drawn in training make a pendulum's policy robust.

    python -m research run domain_randomization [--seeds 5] [--total-steps N] [--quick]

Policies are trained on the inverted pendulum (`pendulum_learn`), on one vehicle and on vehicles
drawn every 10 episodes: the base's mass, each axis of its inertia and both time constants of each
rotor by +-10, 30 or 50 %. The rotor lag is the same in both. Each policy then flies the same draws,
new ones for every episode, of each spread, and is evaluated by the paper's reward. Finished runs
and evaluations are not repeated, and interrupted ones are resumed. Writes domain_randomization.md
and its JSON.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy import stats
from skybody.program import module_command
from skybody.train.checkpoint import checkpoint_folders, read_meta
from skybody.train.presets import preset

from research.common.machine import machine_line
from research.common.options import Options, heading
from research.common.pages import head, markdown_table, write_page
from research.common.programs import RunError, output_of
from research.common.training_runs import Run, changed_hyper, train_all

PAGE = "domain_randomization"

FIXED, DRAWN = "pendulum_learn", "pendulum_learn_randomized"
SPREADS = (0.1, 0.3, 0.5)
EPISODES, QUICK_EPISODES = 1000, 20
QUICK_STEPS = 40_000
EVALUATION_SEED = 4242
CONFIDENCE = 0.95
# Figure 11 and its text: return with its deviation, on drawn vehicles, and in training.
PAPER = {"fixed": ("440 +- 176", "428 +- 139"), "drawn": ("643 +- 232", "398 +- 130")}
PAPER_REWARD = tuple(
    f"task.parameters.{name}_reward=0" for name in ("approach", "precision", "heading")
)


def drawn_by(spread: float, every: int) -> tuple[str, ...]:
    """Overrides of DRAWN: all its draws by +-`spread`, every `every` episodes."""
    limits = f"[{1.0 - spread:g},{1.0 + spread:g}]"
    return tuple(
        f"randomization[{k}].parameters.{name}={value}"
        for k in range(3)
        for name, value in (("range", limits), ("every", every))
    )


@dataclass(frozen=True)
class Policy:
    """The policy of one seed: trained on one vehicle (spread 0), or on drawn ones."""

    spread: float
    run: Run

    def flies(self) -> list[float]:
        """Spreads of its evaluation; 0: the nominal vehicle."""
        return [0.0, *SPREADS] if self.spread == 0.0 else [self.spread]


def policies(out: Path, seeds: int, total_steps: int) -> list[Policy]:
    """All policies to train, seed after seed. The presets of both scenarios are equal."""
    made = []
    for seed in range(1, seeds + 1):
        for spread in (0.0, *SPREADS):
            run = Run(
                folder=out / f"spread-{round(100 * spread)}-seed-{seed}",
                scenario=FIXED if spread == 0.0 else DRAWN,
                algorithm="fast-ppo",
                seed=seed,
                total_steps=total_steps,
                threads=1,
                overrides=() if spread == 0.0 else drawn_by(spread, every=10),
                checkpoints=4,
                eval_episodes=0,
            )
            made.append(Policy(spread, run))
    return made


def judged(policy: Policy, spread: float, episodes: int) -> dict[str, Any]:
    """The policy's flights on drawn vehicles, saved in its run folder."""
    checkpoint = checkpoint_folders(policy.run.folder)[-1]
    path = policy.run.folder / f"flights-{round(100 * spread)}-{episodes}.json"
    if not path.exists():
        scenario = FIXED if spread == 0.0 else DRAWN
        overrides = PAPER_REWARD + (() if spread == 0.0 else drawn_by(spread, every=1))
        command = module_command("skybody.train.evaluate", str(checkpoint))
        command += ["--scenario", scenario, "--episodes", str(episodes)]
        command += ["--seed", str(EVALUATION_SEED), "--threads", "1"]
        for override in overrides:
            command += ["--override", override]
        part = path.with_suffix(".part")
        output_of([*command, "--json", part])
        part.rename(path)
    flights: dict[str, Any] = json.loads(path.read_text())
    return {
        "return": float(np.mean(flights["returns"])),
        "deviation": float(np.std(flights["returns"])),
        "without_failure": 1.0 - float(np.mean(flights["failed"])),
        "error": float(np.median(flights["position_errors"])),
    }


def difference(a: Sequence[float], b: Sequence[float]) -> tuple[float, float]:
    """Mean of b minus mean of a, and half of its confidence interval (B. L. Welch, 1947).

    Args:
        a: a figure of each of several runs, at least two.
        b: the same of others, independent of the first.
    """
    shares = [float(np.var(x, ddof=1)) / len(x) for x in (a, b)]
    spread = sum(shares)
    gap = float(np.mean(b) - np.mean(a))
    if spread == 0.0:
        return gap, 0.0
    freedom = spread**2 / sum(s**2 / (len(x) - 1) for s, x in zip(shares, (a, b), strict=True))
    return gap, float(stats.t.ppf(0.5 + 0.5 * CONFIDENCE, freedom)) * math.sqrt(spread)


def rows_of(trained: Sequence[Policy], episodes: int) -> list[dict[str, Any]]:
    """For each spread of the flown vehicles: both kinds of policies, seed by seed."""
    rows = []
    for spread in (0.0, *SPREADS):
        row: dict[str, Any] = {"spread": spread}
        for kind in ("fixed", "drawn"):
            row[kind] = [
                judged(policy, spread, episodes)
                for policy in trained
                if spread in policy.flies() and (policy.spread == 0.0) == (kind == "fixed")
            ]
        if row["drawn"]:
            both = [[found["return"] for found in row[kind]] for kind in ("fixed", "drawn")]
            row["difference"], row["half"] = difference(*both)
        rows.append(row)
        print(f"+-{100 * spread:.0f} %: flown", flush=True)
    return rows


def cells(found: Sequence[dict[str, Any]]) -> list[str]:
    """Mean over seeds, deviation over all episodes, share without failure, median error."""
    if not found:
        return [""] * 3
    deviation = math.sqrt(
        np.mean([f["deviation"] ** 2 for f in found]) + np.var([f["return"] for f in found])
    )
    means = {name: np.mean([f[name] for f in found]) for name in found[0]}
    returns = f"{means['return']:.0f} +- {deviation:.0f}"
    return [returns, f"{100 * means['without_failure']:.0f} %", f"{means['error']:.2f}"]


def answer(rows: Sequence[dict[str, Any]]) -> str:
    """The answer in a sentence: the spreads at which the interval of the gain excludes 0."""

    def names(found: Sequence[dict[str, Any]]) -> str:
        return ", ".join(f"+-{100 * row['spread']:.0f} %" for row in found)

    compared = [row for row in rows if row["drawn"]]
    better = [row for row in compared if row["difference"] > row["half"]]
    worse = [row for row in compared if row["difference"] < -row["half"]]
    open_ones = [row for row in compared if abs(row["difference"]) <= row["half"]]
    parts = []
    if better:
        parts.append(f"who was trained on drawn vehicles gets more at {names(better)}")
    if worse:
        parts.append(f"who was trained on one vehicle gets more at {names(worse)}")
    if open_ones:
        parts.append(f"no difference can be told at {names(open_ones)}")
    text = "; ".join(parts)
    return f"{text[0].upper()}{text[1:]}."


def markdown(content: dict[str, Any]) -> str:
    """The page."""
    of_kind = "return | without failure | error [m]"
    names = f"vehicles flown | trained on one: {of_kind} | trained on drawn ones: {of_kind}"
    table = [head(f"{names} | gain by drawing, 95 % interval")]
    for row in content["rows"]:
        name = "nominal" if row["spread"] == 0.0 else f"+-{100 * row['spread']:.0f} %"
        gain = f"{row['difference']:+.0f} +- {row['half']:.0f}" if row["drawn"] else ""
        table.append([name, *cells(row["fixed"]), *cells(row["drawn"]), gain])
    return f"""\
# Drawn vehicles in training

Figure 11 of the GzDRL paper asks whether a policy that is trained on vehicles drawn every 10
episodes balances the inverted pendulum on vehicles that it has not seen better than one that was
trained on one vehicle. Here both have the same rotor lag (the reference's rotors lag only while
vehicles are drawn), by

    {content["command"]}

on {machine_line(content["machine"])}:
{content["seeds"]} seeds of each, {content["total_steps"]:,} steps a run. Base mass, each axis of
the base's inertia and both time constants of each rotor are drawn by the spread that is shown; axes
that no rigid body has are drawn again. Every policy flies the same {content["episodes"]:,} draws,
a new vehicle in each episode.

{answer(content["rows"])}

{markdown_table(table)}

On the nominal vehicle only those fly that were trained on it.

Returns are by the paper's reward, 10 s at most; +- after them is the deviation over all episodes
and seeds. The gain is that of the means of the seeds, its interval Welch's. Error: the bob's median
distance from its target in the last second. `skybody train` trains `pendulum_learn` and
`pendulum_learn_randomized`, whose reward pays for being near, too, with the same hyper-parameters,
those of their presets: {", ".join(content["hyper"])}.

The paper's figures, one spread of 10 %: trained on one vehicle {PAPER["fixed"][0]} on drawn ones
({PAPER["fixed"][1]} while training), trained on drawn ones {PAPER["drawn"][0]}
({PAPER["drawn"][1]} while training). Its rotors lagged in the second kind of training alone.
"""


def main(arguments: list[str] | None = None) -> int:
    """Trains, flies, writes; returns the exit code."""
    options = (
        Options(__doc__, __name__, "2 seeds, short runs, few episodes")
        .of_runs()
        .of_training(5)
        .add("--total-steps", type=float, help="steps of a run; default: the preset's")
        .given(arguments)
    )
    options.seeds = 2 if options.quick else options.seeds
    if options.seeds < 2:
        raise RunError(f"--seeds {options.seeds}: an interval takes 2 at least")
    wanted = options.total_steps or (QUICK_STEPS if options.quick else 0)
    total_steps = int(wanted or preset(FIXED, "fast-ppo").total_steps)
    episodes = QUICK_EPISODES if options.quick else EPISODES
    trained = policies(options.runs, options.seeds, total_steps)
    train_all([policy.run for policy in trained], options.jobs, say)
    content = {
        **heading("vehicles drawn in training", options),
        "seeds": options.seeds,
        "total_steps": total_steps,
        "episodes": episodes,
        "hyper": changed_hyper(trained[0].run.config()),
        "rows": rows_of(trained, episodes),
    }
    write_page(options.out, PAGE, markdown(content), content)
    return 0


def say(run: Run) -> str:
    """One line on a finished run."""
    meta = read_meta(checkpoint_folders(run.folder)[-1])
    return f"{run.folder.name}: {meta['steps']:,} steps, {meta['wall_clock']:.0f} s"
