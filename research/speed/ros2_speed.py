"""A policy as a node of ROS 2 beside the same policy in one process: speed, latency, flight error.

    .peers/ros/bin/python -m research run ros2_speed [--steps 5000] [--seconds 30] [--quick]

`./dev ros` installs that Python. `skybody ros2 trajectory_ctbr` is one process, the shipped policy
another one, both on this machine. In lockstep each action makes one step (10 ms of flight), and a
round trip is the time from an action to the next observation. In real time the simulation runs by
the clock; observations should come every 10 ms, and each action takes effect in the next step.
Writes ros2_speed.md and its JSON. Fails if the flight in lockstep has other observations than the
one in process.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from skybody import Simulation
from skybody.train.policy_file import Policy, read_policy, shipped_policy

from research.common.machine import facts, machine_line
from research.common.options import Options
from research.common.pages import markdown_table, write_page
from research.common.programs import RunError

PAGE = "ros2_speed"

SCENARIO = "trajectory_ctbr"
SEED = 5
MAP = """
publish:
  - {topic: /quad/observation, type: std_msgs/msg/Float32MultiArray, from: observation}
  - {topic: /quad/info, type: std_msgs/msg/Float32MultiArray, from: info}
command:
  - {topic: /quad/action, type: std_msgs/msg/Float32MultiArray, to: action}
"""
LOCAL = {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
SETTLED = 5.0  # of a flight, before its errors count [s]
QUANTILES = (50.0, 99.0, 99.9, 100.0)  # [%]

Row = NDArray[np.float32]


def in_process(policy: Policy, steps: int) -> tuple[list[Row], list[float], float]:
    """Observations, position errors [m] and steps/s without ROS."""
    simulation = Simulation(SCENARIO, seed=SEED)
    simulation.reset()
    seen, errors = [], []
    first = error_index(simulation)
    begin = time.perf_counter()
    for _ in range(steps):
        seen.append(simulation.observation)
        action = policy(seen[-1][None])[0].astype(np.float32)
        if simulation.terminated or simulation.truncated:
            simulation.reset()  # as the node does
        else:
            simulation.step(action)
        errors.append(float(simulation.info[first]))
    return seen, errors, steps / (time.perf_counter() - begin)


def error_index(simulation: Simulation) -> int:
    """Place of the position error among the infos."""
    return next(c.first for c in simulation.compiled.info_channels if c.name == "position_error")


class Flight:
    """A policy node, with the times at which observations came."""

    def __init__(self, policy: Policy) -> None:
        import rclpy
        from std_msgs.msg import Float32MultiArray

        self._rclpy, self._message, self._policy = rclpy, Float32MultiArray, policy
        self.node = rclpy.create_node("policy")
        self._actions = self.node.create_publisher(Float32MultiArray, "/quad/action", 10)
        self.node.create_subscription(Float32MultiArray, "/quad/observation", self._act, 10)
        self.node.create_subscription(Float32MultiArray, "/quad/info", self._note, 10)
        self.seen: list[Row] = []
        self.infos: list[Row] = []
        self.came: list[float] = []
        self.sent: list[float] = []

    def ask(self) -> None:
        """Asks for the first states, once both nodes see each other."""
        from std_srvs.srv import Trigger

        service = self.node.create_client(Trigger, "/skybody/states")
        while self.node.count_subscribers("/quad/action") == 0 or not service.wait_for_service(1.0):
            time.sleep(0.05)
        service.call_async(Trigger.Request())

    def spin_until(self, done: Callable[[], bool]) -> None:
        """Flies until a condition holds, for at most ten minutes."""
        until = time.monotonic() + 600.0
        while not done():
            if time.monotonic() > until:
                raise RunError("the nodes do not answer one another")
            self._rclpy.spin_once(self.node, timeout_sec=1.0)

    def _act(self, message: Any) -> None:
        self.came.append(time.perf_counter())
        self.seen.append(np.array(message.data, np.float32))
        action = self._policy(self.seen[-1][None])[0].astype(np.float32)
        self._actions.publish(self._message(data=action.tolist()))
        self.sent.append(time.perf_counter())

    def _note(self, message: Any) -> None:
        self.infos.append(np.array(message.data, np.float32))


def flown(policy: Policy, options: list[str], done: Callable[[Flight], bool]) -> Flight:
    """Flies against a node of its own."""
    import rclpy

    os.environ.update(LOCAL, ROS_DOMAIN_ID=str(os.getpid() % 90 + 1))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "map.yaml"
        path.write_text(MAP)
        command = [sys.executable, "-m", "skybody.ros2", SCENARIO, "--map", str(path)]
        process = subprocess.Popen(
            [*command, "--seed", str(SEED), *options], stdout=subprocess.PIPE, text=True
        )
        try:
            assert process.stdout is not None
            process.stdout.readline()  # it is there
            rclpy.init()
            flight = Flight(policy)
            flight.ask()
            flight.spin_until(lambda: done(flight))
            flight.node.destroy_node()
            rclpy.try_shutdown()
            return flight
        finally:
            process.terminate()
            process.wait()


def quantiles(values: NDArray[np.float64]) -> list[float]:
    """QUANTILES of times [ms]."""
    return [1e3 * float(np.percentile(values, q)) for q in QUANTILES]


def measured(steps: int, seconds: float) -> dict[str, Any]:
    """All figures.

    Raises:
        RunError: the flight in lockstep is another one.
    """
    policy = read_policy(shipped_policy(SCENARIO))
    period = Simulation(SCENARIO).compiled
    step = period.dt * period.action_repeat
    ticks = round(seconds / step)
    alone, errors, rate = in_process(policy, max(steps, ticks))
    locked = flown(policy, [], lambda flight: len(flight.seen) > steps)
    if any(not np.array_equal(a, b) for a, b in zip(alone, locked.seen[:steps], strict=False)):
        raise RunError("the flight through ROS 2 is not that of one process")
    trips = np.array(locked.came[1 : steps + 1]) - np.array(locked.sent[:steps])
    real = flown(policy, ["--real-time", "1"], lambda flight: len(flight.seen) > ticks)
    spans = np.diff(real.came)
    settled, first = round(SETTLED / step), error_index(Simulation(SCENARIO))
    through = [float(row[first]) for row in real.infos[settled:ticks]]
    return {
        **facts(),
        "steps": steps,
        "seconds": seconds,
        "in_process": rate,
        "lockstep": steps / (locked.came[steps] - locked.came[0]),
        "round_trip_ms": quantiles(trips),
        "late_ms": quantiles(np.abs(spans - step)),
        "error_in_process": float(np.mean(errors[settled:ticks])),
        "error_real_time": float(np.mean(through)),
    }


def page(found: dict[str, Any]) -> str:
    """The page."""
    names = ("p50", "p99", "p99.9", "greatest")
    speed = [
        ["", "steps/s"],
        ["one process", f"{found['in_process']:,.0f}"],
        ["two processes, lockstep over ROS 2", f"{found['lockstep']:,.0f}"],
    ]
    trips = [f"{t:.3f}" for t in found["round_trip_ms"]]
    late = [f"{t:.3f}" for t in found["late_ms"]]
    times = [
        ["[ms]", *names],
        ["round trip in lockstep", *trips],
        ["in real time: interval of observations less 10 ms", *late],
    ]
    errors = [
        ["mean position error", "m"],
        ["one process", f"{found['error_in_process']:.4f}"],
        ["ROS 2 in real time", f"{found['error_real_time']:.4f}"],
    ]
    return "\n".join(
        [
            "# A policy as a node of ROS 2\n",
            f"`skybody ros2 {SCENARIO}` and its shipped policy (evaluated by NumPy), a process "
            "each, on the loopback interface (rclpy, Fast DDS). In lockstep "
            f"{found['steps']:,} steps had the same bits as in one process.\n",
            markdown_table(speed) + "\n",
            markdown_table(times) + "\n",
            f"Flights of {found['seconds']:g} s, from {SETTLED:g} s on:\n",
            markdown_table(errors) + "\n",
            machine_line(found) + "\n",
        ]
    )


def main() -> int:
    """Measures, writes; returns the exit code."""
    options = (
        Options(__doc__, __name__, "200 steps, 7 seconds")
        .add("--steps", type=int, default=5000, help="in lockstep; default: 5000")
        .add("--seconds", type=float, default=30.0, help="in real time; default: 30")
        .given()
    )
    steps, seconds = (200, 7.0) if options.quick else (options.steps, options.seconds)
    content = measured(steps, seconds)
    write_page(options.out, PAGE, page(content), content)
    return 0
