"""gym-pybullet-drones: CtrlAviary, PyBullet's physics at 1 kHz, one and two processes.

Needs a checkout, since it is in no registry: `--checkout FOLDER`. Its own physics (DYN, explicit,
in Python) is slower than PyBullet's. Environments are stepped one after the other in each process,
the usual way of many `gym` environments in one loop.
"""

from __future__ import annotations

import contextlib
import functools
import importlib.metadata
import io
import pathlib
import re
import sys
from typing import Any

import measure
import numpy as np
import processes

DIFFERS = "Crazyflie 2; contact on; ground plane; no rotor lag; 20 states"


def peer(checkout: pathlib.Path) -> measure.Peer:
    found = re.search(r'^version = "(.+)"$', (checkout / "pyproject.toml").read_text(), re.M)
    engine = f"Bullet (PyBullet {importlib.metadata.version('pybullet')})"
    return measure.Peer("gym-pybullet-drones", found[1] if found else "", engine, DIFFERS)


class Aviaries:
    """A number of CtrlAviary with a number of drones each, in the caller's process."""

    def __init__(self, envs: int, robots: int, substeps: int) -> None:
        from gym_pybullet_drones.envs.CtrlAviary import CtrlAviary

        starts = np.array([[0.7 * k, 0.7 * k, 1.5] for k in range(robots)])
        make = functools.partial(
            CtrlAviary,
            num_drones=robots,
            initial_xyzs=starts,
            pyb_freq=1000,
            ctrl_freq=1000 // substeps,
        )
        with contextlib.redirect_stdout(io.StringIO()):  # it prints its parameters
            self.aviaries: list[Any] = [make() for _ in range(envs)]
        for aviary in self.aviaries:
            aviary.reset()
        self.hover = self.aviaries[0].HOVER_RPM

    def step(self, commands: processes.Array, states: processes.Array) -> None:
        """commands: rotor speeds relative to hover (envs, robots, 4)."""
        for aviary, speeds, rows in zip(self.aviaries, self.hover * commands, states, strict=True):
            rows[:] = aviary.step(speeds)[0]


def row(
    effort: measure.Effort,
    who: measure.Peer,
    envs: int,
    cores: int,
    robots: int = 1,
    substeps: int = 1,
) -> None:
    make = functools.partial(Aviaries, robots=robots, substeps=substeps)
    used = f"{cores} process{'es' if cores > 1 else ''}"
    batch = processes.Batch(make, np.ones((envs, robots, 4)), (robots, 20), cores)

    def check() -> None:
        measure.require(bool(np.abs(batch()[..., 2] - 1.5).max() < 1.0), "a vehicle did not hover")
        before = batch()[..., 12].copy()
        batch.commands *= np.sqrt(1.1)
        measure.require_climb((batch()[..., 12] - before).min(), 0.001 * substeps)

    try:
        who.row(
            batch,
            effort,
            mode=f"CtrlAviary, {used}, {substeps} steps an action",
            cores=cores,
            envs=envs,
            robots=robots,
            substeps=substeps,
            task="hover" if robots == 1 else "robots",
            check=check,
        )
    finally:
        batch.close()


def main() -> None:
    parser = measure.parser(__doc__)
    parser.add_argument(
        "--checkout", type=pathlib.Path, required=True, help="folder of its repository"
    )
    options = parser.parse_args()
    effort = measure.effort(parser, options)
    sys.path.insert(0, str(options.checkout))
    measure.use_cores(2)
    who = peer(options.checkout)
    attempt, some = who.attempt, functools.partial
    for envs, cores, substeps in ((1, 1, 1), (1, 1, 10), (16, 2, 1), (16, 2, 10)):
        attempt(f"hover, {envs}", some(row, effort, who, envs, cores, substeps=substeps))
    for robots in measure.ROBOTS:
        attempt(f"{robots} robots", some(row, effort, who, 4, 2, robots=robots))


if __name__ == "__main__":
    main()
