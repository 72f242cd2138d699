"""Page and picture of multi_agent.py."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from research.common.machine import machine_line
from research.common.pages import markdown_table, percent, thousands
from research.common.plots import save
from research.speed import paper_tables
from research.speed.paper_tables import ROBOTS
from research.speed.throughput_plot import curve, two_panels

Result = dict[str, Any]
GOALS = dict(zip(ROBOTS, (300.0, 250.0, 200.0, 150.0), strict=True))  # times the workstation's row
WORKSTATION = dict(zip(ROBOTS, paper_tables.GAZEBO_POOL_WORKSTATION.rates, strict=True))
FLAT = 1.25  # the largest cost of a robot over the smallest, 2 to 20 in a world

HEAD = """\
# Several robots in a world: the paper's Table IV and figure 8

Written by `research/speed/multi_agent.py`; all trials are in data/multi_agent.json.
{machine}.

![Throughput and processor use over the number of robots](images/multi_agent.png)

{envs} environments, one thread per processor, one physics step of 1 ms an action, four commands a
robot: `formation_2`, `formation`, `formation_10` and `formation_20` with the joint observation,
N x (18 + 16 (N - 1)) values, randomization left on; for one robot `hover`. Thousands of
environment steps a second, where **a world counts once however many robots fly in it**, mean and
95 % Student's t interval over {trials} trials.

## Table IV

**The paper's rows are its own figures, from other computers**: {paper}.
Ours are from {processors} cores."""

PROTOCOL = """\
- `hold`: hover speed, in episodes of 1 s (`stepping.horizon=1000`), so that all robots are in
  flight: a constant action does not keep robots of drawn masses in the air for the scenario's 20 s.
- `zero`: the reference's constant action, 68 % of the thrust that hovers, and the scenario as
  shipped: robots fall from up to 11 m, bounce and come to rest on the ground or on each other.
  Steps in contact are dearer than steps in the air: rates depend on how far into the episodes a
  trial gets, and the C++ rows are measured when all have come down.
- Python: `make_pool` as in [scalability.md](scalability.md), {warm_up:,} receives of warm-up and
  {receives:,} measured, or {seconds:g} s where that is longer; {most:g} s each at most. The warm-up
  of the reference's code is N_E times as long.
- C++: `skybody bench --actions zero`, {seconds:g} s after {cpp_warm_up:g} s of warm-up; for `hold`
  the range of rotor speeds is set so that hover speed lies in its middle. Rows that begin an
  episode are not counted."""

GOAL_HEAD = """\
## Times the paper's workstation row"""

COST_HEAD = """\
## What a robot costs

A robot's share of an environment step on one thread, in flight, {envs} environments, the least of
{trials} trials [ns]. The second row has observation and reward of `hover` for one of the robots in
place of the joint observation and the team's reward. The third is what `skybody bench` estimates of
physics alone: rotors, bodies, ground. Goal: flat within 25 % from 2 to 20 robots, apart from the
observation; {verdict}."""


@dataclass(frozen=True)
class Row:
    """One of our rows in Table IV: a result by number of robots."""

    name: str
    results: dict[int, Result]

    def rate(self, robots: int) -> float:
        """[steps/s]"""
        return float(self.results[robots]["mean"]["rate"])


def markdown(content: dict[str, Any]) -> str:
    """The whole page."""
    length, envs = content["length"], paper_tables.ENVS
    head = HEAD.format(
        machine=machine_line(content["facts"]),
        envs=envs,
        trials=length["trials"],
        paper=paper_tables.machines_line(),
        processors=content["facts"]["cores"],
    )
    cost_head = COST_HEAD.format(envs=envs, trials=length["trials"], verdict=verdict(content))
    parts = [
        head,
        markdown_table(rate_rows(content)),
        PROTOCOL.format(cpp_warm_up=min(1.0, length["seconds"]), **length),
        "Physics steps with something near enough to touch, in the C++ rows' runs [%]:",
        markdown_table(near_rows(content)),
        "Processor use of the Python rows, and thousands of receives and of environment steps that "
        "a trial\nmeasured:",
        markdown_table(measured_rows(content)),
        GOAL_HEAD,
        markdown_table(goal_rows(content)),
        cost_head,
        markdown_table(cost_rows(content)),
    ]
    return "\n\n".join(parts) + "\n"


# --- tables -------------------------------------------------------------------------------------


def our_rows(content: dict[str, Any]) -> list[Row]:
    """Our rows by language, batch and action."""
    rows: dict[str, dict[int, Result]] = {}
    for language, key in (("Python", "python"), ("C++", "cpp")):
        for r in content[key]:
            name = f"{language}, N_B = {r['batch']}, {r['action']}"
            rows.setdefault(name, {})[r["robots"]] = r
    return [Row(name, results) for name, results in rows.items()]


def rate_rows(content: dict[str, Any]) -> list[list[str]]:
    """Table IV: ours, then the paper's."""
    ours = our_rows(content)
    counts = list(ours[0].results)
    rows = [["", *(f"N_A = {n}" for n in counts)]]
    for row in ours:
        means = [row.results[n]["mean"] for n in counts]
        rows.append([row.name, *(thousands(m["rate"], m["interval"]) for m in means)])
    for paper in paper_tables.TABLE_4:
        rates = dict(zip(ROBOTS, paper.rates, strict=True))
        cells = [f"{rates[n]:.2f}" if n in rates else "" for n in counts]
        rows.append([f"the paper's {paper.computer}: {paper.name}", *cells])
    return rows


def goal_rows(content: dict[str, Any]) -> list[list[str]]:
    """Ratios of ours to the paper's workstation row, and the goal."""
    rows = [["", *(f"N_A = {n}" for n in ROBOTS)]]
    rows.append(["goal", *(f">= {GOALS[n]:g}" for n in ROBOTS)])
    rows += [[row.name, *(_goal_cell(row, n) for n in ROBOTS)] for row in our_rows(content)]
    return rows


def _goal_cell(row: Row, robots: int) -> str:
    ratio = row.rate(robots) / (1e3 * WORKSTATION[robots])
    return f"{ratio:.0f} {'met' if ratio >= GOALS[robots] else 'missed'}"


def near_rows(content: dict[str, Any]) -> list[list[str]]:
    """Share of physics steps of the C++ rows with contact detection."""
    ours = [row for row in our_rows(content) if row.name.startswith("C++")]
    counts = list(ours[0].results)
    rows = [["", *(f"N_A = {n}" for n in counts)]]
    for row in ours:
        shares = [100.0 * float(row.results[n]["near_share"]) for n in counts]
        rows.append([row.name, *(f"{share:.4g}" for share in shares)])
    return rows


def measured_rows(content: dict[str, Any]) -> list[list[str]]:
    """Processor use, receives and steps of the Python rows."""
    ours = [row for row in our_rows(content) if row.name.startswith("Python")]
    counts = list(ours[0].results)
    rows = [["CPU [%]; receives; steps", *(f"N_A = {n}" for n in counts)]]
    for row in ours:
        means = [row.results[n]["mean"] for n in counts]
        cells = [
            (percent(m["cpu_use"]), *map(thousands, (m["receives"], m["steps"]))) for m in means
        ]
        rows.append([row.name, *map("; ".join, cells)])
    return rows


COSTS = {
    "whole": "whole step",
    "rest": "without joint observation and team reward",
    "physics": "physics alone",
}


def cost_rows(content: dict[str, Any]) -> list[list[str]]:
    """[ns] by number of robots; the last column is the flatness of the row."""
    by_robots = {r["robots"]: r for r in content["costs"]}
    rows = [["", *(f"N_A = {n}" for n in by_robots), "most by least, 2 to 20"]]
    for key, name in COSTS.items():
        cells = [f"{by_robots[n][key]:.1f}" for n in by_robots]
        rows.append([name, *cells, f"{flatness(content['costs'], key):.2f}"])
    return rows


def flatness(costs: Sequence[Result], key: str) -> float:
    """The largest cost per robot over the smallest, from 2 to 20 robots."""
    found = [float(r[key]) for r in costs if r["robots"] in ROBOTS]
    return max(found) / min(found)


def verdict(content: dict[str, Any]) -> str:
    """Whether the goal is met, for the physics and for the step without joint observation."""
    words = []
    for key, name in (("physics", "physics alone"), ("rest", "the rest of the step")):
        met = flatness(content["costs"], key) <= FLAT
        words.append(f"{'met' if met else 'missed'} by {name}")
    return ", ".join(words)


# --- the picture --------------------------------------------------------------------------------

OUR_LOOKS = {"hold": "-", "zero": ":"}
OUR_COLORS = {("Python", 11): "C0", ("Python", 32): "C9", ("C++", 32): "C2"}
PAPER_COLORS = {
    "GzDRL (GazeboPool)": "black",
    "OmniDrones": "C1",
    "Aerial Gym": "C3",
    "PyBullet-Drones": "C4",
}
PAPER_LOOKS = {"workstation": ("*", "--"), "laptop": ("P", ":")}


def draw(content: dict[str, Any], out: Path) -> None:
    """Throughput above processor use, over the number of robots: figure 8."""
    found = content["facts"]
    title = f"{paper_tables.ENVS} environments; ours: {found['cores']} cores of "
    title += f"{found['processor']}; the paper's:"
    ticks = [r["robots"] for r in content["costs"]]
    figure, (rates, use) = two_panels(title, "robots in a world N_A", ticks, 10)
    for row in our_rows(content):
        first = next(iter(row.results.values()))
        color = OUR_COLORS[row.name.partition(",")[0], first["batch"]]
        means = [result["mean"] for result in row.results.values()]
        look = {"color": color, "linestyle": OUR_LOOKS[first["action"]]}
        curve((rates, use), list(row.results), means, row.name, **look)
    for paper in paper_tables.TABLE_4:
        marker, line = PAPER_LOOKS[paper.computer]
        look = {"color": PAPER_COLORS[paper.name], "marker": marker, "linestyle": line}
        label = f"the paper's {paper.computer}: {paper.name}"
        rates.plot(ROBOTS, [1e3 * r for r in paper.rates], lw=0.8, alpha=0.8, label=label, **look)
    wanted = [1e3 * GOALS[n] * WORKSTATION[n] for n in ROBOTS]
    label = "goal: 300, 250, 200, 150 times the workstation"
    rates.plot(ROBOTS, wanted, "_", color="0.4", markersize=16, label=label)
    figure.legend(loc="outside lower center", ncols=2, fontsize=8)
    save(figure, out)
