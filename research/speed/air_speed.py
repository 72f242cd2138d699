"""Cost of effects of air and actuators on hover, and of requests relative to a respawn.

    python -m research run air_speed [--quick] [--out DIR]

Rates are physics steps per second of all environments on one core, in one run.
"""

from __future__ import annotations

import re
import statistics
import sys
import tempfile
import textwrap
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import skybody
from skybody.requests import Draw

from research.common.machine import facts, machine_line
from research.common.options import Options
from research.common.pages import head, markdown_table, thousands, write_page
from research.common.places import RESULTS, ROOT
from research.common.programs import run_bench
from research.common.throughput import ACTIONS
from research.common.trials import in_turns

ENVS = 512
DRAG = "{plugin: body_drag, parameters: {linear: [0.1, 0.1, 0.2], quadratic: [0.02, 0.02, 0.03]}}"
DRYDEN = "{plugin: dryden, parameters: {period: 10}}"
BATTERY = "{plugin: battery}"
TOGETHER = "body_drag, dryden and battery"
PAGE = "air_speed"


def effects(table: Path) -> dict[str, str]:
    """Each effect by itself, active, as a value of `effects`; and the effects of the goal.

    @param table  CSV of wind
    """
    alone = {
        "battery": BATTERY,
        "blade_flapping": "{plugin: blade_flapping, parameters: "
        "{flapping: 1e-5, axial_drag: 1e-5, translational_lift: 1e-3}}",
        "body_drag": DRAG,
        "ceiling_effect": "{plugin: ceiling_effect, parameters: {height: 4, radius: 0.1}}",
        "downwash": "{plugin: downwash, parameters: {radius: 0.1}}",
        "dryden": DRYDEN,
        "ground_effect": "{plugin: ground_effect, parameters: {radius: 0.1}}",
        "motor": "{plugin: motor, parameters: "
        "{torque_constant: 0.0055, resistance: 0.1, max_current: 30, voltage: 16.8}}",
        "rotor_failure": "{plugin: rotor_failure, parameters: {earliest: 0.1, latest: 0.4}}",
        "thrust_curve": "{plugin: thrust_curve, parameters: {thrust: [0, 0, 1.9533e-6], "
        "thrust_by_advance: [-0.4, -0.5], diameter: 0.2}}",
        "wind": "{plugin: wind, parameters: {velocity: [2, 1, 0], gust_speed: 3}}",
        "wind_table": f"{{plugin: wind_table, parameters: {{file: {table}, loop: true}}}}",
    }
    cases = {name: f"[{effect}]" for name, effect in alone.items()}
    return cases | {TOGETHER: f"[{DRAG}, {DRYDEN}, {BATTERY}]"}


BASES = ("hover", "formation_2")  # without effects
# Scenarios for effects that are not active in `hover`.
SCENARIOS = {"downwash": "formation_2"}


def base_of(name: str) -> str:
    """The row with the same scenario without effects."""
    return SCENARIOS.get(name, "hover")


def rates(trials: int, seconds: float) -> dict[str, list[float]]:
    """Rates of the scenarios without effects, and with each of effects()."""
    with tempfile.TemporaryDirectory() as folder:
        table = Path(folder) / "wind.csv"
        table.write_text("t,x,y,z\n0,0,0,0\n1,3,1,0.2\n2,0,0,0\n")
        cases = dict.fromkeys(BASES, "[]") | effects(table)

        def rate(name: str) -> float:
            scenario = name if name in BASES else base_of(name)
            overrides = [f"effects={cases[name]}"]
            bench = run_bench(scenario, seconds, envs=ENVS, overrides=overrides)
            return float(bench["physics_steps_per_second"])

        return in_turns(list(cases), trials, rate)


# --- requests ---------------------------------------------------------------------------------

WORLD = "payload"  # vehicle and bob are drawn
MASS = "robots.quad.links.base_link.mass"
ROUND, QUICK_ROUND = 100, 5  # steps of all environments between two readings of the clock


def seconds_a_step(pool: skybody.Pool, steps: int, before: Callable[[], None]) -> float:
    """The minimum of five rounds: other processes only add time [s, for all environments]."""
    rows = np.full((ENVS, pool.compiled.action_size), ACTIONS["hold"], np.float32)
    least = np.inf
    for _ in range(5):
        start = time.perf_counter()
        for _ in range(steps):
            before()
            pool.step(rows)
        least = min(least, (time.perf_counter() - start) / steps)
    return float(least)


def respawn_seconds() -> float:
    """The paper's respawn here: the model built anew, on Simbody, and three steps [s]."""
    least = np.inf
    for seed in range(5):
        start = time.perf_counter()
        compiled = skybody.CompiledScenario(
            WORLD, overrides=["stepping.dynamics=simbody", "stepping.action_repeat=1"]
        )
        simulation = skybody.Simulation(compiled, seed=seed)
        simulation.reset()
        for _ in range(3):
            simulation.step(np.zeros(compiled.action_size, np.float32))
        least = min(least, time.perf_counter() - start)
    return float(least)


def request_costs(steps: int) -> dict[str, float]:
    """Costs for one environment [s].

    @param steps  of a round
    """
    compiled = skybody.CompiledScenario(WORLD)
    nominal = float(compiled.param_info(MASS)[0])
    draw = {MASS: Draw(range=(0.99, 1.01), form="scale")}
    with skybody.make_pool(compiled, ENVS, num_threads=1, seed=1, infos=False) as pool:
        pool.reset()
        seconds_a_step(pool, steps, lambda: None)  # warms up
        step = seconds_a_step(pool, steps, lambda: None)
        value = seconds_a_step(pool, steps, lambda: pool.request(None, {MASS: nominal}))
        drawn = seconds_a_step(pool, steps, lambda: pool.request(None, draw))
        redrawn = seconds_a_step(pool, steps, lambda: pool.randomize(None))
        # drawn vehicles, other episodes
        step = max(step, seconds_a_step(pool, steps, lambda: None))
    return {
        "step": step / ENVS,
        "value": (value - step) / ENVS,
        "draw": (drawn - step) / ENVS,
        "redraw": (redrawn - step) / ENVS,
        "respawn": respawn_seconds(),
    }


def page(found: dict[str, Any]) -> str:
    median = {name: statistics.median(rates) for name, rates in found["rates"].items()}
    rows = [head("effects | steps/s | of it without | ns a step")]
    for name, rate in median.items():
        if name in BASES:
            rows.append([f"{name} without", thousands(rate), "", ""])
            continue
        base = median[base_of(name)]
        cost = f"{1e9 / rate - 1e9 / base:.0f}"
        rows.append([name, thousands(rate), f"{rate / base:.2f}", cost])
    costs = found["requests"]
    what = {
        "step": "an action: 10 physics steps, reward, observation",
        "value": "request of a value (mass), besides",
        "draw": "request of a draw of it, besides",
        "redraw": "`randomize`: all that its randomizers draw, besides",
        "respawn": "respawn: the model read and built anew on Simbody, 3 physics steps",
    }
    table = [["for one environment", "us"]]
    table += [[text, f"{1e6 * costs[key]:,.2f}"] for key, text in what.items()]
    return f"""# Speed in the air: effects and requests

{machine_line(found["facts"])}

    .venv/bin/python -m research run air_speed

Thousands of physics steps a second of `hover` as it is shipped (K = 1), {ENVS} environments on one
core, median of {found["trials"]} trials of {found["seconds"]:g} s, in one run. Each effect has
something to do: what it is given stands in the script. `dryden` makes a new value each 10 ms,
`downwash` is measured on `formation_2`.

{markdown_table(rows)}

## Requests

World `{WORLD}`, {ENVS} environments, one thread, from Python, the least of five rounds of
{found["round"]} steps. A new mass or inertia makes the vehicle's constants anew. The GzDRL paper
respawns the model for that, which takes it three physics steps; here is what the same takes with
Simbody in Gazebo's place.

{markdown_table(table)}
"""


COST = re.compile(r"^Cost on .* in lanes: (?:.+\n)+", re.MULTILINE)  # a paragraph


def write_costs(found: dict[str, Any]) -> None:
    """Writes the cost of each effect into its README."""
    median = {name: statistics.median(rates) for name, rates in found["rates"].items()}
    for readme in sorted((ROOT / "effects").glob("*/README.md")):
        name = readme.parent.name
        rate, base = median[name], median[base_of(name)]
        cost = (
            f"Cost on `{base_of(name)}` in lanes: {1e9 / rate - 1e9 / base:.0f} ns per physics "
            f"step and environment, {rate / base:.2f} of the speed without it "
            f"([measured](../../docs/results/{PAGE}.md))."
        )
        paragraph = textwrap.fill(cost, 100, break_long_words=False, break_on_hyphens=False) + "\n"
        text = readme.read_text()
        if COST.search(text) is None:
            sys.exit(f"{readme} has no line `Cost on SCENARIO in lanes: `")
        readme.write_text(COST.sub(lambda _, paragraph=paragraph: paragraph, text))


def main() -> int:
    options = Options(__doc__, __name__).given()
    trials, seconds, steps = (1, 0.05, QUICK_ROUND) if options.quick else (3, 2.0, ROUND)
    found: dict[str, Any] = {
        "facts": facts(),
        "trials": trials,
        "seconds": seconds,
        "round": steps,
        "rates": rates(trials, seconds),
        "requests": request_costs(steps),
    }
    write_page(options.out, PAGE, page(found), found)
    if options.out == RESULTS:
        write_costs(found)
    return 0
