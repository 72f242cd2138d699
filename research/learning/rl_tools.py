"""rl_tools' published hover training, built from the user's checkout and compared with ours."""

from __future__ import annotations

import json
import shutil
import statistics
import subprocess
import time
from pathlib import Path
from typing import Any

from research.common.pages import write_json
from research.common.places import ROOT
from research.common.programs import RunError, output_of

LEARNER = "rl_tools SAC"
SOURCE = ROOT / "research/peers/rl_tools_hover.cpp"
# As in the README of rl_tools, for this processor.
FLAGS = ("-std=c++17", "-O3", "-ffast-math", "-march=native")
POINTS = 10  # of a curve
DIFFERS = """\
`rl_tools SAC` is the zoo's tiny SAC of rl_tools (arXiv 2306.03530), commit {commit}, without a BLAS
and on one thread, by `{compiler}`.
What differs: its vehicle is a Crazyflie of 25 g with its own dynamics (L2F, one Runge-Kutta step of
20 ms an action; ours has 20 steps), nothing is drawn but the start, which is within 0.5 m of the
target, 20 degrees, 1 m/s and 1 rad/s (ours: within 5 m, at rest), and an episode fails beyond 1 m.
The target stays at one place, in place of the zoo's figure of eight. Its policy flies {episodes}
held-out episodes of 7 s by the mean of its actions; errors are measured as ours, over the last
second that an episode flew. Seconds are those of training alone: neither start nor evaluation.
"""


def check(checkout: Path) -> None:
    """Raises RunError if the folder is not a checkout, or does not contain the training."""
    needed = checkout / "src/rl/zoo/l2f/sac_tiny.h"
    if not needed.exists():
        raise RunError(
            f"--rl-tools {checkout}: no {needed.relative_to(checkout)}; give the folder that "
            "`git clone https://github.com/rl-tools/rl-tools` makes"
        )


def build(checkout: Path, out: Path) -> Path:
    """Compiles the training, if necessary; returns the program.

    Raises RunError with the compiler's messages.
    """
    program = out / "rl_tools_hover"
    if program.exists() and program.stat().st_mtime > SOURCE.stat().st_mtime:
        return program
    compiler = shutil.which("g++")
    if compiler is None:
        raise RunError("rl_tools is compiled by g++, which is not installed: apt install g++")
    out.mkdir(parents=True, exist_ok=True)
    includes = [f"-I{checkout / 'include'}", f"-I{checkout / 'src/rl/zoo'}"]
    output_of([compiler, *FLAGS, *includes, SOURCE, "-o", program])
    return program


def record(program: Path, seed: int, out: Path) -> dict[str, Any]:
    """Trains and evaluates a seed, or reads an earlier measurement.

    A record of learning_speed.py, without the times at which limits are reached.
    """
    path = out / f"rl_tools-seed-{seed}.json"
    if path.exists():
        kept: dict[str, Any] = json.loads(path.read_text())
        return kept
    begun = time.time()
    printed = output_of([program, str(seed), str(POINTS)])
    points = [point(json.loads(line)) for line in printed.splitlines() if line[:1] == "{"]
    if len(points) != POINTS:
        raise RunError(f"{program} printed {len(points)} points, not {POINTS}")
    made = {
        "learner": LEARNER,
        "seed": seed,
        "seconds": time.time() - begun,
        "steps_per_second": points[-1]["steps"] / points[-1]["seconds"],
        "points": points,
    }
    write_json(path, made)
    return made


def point(printed: dict[str, Any]) -> dict[str, Any]:
    """A point of a curve, from a line of the program."""
    episodes = len(printed["errors"])
    return {
        "steps": printed["steps"],
        "seconds": printed["seconds"],
        "median_error": statistics.median(printed["errors"]),
        "success_share": 1.0 - printed["failures"] / episodes,
    }


def note(found: dict[str, str], episodes: int) -> str:
    """The page's note on it; `found` is facts()."""
    return DIFFERS.format(episodes=episodes, **found)


def facts(checkout: Path) -> dict[str, str]:
    """Commit of the checkout (if it has one) and the compiler's version."""
    commit = subprocess.run(
        ["git", "-C", str(checkout), "rev-parse", "--short=8", "HEAD"],
        capture_output=True,
        text=True,
        check=False,
    )
    version = subprocess.run(["g++", "--version"], capture_output=True, text=True, check=True)
    return {
        "commit": commit.stdout.strip() or "unknown",
        "compiler": f"g++ {version.stdout.splitlines()[0].split()[-1]} {' '.join(FLAGS)}",
    }
