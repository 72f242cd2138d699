"""Skybody's trajectory and race policies, frozen, in MuJoCo, Bullet and RotorPy.

    python -m research run transfer [--quick] [--jobs N] [--runs FOLDER] [--out FOLDER]

Nine references as in the GzDRL paper's flights, flown by a policy for rotor speeds and one for
forces, in each engine: as trained, and with errors of mass, inertia, thrust and lag, wind, noise
and delay that the policy does not know. The engines' models are written from the URDF by code that
shares nothing with Skybody. Races are flown in MuJoCo, with gates that can be touched.

Engines are installed below .peers. --quick flies 0.3 s in those engines that this Python has.
Finished flights are kept in --runs, and are not repeated for an equal request.
"""

from __future__ import annotations

import dataclasses
import importlib.util
import json
import os
import sys
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

from research.common.options import Options, heading
from research.common.pages import write_page
from research.common.places import ROOT
from research.common.programs import RunError, output_of
from research.peers.environments import Skipped, alone, python_of
from research.transfer import report
from research.transfer.conditions import HIDDEN, PLAIN, Condition
from research.transfer.flight import DT, REPEAT, SETTLE, Flights
from research.transfer.network import arrays_of
from research.transfer.references import COUNT, TRIAL_COUNT

PAGE = "transfer"
Arrays = Mapping[str, Any]
ENGINES = {  # package, and environment below .peers
    "mujoco": ("mujoco", "mujoco"),
    "bullet": ("pybullet", "pybullet"),
    "rotorpy": ("torchdiffeq", "rotorpy"),
    "skybody": ("skybody", ""),
}
SHIPPED, OWN = ROOT / "scenarios/trajectory/policies", ROOT / "research/transfer/policies"
POLICIES = {
    ("rotor_speed", "shipped"): SHIPPED / "trajectory.h5",
    ("modular", "shipped"): SHIPPED / "trajectory_modular.h5",
    ("rotor_speed", "drawn"): OWN / "trajectory_drawn.h5",
    ("modular", "drawn"): OWN / "trajectory_modular_drawn.h5",
}
RACE_POLICY = ROOT / "scenarios/racing/policies/racing.h5"
CONDITIONS = {"plain": PLAIN, "hidden": HIDDEN}
PARTS = {  # of the hidden condition, each alone
    "errors of the model": Condition(errors=HIDDEN.errors, unequal=HIDDEN.unequal, filtered=False),
    "wind": Condition(wind=HIDDEN.wind, gust=HIDDEN.gust, filtered=False),
    "sensors and delay": dataclasses.replace(HIDDEN, errors=0.0, unequal=0.0, wind=0.0, gust=0.0),
}
SEEDS = [1, 2, 3, 4, 5]
SECONDS, RACE_SECONDS = 30.0, 12.0
RACES = 50
ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}


class Workshop:
    """Runs requests in the engines' environments, and keeps the answers."""

    def __init__(self, options: Any) -> None:
        self.folder: Path = options.runs
        self.folder.mkdir(parents=True, exist_ok=True)
        self.quick: bool = options.quick
        self.pythons: dict[str, Path] = {}
        self.left_out: dict[str, str] = {}
        for engine in ENGINES:
            try:
                self.pythons[engine] = self._python(engine)
            except Skipped as why:
                self.left_out[engine] = str(why)
                print(f"  left out: {engine}: {why}", file=sys.stderr, flush=True)

    def _python(self, engine: str) -> Path:
        package, environment = ENGINES[engine]
        if not environment or self.quick:
            if importlib.util.find_spec(package) is None:
                raise Skipped(f"no package {package}")
            return Path(sys.executable)
        with alone():
            return python_of(environment)

    def run(self, name: str, request: dict[str, Any], policy: Path) -> Arrays:
        """The answer of research.transfer.worker."""
        asked, answer = self.folder / f"{name}.json", self.folder / f"{name}.npz"
        weights = self.folder / f"{name}.policy.npz"
        arrays = arrays_of(policy)
        np.savez(weights, **arrays)
        key = json.dumps(request | {"policy_file": policy.name, "weights": digest(arrays)})
        if not (answer.exists() and asked.exists() and asked.read_text() == key):
            given = self.folder / f"{name}.request.json"
            given.write_text(json.dumps(request | {"policy": str(weights)}))
            program = [self.pythons[request["engine"]], "-m", "research.transfer.worker"]
            paths = [str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])]
            environment = os.environ | ONE_THREAD | {"PYTHONPATH": os.pathsep.join(paths)}
            output_of([*program, given, answer], env=environment, cwd=self.folder)
            asked.write_text(key)
            print(f"  flown: {name}", file=sys.stderr, flush=True)
        return np.load(answer)


def digest(arrays: Mapping[str, Any]) -> float:
    """A number that changes with a policy's weights."""
    return float(sum(np.abs(arrays[name]).sum() for name in arrays if name.startswith("weight")))


def request(engine: str, form: str, condition: Condition, options: Any) -> dict[str, Any]:
    """A request for flights along the references; plain flights have nothing to draw."""
    seeds = SEEDS if condition != PLAIN else SEEDS[:1]
    return {
        "engine": engine,
        "form": form,
        "condition": dataclasses.asdict(condition),
        "seeds": seeds[:2] if options.quick else seeds,
        "references": TRIAL_COUNT if options.quick else COUNT,
        "seconds": options.seconds,
    }


def row(answer: Arrays, **labels: Any) -> dict[str, Any]:
    """Mean and RMS of each flight [m], seed by seed, and failures."""
    flights = Flights(answer["flown"], answer["wanted"], answer["failed"])
    errors = flights.errors(min(SETTLE, 0.1 * DT * REPEAT * flights.flown.shape[1]))
    rms = np.sqrt(np.mean(errors**2, axis=1))
    numbers = {"mean": errors.mean(axis=1), "rms": rms}
    listed = {name: [float(f"{x:.4g}") for x in part] for name, part in numbers.items()}
    return labels | listed | {"failed": int(flights.failed.sum()), "version": str(answer["engine"])}


def race_row(answer: Arrays, **labels: Any) -> dict[str, Any]:
    """Gates, touches, misses and times of all races."""
    seconds = answer["seconds"]
    return labels | {
        "passed": answer["passed"].tolist(),
        "touched": int(answer["touched"].sum()),
        "missed": int(answer["missed"].sum()),
        "seconds": [None if np.isnan(x) else float(f"{x:.4g}") for x in seconds],
    }


def flights(workshop: Workshop, options: Any) -> tuple[list[dict[str, Any]], dict[str, Arrays]]:
    """Rows of all engines, forms, policies and conditions, and the answers by name."""
    work: dict[str, tuple[dict[str, Any], dict[str, Any], Path]] = {}
    for engine in workshop.pythons:
        for (form, policy), file in POLICIES.items():
            if options.quick and policy != "drawn":
                continue
            named = dict(CONDITIONS)
            if engine == "skybody" and policy == "shipped" and not options.quick:
                named |= PARTS
            for condition, values in named.items():
                labels = dict(engine=engine, form=form, policy=policy, condition=condition)
                name = "-".join(labels.values()).replace(" ", "_")
                work[name] = (labels, request(engine, form, values, options), file)
    with ThreadPoolExecutor(options.jobs) as jobs:
        found = {
            name: jobs.submit(workshop.run, name, asked, file)
            for name, (_, asked, file) in work.items()
        }
        answers = {name: future.result() for name, future in found.items()}
    return [row(answers[name], **work[name][0]) for name in work], answers


def races(workshop: Workshop, options: Any) -> list[dict[str, Any]]:
    """Rows of the races in MuJoCo."""
    rows = []
    for name, condition in CONDITIONS.items() if "mujoco" in workshop.pythons else ():
        asked = {
            "engine": "mujoco",
            "condition": dataclasses.asdict(condition),
            "races": 2 if options.quick else RACES,
            "seed": SEEDS[0],
            "seconds": min(options.seconds, RACE_SECONDS),
        }
        answer = workshop.run(f"race-{name}", asked, RACE_POLICY)
        rows.append(race_row(answer, condition=name))
    return rows


def main(arguments: list[str] | None = None) -> int:
    """Flies, writes; returns the exit code."""
    parser = Options(__doc__, __name__, "0.3 s, two references").of_runs()
    parser.add("--jobs", type=int, default=2, help="parallel flights; default: 2")
    options = parser.given(arguments)
    options.seconds = 0.3 if options.quick else SECONDS
    workshop = Workshop(options)
    if not workshop.pythons:
        raise RunError("no engine is available")
    rows, answers = flights(workshop, options)
    content = heading("policies in other simulators", options) | {
        "conditions": {name: dataclasses.asdict(value) for name, value in CONDITIONS.items()},
        "flights": rows,
        "races": races(workshop, options),
        "left_out": sorted(workshop.left_out),
    }
    report.draw(answers, options.out / "images")
    write_page(options.out, PAGE, report.page(content), content)
    return 0
