"""Trains over seeds, hyper-parameters and scenarios on a Ray cluster; see docs/ray.md.

python -P -m skybody.ray.sweep hover_learn --seeds 1,2,3 --set learning_rate=3e-4,1e-3 --out sweep
"""

from __future__ import annotations

import argparse
import json
import os
from pathlib import Path
from typing import Any

from skybody._native import CompiledScenario, Error, InputError
from skybody.arguments import check_plugin_path
from skybody.command_line import CommandLine, report_error, whole
from skybody.program import run_program
from skybody.ray import sweep_table
from skybody.ray.absolute_paths import absolute_scenario, folders_from_anywhere
from skybody.ray.cluster import ADDRESS_HELP, LOCAL, check_cpus, cluster
from skybody.ray.trials import Trial, make_trials, parse_grid
from skybody.train import files
from skybody.train.algorithms import DEFAULT_ALGORITHM, algorithm_of, summaries
from skybody.train.evaluate import in_our_words
from skybody.train.hyperparameters import UsageError
from skybody.train.json_file import read_json
from skybody.train.options import RANGES
from skybody.train.presets import told
from skybody.train.requirements import demand_packages, packages_of

EPILOG = """\
Every combination has a run folder below --out, as written by `python -P -m skybody.train`. If the
same command is given again, it continues unfinished trials and adds new seeds and values. On a
cluster, --out must be a folder that all machines share.
Exit status: 0 done, 1 a trial failed, 2 invalid input, 130 interrupted
(the same command continues)."""
MOST_FAILURES = 10  # machines that may be lost under a trial before it fails


def parser() -> argparse.ArgumentParser:
    """The command line."""
    made = CommandLine(
        prog="python -P -m skybody.ray.sweep",
        description="Trains over seeds, hyper-parameters and scenarios, with Ray Tune.",
        epilog=EPILOG,
        allow_abbrev=False,
    )
    add = made.add_argument
    add(
        "scenarios", nargs="+", metavar="SCENARIO", help="names of shipped scenarios, or YAML files"
    )
    add("--out", type=Path, required=True, metavar="DIR", help="folder of the runs")
    add("--algo", default=DEFAULT_ALGORITHM, metavar="LEARNER", help=summaries())
    add("--seeds", type=seeds, default=[0], metavar="S,S", help="seeds; default: 0")
    add(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE,VALUE",
        help="a hyper-parameter and its values; semicolons separate values that are lists "
        "('hidden=64,64;512,512'); repeatable: all combinations are trained",
    )
    add(
        "--total-steps",
        type=whole(*RANGES["total_steps"]),
        metavar="N",
        help="steps of each trial; default: the preset's, otherwise 1e6",
    )
    add(
        "--checkpoint-every",
        type=whole(*RANGES["checkpoint_every"]),
        metavar="N",
        help="steps between checkpoints; default: a tenth of --total-steps",
    )
    add(
        "--eval-episodes",
        type=whole(*RANGES["eval_episodes"]),
        default=20,
        metavar="N",
        help="evaluation episodes per checkpoint; default: 20",
    )
    add(
        "--override",
        action="append",
        default=[],
        metavar="PATH=VALUE",
        help="override one value of the scenarios; repeatable",
    )
    add(
        "--plugin-path",
        action="append",
        default=[],
        metavar="DIR",
        help="folder to search for plugins first; repeatable",
    )
    add("--address", default=LOCAL, help=ADDRESS_HELP)
    add(
        "--cpus",
        type=whole(1, 1024),
        default=1,
        metavar="N",
        help="processors per trial; default: 1. Trials run in parallel as far as there are "
        "processors",
    )
    return made


def seeds(text: str) -> list[int]:
    """`1,2,3` or `1-10`."""
    seed = whole(*RANGES["seed"])
    found: list[int] = []
    for part in text.split(","):
        first, dash, last = part.partition("-")
        if not first.isdecimal() or (dash and not last.isdecimal()):
            raise argparse.ArgumentTypeError(f"{text}: write seeds as 1,2,3 or 1-10")
        found += range(seed(first), seed(last or first) + 1)
    return found


def trials_of(options: argparse.Namespace) -> list[Trial]:
    """All trials, checked: every problem is reported before any trial begins.

    Tune runs each trial in its own folder, so file names are made absolute.
    """
    algorithm_of(options.algo)
    check_plugin_path(options.plugin_path, "--plugin-path")
    common = ["--eval-episodes", str(options.eval_episodes)]
    if options.checkpoint_every is not None:
        common += ["--checkpoint-every", str(options.checkpoint_every)]
    common += [word for change in options.override for word in ("--override", change)]
    scenarios = [absolute_scenario(scenario) for scenario in options.scenarios]
    compiled = {scenario: _load(scenario, options) for scenario in scenarios}
    steps = {
        scenario: told(scenario, options.algo, loaded, (), options.total_steps).total_steps
        for scenario, loaded in compiled.items()
    }
    trials = make_trials(
        options.out.absolute(),
        scenarios,
        options.algo,
        options.seeds,
        parse_grid(options.set, options.algo),
        steps,
        common,
        options.eval_episodes > 0,
        folders_from_anywhere(options.plugin_path),
    )
    for trial in trials:
        of_scenario = compiled[trial.scenario]
        told(trial.scenario, trial.algorithm, of_scenario, trial.settings).hyper.check()
    return trials


def _load(scenario: str, options: argparse.Namespace) -> CompiledScenario:
    """Loads a scenario, and checks that it can be trained and, if requested, evaluated."""
    compiled = CompiledScenario(scenario, options.override, options.plugin_path)
    if compiled.horizon == 0 and options.eval_episodes > 0:
        raise UsageError(f"scenario {scenario} has no horizon: --eval-episodes 0")
    return compiled


def spec_of(options: argparse.Namespace) -> dict[str, Any]:
    """Settings that all trials of a sweep share, for sweep.json."""
    names = ("algo", "total_steps", "checkpoint_every", "eval_episodes", "override")
    return {name: getattr(options, name) for name in names}


def check_folder(out: Path, spec: dict[str, Any]) -> None:
    """Raises UsageError if the folder contains anything but this sweep."""
    path = out / "sweep.json"
    if path.exists():
        found = _read_spec(path)
        for name, value in spec.items():
            if found.get(name) != value:
                was, now = ("left out" if v is None else v for v in (found.get(name), value))
                raise UsageError(
                    f"--out {out} holds a sweep with {name} {was}, not {now}; put it back, or "
                    "take another folder"
                )
    elif out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise UsageError(f"--out {out} is not empty and holds no sweep: take another")


def _read_spec(path: Path) -> dict[str, Any]:
    """Reads sweep.json. Raises UsageError if it is damaged."""
    try:
        found = read_json(path)
    except ValueError as error:
        raise UsageError(f"{path} is damaged ({error}): take another folder") from error
    if not isinstance(found, dict):
        raise UsageError(f"{path} is damaged (no map): take another folder")
    return found


def write_spec(out: Path, spec: dict[str, Any]) -> None:
    """Creates the folder of a sweep."""
    out.mkdir(parents=True, exist_ok=True)
    files.write_file(out / "sweep.json", (json.dumps(spec, indent=1) + "\n").encode())


def run_trials(ray: Any, waiting: list[Trial], out: Path, cpus: int) -> dict[str, str]:
    """Trains the trials with Tune; returns the messages of failed ones, by name of the folder."""
    # Ctrl-C ends this program at once: the runs write checkpoints and can be resumed.
    os.environ["TUNE_DISABLE_SIGINT_HANDLER"] = "1"
    os.environ.setdefault("RAY_AIR_NEW_OUTPUT", "0")  # the old output can be silenced
    from ray import tune

    errors: dict[str, str] = {}

    class Lines(tune.Callback):  # type: ignore[misc]
        """Prints a line for each trial that has ended."""

        def on_trial_complete(self, iteration: int, trials: Any, trial: Any, **_: Any) -> None:
            result = trial.last_result
            if result["error"]:
                errors[result["name"]] = result["error"]
            print(f"{result['name']}: {result['error'] or 'done'}", flush=True)

    def train(config: dict[str, Any]) -> None:
        trial: Trial = waiting[config["trial"]]
        error = ""
        try:
            trial.train(cpus)
        except RuntimeError as failure:
            error = str(failure)
        tune.report({"name": trial.folder.name, "error": error, **trial.result()})

    tuner = tune.Tuner(
        tune.with_resources(train, {"cpu": cpus}),
        param_space={"trial": tune.grid_search(list(range(len(waiting))))},
        run_config=tune.RunConfig(
            storage_path=str(out.absolute() / ".tune"),
            failure_config=tune.FailureConfig(max_failures=MOST_FAILURES),
            callbacks=[Lines()],
            verbose=0,
        ),
    )
    found = tuner.fit()
    for failure in found.errors:
        errors.setdefault("a worker", str(failure))
    return errors


def main(arguments: list[str] | None = None) -> int:
    """Sweeps; returns the exit code."""
    options = parser().parse_args(arguments)
    try:
        demand_packages(packages_of(options.algo))
        trials = trials_of(options)
        check_folder(options.out, spec_of(options))
        errors = sweep(options, [trial for trial in trials if not trial.finished()])
        rows = sweep_table.rows_of(trials, errors)
        sweep_table.write(options.out, rows)
    except (UsageError, InputError, Error, OSError, ValueError) as error:
        return report_error(in_our_words(error))
    print(sweep_table.text(rows))
    print(f"tables {options.out / 'results.csv'} and results.json")
    return 1 if errors or any(row["state"] != "done" for row in rows) else 0


def sweep(options: argparse.Namespace, waiting: list[Trial]) -> dict[str, str]:
    """Trains the unfinished trials; returns the messages of failed ones, by name of the folder."""
    if not waiting:
        return {}
    with cluster(options.address) as ray:
        check_cpus(ray, options.cpus, f"--cpus {options.cpus}")
        write_spec(options.out, spec_of(options))
        print(f"{len(waiting)} trials to train", flush=True)
        return run_trials(ray, waiting, options.out, options.cpus)


if __name__ == "__main__":
    run_program(main)
