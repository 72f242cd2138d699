"""MuJoCo through its Python package: mj_step on one core and mujoco.rollout on two threads.

rollout uses the fastest documented settings: one Rollout object for all calls, outputs allocated
once, no checks; the final states of one call are the initial states of the next.
"""

from __future__ import annotations

import functools

import measure
import mujoco
import mujoco.rollout
import mujoco_worlds as worlds
import numpy as np
import vehicle

FULL = mujoco.mjtState.mjSTATE_FULLPHYSICS.value
CONTROL = mujoco.mjtState.mjSTATE_CTRL.value
FORCE = mujoco.mjtState.mjSTATE_QFRC_APPLIED.value


def peer() -> measure.Peer:
    version = mujoco.__version__
    return measure.Peer("MuJoCo", version, f"MuJoCo {version}", worlds.DIFFERS)


def one_world(effort: measure.Effort, substeps: int, motors: bool) -> None:
    """mj_step called from Python; with several steps per call the loop over them is in C."""
    work = worlds.Work(1, substeps=substeps, motors=motors)
    model = work.model()
    data = mujoco.MjData(model)
    command, state = work.thrusts()[0, 0], np.empty(13)
    mixer, force = worlds.MIXER, data.qfrc_applied

    def push() -> None:
        """As Wrenches.write, with Python numbers, which are faster for one world."""
        thrust, *moments = (mixer @ command).tolist()
        w, x, y, z = data.qpos[3:].tolist()
        force[:] = (
            2.0 * thrust * (x * z + w * y),
            2.0 * thrust * (y * z - w * x),
            thrust * (1.0 - 2.0 * (x * x + y * y)),
            *moments,
        )

    def call() -> None:
        if motors:
            data.ctrl[:] = command
        else:
            push()
        mujoco.mj_step(model, data, substeps)
        state[:7] = data.qpos
        state[7:] = data.qvel

    mode = f"mj_step, {work.way}" + (", nstep in C" if substeps > 1 else "")

    def check() -> None:
        worlds.check_hover(state[2])
        before = float(state[9])
        command[:] *= 1.1
        call()
        measure.require_climb(state[9] - before, substeps * vehicle.DT)

    peer().row(call, effort, mode=mode, cores=1, substeps=substeps, check=check)


class Rollout:
    """A number of worlds of a model, by mujoco.rollout."""

    def __init__(self, work: worlds.Work, threads: int) -> None:
        self.work = work
        model, envs, substeps = work.model(), work.envs, work.substeps
        data = mujoco.MjData(model)
        state = np.empty(mujoco.mj_stateSize(model, FULL))
        mujoco.mj_getState(model, data, state, FULL)
        self.models = [model] * envs
        self.data = [mujoco.MjData(model) for _ in range(max(1, threads))]
        self.pool = mujoco.rollout.Rollout(nthread=threads)
        self.spec = CONTROL if work.motors else FORCE
        self.thrusts = work.thrusts()
        self.control = np.zeros((envs, substeps, mujoco.mj_stateSize(model, self.spec)))
        self.states = [np.empty((envs, substeps, len(state))) for _ in range(2)]
        self.states[1][:] = state
        self.initial = np.empty((envs, len(state)))
        positions = slice(1, 1 + model.nq)  # behind the time
        self.velocities = slice(positions.stop, positions.stop + model.nv)
        self.wrenches = [
            worlds.Wrenches(work.robots, s[:, -1, positions], self.control[:, 0])
            for s in self.states
        ]

    def first(self, last: worlds.Array) -> worlds.Array:
        """The initial states of a call; with one step per call they are the last call's array."""
        if self.work.substeps == 1:
            return last[:, 0]
        self.initial[:] = last[:, -1]
        return self.initial

    def __call__(self) -> worlds.Array:
        """The time and the states of all worlds after each step: (envs, substeps, 1 + states)."""
        new, last = self.states
        if self.work.motors:
            self.control.reshape(len(last), self.work.substeps, -1, 4)[:] = self.thrusts[:, None]
        else:
            self.wrenches[1].write(self.thrusts)
        self.pool.rollout(
            self.models,
            self.data,
            self.first(last),
            self.control,
            control_spec=self.spec,
            skip_checks=True,
            nstep=self.work.substeps,
            state=new,
        )
        self.states.reverse()
        self.wrenches.reverse()
        return new

    def check(self) -> None:
        states = self()[:, -1]
        worlds.check_hover(states[:, 3])
        before = self.climbing(states).copy()
        self.thrusts *= 1.1
        speed = self.climbing(self()[:, -1])
        measure.require_climb((speed - before).min(), self.work.substeps * vehicle.DT)

    def climbing(self, states: worlds.Array) -> worlds.Array:
        """Upward speed of each robot, (envs, robots) [m/s]."""
        velocities = states[:, self.velocities]
        return worlds.robots_of(velocities, self.work.robots)[..., 2]


def rollout(effort: measure.Effort, work: worlds.Work) -> None:
    threads = 2 if work.envs > 1 else 0  # 0: on the caller's own
    batch = Rollout(work, threads)
    peer().row(
        batch,
        effort,
        mode=f"rollout, {threads or 1} thread{'s' if threads else ''}, {work.way}",
        cores=max(1, threads),
        differs="states after each of the steps" if work.substeps > 1 else "",
        check=batch.check,
        **work.row(),
    )


def main() -> None:
    effort = measure.parse(__doc__)
    measure.use_cores(2)
    attempt, some = peer().attempt, functools.partial
    for substeps, motors in ((1, False), (1, True), (100, True)):
        attempt(f"mj_step, {substeps}", some(one_world, effort, substeps, motors))
    for work in worlds.batch_work(effort, most=8192):
        attempt(work.name(), some(rollout, effort, work))


if __name__ == "__main__":
    main()
