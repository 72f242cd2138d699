"""The published policy RAPTOR on our vehicles, and our policies in L2F: each in both engines.

    python -m research run raptor [--quick] [--out FOLDER] [--runs FOLDER]

Every flight is flown twice: here, and in L2F, the simulator in which RAPTOR was trained, with the
same vehicle, start, target and rate of actions. RAPTOR's policy comes from PyPI. Ours is trained by
the preset of scenario `vehicles`, once as it is and once with vehicles drawn as RAPTOR's. Where the
two engines differ, terms of the physics are switched one at a time. The first run installs both
packages into .peers; the trial does not.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from skybody.train.checkpoint import checkpoint_folders
from skybody.train.policy_file import Policy, read_policy

from research.common.machine import machine_line
from research.common.options import Options, heading
from research.common.pages import write_page
from research.common.programs import RunError
from research.common.training_runs import Run, train_all
from research.peers import environments
from research.transfer import raptor_cases as cases
from research.transfer.raptor_flights import Course, Flown, fly, median_gap, summary
from research.transfer.raptor_page import draw, page
from research.transfer.raptor_policies import OurPolicy, Pilot, Raptor
from research.transfer.raptor_vehicles import Fleet
from research.transfer.raptor_worlds import L2f, Ours, Peer, World

PAGE = "raptor"
EXPERIMENT = "RAPTOR's policy on our vehicles, our policy in L2F"
STEPS, QUICK_STEPS = 4_800_000, 16_384  # of the training
VARIED = 200  # flights of a variant, at most
QUICK_FLIGHTS, QUICK_SECONDS = 3, 0.3
SEED = 4242
Row = dict[str, Any]
TRAININGS = {
    cases.OURS: ("vehicles", ()),
    cases.OURS_RAPTOR: ("vehicles-raptor", (cases.drawn_in_training("raptor"),)),
}


def training(options: argparse.Namespace, name: str, overrides: tuple[str, ...]) -> Run:
    """The training of a policy of ours."""
    return Run(
        folder=options.runs / f"{name}-seed-1",
        scenario=cases.SCENARIO,
        algorithm="gradient",
        seed=1,
        total_steps=QUICK_STEPS if options.quick else STEPS,
        overrides=overrides,
        checkpoints=1,
        eval_episodes=0,
    ).with_threads_of_folder()


class Stage:
    """Both policies and both engines. Without `peer` there are only ours."""

    def __init__(self, options: argparse.Namespace, peer: Peer | None) -> None:
        self.peer, self.quick = peer, bool(options.quick)
        runs = {name: training(options, *words) for name, words in TRAININGS.items()}
        train_all(list(runs.values()), 1, lambda run: run.folder.name)
        self.policies: dict[str, Policy] = {
            name: read_policy(checkpoint_folders(run.folder)[-1] / "policy.h5")
            for name, run in runs.items()
        }

    def pilot(self, policy: str, fleet: Fleet, variant: cases.Variant) -> Pilot | None:
        """A policy at the beginning of its flights, or None if it is not there."""
        if policy in self.policies:
            return OurPolicy(self.policies[policy], fleet)
        if self.peer is None:
            return None
        return Raptor(self.peer, fleet, variant.clip, variant.as_thrust)

    def fly(
        self,
        vehicles: cases.Vehicles,
        policy: str,
        course: Course,
        variant: cases.Variant,
        most: int,
    ) -> tuple[Row, dict[str, Flown], Fleet]:
        """Flies in both engines; the fleet is that of both."""
        n = QUICK_FLIGHTS if self.quick else min(most, vehicles.flights)
        overrides = (*vehicles.overrides(variant.reach), f"stepping.action_repeat={variant.period}")
        ours = Ours(cases.SCENARIO, overrides, n, SEED, variant.changes)
        worlds: dict[str, World] = {"here": ours}
        if self.peer is not None:
            start = (ours.motion(), ours.rotor_speeds())
            worlds["l2f"] = L2f(self.peer, ours.fleet, *start, ours.period, variant.dt)
        flown = {}
        for name, world in worlds.items():
            pilot = self.pilot(policy, ours.fleet, variant)
            if pilot is not None:
                flown[name] = fly(world, pilot, course, QUICK_SECONDS if self.quick else None)
        row: Row = {"vehicles": vehicles.name, "policy": policy, "course": course.name}
        row |= {name: summary(one) for name, one in flown.items()}
        if len(flown) == 2:
            flying = ~(flown["here"].failed | flown["l2f"].failed)
            row["gap"] = median_gap(worlds["here"].motion(), worlds["l2f"].motion(), flying)
        return row, flown, ours.fleet


def main_rows(stage: Stage) -> Iterator[Row]:
    """Every policy, fleet and course; of RAPTOR's vehicles with each error."""
    for policy in cases.POLICIES:
        for vehicles in cases.FLEETS:
            for course in cases.COURSES:
                row, flown, fleet = stage.fly(
                    vehicles, policy, course, cases.PLAIN, vehicles.flights
                )
                if vehicles is cases.DRAWN:
                    row["turns"] = [round(float(turn), 1) for turn in fleet.turn]
                    row["errors"] = {
                        name: [round(float(e), 4) for e in one.error] for name, one in flown.items()
                    }
                print(f"{policy}, {vehicles.name}, {course.name}", flush=True)
                yield row


def variant_rows(stage: Stage) -> Iterator[Row]:
    """Flights with one term changed."""
    for vehicles, policy, course, variants in cases.VARIANTS:
        for variant in variants[: 2 if stage.quick else None]:
            row, _, _ = stage.fly(vehicles, policy, course, variant, VARIED)
            print(f"{policy}, {vehicles.name}: {variant.name}", flush=True)
            yield {**row, "variant": variant.name}


def started_peer(quick: bool) -> Peer | None:
    """The program in its environment; of a trial None if that is not installed.

    Raises:
        RunError: it cannot be installed.
    """
    ready: Path = environments.FOLDER / "raptor/bin/python"
    if quick and not ready.is_file():
        print("left out: RAPTOR's policy and L2F, which a full run installs into .peers")
        return None
    try:
        with environments.alone():
            return Peer(environments.python_of("raptor"))
    except environments.Skipped as why:
        raise RunError(str(why)) from None


def main(arguments: list[str] | None = None) -> int:
    """Trains, flies, writes; returns the exit code."""
    options = Options(__doc__, __name__, "few flights of 0.3 s").of_runs().given(arguments)
    peer = started_peer(options.quick)
    try:
        stage = Stage(options, peer)
        content = {
            **heading(EXPERIMENT, options),
            "rows": list(main_rows(stage)),
            "variants": list(variant_rows(stage)),
        }
    finally:
        if peer is not None:
            peer.close()
    if peer is None:
        print("no page: half of it is missing")
        return 0
    draw(content["rows"], options.out / f"images/{PAGE}.png")
    write_page(options.out, PAGE, page(content, machine_line(content["machine"])), content)
    return 0
