"""Betaflight's SITL in the loop: a state packet, then its motor packet, then physics steps.

Betaflight's clock is that of the wall, scaled by the spacing of the state packets. They are
therefore sent at a steady rate on the wall, `factor` times that of the simulation.
"""

from __future__ import annotations

import socket
import time
from typing import Protocol

import numpy as np

from . import betaflight
from .betaflight_program import CONSOLE, BetaflightProgram, console
from .frames import Array
from .messages import Messages
from .sockets import HOST, bound
from .vehicle import Reading, Vehicle

MOTOR_PORT, STATE_PORT, RADIO_PORT = 9002, 9003, 9004
STATE_PERIOD = 0.001  # [s]
ANSWER = 0.02  # on the wall, longest wait for motors; then the state is sent again [s]
LATE = 0.1  # on the wall, behind the wanted rate before that begins anew [s]
STARTS, PROBES = 8, 50  # of Betaflight; answers of one whose clock runs
WAITING = 1.0  # simulated time over that on the wall while the vehicle is held
SILENCE = 2.0  # on the wall, before a message [s]


class Pilot(Protocol):
    """Chooses the channels of the radio: roll, pitch, throttle, yaw, switches."""

    @property
    def radio_period(self) -> float:
        """Time between two packets [s]."""

    @property
    def waits(self) -> bool:
        """Whether the vehicle is held at its start, while Betaflight's clock runs."""

    @property
    def ended(self) -> bool:
        """Whether the flight is over."""

    def prepare(self, time: float, throttles: Array) -> list[float]:
        """Channels [us] while the vehicle is held, at Betaflight's time [s]."""

    def channels(self, reading: Reading, motors_turn: bool) -> list[float]:
        """Channels [us] in flight."""


class BetaflightLink:
    """One Betaflight, started here or by somebody else."""

    def __init__(
        self,
        vehicle: Vehicle,
        pilot: Pilot | None,
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
        self._next_radio += self.pilot.radio_period
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
            self._await_pilot(link, program)
            begun, first = time.monotonic(), self.vehicle.time
            while self.vehicle.time < seconds and not self._pilot_ended():
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

    def _await_pilot(self, link: socket.socket, program: BetaflightProgram | None) -> None:
        """Holds the vehicle at its start until the pilot is ready; the clock of the states runs."""
        reading, next_radio = self.vehicle.read(), 0.0
        begun, first = time.monotonic(), self.late
        while self.pilot is not None and self.pilot.waits:
            if self.late >= next_radio:
                next_radio = self.late + self.pilot.radio_period
                channels = self.pilot.prepare(self.late, self.throttles)
                link.sendto(betaflight.encode_radio(self.late, channels), (HOST, RADIO_PORT))
            waited = self._answer_to(link, reading, program)
            self.late += STATE_PERIOD
            left = begun + (self.late - first) / WAITING - time.monotonic()
            if waited or left < -LATE:
                begun, first = time.monotonic(), self.late
            elif left > 0.0:
                time.sleep(left)

    def _pilot_ended(self) -> bool:
        return self.pilot is not None and self.pilot.ended

    def _exchange(
        self, link: socket.socket, reading: Reading, program: BetaflightProgram | None
    ) -> bool:
        """Sends the radio's packet, if it is due, and a state. Returns as `_answer_to`."""
        radio = self.radio(reading)
        if radio is not None:
            link.sendto(radio, (HOST, RADIO_PORT))
        return self._answer_to(link, reading, program)

    def _answer_to(
        self, link: socket.socket, reading: Reading, program: BetaflightProgram | None
    ) -> bool:
        """Sends a state until motors answer; whether that took more than one packet.

        A repeated state has a later time stamp. Betaflight's clock runs by the differences of the
        stamps: it stands still after a long pause, until there is another difference.
        """
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
