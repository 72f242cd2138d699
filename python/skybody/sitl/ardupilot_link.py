"""ArduPilot in the loop: one packet of servo values, some physics steps, one reply."""

from __future__ import annotations

import math
import socket
import time
from typing import Any

from . import ardupilot
from .messages import Messages
from .sockets import bound
from .vehicle import Vehicle

PORT = 9002
SILENCE = 2.0  # on the wall, before a message that ArduPilot is gone [s]
RANGES = 6  # at most, in a reply


class ArdupilotLink:
    """Answers packets of ArduPilot."""

    def __init__(self, vehicle: Vehicle, messages: Messages | None = None) -> None:
        self.vehicle = vehicle
        self.messages = messages or Messages()
        self._frame: int | None = None  # count of the last packet
        self._due = 0.0  # physics steps that ArduPilot's rate has asked for and has not got
        self._reply = b""

    def answer(self, packet: bytes) -> bytes | None:
        """The reply to a packet, after its physics steps; None for a packet of others.

        A repeated frame count gets the last reply again, a smaller one begins the flight anew.
        """
        try:
            servos = ardupilot.decode(packet)
        except ValueError as error:
            self.messages.warn("ignored", f"{error}; ignored")
            return None
        count, last = servos.frame_count, self._frame
        self._frame = count
        if count == last:
            self.messages.counts["repeated"] += 1
            return self._reply
        if last is not None and count < last:
            self.messages.say(f"restart  frame {last} to {count}: the flight begins anew")
            self.vehicle.reset()
            self._due = 0.0
        elif last is not None and count > last + 1:
            lost = count - last - 1
            self.messages.warn("gaps", f"{lost} frames before frame {count} are lost")
        self.vehicle.advance(
            ardupilot.throttles(servos.pulses, self.vehicle.motors),
            self._steps(servos.frame_rate),
        )
        self._reply = ardupilot.reply(self.vehicle.read(), self._more())
        return self._reply

    def _steps(self, frame_rate: int) -> int:
        """Physics steps of a frame: at least 1, on average those of the rate [Hz]."""
        self._due += 1.0 / (max(frame_rate, 1) * self.vehicle.dt)
        steps = max(1, math.floor(self._due + 0.5))
        self._due = max(self._due - steps, -0.5)
        return steps

    def _more(self) -> dict[str, Any]:
        """Optional fields by sensors of the scenario."""
        more: dict[str, Any] = {}
        ranges = self.vehicle.extra("range_finder", "range")
        if ranges is not None:
            for number, value in enumerate(ranges.ravel()[:RANGES].tolist(), start=1):
                more[f"rng_{number}"] = value
        voltage = self.vehicle.extra("battery", "voltage")
        current = self.vehicle.extra("battery", "current")
        if voltage is not None and current is not None:
            more["battery"] = {"voltage": float(voltage), "current": float(current)}
        return more

    def serve(self, port: int, seconds: float) -> None:
        """Answers until the simulated time is over; waits for an ArduPilot that is silent."""
        with bound(socket.SOCK_DGRAM, port) as link:
            self.messages.say(f"waiting  for ArduPilot on UDP 127.0.0.1:{link.getsockname()[1]}")
            heard: float | None = None  # time of the last packet; None: silence was told
            while self.vehicle.time < seconds:
                try:
                    packet, sender = link.recvfrom(4096)
                except (TimeoutError, ConnectionError):
                    if heard is not None and time.monotonic() - heard > SILENCE:
                        self.messages.say("waiting  ArduPilot is silent")
                        heard = None
                    continue
                answer = self.answer(packet)
                if answer is None:
                    continue
                if heard is None:
                    self.messages.say(f"flying   with {sender[0]}:{sender[1]}")
                heard = time.monotonic()
                send(link, answer, sender)


def send(link: socket.socket, packet: bytes, address: tuple[str, int]) -> None:
    """Sends a datagram; a receiver that is gone loses it."""
    try:
        link.sendto(packet, address)
    except ConnectionError:
        return
