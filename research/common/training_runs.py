"""Runs of `python -P -m skybody.train` as separate processes, trained once and then kept."""

from __future__ import annotations

import dataclasses
import json
import subprocess
import sys
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from skybody import CompiledScenario
from skybody.program import INTERRUPTED, module_command
from skybody.train.algorithms import algorithm_of
from skybody.train.checkpoint import checkpoint_folders, read_meta
from skybody.train.evaluation_file import read_evaluation
from skybody.train.hyperparameters import with_settings
from skybody.train.presets import preset

from research.common.programs import RunError


@dataclass(frozen=True)
class Run:
    """One training run and its folder."""

    folder: Path
    scenario: str
    algorithm: str
    seed: int
    total_steps: int
    threads: int = 0  # of the environments; 0: all
    overrides: tuple[str, ...] = ()
    settings: tuple[str, ...] = ()  # hyper-parameters, KEY=VALUE
    checkpoints: int = 10
    eval_episodes: int = 20  # during training, per checkpoint; 0: none
    program: tuple[str, ...] = tuple(module_command("skybody.train")[1:])  # of the training

    @property
    def log(self) -> Path:
        """File with the run's output."""
        return self.folder.with_name(f"{self.folder.name}.log")

    def command(self) -> list[str]:
        """The command that begins the run, or resumes it."""
        made = [sys.executable, *self.program, "--out", str(self.folder)]
        if (self.folder / "config.json").exists():
            return [*made, "--resume"]
        made += [self.scenario, "--algo", self.algorithm, "--seed", str(self.seed)]
        made += ["--threads", str(self.threads), "--total-steps", str(self.total_steps)]
        made += ["--checkpoint-every", str(max(1, self.total_steps // self.checkpoints))]
        made += ["--eval-episodes", str(self.eval_episodes)]
        for option, values in (("--override", self.overrides), ("--set", self.settings)):
            for value in values:
                made += [option, value]
        return made

    def check(self) -> None:
        """Raises RunError if the folder contains a run other than this one."""
        path = self.folder / "config.json"
        if not path.exists():
            return
        config = json.loads(path.read_text())
        wanted = {
            "scenario": self.scenario,
            "algorithm": self.algorithm,
            "seed": self.seed,
            "total_steps": self.total_steps,
            "threads": self.threads,
            "overrides": list(self.overrides),
            "eval_episodes": self.eval_episodes,
        }
        compiled = CompiledScenario(self.scenario, list(self.overrides))
        base = preset(self.scenario, self.algorithm, compiled.dt * compiled.action_repeat)
        hyper = dataclasses.asdict(with_settings(base.hyper, self.settings))
        wanted |= {name: json.loads(json.dumps(value)) for name, value in hyper.items()}
        wanted["scenario_hash"] = f"{compiled.scenario_hash:016x}"
        for name, value in wanted.items():
            found = (config["hyper"] if name in hyper else config)[name]
            if found != value:
                raise RunError(
                    f"{self.folder} holds a run with {name} {found}, not {value}; "
                    "remove it, or take another --out"
                )

    def with_threads_of_folder(self) -> Run:
        """With the folder's number of threads, if any: it changes no bits, and a resume uses it."""
        if not (self.folder / "config.json").exists():
            return self
        return dataclasses.replace(self, threads=self.config()["threads"])

    def finished(self) -> bool:
        """Whether it has reached its end and every checkpoint has its evaluation."""
        found = checkpoint_folders(self.folder)
        if not found or read_meta(found[-1])["steps"] < self.total_steps:
            return False
        evaluated = all(read_evaluation(folder) is not None for folder in found)
        return evaluated or self.eval_episodes == 0

    def config(self) -> dict[str, Any]:
        """Its options, hyper-parameters and versions."""
        made: dict[str, Any] = json.loads((self.folder / "config.json").read_text())
        return made

    def evaluations(self) -> list[dict[str, Any]]:
        """Evaluations of all checkpoints that have one, oldest first."""
        found = [read_evaluation(folder) for folder in checkpoint_folders(self.folder)]
        return [row for row in found if row is not None]

    def train(self) -> None:
        """Begins or resumes it, and waits for its end. Raises RunError, KeyboardInterrupt."""
        self.check()
        self.folder.parent.mkdir(parents=True, exist_ok=True)
        with self.log.open("a") as log:
            done = subprocess.run(self.command(), stdout=log, stderr=subprocess.STDOUT, check=False)
        if done.returncode == INTERRUPTED:
            raise KeyboardInterrupt
        if done.returncode != 0 or not self.finished():
            last = "\n".join(self.log.read_text().splitlines()[-10:])
            raise RunError(f"{self.folder} failed (exit code {done.returncode}); its log:\n{last}")


def train_all(runs: Sequence[Run], jobs: int, say: Callable[[Run], str]) -> None:
    """Trains the unfinished runs, `jobs` at a time; prints the line of `say` for each.

    After the first failure or Ctrl-C no further run begins; running ones come to an end (after
    Ctrl-C: the end of their rollout, with a checkpoint).
    """
    for run in runs:
        run.check()
    waiting = [run for run in runs if not run.finished()]
    print(f"{len(runs)} runs, {len(runs) - len(waiting)} of them finished before", flush=True)
    stop, done = threading.Event(), len(runs) - len(waiting)

    def train(run: Run) -> Run | None:
        if stop.is_set():
            return None
        try:
            run.train()
        except BaseException:
            stop.set()
            raise
        return run

    with ThreadPoolExecutor(jobs) as pool:
        futures = [pool.submit(train, run) for run in waiting]
        try:
            for future in futures:
                if (trained := future.result()) is not None:
                    done += 1
                    print(f"[{done}/{len(runs)}] {say(trained)}", flush=True)
        finally:
            stop.set()


def settings_with(values: dict[str, Any], algorithm: str) -> tuple[str, ...]:
    """Hyper-parameters as arguments of --set, without those that the learner does not have."""
    known = vars(algorithm_of(algorithm).defaults())
    return tuple(f"{name}={value}" for name, value in values.items() if name in known)


def changed_hyper(config: dict[str, Any]) -> list[str]:
    """Hyper-parameters of a run that differ from its learner's defaults, KEY=VALUE, by a preset or
    the command line.
    """
    defaults = dataclasses.asdict(algorithm_of(config["algorithm"]).defaults())
    changed = []
    for name, value in config["hyper"].items():
        default = defaults[name]
        if value == (list(default) if isinstance(default, tuple) else default):
            continue
        text = ",".join(map(str, value)) if isinstance(value, list) else str(value)
        changed.append(f"{name}={text.lower() if isinstance(value, bool) else text}")
    return changed
