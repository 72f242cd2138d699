"""Figures of the paper's tables and figures, read from the data of result pages.

Each function takes the folder of the results, docs/results, and returns one number.
"""

from __future__ import annotations

import json
import re
import statistics
from itertools import pairwise
from pathlib import Path
from typing import Any

from research.common.places import ROOT

PAPER_SIZES = (1, 4, 8, 16, 32, 64, 128)  # environments of figure 7
FASTEST = {2: 35_520.0, 5: 17_820.0, 10: 8_100.0, 20: 5_530.0}  # Table IV, workstation [steps/s]
BATCH = 11  # N_B of 32 environments in Table IV
FOREIGN = ("mujoco", "bullet", "rotorpy")
FEATURES = {  # of Table I's last row, and a file of each here
    "runtime randomization": "randomization/vehicle_constants",
    "synchronous stepping": "core/env/compiled_scenario.cpp",
    "native ROS": "python/skybody/ros2",
    "IMU": "sensors/imu",
    "RGB-D": "sensors/camera",
    "segmentation": "sensors/camera/README.md",
    "force": "sensors/force_torque",
    "contact": "sensors/contact",
    "C++": "include/skybody/skybody.h",
    "Python": "python/skybody/__init__.py",
    "single and multiple agents": "python/skybody/multi_agent.py",
}
Data = dict[str, Any]


def data(results: Path, name: str) -> Data:
    """Data of a page. Raises FileNotFoundError if it was not made."""
    return dict(json.loads((results / f"data/{name}.json").read_text(encoding="utf-8")))


def films(_: Path) -> float:
    """Films of the gallery; 0 if one of the paper's two named ones is missing."""
    found = {path.stem for path in (ROOT / "docs/gallery").glob("*.webp")} - {"overview"}
    return len(found) if {"racing", "cooperative_payload_learn"} <= found else 0


def control_levels(_: Path) -> float:
    """Signals of docs/control-modes.md."""
    text = (ROOT / "docs/control-modes.md").read_text(encoding="utf-8")
    part = text.partition("<!-- signals")[2].partition("<!-- end of signals")[0]
    return len(re.findall(r"^\| `", part, re.M))


def features(_: Path) -> float:
    """Features whose source is here."""
    return sum((ROOT / path).exists() for path in FEATURES.values())


def identical_flights(results: Path) -> float:
    """Share of the flights with the same bits everywhere [%]."""
    flights = data(results, "determinism_matrix").values()
    return 100.0 * statistics.fmean(flight["verdict"] == "identical" for flight in flights)


def in_process(results: Path) -> list[Data]:
    """Rows of synchronization of one process, open and closed loop."""
    rows = data(results, "synchronization")["rows"]
    return [row for row in rows if row["stepping"] == "in process"]


def steps_between(results: Path) -> float:
    """Greatest number of physics steps between, of both loops."""
    return float(max(row["intervening"][-1] for row in in_process(results)))


def spread(results: Path) -> float:
    """Greatest spread of the positions, of both loops [mm]."""
    return float(max(max(row["spread_mm"]) for row in in_process(results)))


def of_one_seed(results: Path, value: str) -> list[float]:
    """A value of the groups with one seed, of both learners and all scenarios."""
    names = ("training_reproducibility", "training_reproducibility_fast-ppo")
    scenarios = [s for name in names for s in data(results, name)["scenarios"].values()]
    return [float(scenario["groups"]["same seed"][value]) for scenario in scenarios]


def deviation_of_one_seed(results: Path) -> float:
    """Greatest standard deviation of the final return."""
    return max(of_one_seed(results, "final_return_std"))


def identical_checkpoints(results: Path) -> float:
    """Least share of identical checkpoints [%]."""
    return min(of_one_seed(results, "identical_checkpoints_percent"))


def rates(results: Path) -> dict[int, float]:
    """Best rate [steps/s] of the pool under zero action, by number of environments."""
    found: dict[int, float] = {}
    for row in data(results, "scalability")["pool"]:
        if (row["dynamics"], row["action"], row["scenario"]) == ("tree", "zero", "hover"):
            found[row["envs"]] = max(found.get(row["envs"], 0.0), row["mean"]["rate"])
    return found


def peak_rate(results: Path) -> float:
    """Greatest rate over the paper's numbers of environments [steps/s]."""
    found = rates(results)
    return max(found[size] for size in PAPER_SIZES)


def rises(results: Path) -> float:
    """How many of the paper's numbers of environments are faster than the one before."""
    found = rates(results)
    return sum(found[more] > found[fewer] for fewer, more in pairwise(PAPER_SIZES))


def rates_of_robots(results: Path) -> dict[int, float]:
    """Rates of worlds [steps/s] by number of robots, N_B = 11, zero action."""
    rows = data(results, "multi_agent")["python"]
    chosen = [row for row in rows if (row["action"], row["batch"]) == ("zero", BATCH)]
    return {row["robots"]: row["mean"]["rate"] for row in chosen}


def rate_of_twenty(results: Path) -> float:
    """Rate of worlds of 20 robots [steps/s]."""
    return rates_of_robots(results)[20]


def least_ratio(results: Path) -> float:
    """Least ratio of our rate to that of the fastest framework of Table IV."""
    found = rates_of_robots(results)
    return min(found[robots] / rate for robots, rate in FASTEST.items())


def transferred(results: Path) -> list[Data]:
    """Flights of policies that were trained on drawn vehicles, with all hidden errors."""
    rows = data(results, "transfer")["flights"]
    wanted = {"policy": "drawn", "condition": "hidden"}
    chosen = [row for row in rows if all(row[name] == value for name, value in wanted.items())]
    return [row for row in chosen if row["engine"] in FOREIGN]


def flights_flown(results: Path) -> float:
    """Share of the flights in other engines without a failure [%]."""
    rows = transferred(results)
    flown = sum(len(row["mean"]) for row in rows)
    return float(100.0 * (1.0 - sum(row["failed"] for row in rows) / flown))


def transfer_error(results: Path) -> float:
    """Greatest mean error in other engines [cm]."""
    return max(100.0 * statistics.fmean(row["mean"]) for row in transferred(results))


def configurations_learned(results: Path) -> float:
    """Share of the runs that pass the smallest threshold of their task [%]."""
    runs = data(results, "control_abstractions")["runs"]
    last = [min(run["steps"].items(), key=lambda step: float(step[0])) for run in runs]
    return 100.0 * statistics.fmean(steps is not None for _, steps in last)


def gain_by_drawing(results: Path) -> float:
    """Gain of the return by drawing: mean over the seeds, at the smallest spread above 0."""
    rows = [row for row in data(results, "domain_randomization")["rows"] if row["drawn"]]
    row = min(rows, key=lambda one: one["spread"])
    means = [statistics.fmean(run["return"] for run in row[kind]) for kind in ("drawn", "fixed")]
    return float(means[0] - means[1])
