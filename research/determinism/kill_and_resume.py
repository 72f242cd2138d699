"""Whether killed and resumed training ends with the same bits.

    python -m research run kill_and_resume [--kills 20] [--seed 1] [--out DIR]

For each learner (fast-ppo, gradient, and PPO of Stable-Baselines3), a small run is trained once to
its end. A second one gets SIGKILL at random moments after the start of its training, and is resumed
each time; after the last kill it is resumed to its end. Moments come from the seed. Prints a
table and writes it to kill_and_resume.md with its figures as JSON. Exit code 1 if the two runs
differ in a bit of their parameters, in the environments' state or in the table of progress.
"""

from __future__ import annotations

import hashlib
import random
import shutil
import signal
import subprocess
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from skybody.program import module_command
from skybody.train.algorithms import ALGORITHMS
from skybody.train.checkpoint import checkpoint_folders, read_meta
from skybody.train.run_folder import read_table

from research.common.machine import machine_line
from research.common.options import Options, heading
from research.common.pages import head, markdown_table, write_page
from research.common.programs import RunError
from research.common.training_runs import settings_with

PAGE = "kill_and_resume"

KILLS = 20
SCENARIO = "hover_learn"
ENVS, ROLLOUT_STEPS = 6, 50
ROLLOUT = ENVS * ROLLOUT_STEPS
# Settings that a learner does not have are left out.
SETTINGS = {"rollout_steps": ROLLOUT_STEPS, "minibatch": 100, "epochs": 2, "hidden": "8,8"}
# One checkpoint per rollout. A part of a run lasts a few of them (learners in C++ make many in the
# time of one of the others), so that kills fall into rollouts, updates and checkpoints.
ROLLOUTS_PER_KILL = {"fast-ppo": 40, "gradient": 40, "ppo": 6}
LATEST = 0.6  # s from the first new checkpoint of a part to its kill
EVERY_FIFTH = 5  # kill falls into the start-up of a part
STARTING = 4.0  # s
PATIENCE = 120.0  # s, for a part to begin or to end, on a loaded machine
# Columns that differ between two runs with the same bits: times and shares of them.
TIMES = ("wall_clock", "steps_per_second", "environment_share", "inference_share", "update_share")


@dataclass
class Result:
    """Comparison of one learner's pair of runs."""

    algorithm: str
    kills: list[int] = field(default_factory=list)  # checkpointed steps at each
    seconds: float = 0.0
    steps: int = 0
    hashes: tuple[str, str] = ("", "")  # uninterrupted, killed
    same_environments: bool = False
    same_progress: bool = False

    def same(self) -> bool:
        """Whether the killed run equals the uninterrupted one."""
        return self.hashes[0] == self.hashes[1] and self.same_environments and self.same_progress


def command(algorithm: str, folder: Path, steps: int) -> list[str]:
    """The command of a small run; networks of 8 x 8, a rollout of 300 steps."""
    words = [SCENARIO, "--algo", algorithm, "--seed", "3", "--out", str(folder)]
    words += ["--total-steps", str(steps), "--checkpoint-every", str(ROLLOUT)]
    words += ["--override", "stepping.horizon=40", "--eval-episodes", "0", "--threads", "1"]
    words += ["--envs", str(ENVS)]
    for setting in settings_with(SETTINGS, algorithm):
        words += ["--set", setting]
    return words


def train(arguments: list[str]) -> subprocess.Popen[str]:
    """Starts a part of a run."""
    return subprocess.Popen(
        module_command("skybody.train", *arguments),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )


def to_the_end(arguments: list[str]) -> None:
    """Runs a part to its end. Raises RunError if it fails."""
    process = train(arguments)
    try:
        _, said = process.communicate()
    finally:
        process.kill()  # after Ctrl-C; otherwise it has ended
    if process.returncode != 0:
        raise RunError(f"exit code {process.returncode}: {said.strip()}")


def newest(folder: Path) -> int:
    """Steps of the newest checkpoint."""
    found = checkpoint_folders(folder)
    return int(found[-1].name.removeprefix("step_")) if found else 0


def kill_once(arguments: list[str], folder: Path, pause: float, most: int, starting: bool) -> int:
    """Kills a part `pause` seconds after its start or first new checkpoint; returns the steps.

    A part is killed at `most` steps at the latest: later steps belong to later kills.
    """
    before, process = newest(folder), train(arguments)
    try:
        deadline = time.monotonic() + PATIENCE
        while not starting and newest(folder) == before and process.poll() is None:
            if time.monotonic() > deadline:
                raise RunError(f"no checkpoint in {PATIENCE:.0f} s")
            time.sleep(0.002)
        moment = time.monotonic() + pause
        while time.monotonic() < moment and newest(folder) < before + most:
            time.sleep(0.002)
    finally:
        process.kill()
        _, said = process.communicate()
    if process.returncode != -signal.SIGKILL:
        raise RunError(f"ended by itself with exit code {process.returncode}: {said.strip()}")
    return newest(folder)


def compare(algorithm: str, out: Path, kills: int, moments: random.Random) -> Result:
    """Makes both runs of a learner, and compares them."""
    part = ROLLOUT * ROLLOUTS_PER_KILL[algorithm]
    result = Result(algorithm, steps=part * (kills + 1))
    whole, killed = out / f"{algorithm}-whole", out / f"{algorithm}-killed"
    for folder in (whole, killed):
        shutil.rmtree(folder, ignore_errors=True)
    began = time.monotonic()
    to_the_end(command(algorithm, whole, result.steps))
    # The uninterrupted run's speed bounds the pauses, so that most kills precede a part's last
    # step.
    pace = float(read_table(whole / "progress.csv")[-1]["wall_clock"]) / result.steps
    longest = min(LATEST, 0.8 * pace * part)
    arguments = command(algorithm, killed, result.steps)
    for number in range(1, kills + 1):
        starting = number % EVERY_FIFTH == 0
        pause = moments.uniform(0.0, STARTING if starting else longest)
        reached = kill_once(arguments, killed, pause, part - ROLLOUT, starting)
        result.kills.append(reached)
        print(f"{algorithm}: kill {number} of {kills} at {reached} steps", flush=True)
        arguments = ["--resume", "--out", str(killed)]
    to_the_end(arguments)
    result.seconds = time.monotonic() - began
    result.hashes = (final_hash(whole), final_hash(killed))
    result.same_environments = environments(whole) == environments(killed)
    result.same_progress = progress(whole) == progress(killed)
    return result


def final_hash(folder: Path) -> str:
    """SHA-256 over all parameters at the end."""
    return str(read_meta(checkpoint_folders(folder)[-1])["parameter_hash"])


def environments(folder: Path) -> str:
    """SHA-256 over every word of every environment at the end."""
    content = (checkpoint_folders(folder)[-1] / "environments.bin").read_bytes()
    return hashlib.sha256(content).hexdigest()


def progress(folder: Path) -> list[dict[str, str]]:
    """The table of progress without times."""
    rows = read_table(folder / "progress.csv")
    return [{name: text for name, text in row.items() if name not in TIMES} for row in rows]


def row(result: dict[str, Any]) -> list[str]:
    """A row of the report's table."""
    cells = [result["algorithm"], f"{result['steps']:,}", str(len(result["kills"]))]
    cells += [f"`{digits[:16]}`" for digits in result["hashes"]]
    return [*cells, "the same" if result["same"] else "DIFFERENT", f"{result['seconds']:.0f}"]


def markdown(content: dict[str, Any]) -> str:
    """The report."""
    names = "learner | steps | kills -9 | parameters, never killed | parameters, killed | all bits"
    table = [head(f"{names} | time [s]"), *map(row, content["results"])]
    return f"""\
# Training that is killed

Does training that gets `kill -9` and goes on by `--resume` end with the bits of one that was never
killed? By

    {content["command"]}

on {machine_line(content["machine"])}.

{markdown_table(table, (0, 3, 4, 5))}

A run is `{SCENARIO}` in {ENVS} environments with networks of 8 x 8 and a checkpoint after every
rollout of at most {ROLLOUT} steps. Moments are drawn under seed {content["seed"]}: every fifth kill
falls into the first {STARTING} s of a resumed part, while it loads and reads the checkpoint; the
others fall uniformly up to {LATEST} s (or 0.8 of the time of a part) behind the part's first new
checkpoint, into rollouts, updates and checkpoints. Parameters: SHA-256 over all of them (16 digits;
the JSON has all). `the same`: so are the environments' words at the end and the table of progress,
but for times.
"""


def main(arguments: list[str] | None = None) -> int:
    """Trains, kills, compares, writes; returns the exit code."""
    kills = f"number of kills of each learner; default: {KILLS}"
    all_of = {"choices": ALGORITHMS, "default": list(ALGORITHMS), "help": "default: all"}
    options = (
        Options(__doc__, __name__, "one kill of fast-ppo")
        .of_runs()
        .add("--kills", type=int, default=KILLS, help=kills)
        .add("--seed", type=int, default=1, help="seed of the moments; default: 1")
        .add("--algorithms", "--algo", nargs="+", **all_of)
        .given(arguments)
    )
    if options.quick:
        options.kills, options.algorithms = 1, ["fast-ppo"]
    moments = random.Random(options.seed)
    results = [compare(a, options.runs, options.kills, moments) for a in options.algorithms]
    content = {
        **heading("kill and resume", options),
        "seed": options.seed,
        "results": [{**vars(result), "same": result.same()} for result in results],
    }
    write_page(options.out, PAGE, markdown(content), content)
    return 0 if all(result.same() for result in results) else 1
