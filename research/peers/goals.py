"""Goals of Skybody: our rows, the peers' rows to beat, and the required ratios.

Python peers and ours have the same two cores, and each uses its best settings; where a
goal states it, rates are per core. A goal whose peer was not measured here has no ratio.
"""

from __future__ import annotations

from dataclasses import dataclass

from research.peers import results
from research.peers.results import OURS, Row, Test

# The paper's figures in thousands of steps/s, its computer and our goals, by robots per world.
from research.speed.multi_agent_report import FLAT, WORKSTATION, flatness
from research.speed.multi_agent_report import GOALS as FORMATION_GOALS
from research.speed.paper_tables import WORKSTATION as COMPUTER

ROTORPY = 170.0


@dataclass(frozen=True)
class Figure:
    """One line of the table of goals; rates in steps/s."""

    what: str
    ours: float | None
    theirs: float | None
    goal: float
    ratio: float | None
    sense: str = ">="
    of: str = ""  # the rows that were used

    @property
    def verdict(self) -> str:
        if self.ratio is None:
            return "not measured"
        met = self.ratio >= self.goal if self.sense == ">=" else self.ratio <= self.goal
        return "met" if met else "missed"


@dataclass(frozen=True)
class Goal:
    what: str
    ours: Test
    theirs: Test
    goal: float
    by_core: bool = False  # rates over the cores of a row, or with all available cores
    note: str = ""  # origin of the goal, if it is not obvious

    def figure(self, rows: list[Row]) -> Figure:
        best = results.quickest if self.by_core else results.on_all_cores
        own = best(rows, lambda row: row.peer == OURS and self.ours(row))
        other = best(rows, lambda row: row.peer != OURS and self.theirs(row))
        ours, theirs = self.rate(own), self.rate(other)
        return Figure(
            self.what + (", by core" if self.by_core else ""),
            ours,
            theirs,
            self.goal,
            ours / theirs if ours and theirs else None,
            of="; ".join([*(describe(row) for row in (own, other) if row), self.note]).strip("; "),
        )

    def rate(self, row: Row | None) -> float | None:
        if row is None:
            return None
        return row.per_core if self.by_core else row.rate


def describe(row: Row) -> str:
    return f"{row.contestant}: N={row.envs}, K={row.substeps}, {row.mode}"


def python(task: str, several: bool, way: str = "Python") -> Test:
    """Our rows from Python, with one physics step per call or several."""
    return lambda row: row.task == task and row.way == way and (row.substeps > 1) == several


def peer(name: str, task: str, several: bool, mode: str = "") -> Test:
    """A peer's rows with one vehicle per world, on any number of cores."""
    return lambda row: (
        row.peer.lower() == name.lower()
        and row.task == task
        and row.robots == 1
        and row.mode.startswith(mode)
        and (row.substeps > 1) == several
    )


def one_way(
    what: str, name: str, goal: float, task: str = "hover", mode: str = "", several: bool = False
) -> Goal:
    """Each at its best number of environments, with one step per call or several (ours ten)."""
    return Goal(
        f"{what}, {task}, {'several steps' if several else 'one step'} a call",
        python(task, several),
        peer(name, task, several, mode),
        goal,
    )


def both_ways(what: str, name: str, goal: float, task: str = "hover", mode: str = "") -> list[Goal]:
    return [one_way(what, name, goal, task, mode, several) for several in (False, True)]


def rk4_goals() -> list[Goal]:
    """Runge-Kutta against Runge-Kutta: L2F has one thread, RotorPy's batch both cores."""
    return [
        Goal(
            "L2F, RK4 against RK4",
            lambda row: row.way == "rk4" and row.cores == 1,
            lambda row: row.peer.lower() == "l2f" and row.task == "hover",
            3.0,
            by_core=True,
        ),
        Goal(
            "RotorPy, RK4 against RK4",
            lambda row: row.way == "rk4",
            lambda row: row.peer == "RotorPy" and row.is_rk4,
            ROTORPY,
            note="no goal of its own: that of one step a call",
        ),
    ]


def cpp(robots: int) -> Test:
    return lambda row: row.way == "C++" and row.robots == robots


def at(test: Test, envs: int) -> Test:
    return lambda row: row.envs == envs and test(row)


def cpp_goals() -> list[Goal]:
    def theirs(robots: int, *names: str) -> Test:
        return lambda row: row.peer in names and row.robots == robots

    both = ("mujoco_cpp", "bullet_cpp")
    return [
        Goal("C++ step, 1 robot: MuJoCo's mj_step", cpp(1), theirs(1, both[0]), 20.0, True),
        Goal("C++ step, 1 robot: Bullet's stepSimulation", cpp(1), theirs(1, both[1]), 10.0, True),
        Goal("C++ step, 20 robots: the quicker of both", cpp(20), theirs(20, *both), 3.0, True),
    ]


def python_goals() -> list[Goal]:
    found = []
    for what, name, mode in (("mjbatch", "mjbatch", ""), ("MuJoCo rollout", "MuJoCo", "rollout")):
        found += both_ways(what, name, 28.0, "hover", mode)
        found += both_ways(what, name, 12.0, "payload", mode)
        found.append(
            Goal(
                f"{what}, payload as shipped (noisy IMU, drawn constants)",
                python("payload", False, "as shipped"),
                peer(name, "payload", False, mode),
                12.0,
            )
        )
    found += both_ways("Crazyflow", "Crazyflow", 2.5)
    one_step = peer("Crazyflow", "hover", False)
    found.append(
        Goal("Crazyflow at N=1024, K=1", at(python("hover", False), 1024), at(one_step, 1024), 12.0)
    )
    found.append(one_way("PyBullet", "PyBullet", 90.0))
    found += both_ways("gym-pybullet-drones", "gym-pybullet-drones", 380.0)
    found.append(one_way("RotorPy", "RotorPy", ROTORPY))
    found += rk4_goals()
    found.append(
        Goal(
            "EnvPool's cheapest environment, N=1024",
            at(python("engine", False), 1024),
            at(peer("EnvPool", "engine", False), 1024),
            50.0,
        )
    )
    return found


def formation_figure(rows: list[Row], robots: int, way: str) -> Figure:
    """Against the paper's workstation: total rates, 32 environments with joint observation."""
    computer = f"the paper's {COMPUTER.name} ({COMPUTER.cores} cores)"
    own = results.on_all_cores(
        rows, lambda row: row.peer == OURS and row.robots == robots and row.way == way
    )
    theirs = 1e3 * WORKSTATION[robots]
    return Figure(
        f"formation, {robots} robots, from {way}: {computer}",
        own.rate if own else None,
        theirs,
        FORMATION_GOALS[robots],
        own.rate / theirs if own else None,
        of=describe(own) if own else "",
    )


def flat_figure(rows: list[Row]) -> Figure:
    """The largest cost per robot from 2 to 20 robots per world over the smallest, without the
    observation of all others.
    """
    short = [row for row in rows if row.way == "C++, no joint observation"]
    costs = {row.robots: 1.0 / (row.robots * row.per_core) for row in short}
    whole = set(WORKSTATION) <= set(costs)
    each = [{"robots": robots, "cost": cost} for robots, cost in costs.items()]
    ratio = flatness(each, "cost") if whole else None
    listed = ", ".join(f"{robots}: {1e9 * costs[robots]:.0f} ns" for robots in sorted(costs))
    return Figure(
        "cost of a robot, 2 to 20, apart from the joint observation: the dearest by the least",
        None,
        None,
        FLAT,
        ratio,
        "<=",
        listed,
    )


def figures(rows: list[Row]) -> list[Figure]:
    """The whole table."""
    found = [goal.figure(rows) for goal in (*cpp_goals(), *python_goals())]
    for way in ("C++", "Python"):
        found += [formation_figure(rows, robots, way) for robots in WORKSTATION]
    return [*found, flat_figure(rows)]
