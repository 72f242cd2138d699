"""A run from its configuration to its summary: rollouts, tables, checkpoints, evaluations."""

from __future__ import annotations

import contextlib
import math
import signal
import sys
import threading
import time
from collections import deque
from collections.abc import Iterator
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Any

import numpy as np

from skybody._native import CompiledScenario, Error
from skybody.train import files
from skybody.train.algorithms import algorithm_of
from skybody.train.averaging import PolicyAverage
from skybody.train.checkpoint import checkpoint_folders, read_checkpoint, write_checkpoint
from skybody.train.evaluations import Evaluations
from skybody.train.events import EventFile
from skybody.train.hashing import parameter_hash
from skybody.train.learner import Learner, Report
from skybody.train.run_folder import Config, ProgressTable, write_evaluations

if TYPE_CHECKING:
    from contextlib import AbstractContextManager

    from tqdm import tqdm  # type: ignore[import-untyped]

RECENT_EPISODES = 100  # window of the progress bar's mean return


def make_learner(config: Config, compiled: CompiledScenario, slices: object = None) -> Learner:
    """Creates the learner of the configuration, in its initial state.

    Args:
        slices: of fast-ppo, if another object holds them.

    Raises:
        ValueError: the scenario observes images, and the algorithm learns from vectors only.
    """
    images = [c.name for c in compiled.observation_columns if c.image >= 0]
    if images and not algorithm_of(config.algorithm).sees_images:
        raise ValueError(
            f"`{compiled.name}` observes {', '.join(images)}, and `{config.algorithm}` learns "
            "from vectors alone: leave images out of `observe`, take `--algo fast-ppo`, or use "
            "`skybody.sb3.SkybodyVecEnv` with MultiInputPolicy"
        )
    arguments = (compiled, config.hyper, config.seed, config.threads, config.total_steps)
    make = algorithm_of(config.algorithm).make
    return make(*arguments) if slices is None else make(*arguments, slices)


class Trainer:
    """Trains until `total_steps` or a first Ctrl-C; starts from the newest checkpoint, if any."""

    def __init__(
        self, run: Path, config: Config, compiled: CompiledScenario, slices: object = None
    ) -> None:
        self.run, self.config = run, config
        self.learner = make_learner(config, compiled, slices)
        averages_itself = algorithm_of(config.algorithm).is_native
        self.average = PolicyAverage(0 if averages_itself else config.hyper.averaging_steps)
        self.shares = {"environment": 0.0, "inference": 0.0, "update": 0.0}
        self.recent: deque[float] = deque(maxlen=RECENT_EPISODES)
        self.faults, self.earlier_seconds, self.began = 0, 0.0, time.perf_counter()
        self.ended = 0.0  # time when training ended and only evaluations remained
        self._resume()
        self.first_step = self.learner.steps
        self.table = ProgressTable(run, self.first_step)
        self.events = EventFile(run, self.first_step)
        self.evaluations = Evaluations(run, config.eval_episodes, config.eval_seed, config.searched)
        self._evaluated = 0

    def _resume(self) -> None:
        files.remove_partial_folders(self.run / "checkpoints")
        found = checkpoint_folders(self.run)
        if not found:
            return
        checkpoint = read_checkpoint(found[-1])
        state = checkpoint.state
        try:
            self.learner.restore(state["learner"], checkpoint.environments)
            self.average.restore(state["average"], self.learner.policy())
            if set(state["shares"]) != set(self.shares):
                raise ValueError("`shares` are of other parts")
            self.shares.update(state["shares"])
            self.recent.extend(state["recent"])
            self.faults, self.earlier_seconds = state["faults"], checkpoint.meta["wall_clock"]
        except (Error, KeyError, TypeError, ValueError, AttributeError, RuntimeError) as error:
            written = checkpoint.meta.get("versions", {}).get("skybody", "another version")
            raise ValueError(
                f"{found[-1]} was written by skybody {written} and does not fit this one "
                f"({error}): go on with that version, or begin a new run in another folder"
            ) from error

    # --- the loop -------------------------------------------------------------------------------

    def train(self) -> bool:
        """Returns True at the end of training; False if it was interrupted and can be resumed."""
        config, learner = self.config, self.learner
        with stop_request() as stop, progress_bar(config.total_steps, self.first_step) as bar:
            while learner.steps < config.total_steps and not stop.is_set():
                before = learner.steps
                report = learner.iterate()
                if self.average.window > 0:
                    self.average.add(learner.policy(), learner.steps - before)
                row = self._record(report, learner.steps - before)
                self._show(bar, row, learner.steps - before)
                passed = (
                    learner.steps // config.checkpoint_every > before // config.checkpoint_every
                )
                if passed or stop.is_set() or learner.steps >= config.total_steps:
                    self._checkpoint()
                if self.evaluations.poll():
                    self._record_evaluations()
            return learner.steps >= config.total_steps

    def _record(self, report: Report, new_steps: int) -> dict[str, Any]:
        parts = (report.environment_seconds, report.inference_seconds, report.update_seconds)
        seconds = sum(parts)
        for name, part in zip(self.shares, parts, strict=True):
            self.shares[name] += part
        self.recent.extend(report.episode_returns)
        self.faults += report.faults
        row: dict[str, Any] = {
            "steps": self.learner.steps,
            "wall_clock": round(self.wall_clock(), 3),
            "steps_per_second": round(new_steps / seconds, 1),
            "episodes": len(report.episode_returns),
            "return_mean": mean(report.episode_returns),
            "recent_return_mean": mean(self.recent),
            "position_error": report.position_error,
            "faults": self.faults,
            **{
                f"{name}_share": round(part / seconds, 4)
                for name, part in zip(self.shares, parts, strict=True)
            },
            **report.losses,
        }
        self.table.append(row)
        curves = {
            f"train/{name}": value
            for name, value in row.items()
            if name not in ("steps", "wall_clock") and not math.isnan(value)
        }
        self.events.add(curves, self.learner.steps)
        return row

    def _show(self, bar: tqdm[Any] | None, row: dict[str, Any], new_steps: int) -> None:
        if bar is None:
            return
        shares = "/".join(f"{100 * row[f'{name}_share']:.0f}" for name in self.shares)
        bar.set_postfix_str(
            f"return {row['recent_return_mean']:.3g}, error {row['position_error']:.2g} m, "
            f"env/infer/update {shares} %",
            refresh=False,
        )
        bar.update(new_steps)

    def wall_clock(self) -> float:
        """Seconds of training so far, over all parts of a resumed run."""
        return self.earlier_seconds + (self.ended or time.perf_counter()) - self.began

    # --- checkpoints and evaluations ------------------------------------------------------------

    def _checkpoint(self) -> None:
        config, learner = self.config, self.learner
        saved = learner.save()
        meta = {
            "steps": learner.steps,
            "parameter_hash": parameter_hash(saved.parameters),
            "algorithm": config.algorithm,
            "seed": config.seed,
            "scenario": config.scenario,
            "overrides": config.overrides,
            "plugin_path": config.plugin_path,
            "scenario_name": config.scenario_name,
            "scenario_hash": config.scenario_hash,
            "versions": config.versions,
            "hyper": vars(config.hyper),
            "total_steps": config.total_steps,
            "wall_clock": self.wall_clock(),
        }
        policy = self.average.of(learner.policy())
        policy.attributes.update(
            scenario=config.scenario_name,
            scenario_hash=config.scenario_hash,
            seed=config.seed,
            algorithm=config.algorithm,
            steps=learner.steps,
            skybody_version=config.versions["skybody"],
        )
        state = {
            "learner": saved.state,
            "average": self.average.state(),
            "shares": self.shares,
            "recent": list(self.recent),
            "faults": self.faults,
        }
        folder = write_checkpoint(self.run, meta, state, saved.environments, policy)
        self.evaluations.add(folder)

    def _record_evaluations(self) -> None:
        rows = write_evaluations(self.run)
        for row in rows[self._evaluated :]:
            names = ("return_mean", "return_cv", "position_error_median", "success_share")
            known = {f"evaluation/{n}": row[n] for n in names if row[n] is not None}
            self.events.add(known, row["steps"])
        self._evaluated = len(rows)

    def finish(self, complete: bool) -> None:
        """Waits for evaluations (or drops them), draws the curve, closes the environments."""
        from skybody.train.curve import draw_curve

        self.ended = time.perf_counter()
        if complete:
            while self.evaluations.wait():
                self._record_evaluations()
        self.evaluations.stop()
        for failure in self.evaluations.failures:
            print(f"warning: an evaluation failed: {failure}", file=sys.stderr)
        self._record_evaluations()
        self.events.close()
        if self.learner.steps > 0:
            draw_curve([self.run], self.run / "curve.png")
        self.learner.close()

    def abandon(self) -> None:
        """Ends everything without further writes: the newest checkpoint remains."""
        self.evaluations.stop()
        self.events.close()
        self.learner.close()

    def summary(self) -> str:
        """A summary of the run in a few lines."""
        seconds = self.wall_clock()
        busy = sum(self.shares.values()) or 1.0
        parts = ", ".join(f"{name} {100 * s / busy:.0f} %" for name, s in self.shares.items())
        rate = self.learner.steps / busy
        lines = [
            f"{self.learner.steps} steps in {seconds:.1f} s, {rate:,.0f} steps/s: {parts}",
            (
                f"mean return of the last {len(self.recent)} episodes {mean(self.recent):.4g}"
                if self.recent
                else "no episode has ended"
            )
            + f", faults {self.faults}",
        ]
        if rows := write_evaluations(self.run):
            last = rows[-1]
            error, reached = last["position_error_median"], last["reached_share"]
            lines.append(
                f"evaluation at {last['steps']} steps, {last['episodes']} episodes: "
                f"return {last['return_mean']:.4g}, "
                + (f"CV {last['return_cv']:.3f}, " if last["return_cv"] is not None else "")
                + (f"median position error {error:.4f} m, " if error is not None else "")
                + f"{100 * last['success_share']:.1f} % without failure"
                + (f", {100 * reached:.1f} % succeed" if reached is not None else "")
            )
        lines.append(f"parameters {parameter_hash(self.learner.parameters())}")
        lines.append(f"run folder {self.run}")
        return "\n".join(lines)


def mean(values: Any) -> float:
    """The mean; nan for an empty list."""
    return float(np.mean(values)) if len(values) else math.nan


@contextlib.contextmanager
def stop_request() -> Iterator[threading.Event]:
    """SIGINT or SIGTERM sets the event; a second one interrupts at once."""
    stop = threading.Event()

    def request(number: int, frame: FrameType | None) -> None:
        if stop.is_set():
            raise KeyboardInterrupt
        stop.set()
        print(
            "\nstopping after this rollout, with a checkpoint; again to stop now", file=sys.stderr
        )

    if threading.current_thread() is not threading.main_thread():
        yield stop
        return
    before = {s: signal.signal(s, request) for s in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield stop
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def progress_bar(total: int, initial: int) -> AbstractContextManager[tqdm[Any] | None]:
    """Only on a terminal: logs get the summary."""
    if not sys.stderr.isatty():
        return contextlib.nullcontext()
    from tqdm import tqdm

    bar: AbstractContextManager[tqdm[Any]] = tqdm(
        total=total,
        initial=initial,
        unit=" steps",
        unit_scale=True,
        dynamic_ncols=True,
        smoothing=0.1,
    )
    return bar
