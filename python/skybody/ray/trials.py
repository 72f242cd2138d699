"""The trials of a sweep: each is a run folder of `python -P -m skybody.train`."""

from __future__ import annotations

import ctypes
import itertools
import os
import signal
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from skybody.program import module_command
from skybody.train.algorithms import algorithm_of
from skybody.train.checkpoint import checkpoint_folders, read_meta
from skybody.train.evaluation_file import read_evaluation
from skybody.train.hyperparameters import UsageError

_DIE_WITH_PARENT = 1  # PR_SET_PDEATHSIG of prctl(2)


@dataclass(frozen=True)
class Trial:
    """One training run of a sweep."""

    folder: Path
    scenario: str
    algorithm: str
    seed: int
    settings: tuple[str, ...]  # hyper-parameters, KEY=VALUE
    total_steps: int
    common: tuple[str, ...] = ()  # further options, the same for all trials
    evaluated: bool = True  # whether checkpoints are evaluated
    plugin_path: tuple[str, ...] = ()  # never from a run folder: it must not choose code

    def command(self, threads: int) -> list[str]:
        """The command that begins the run, or resumes it."""
        made = module_command("skybody.train", "--out", str(self.folder))
        made += ["--threads", str(threads)]
        made += [word for folder in self.plugin_path for word in ("--plugin-path", folder)]
        made += ["--total-steps", str(self.total_steps)]
        if (self.folder / "config.json").exists():
            return [*made, "--resume"]
        made += [self.scenario, "--algo", self.algorithm, "--seed", str(self.seed), *self.common]
        return made + [word for setting in self.settings for word in ("--set", setting)]

    def finished(self) -> bool:
        """Whether its newest checkpoint is the last, including its evaluation if requested."""
        found = checkpoint_folders(self.folder)
        if not found or read_meta(found[-1])["steps"] < self.total_steps:
            return False
        return not self.evaluated or read_evaluation(found[-1]) is not None

    def result(self) -> dict[str, Any]:
        """Results of its newest checkpoint; empty if there is none."""
        found = checkpoint_folders(self.folder)
        if not found:
            return {}
        meta, evaluation = read_meta(found[-1]), read_evaluation(found[-1]) or {}
        keep = ("return_mean", "return_cv", "position_error_median", "success_share")
        return {
            "steps": meta["steps"],
            "wall_clock": meta["wall_clock"],
            **{name: evaluation.get(name) for name in keep},
            "parameter_hash": meta["parameter_hash"],
        }

    def train(self, threads: int) -> None:
        """Begins or resumes the run, and waits for its end. Raises RuntimeError with its messages.

        The run ends with the process that called this: it writes a checkpoint and exits, so that
        its folder is free for a later resume.
        """
        self.folder.parent.mkdir(parents=True, exist_ok=True)
        log = self.folder.with_name(f"{self.folder.name}.log")
        with log.open("w") as file:
            done = subprocess.run(
                self.command(threads),
                stdout=file,
                stderr=subprocess.STDOUT,
                check=False,
                preexec_fn=_die_with_parent,
                env={**os.environ, "OMP_NUM_THREADS": str(threads)},
            )
        if done.returncode != 0:
            said = "\n".join(log.read_text().splitlines()[-5:])
            raise RuntimeError(f"exit code {done.returncode}: {said}")


def make_trials(
    out: Path,
    scenarios: Sequence[str],
    algorithm: str,
    seeds: Sequence[int],
    grid: dict[str, list[str]],
    total_steps: Mapping[str, int],
    common: Sequence[str],
    evaluated: bool,
    plugin_path: Sequence[str],
) -> list[Trial]:
    """All combinations: all seeds of a scenario and its settings, then the next ones.

    Args:
        total_steps: of each scenario.
        common: further options, the same for all.
    """
    trials = []
    choices = [[f"{key}={value}" for value in values] for key, values in grid.items()]
    for scenario, settings, seed in itertools.product(
        scenarios, list(itertools.product(*choices)), seeds
    ):
        name = "-".join([Path(scenario).stem, *settings, f"seed={seed}"]).replace("/", "_")
        trials.append(
            Trial(
                out / name,
                scenario,
                algorithm,
                seed,
                settings,
                total_steps[scenario],
                tuple(common),
                evaluated,
                tuple(plugin_path),
            )
        )
    if len({trial.folder for trial in trials}) < len(trials):
        raise UsageError("two trials of this sweep are the same: give each value once")
    return trials


def parse_grid(settings: Sequence[str], algorithm: str) -> dict[str, list[str]]:
    """Parses `--set` of a sweep: KEY=VALUE,VALUE; sizes of layers are separated by semicolons.

    Raises:
        UsageError: no `=`, or one key twice. Unknown keys are reported by the check of a run.
    """
    like = vars(algorithm_of(algorithm).defaults())
    grid: dict[str, list[str]] = {}
    for setting in settings:
        key, equals, text = setting.partition("=")
        if not equals or not text:
            raise UsageError(f"--set {setting}: write KEY=VALUE or KEY=VALUE,VALUE")
        if key in grid:
            raise UsageError(f"--set {setting}: `{key}` is given twice; write {key}=VALUE,VALUE")
        separator = ";" if ";" in text or isinstance(like.get(key), tuple) else ","
        grid[key] = [value.strip() for value in text.split(separator)]
    return grid


def _die_with_parent() -> None:
    """Linux: the kernel signals the child when the thread that started it ends."""
    ctypes.CDLL(None).prctl(_DIE_WITH_PARENT, signal.SIGTERM)
