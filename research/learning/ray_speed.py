"""Cost of learning on Ray's workers relative to one process.

`fast-ppo` on Ray's workers and in one process, all on this machine.

    .peers/ray/bin/python -m research run ray_speed [--turns 3] [--out DIR]

`./dev ray` installs that Python. Environment steps per second of whole iterations (rollout, update,
and with workers the state of every slice, which the driver fetches after each), the settings in
turns. All must end with the same parameters, otherwise this fails. Writes ray_speed.md and its
JSON.
"""

from __future__ import annotations

import statistics
import time
from dataclasses import dataclass
from typing import Any

from skybody import CompiledScenario
from skybody.ray.cluster import LOCAL, ClusterError, cluster
from skybody.ray.slices import MOST_SLICES, RaySlices, Setup
from skybody.train.native_learners import FastPpo
from skybody.train.presets import Preset, told

from research.common.machine import facts, machine_line
from research.common.options import Options
from research.common.pages import markdown_table, write_page

PAGE = "ray_speed"

SCENARIO = "hover_learn"
WORKERS = (1, 2, 4)
SEED = 1


@dataclass(frozen=True)
class Work:
    """A training task."""

    name: str
    settings: tuple[str, ...] = ()
    overrides: tuple[str, ...] = ()
    iterations: int = 8

    def compiled(self) -> CompiledScenario:
        return CompiledScenario(SCENARIO, list(self.overrides))

    def told(self, compiled: CompiledScenario) -> Preset:
        return told(SCENARIO, "fast-ppo", compiled, self.settings)


WORKS = (
    Work("as shipped", iterations=15),
    Work("ten physics steps for one", overrides=("stepping.dt=1e-4", "stepping.action_repeat=200")),
    Work("layers of [512, 512]", ("hidden=512,512", "minibatch=4096"), iterations=3),
)


@dataclass(frozen=True)
class Turn:
    """One run: its rate, and its parameters."""

    rate: float  # environment steps per second
    parameters: str


def timed(learner: FastPpo, iterations: int) -> Turn:
    """Times the iterations after a first, uncounted one, which allocates memory."""
    learner.iterate()
    before, begin = learner.steps, time.perf_counter()
    for _ in range(iterations):
        learner.iterate()
    rate = (learner.steps - before) / (time.perf_counter() - begin)
    return Turn(rate, f"{learner.native_hash:016x}")


def at_home(work: Work, threads: int) -> Turn:
    """Runs it in this process."""
    compiled = work.compiled()
    given = work.told(compiled)
    return timed(FastPpo(compiled, given.hyper, SEED, threads, given.total_steps), work.iterations)


def on_workers(work: Work, workers: int, ray: Any) -> Turn:
    """Runs it on that many workers, of one thread each."""
    compiled = work.compiled()
    given = work.told(compiled)
    setup = Setup(
        scenario=SCENARIO,
        overrides=list(work.overrides),
        plugin_path=[],
        scenario_hash=f"{compiled.scenario_hash:016x}",
        hyper=dict(vars(given.hyper)),
        seed=SEED,
        total_steps=given.total_steps,
    )
    slices = RaySlices(ray, setup, MOST_SLICES, workers, 1)
    try:
        return timed(
            FastPpo(compiled, given.hyper, SEED, 1, given.total_steps, slices), work.iterations
        )
    finally:
        for worker in slices.workers:
            ray.kill(worker)


def settings_of(processors: int) -> list[str]:
    """The compared settings, in the order of the table; the first is the reference."""
    home = [f"one process, {n} thread{'s' * (n > 1)}" for n in sorted({1, processors})]
    return home + [f"{n} worker{'s' * (n > 1)} of one thread" for n in WORKERS]


def turn(work: Work, processors: int, ray: Any) -> list[Turn]:
    """A run of each setting."""
    home = [at_home(work, threads) for threads in sorted({1, processors})]
    return home + [on_workers(work, workers, ray) for workers in WORKERS]


def figures(work: Work, names: list[str], turns: list[list[Turn]]) -> dict[str, Any]:
    """Medians over the turns of a task. Raises ClusterError if the settings do not agree."""
    found = {one.parameters for of_turn in turns for one in of_turn}
    if len(found) > 1:
        raise ClusterError(f"{work.name}: different parameters: {', '.join(sorted(found))}")
    rates = {name: [of_turn[k].rate for of_turn in turns] for k, name in enumerate(names)}
    return {
        "work": work.name,
        "settings": list(work.settings),
        "overrides": list(work.overrides),
        "iterations": 1 + work.iterations,
        "parameters": found.pop(),
        "rates": rates,
        "medians": {name: statistics.median(values) for name, values in rates.items()},
    }


def measured(turns: int) -> dict[str, Any]:
    """All figures, and facts about the machine."""
    content = {**facts(), "turns": turns}
    processors = content["cores"]
    names = settings_of(processors)
    with cluster(LOCAL, max(WORKERS)) as ray:
        content["ray"] = ray.__version__
        content["rows"] = [
            figures(work, names, [turn(work, processors, ray) for _ in range(turns)])
            for work in WORKS
        ]
    return content


def page(content: dict[str, Any]) -> str:
    """The page."""
    names = list(content["rows"][0]["medians"])
    rows = [[SCENARIO, *names, "parameters"]]
    for row in content["rows"]:
        own = row["medians"][names[0]]
        cells = [
            f"{row['medians'][name]:,.0f} ({row['medians'][name] / own:.2f})" for name in names
        ]
        rows.append([row["work"], *cells, f"`{row['parameters']}`"])
    works = "\n".join(
        f"- {row['work']}: "
        + (", ".join(f"`{text}`" for text in [*row["settings"], *row["overrides"]]) or "the preset")
        + f"; {row['iterations']} iterations"
        for row in content["rows"]
    )
    return f"""# One policy on Ray's workers, beside one process

    python -m research run ray_speed --turns {content["turns"]}

on {machine_line(content)}; Ray {content["ray"]}.

Environment steps a second of `fast-ppo`'s whole iterations, medians of {content["turns"]} turns,
and in brackets how many times the first column's. At their ends all have the same parameters, whose
hash is the last column.

{markdown_table(rows)}

{works}

All workers are on this machine, whose cores they share with one another and with the driver: what
is to be read here is what the way over Ray costs. A minibatch is a question and an answer of every
worker, and after an iteration the driver fetches every word of every slice, lest a worker dies. The
more an iteration computes, the less that weighs ([ray.md](../ray.md)).
"""


def main() -> int:
    """Measures, writes; returns the exit code."""
    options = (
        Options(__doc__, __name__)
        .add("--turns", type=int, metavar="N", help="default: 3, with --quick 1")
        .given()
    )
    turns = options.turns or (1 if options.quick else 3)
    content = measured(turns)
    write_page(options.out, PAGE, page(content), content)
    return 0
