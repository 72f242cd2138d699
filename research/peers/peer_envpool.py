"""EnvPool's own overhead: its cheapest environments, Gymnasium's classic control, in C++.

Its rate is an upper bound for its engine with a quadrotor. Synchronous (all environments in each
call) and asynchronous (the half that is ready first), on two threads.
"""

from __future__ import annotations

import functools

import envpool
import measure
import numpy as np

TASKS = ("CartPole-v1", "Pendulum-v1")
DIFFERS = "no quadrotor: environment steps with observation, reward, ends, resets and infos"


def peer() -> measure.Peer:
    return measure.Peer("EnvPool", envpool.__version__, "its own classic control", DIFFERS)


def actions_for(pool: object, count: int) -> np.ndarray:
    space = pool.action_space  # type: ignore[attr-defined]
    shape = (count, *space.shape)
    return np.zeros(shape, space.dtype)


def synchronous(effort: measure.Effort, task: str, envs: int) -> None:
    pool = envpool.make(task, env_type="gymnasium", num_envs=envs, num_threads=2)
    actions = actions_for(pool, envs)
    pool.reset()
    line(effort, lambda: pool.step(actions), task, envs, envs, "sync")
    pool.close()


def asynchronous(effort: measure.Effort, task: str, envs: int) -> None:
    batch = envs // 2
    pool = envpool.make(task, env_type="gymnasium", num_envs=envs, batch_size=batch, num_threads=2)
    actions = actions_for(pool, batch)
    pool.async_reset()

    def call() -> None:
        info = pool.recv()[4]
        pool.send(actions, info["env_id"])

    line(effort, call, task, envs, batch, f"async, batch_size={batch}")
    pool.close()


def line(
    effort: measure.Effort, call: measure.Call, task: str, envs: int, batch: int, how: str
) -> None:
    peer().line(
        rate=measure.best_rate(call, batch, effort),
        mode=f"{task}, {how}, 2 threads",
        cores=2,
        envs=envs,
        robots=1,
        substeps=1,
        task="engine",
        differs=DIFFERS,
        unit="environment steps/s",
    )


def main() -> None:
    effort = measure.parse(__doc__)
    measure.use_cores(2)
    for task in TASKS:
        for envs in (1024,) if effort.quick else (128, 1024, 8192):
            for way in (synchronous, asynchronous):
                peer().attempt(f"{task}, {envs}", functools.partial(way, effort, task, envs))


if __name__ == "__main__":
    main()
