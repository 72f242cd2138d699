"""mjbatch: many MuJoCo worlds on a pool of C++ threads, their states bound to NumPy arrays.

As in its own example: bind once, write the controls' array, step; states change in place. Several
steps per call by its `nstep`.
"""

from __future__ import annotations

import functools
import importlib.metadata

import measure
import mujoco
import mujoco_worlds as worlds
import vehicle
from mjbatch import Batch


def peer() -> measure.Peer:
    version = importlib.metadata.version("mjbatch")
    return measure.Peer("mjbatch", version, f"MuJoCo {mujoco.__version__}", worlds.DIFFERS)


def batch(effort: measure.Effort, work: worlds.Work) -> None:
    threads = min(2, work.envs)
    sims = Batch(work.model(), num_sims=work.envs, num_threads=threads)
    position, velocity = sims.bind("qpos"), sims.bind("qvel")  # 13 states, live
    control = sims.bind("ctrl" if work.motors else "qfrc_applied")
    commands = work.thrusts()
    wrenches = None if work.motors else worlds.Wrenches(work.robots, position, control)

    def call() -> None:
        if wrenches:
            wrenches.write(commands)
        else:
            worlds.robots_of(control, work.robots)[:] = commands
        sims.step(nstep=work.substeps)

    def check() -> None:
        worlds.check_hover(worlds.robots_of(position, work.robots)[..., 2])
        speed = worlds.robots_of(velocity, work.robots)[..., 2]
        before = speed.copy()
        commands[:] *= 1.1
        call()
        measure.require_climb((speed - before).min(), work.substeps * vehicle.DT)

    peer().row(
        call,
        effort,
        mode=f"Batch.step, {threads} thread{'s' if threads > 1 else ''}, {work.way}",
        cores=threads,
        check=check,
        **work.row(),
    )


def main() -> None:
    effort = measure.parse(__doc__)
    measure.use_cores(2)
    attempt, some = peer().attempt, functools.partial
    for work in worlds.batch_work(effort, most=8192):
        attempt(work.name(), some(batch, effort, work))


if __name__ == "__main__":
    main()
