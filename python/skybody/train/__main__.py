"""Trains a policy in a scenario; see docs/training.md.

skybody train SCENARIO --algo LEARNER --seed S --total-steps N --out DIR
skybody train --resume --out DIR
skybody train SCENARIO --ray HOST:PORT --workers N

`python -P -m skybody.train` is the same.
"""

from __future__ import annotations

import argparse
import contextlib
import dataclasses
import platform
import shlex
import shutil
import sys
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING

from skybody._native import CompiledScenario, Error, InputError, versions
from skybody.arguments import check_plugin_path
from skybody.command_line import range_problem, report_error
from skybody.program import INTERRUPTED, run_program
from skybody.train import evaluate, files
from skybody.train.algorithms import DEFAULT_ALGORITHM
from skybody.train.checkpoint import checkpoint_folders, read_meta
from skybody.train.hyperparameters import UsageError
from skybody.train.options import RANGES, parser
from skybody.train.presets import preset, presets_file, told
from skybody.train.requirements import (
    demand_packages,
    missing_text,
    package_versions,
    packages_of,
)
from skybody.train.run_folder import Config, is_unbegun, load_recorded

if TYPE_CHECKING:
    from skybody.train.trainer import Trainer

NO_MEMORY = "not enough memory: take fewer envs or rollout_steps, or smaller layers (hidden)"


def given(value: int | None, default: int) -> int:
    """Returns the option's value if it is given, otherwise `default`."""
    return default if value is None else value


def new_config(options: argparse.Namespace, compiled: CompiledScenario) -> Config:
    """The configuration of a new run."""
    if options.envs is not None and any(s.startswith("envs=") for s in options.set):
        raise UsageError("--envs and --set envs=...: give one of them")
    algorithm = options.algo or DEFAULT_ALGORITHM
    found = told(options.scenario, algorithm, compiled, options.set, options.total_steps)
    hyper, total = found.hyper, found.total_steps
    if options.envs is not None:
        hyper = dataclasses.replace(hyper, envs=options.envs)
    return Config(
        scenario=options.scenario,
        overrides=options.override or [],
        plugin_path=options.plugin_path or [],
        searched=options.plugin_path or [],
        algorithm=algorithm,
        seed=given(options.seed, 0),
        total_steps=total,
        checkpoint_every=given(options.checkpoint_every, max(1, total // 10)),
        threads=given(options.threads, 0),
        eval_episodes=given(options.eval_episodes, 20),
        eval_seed=given(options.eval_seed, evaluate.SEED),
        hyper=hyper,
        scenario_name=compiled.name,
        scenario_hash=f"{compiled.scenario_hash:016x}",
        scenario_text=compiled.scenario_text,
        versions=all_versions(compiled, algorithm),
    )


def resumed_config(options: argparse.Namespace) -> Config:
    """The configuration of the run folder. Settings without influence on bits, and the number of
    steps, may differ.

    Folders with plugins must be given again: a run folder from elsewhere must not choose code to
    run. Its recorded folders stay on its list, so that each later resume names them again.
    """
    config = Config.read(options.out)
    plugin_path = options.plugin_path or []
    evaluate.warn_of_plugin_path(options.out, config.plugin_path, plugin_path)
    recorded = list(dict.fromkeys([*config.plugin_path, *plugin_path]))
    config = dataclasses.replace(config, plugin_path=recorded, searched=plugin_path)
    fixed = {
        "scenario": options.scenario,
        "algorithm": options.algo,
        "seed": options.seed,
        "overrides": options.override,
    }
    for name, value in fixed.items():
        if value is not None and value != getattr(config, name):
            raise UsageError(
                f"--resume: {options.out} was begun with {name} {getattr(config, name)}, "
                f"not {value}; leave the option out, or begin a new run in another folder"
            )
    if options.set or options.envs is not None:
        raise UsageError(
            "--resume: hyper-parameters are those of the run; leave --set and --envs out"
        )
    if newest := checkpoint_folders(options.out)[-1:]:
        meta = read_meta(newest[0])
        config.check_trained_with(meta, newest[0])
        if options.total_steps is not None and options.total_steps < meta["steps"]:
            raise UsageError(
                f"--total-steps {options.total_steps}: {meta['steps']} are done already; "
                "take more, or leave it out"
            )
    free = ("total_steps", "checkpoint_every", "threads", "eval_episodes", "eval_seed")
    changes = {name: getattr(options, name) for name in free if getattr(options, name) is not None}
    return dataclasses.replace(config, **changes)


def check(config: Config) -> None:
    """Raises UsageError for numbers out of range."""
    for name, (low, high) in RANGES.items():
        if problem := range_problem(getattr(config, name), low, high):
            raise UsageError(f"--{name.replace('_', '-')}: {problem}")
    config.hyper.check()


def all_versions(compiled: CompiledScenario, algorithm: str) -> dict[str, str]:
    """Versions of all software that the result may depend on."""
    return {
        **{name: str(version) for name, version in versions().items()},
        **{f"plugin {name}": str(version) for name, version in compiled.plugins.items()},
        "python": platform.python_version(),
        **package_versions(algorithm),
    }


def prepare(options: argparse.Namespace) -> tuple[Config, CompiledScenario]:
    """The run's checked configuration and its loaded scenario. Sets `options.out`."""
    demand_packages(packages_of(options.algo or DEFAULT_ALGORITHM))
    options.out = options.out or default_folder(options)
    config, compiled = resumed_run(options) if options.resume else new_run(options)
    check(config)
    if config.eval_episodes > 0 and compiled.horizon == 0:
        raise UsageError(
            f"scenario {compiled.name} has no horizon, evaluations might never end: "
            "--override stepping.horizon=N, or --eval-episodes 0"
        )
    return config, compiled


def new_run(options: argparse.Namespace) -> tuple[Config, CompiledScenario]:
    """The configuration and scenario of a new run, from the command line."""
    run: Path = options.out
    if options.scenario is None:
        raise UsageError("which scenario? Give its name or file, or --resume")
    if run.exists() and not run.is_dir():
        raise UsageError(f"--out {run} is a file: name a new folder")
    if run.exists() and not is_unbegun(run):
        raise UsageError(f"--out {run} exists and is not empty: take another, or --resume")
    plugin_path = options.plugin_path or []
    check_plugin_path(plugin_path, "--plugin-path")
    compiled = CompiledScenario(options.scenario, options.override or [], plugin_path)
    return new_config(options, compiled), compiled


def resumed_run(options: argparse.Namespace) -> tuple[Config, CompiledScenario]:
    """The configuration and scenario of the run folder; checks that the scenario is unchanged."""
    config = resumed_config(options)
    demand_packages(packages_of(config.algorithm))
    check_plugin_path(config.searched, "--plugin-path")
    record = options.out / "config.json"
    compiled = load_recorded(record, config.scenario, config.overrides, config.searched)
    found = f"{compiled.scenario_hash:016x}"
    if found != config.scenario_hash:
        raise UsageError(
            f"--resume: scenario {config.scenario} has changed since this run began "
            f"(hash {config.scenario_hash} then, {found} now; its text then is in config.json)"
        )
    now = all_versions(compiled, config.algorithm)
    changed = [n for n, v in now.items() if config.versions.get(n) != v]
    if changed:
        was = ", ".join(f"{n} {config.versions.get(n)} -> {now[n]}" for n in changed)
        print(f"warning: versions differ, and so may bits: {was}", file=sys.stderr)
    known = dataclasses.replace(
        config, scenario_name=compiled.name, scenario_text=compiled.scenario_text, versions=now
    )
    return known, compiled


def main(arguments: list[str] | None = None) -> int:
    """Trains; returns the exit code."""
    options = parser().parse_args(arguments)
    with contextlib.ExitStack() as scope:
        try:
            trainer = make_trainer(options, scope)
        except BlockingIOError:
            return report_error(
                f"--out {options.out}: another process trains there; wait for it, or stop it"
            )
        except (UsageError, InputError, Error, OSError, ValueError) as error:
            return report_error(evaluate.in_our_words(error))
        except MemoryError:
            return report_error(NO_MEMORY)
        except ModuleNotFoundError as error:
            return report_error(missing_text([str(error.name)]))
        print(opening(options, trainer.config, trainer.first_step), flush=True)
        return train(trainer)


def opening(options: argparse.Namespace, config: Config, first_step: int) -> str:
    """The first message: the run, its folder, and the source of its hyper-parameters."""
    run = f"{config.scenario_name}, {config.algorithm}, seed {config.seed}, in {options.out}"
    if options.resume:
        if first_step >= config.total_steps:
            return f"{run}: complete at {first_step:,} steps; --total-steps N goes further"
        return f"{run}: goes on at {first_step:,} of {config.total_steps:,} steps"
    file, steps = presets_file(config.scenario), f"{config.total_steps:,} steps"
    if not file.is_file():
        return f"{run}: {steps}; defaults, since there is no {file}"
    whole = preset(config.scenario, config.algorithm).total_steps
    if config.total_steps < whole:
        steps += f", in which the schedules of {whole:,} are squeezed together"
    return f"{run}: {steps}; presets of {file}"


def default_folder(options: argparse.Namespace) -> Path:
    """A new folder for a run without --out: flights/SCENARIO_ALGO, or with -2, -3, ... appended.

    Raises UsageError for --resume, because the folder is ambiguous.
    """
    if options.resume:
        raise UsageError("--resume: which run? Name its folder with --out DIR")
    name = f"{Path(options.scenario or '').stem}_{options.algo or DEFAULT_ALGORITHM}"
    names = (name if k == 1 else f"{name}-{k}" for k in count(1))
    return next(folder for folder in map(Path("flights").joinpath, names) if not folder.exists())


def make_trainer(options: argparse.Namespace, scope: contextlib.ExitStack) -> Trainer:
    """Checks everything, then writes the configuration to the run folder.

    This process owns the folder, and the workers of a cluster, until `scope` ends.
    """
    check_cluster_options(options)
    config, compiled = prepare(options)
    slices = None
    if options.ray is not None:
        from skybody.ray.train import hold_slices

        slices = hold_slices(options, config, scope)
    return open_trainer(options, config, compiled, scope, slices)


def check_cluster_options(options: argparse.Namespace) -> None:
    """Raises UsageError for --workers without a cluster, and for learners without slices."""
    if options.ray is None:
        for name in ("workers", "worker_threads"):
            if (value := getattr(options, name)) is not None:
                raise UsageError(
                    f"--{name.replace('_', '-')} {value} is of a cluster: give --ray ADDRESS, too "
                    "(--threads says how many threads train in this process)"
                )
        return
    from skybody.ray.train import check_options

    check_options(options)


def open_trainer(
    options: argparse.Namespace,
    config: Config,
    compiled: CompiledScenario,
    scope: contextlib.ExitStack,
    slices: object,
) -> Trainer:
    """Opens the run folder; `slices` as in make_learner()."""
    from skybody.train.trainer import Trainer

    run: Path = options.out
    is_new = not run.exists()
    (run / "checkpoints").mkdir(parents=True, exist_ok=True)
    scope.enter_context(files.folder_lock(run))
    try:
        trainer = Trainer(run, config, compiled, slices)
        config.write(run)
    except BaseException:
        if is_new:
            shutil.rmtree(run)
        raise
    return trainer


def train(trainer: Trainer) -> int:
    """Trains to the end or to an interruption; returns the exit code."""
    try:
        return run_to_end(trainer)
    except KeyboardInterrupt:
        trainer.abandon()
        print("interrupted; --resume goes on from the newest checkpoint", file=sys.stderr)
        return INTERRUPTED
    except MemoryError:
        trainer.abandon()
        return report_error(NO_MEMORY)
    except (OSError, Error, UsageError) as error:
        trainer.abandon()
        return report_error(
            f"{evaluate.in_our_words(error)}; once that is mended, --resume goes on from the "
            "newest checkpoint"
        )


def run_to_end(trainer: Trainer) -> int:
    """train() without the handling of a Ctrl-C that ends it at once and of files that cannot be
    written.
    """
    try:
        complete = trainer.train()
    except FloatingPointError as error:
        trainer.finish(complete=False)
        return report_error(str(error))
    trainer.finish(complete)
    print(trainer.summary())
    if complete:
        print(f"fly it  {fly_command(trainer.config, trainer.run)}")
        if trainer.config.eval_episodes > 0:
            show_page(trainer.run)
    else:
        print(f"go on  {resume_command(trainer.config, trainer.run)}")
    return 0 if complete else INTERRUPTED


def show_page(run: Path) -> None:
    """Writes the page of a run that has ended, or says why there is none."""
    from skybody.view.runs import write_run_page  # takes longer to load than some runs

    page = run / "flight.html"
    try:
        write_run_page(run, page)
    except (OSError, Error, UsageError, ValueError) as error:
        print(f"warning: no page: {error}", file=sys.stderr)
    else:
        print(f"see it  {page}")


def fly_command(config: Config, run: Path) -> str:
    """Shell command that flies the policy of a run, in the scenario in which it was trained."""
    words = ["skybody", "run", config.scenario, "--policy", str(run)]
    words += [word for override in config.overrides for word in ("--set", override)]
    return shlex.join(words + search_options(config))


def resume_command(config: Config, run: Path) -> str:
    """Shell command that resumes a run."""
    words = ["skybody", "train", "--resume", "--out", str(run)]
    return shlex.join(words + search_options(config))


def search_options(config: Config) -> list[str]:
    """Options for folders of plugins, which each command must be given (docs/plugins.md)."""
    return [word for folder in config.searched for word in ("--plugin-path", folder)]


if __name__ == "__main__":
    run_program(main)
