"""Steps a second by robots in a world (the paper's Table IV).

    python -m research run multi_agent [--quick] [--out docs/results] [--program PROGRAM]

The formation scenarios with their joint observation, with randomization, one thread per
processor. From Python in the paper's batches of 11 and in batches of all, and from C++ by
`skybody bench`; under the reference's constant zero action, and in flight. Then the cost per robot,
with the joint observation and without it. Writes multi_agent.md, data/multi_agent.json and
images/multi_agent.png, with the paper's own figures and ours. Takes about 12 minutes; nothing
else should run during that time.
"""

from __future__ import annotations

import argparse
import dataclasses
import statistics
from typing import Any

from research.common.machine import facts, machine_line, processors
from research.common.options import Options
from research.common.pages import thousands, write_page
from research.common.places import PROGRAM
from research.common.programs import run_bench
from research.common.throughput import FULL, QUICK, Case, Length, measure, summary
from research.common.trials import interval
from research.speed import multi_agent_report, paper_tables

PAGE = "multi_agent"

SCENARIOS = {1: "hover", 2: "formation_2", 5: "formation", 10: "formation_10", 20: "formation_20"}
ENVS = paper_tables.ENVS
BATCHES = (11, ENVS)
# A constant action keeps a robot of drawn mass in the air for a second, not for the scenario's 20.
EPISODES: dict[str, tuple[str, ...]] = {"hold": ("stepping.horizon=1000",), "zero": ()}
MOST = 5.0  # [s]: on Simbody, 10,000 receives would take minutes
QUICK_BENCHES = 2  # runs of `skybody bench`, each of at least half a second
HOVER_RANGE = 2.0 * 1391.0  # [rad/s]: the largest speed for which an action of zero is hover speed
Result = dict[str, Any]


def bench(
    robots: int, threads: int, overrides: tuple[str, ...], options: argparse.Namespace
) -> Result:
    """Figures of `skybody bench` for `robots` robots under a constant action of zero."""
    scenario, seconds, words = SCENARIOS[robots], options.seconds, ("--actions", "zero")
    program = options.program
    return run_bench(
        scenario, seconds, *words, threads=threads, envs=ENVS, overrides=overrides, program=program
    )


def robot_names(robots: int) -> list[str]:
    """Names of the robots in the scenarios."""
    return ["quad"] if robots == 1 else [f"quad{k + 1}" for k in range(robots)]


def in_flight(robots: int) -> tuple[str, ...]:
    """Overrides for `skybody bench`: zero is hover speed, episodes are short."""
    speeds = (
        f"robots.{name}.controllers.motors.parameters.max_speed={HOVER_RANGE:g}"
        for name in robot_names(robots)
    )
    return (*EPISODES["hold"], *speeds)


def without_joint_observation(robots: int) -> str:
    """Override: observation and reward of hover for one of the robots, without ends."""
    parameters = f"robot: {robot_names(robots)[0]}, bound: 1000, tilt_max: 3.1"
    return f"task={{plugin: hover, parameters: {{{parameters}}}}}"


# --- measurements -------------------------------------------------------------------------------


def from_python(length: Length) -> list[Result]:
    """The asynchronous pool: one result per case, printed at once."""
    results = []
    for robots, scenario in SCENARIOS.items():
        for action, overrides in EPISODES.items():
            for batch in BATCHES:
                trials = measure(Case(scenario, ENVS, batch, action, overrides), length)
                found = dataclasses.asdict(summary(trials))
                _say(f"Python, N_B {batch}", robots, action, found)
                results.append(
                    {"robots": robots, "action": action, "batch": batch, "mean": found}
                    | {"trials": [dataclasses.asdict(trial) for trial in trials]}
                )
    return results


def from_cpp(options: argparse.Namespace, trials: int) -> list[Result]:
    """The same without Python, all worlds in one batch."""
    results = []
    for robots in SCENARIOS:
        for action in EPISODES:
            overrides = in_flight(robots) if action == "hold" else ()
            runs = [bench(robots, processors(), overrides, options) for _ in range(trials)]
            rates = [float(run["env_steps_per_second"]) for run in runs]
            found = {"rate": statistics.mean(rates), "interval": interval(rates)}
            _say(f"C++, N_B {ENVS}", robots, action, found)
            near = statistics.mean(float(run["near_share"]) for run in runs)
            results.append(
                {"robots": robots, "action": action, "batch": ENVS, "mean": found}
                | {"near_share": near, "rates": rates}
            )
    return results


def costs(options: argparse.Namespace, trials: int) -> list[Result]:
    """Costs of a robot's step on one thread, in flight [ns]: the minimum of all trials."""
    results = []
    for robots in SCENARIOS:
        short = (*in_flight(robots), without_joint_observation(robots))
        whole = [bench(robots, 1, in_flight(robots), options) for _ in range(trials)]
        rest = [bench(robots, 1, short, options) for _ in range(trials)]
        found = {
            "whole": min(step_cost(run, robots) for run in whole),
            "rest": min(step_cost(run, robots) for run in rest),
            "physics": min(physics_cost(run, robots) for run in (*whole, *rest)),
        }
        print(
            f"{robots:>2} robots: {found['whole']:.0f} ns a robot, {found['rest']:.0f} without "
            f"joint observation and team reward, {found['physics']:.0f} of physics",
            flush=True,
        )
        results.append({"robots": robots} | found)
    return results


def step_cost(run: Result, robots: int) -> float:
    """Cost of an environment step per robot [ns of a thread]."""
    return 1e9 / (float(run["env_steps_per_second_per_thread"]) * robots)


def physics_cost(run: Result, robots: int) -> float:
    """Estimate of `skybody bench` for the physics, per robot [ns of a thread]."""
    return float(run["physics_share"]) * step_cost(run, robots)


def _say(how: str, robots: int, action: str, found: Result) -> None:
    rate = thousands(found["rate"], found["interval"])
    print(f"{how:<14} {robots:>2} robots  {action:>5}  {rate:>20}", flush=True)


def main() -> int:
    """Measures, prints, writes."""
    options = Options(__doc__, __name__, program=PROGRAM).given()
    length = dataclasses.replace(QUICK if options.quick else FULL, most=MOST)
    options.seconds = length.seconds
    content: dict[str, Any] = {"facts": facts(), "length": dataclasses.asdict(length)}
    print(f"{machine_line(content['facts'])}\nthousands of environment steps a second", flush=True)
    content["python"] = from_python(length)
    trials = QUICK_BENCHES if options.quick else length.trials
    content["cpp"] = from_cpp(options, trials)
    content["costs"] = costs(options, trials)

    multi_agent_report.draw(content, options.out / "images/multi_agent.png")
    write_page(options.out, PAGE, multi_agent_report.markdown(content), content)
    return 0
