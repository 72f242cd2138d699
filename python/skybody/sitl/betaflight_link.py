"""Betaflight's SITL in the loop: a state packet, then its motor packet, then physics steps.

Betaflight's clock is that of the wall, scaled by the spacing of the state packets. They are
therefore sent at a steady rate on the wall, `factor` times that of the simulation.
"""

from __future__ import annotations

import socket
import time

import numpy as np

from . import betaflight
from .betaflight_pilot import HoldPilot
from .betaflight_program import CONSOLE, BetaflightProgram, console
from .frames import Array
from .messages import Messages
from .sockets import HOST, bound
from .vehicle import Reading, Vehicle

MOTOR_PORT, STATE_PORT, RADIO_PORT = 9002, 9003, 9004
STATE_PERIOD = 0.001  # [s]
RADIO_PERIOD = 0.004  # [s]
ANSWER = 0.02  # on the wall, longest wait for motors; then the state is sent again [s]
LATE = 0.1  # on the wall, behind the wanted rate before that begins anew [s]
STARTS, PROBES = 8, 50  # of Betaflight; answers of one whose clock runs
SILENCE = 2.0  # on the wall, before a message [s]


class BetaflightLink:
    """One Betaflight, started here or by somebody else."""

    def __init__(
        self,
        vehicle: Vehicle,
        pilot: HoldPilot | None,
        factor: float,
        messages: Messages | None = None,
    ) -> None:
        """factor: simulated time over that on the wall."""
        self.vehicle = vehicle
        self.messages = messages or Messages()
        self.pilot = pilot
        self.factor = factor
        self.steps = vehicle.steps_for(STATE_PERIOD)
        self.throttles: Array = np.zeros(4)
        self.late = 0.0  # of Betaflight's clock before ours, by repeated states [s]
        self._next_radio = 0.0

    # --- packets --------------------------------------------------------------------------------

    def take(self, packet: bytes) -> bool:
        """Takes a packet of motors; False for others."""
        try:
            values = betaflight.decode_motors(packet)
        except ValueError as error:
            self.messages.warn("ignored", f"{error}; ignored")
            return False
        if not np.isfinite(values).all():
            self.messages.warn("not finite", "a motor value is not finite: its motor stops")
        self.throttles = np.clip(np.nan_to_num(values, nan=0.0), 0.0, 1.0)
        return True

    def state(self, reading: Reading) -> bytes:
        """The state packet."""
        stamp = reading.time + self.late
        return betaflight.encode_state(reading, self.vehicle.setup.home, stamp)

    def radio(self, reading: Reading) -> bytes | None:
        """The radio's packet; None if it is not due, or somebody else sends it."""
        if self.pilot is None or reading.time < self._next_radio - 0.5 * self.vehicle.dt:
            return None
        self._next_radio += RADIO_PERIOD
        channels = self.pilot.channels(reading, bool(self.throttles.any()))
        return betaflight.encode_radio(reading.time, channels)

    # --- connection -----------------------------------------------------------------------------

    def serve(self, seconds: float, program: BetaflightProgram | None) -> None:
        """Flies until the simulated time is over; waits for a Betaflight that is silent."""
        with bound(socket.SOCK_DGRAM, MOTOR_PORT, "(Betaflight has no other)") as link:
            link.settimeout(ANSWER)
            self._await_console(program)
            if program is not None:
                self._await_clock(link, program)
            begun, first = time.monotonic(), self.vehicle.time
            while self.vehicle.time < seconds:
                waited = self._exchange(link, self.vehicle.read(), program)
                self.vehicle.advance(self.throttles, self.steps)
                due = begun + (self.vehicle.time - first) / self.factor
                left = due - time.monotonic()
                if waited or left < -LATE:  # late: the clock begins anew
                    begun, first = time.monotonic(), self.vehicle.time
                elif left > 0.0:
                    time.sleep(left)

    def _await_console(self, program: BetaflightProgram | None) -> None:
        """Betaflight is up when its console is; states that come earlier confuse its clock."""
        if program is not None:
            program.console().close()
            return
        self.messages.say(f"waiting  for Betaflight's TCP port {CONSOLE}")
        while True:
            try:
                console(1.0).close()
                return
            except TimeoutError:
                continue

    def _await_clock(self, link: socket.socket, program: BetaflightProgram) -> None:
        """Starts Betaflight anew until its clock runs.

        At its first states the clock sometimes leaps by an hour: its control loop then waits for
        that time.

        Raises:
            ValueError: it does not answer after some starts.
        """
        for _ in range(STARTS):
            reading, answers = self.vehicle.read(), 0
            end = time.monotonic() + SILENCE
            while answers < PROBES and time.monotonic() < end:
                link.sendto(self.state(reading), (HOST, STATE_PORT))
                self.late += STATE_PERIOD
                try:
                    answers += self.take(link.recv(4096))
                except (TimeoutError, ConnectionError):
                    continue
                time.sleep(STATE_PERIOD / self.factor)
            if answers == PROBES:
                return
            self.messages.counts["starts of Betaflight that failed"] += 1
            program.restart()
            program.console().close()
        raise ValueError(f"Betaflight answers to no state after {STARTS} starts")

    def _exchange(
        self, link: socket.socket, reading: Reading, program: BetaflightProgram | None
    ) -> bool:
        """Sends a state until motors answer; whether that took more than one packet.

        A repeated state has a later time stamp. Betaflight's clock runs by the differences of the
        stamps: it stands still after a long pause, until there is another difference.
        """
        radio = self.radio(reading)
        if radio is not None:
            link.sendto(radio, (HOST, RADIO_PORT))
        begun, told, tries = time.monotonic(), False, 0
        while True:
            link.sendto(self.state(reading), (HOST, STATE_PORT))
            tries += 1
            try:
                while not self.take(link.recv(4096)):
                    continue
                return tries > 1
            except (TimeoutError, ConnectionError):
                self.messages.counts["late answers"] += 1
                self.late += STATE_PERIOD
            if program is not None:
                program.check()
            if not told and time.monotonic() - begun > SILENCE:
                self.messages.say("waiting  Betaflight is silent")
                told = True
