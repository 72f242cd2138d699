"""The policy's process: trials of 200 wrenches through a middleware, each from the same state.

python -m research.sync.agent ros2 --loop open --trials 100 --out trials.npz [--free]

With --free an action is sent every 10 ms by the clock on the wall, on the newest odometry;
otherwise as soon as the odometry of the action before it is there.
"""

from __future__ import annotations

import argparse
import importlib
import json
import time
from pathlib import Path

import numpy as np

from research.sync.link import Link
from research.sync.work import ACTS, END, LOOPS, PERIOD, RESTORE, STEPS, WRENCHES, Act, Observation

LINKS = {
    "ros2": ("link_ros2", "Ros2Link"),
    "cyclone": ("link_native", "cyclone"),
    "gazebo": ("link_native", "gazebo"),
    "ros1": ("link_ros1", "Ros1Link"),
}
NOTHING = np.zeros(6)
ANSWER = 2.0  # longest time of an answer [s]
TRIES, PAUSE = 100, 0.2  # until the first answer; between two tries [s]


class Trials:
    """Notes of the policy: its actions, and the odometry that came."""

    def __init__(self) -> None:
        self.actions: list[tuple[float, ...]] = []  # trial, action, step of its odometry, time sent
        self.came: list[tuple[float, ...]] = []  # trial, step, time

    def fly(self, link: Link, act: Act, trial: int, is_free: bool) -> None:
        """One trial."""
        seen = begun(link, trial)
        start = time.perf_counter()
        for action in range(WRENCHES):
            if is_free:
                link.spin_until(start + PERIOD * action)
                assert link.newest is not None
                seen = link.newest
            wrench = act(action, seen)
            sent = time.perf_counter()
            link.send(str(action), wrench)
            self.actions.append((trial, action, seen.step, sent))
            if not is_free:
                seen = answered(link, STEPS * (action + 1))
        if is_free:
            link.spin_until(start + PERIOD * (WRENCHES + 2))
        self.came += [(trial, one.step, one.came) for one in link.came]

    def write(self, path: Path) -> None:
        """Writes both tables."""
        np.savez(path, actions=np.array(self.actions), came=np.array(self.came))


def newest_steps(link: Link, act: Act, seconds: float) -> dict[str, float]:
    """Steps that send an action and return the newest odometry that is there.

    Returns:
        `calls` in `seconds`, and how many of them returned `other` odometry than the one before.
    """
    seen = begun(link, 0)
    start, calls, other = time.perf_counter(), 0, 0
    while (now := time.perf_counter()) - start < seconds:
        link.send(str(calls % WRENCHES), act(calls % WRENCHES, seen))
        link.spin(0.0)
        assert link.newest is not None
        other += link.newest is not seen
        seen, calls = link.newest, calls + 1
    return {"calls": calls, "other": other, "seconds": now - start}


def connect(link: Link) -> None:
    """Sends wrenches until one has moved the simulation: messages go both ways.

    Raises:
        RuntimeError: nothing answers.
    """
    for _ in range(TRIES):
        link.send("0", NOTHING)
        link.spin_until(time.perf_counter() + PAUSE)
        if link.newest is not None and link.newest.step > 0:
            return
    raise RuntimeError("the simulator does not answer")


def begun(link: Link, trial: int) -> Observation:
    """Puts the simulation back to its first state; the odometry of it.

    Raises:
        RuntimeError: nothing answers.
    """
    link.forget()
    link.send(f"{RESTORE} {trial}", NOTHING)
    seen = answered(link, 0)
    link.came = [seen]  # none of the trial before
    return seen


def answered(link: Link, step: int) -> Observation:
    """The odometry of a physics step.

    Raises:
        RuntimeError: it does not come.
    """
    if (seen := link.wait_for(step, ANSWER)) is None:
        raise RuntimeError(f"the odometry of step {step} does not come")
    return seen


def main() -> None:
    """Flies all trials."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("middleware", choices=LINKS)
    parser.add_argument("--loop", choices=LOOPS, required=True)
    parser.add_argument("--trials", type=int, default=1)
    parser.add_argument("--free", action="store_true")
    parser.add_argument("--newest", type=float, metavar="SECONDS", help="steps without waiting")
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args()
    module, name = LINKS[options.middleware]
    link: Link = getattr(importlib.import_module(f"research.sync.{module}"), name)()
    connect(link)
    if options.newest is not None:
        found = newest_steps(link, ACTS[options.loop](), options.newest)
        options.out.write_text(json.dumps(found))
        return
    trials = Trials()
    for trial in range(options.trials):
        trials.fly(link, ACTS[options.loop](), trial, options.free)
    link.send(END, NOTHING)
    trials.write(options.out)
    time.sleep(0.2)  # the last message goes out
    link.close()


if __name__ == "__main__":
    main()
