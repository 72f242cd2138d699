"""A simulation as the vehicle of the program onboard, in lockstep."""

from __future__ import annotations

import socket

import numpy as np
from numpy.typing import NDArray

from skybody import Simulation

from . import packets

HOST = "127.0.0.1"
WAIT = 10.0  # longest wait for an answer [s]
OWNERS = ("task.", "obstacles.")  # parameters that a task reads


class Vehicle:
    """Sends the state of a simulation and takes the program's commands."""

    def __init__(self, simulation: Simulation, port: int, robot: str = "") -> None:
        """Connects to the program at a port of this machine.

        Args:
            simulation: of one vehicle or several; its episode has begun.
            port: of the program, UDP.
            robot: that flies; may be left out for a single one.
        """
        self.simulation = simulation
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.settimeout(WAIT)
        self._socket.connect((HOST, port))
        compiled = simulation.compiled
        self._base = next(
            k for k, name in enumerate(compiled.bodies) if name.startswith(f"{robot}.") or not robot
        )
        self._imus = [
            path.removesuffix("specific_force")
            for path in simulation.state_paths()
            if path.endswith(".specific_force")
        ]
        self._given: dict[str, float] = {}  # parameters sent so far; others are the mission's
        self._sequence = 0
        self._clock, self._begun = 0.0, 0.0

    def close(self) -> None:
        """Closes the socket."""
        self._socket.close()

    def begin(self) -> None:
        """The policy begins an episode: its drawn parameters, and a clock that goes on."""
        self._send(packets.control(self._sequence, True))
        compiled, simulation = self.simulation.compiled, self.simulation
        for path in compiled.param_paths:
            value = simulation.param(path)
            if path.startswith(OWNERS) and value != self._given.get(
                path, compiled.param_info(path)[0]
            ):
                self._given[path] = value
                self._send(packets.param(self._sequence, path, [value]))
        self._begun = self._clock + 1.0

    def ask(self) -> packets.Command:
        """Sends the state, that of the base last, and waits for the command.

        Raises:
            TimeoutError: no answer came.
        """
        self._clock = self._begun + self.simulation.time
        self._send_imu()
        bodies = self.simulation.bodies
        order = [k for k in range(len(bodies)) if k != self._base] + [self._base]
        for k in order:
            body = bodies[k]
            self._send(
                packets.state(
                    self._sequence,
                    self._clock,
                    body.position,
                    body.rotation,
                    body.velocity,
                    body.angular_velocity,
                    packets.BASE if k == self._base else k,
                )
            )
        return packets.read_command(self._socket.recv(4096))

    def _send(self, packet: bytes) -> None:
        self._socket.send(packet)
        self._sequence += 1

    def _send_imu(self) -> None:
        for imu in self._imus:
            force = self.simulation.state(imu + "specific_force")
            rate = self.simulation.state(imu + "angular_rate")
            self._send(packets.imu(self._sequence, self._clock, force, rate))


def fly(
    simulation: Simulation,
    vehicle: Vehicle,
    entries: NDArray[np.int_] | None = None,
    steps: int = 10**9,
) -> list[packets.Command]:
    """Flies the episode that has begun under the program's actions, until it ends.

    Args:
        entries: of the action row that the program gives; None: all.
        steps: at most so many.

    Returns:
        The answers, one of each step.
    """
    answers: list[packets.Command] = []
    row = np.zeros(simulation.compiled.action_size, np.float32)
    vehicle.begin()
    while not (simulation.terminated or simulation.truncated) and len(answers) < steps:
        answers.append(vehicle.ask())
        row[slice(None) if entries is None else entries] = answers[-1].action
        simulation.step(row)
    return answers
