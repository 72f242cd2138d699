"""RAPTOR's policy and L2F's vehicles, served over standard input and output.

J. Eschmann et al., "RAPTOR: A Foundation Policy for Quadrotor Control", 2025, and its simulator
L2F. A request is a line of JSON; arrays of 32-bit floats with its `shapes` follow. The answer is
the shape of an array, a line of JSON, and the array. Requests by `do`:

    forget                        the policy begins new episodes; answers with nothing to read: [0]
    act      observations (n, 22) actions (n, 4) of the policy
    world    vehicles, starts, dt makes n vehicles; their states (n, 18)
    step     throttles (n, 4)     advances them by `count` steps; their states

A state is position (3), rotation matrix by rows (9), velocity (3), angular velocity in B (3).
"""

from __future__ import annotations

import json
import sys
from typing import Any

import foundation_policy
import l2f
import numpy as np

NUMBERS = 18  # of a state


class World:
    """Vehicles of L2F. Its batches have powers of two as sizes: the rest are copies of the first.

    `vehicles` are changes of its parameters `dynamics`, one for each.
    """

    def __init__(self, vehicles: list[dict[str, Any]], starts: list[dict[str, Any]], dt: float):
        self.used = len(vehicles)
        size = 1 << (self.used - 1).bit_length()
        self.kind = getattr(l2f, f"vector{size}")
        self.device = l2f.Device()
        self.rng, self.env = self.kind.VectorRng(), self.kind.VectorEnvironment()
        self.parameters = self.kind.VectorParameters()
        self.now, self.next = self.kind.VectorState(), self.kind.VectorState()
        self.kind.initialize_rng(self.device, self.rng, 0)
        self.kind.initialize_environment(self.device, self.env)
        self.kind.initial_parameters(self.device, self.env, self.parameters)
        self.kind.initial_state(self.device, self.env, self.parameters, self.now)
        self.seen = np.zeros((size, self.env.OBSERVATION_DIM), np.float32)
        for k in range(size):
            self._set(k, vehicles[k if k < self.used else 0], starts[k if k < self.used else 0], dt)

    def _set(self, k: int, vehicle: dict[str, Any], start: dict[str, Any], dt: float) -> None:
        env, own = self.env.environments[k], self.parameters.parameters[k]
        values = json.loads(l2f.parameters_to_json(self.device, env, own))
        values["integration"]["dt"] = dt
        values["dynamics"] |= vehicle
        l2f.parameters_from_json(self.device, env, json.dumps(values), own)
        for name, value in start.items():
            setattr(self.now.states[k], name, value)

    def states(self) -> np.ndarray:
        """(n, 18)"""
        self.kind.observe(self.device, self.env, self.parameters, self.now, self.seen, self.rng)
        return self.seen[: self.used, :NUMBERS]

    def step(self, throttles: np.ndarray, count: int) -> None:
        """Advances by `count` steps with throttles in [0, 1]."""
        rows = np.zeros((len(self.seen), 4), np.float32)
        rows[: self.used] = 2.0 * throttles - 1.0
        for _ in range(count):
            self.kind.step(
                self.device, self.env, self.parameters, self.now, rows, self.next, self.rng
            )
            self.now, self.next = self.next, self.now


class Server:
    """Answers requests."""

    def __init__(self) -> None:
        self.policy = foundation_policy.Raptor()
        self.world: World | None = None

    def answer(self, request: dict[str, Any], arrays: list[np.ndarray]) -> np.ndarray:
        """The array that answers a request."""
        if request["do"] == "act":
            return self.policy.evaluate_step(arrays[0])
        if request["do"] == "world":
            self.world = World(request["vehicles"], request["starts"], request["dt"])
            return self.world.states()
        if request["do"] == "step" and self.world is not None:
            self.world.step(arrays[0], request["count"])
            return self.world.states()
        self.policy.reset()
        return np.zeros(1, np.float32)


def main() -> None:
    server, source, sink = Server(), sys.stdin.buffer, sys.stdout.buffer
    for line in source:
        request = json.loads(line)
        arrays = [
            np.frombuffer(source.read(4 * int(np.prod(shape))), np.float32).reshape(shape)
            for shape in request["shapes"]
        ]
        found = np.ascontiguousarray(server.answer(request, arrays), np.float32)
        sink.write(json.dumps(found.shape).encode() + b"\n" + found.tobytes())
        sink.flush()


if __name__ == "__main__":
    main()
