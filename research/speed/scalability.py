"""Steps a second by number of environments (the paper's Table III).

    python -m research run scalability [--quick] [--out docs/results]

N_B = N_E / 3 and N_B = N_E, on min(N_E, processors) threads, under the reference's constant zero
action and under hover speed (hold), on the tree dynamics and on Simbody; then the paper's baselines
(baselines.py). Writes scalability.md, data/scalability.json and images/scalability.png, with
the paper's own figures and ours. Takes about 12 minutes; nothing else should run during that time.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np
import skybody

from research.common.machine import facts, machine_line
from research.common.options import Options
from research.common.pages import thousands, write_page
from research.common.throughput import ACTIONS, FULL, QUICK, Case, Length, measure, summary
from research.common.trials import interval
from research.speed import baselines, paper_tables

PAGE = "scalability"

SCENARIO = "hover"
COUNTS = (*paper_tables.COUNTS, 1_024, 16_384)
QUICK_COUNTS = (1, 8, 64, 1_024)
DYNAMICS: dict[str, tuple[str, ...]] = {"tree": (), "simbody": ("stepping.dynamics=simbody",)}
SIMBODY_MOST = 1.0  # [s]: 10,000 receives of 128 environments at 10 us a step would take minutes
EPISODE_ENVS = 64
Result = dict[str, Any]


def batches(envs: int) -> tuple[int, ...]:
    """N_B of the paper, and N_E."""
    return tuple(dict.fromkeys((max(1, envs // 3), envs)))


def cases(counts: Sequence[int]) -> list[tuple[str, Case]]:
    """Cases with their dynamics; Simbody up to the paper's largest number of environments."""
    return [
        (dynamics, Case(SCENARIO, envs, batch, action, overrides))
        for dynamics, overrides in DYNAMICS.items()
        for envs in counts
        if dynamics == "tree" or envs <= max(paper_tables.COUNTS)
        for batch in batches(envs)
        for action in ACTIONS
    ]


def run_pool(counts: Sequence[int], length: Length) -> list[Result]:
    """The asynchronous pool: one result per case, printed at once."""
    results = []
    for dynamics, case in cases(counts):
        limit = min(length.most, SIMBODY_MOST) if dynamics == "simbody" else length.most
        trials = measure(case, dataclasses.replace(length, most=limit))
        found = summary(trials)
        print(
            f"pool {dynamics:>8} {case.action:>5}  N_E {case.envs:>6,}  N_B {case.batch:>6,}"
            f"  {thousands(found.rate, found.interval):>20}  CPU {100 * found.cpu_use:3.0f} %",
            flush=True,
        )
        results.append(
            {"dynamics": dynamics, "threads": case.threads}
            | dataclasses.asdict(case)
            | {"mean": dataclasses.asdict(found)}
            | {"trials": [dataclasses.asdict(trial) for trial in trials]}
        )
    return results


def run_baselines(counts: Sequence[int], trials: int, seconds: float) -> list[Result]:
    """The paper's other ways of stepping N worlds."""
    results = []
    for envs in counts:
        for way, make in baselines.WAYS.items():
            found = baselines.measure(make, envs, trials, seconds)
            rate, half = float(np.mean(found.rates)), interval(found.rates)
            print(
                f"{way:>9}  N {envs:>4}  {thousands(rate, half):>20}"
                f"  CPU {100 * found.cpu_use:3.0f} %",
                flush=True,
            )
            mean = {"rate": rate, "interval": half, "cpu_use": found.cpu_use}
            results.append({"way": way, "envs": envs, "mean": mean, "rates": found.rates})
    return results


def reset_share(action: str) -> float:
    """Share of rows that begin an episode, over the length of the longest one."""
    with skybody.make_pool(SCENARIO, EPISODE_ENVS, infos=False) as pool:
        pool.reset()
        rows = np.full((EPISODE_ENVS, pool.compiled.action_size), ACTIONS[action], np.float32)
        receives = pool.compiled.horizon + 1
        begun = 0
        for _ in range(receives):
            pool.send(rows)
            begun += int(pool.recv()[4]["was_reset"].sum())
    return begun / (receives * EPISODE_ENVS)


def main() -> int:
    """Measures, prints, writes."""
    options = Options(__doc__, __name__).given()
    length = QUICK if options.quick else FULL
    counts = QUICK_COUNTS if options.quick else COUNTS
    content: dict[str, Any] = {"facts": facts(), "length": dataclasses.asdict(length)}
    content["length"]["simbody_most"] = SIMBODY_MOST
    print(f"{machine_line(content['facts'])}\nthousands of environment steps a second", flush=True)
    content["pool"] = run_pool(counts, length)
    small = [envs for envs in counts if envs <= max(paper_tables.COUNTS)]
    content["baselines"] = run_baselines(small, length.trials, length.seconds)
    content["reset_share_envs"] = EPISODE_ENVS
    content["reset_share"] = {action: reset_share(action) for action in ACTIONS}

    from research.speed import scalability_report  # Matplotlib: not in processes that are spawned

    scalability_report.draw(content, options.out / "images/scalability.png")
    write_page(options.out, PAGE, scalability_report.markdown(content), content)
    return 0
