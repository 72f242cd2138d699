"""PX4 in the loop: sensors out, then blocked until the actuator controls come.

Before its first HIL_ACTUATOR_CONTROLS PX4 boots, and needs sensors meanwhile: they are sent in real
time, and the vehicle waits on the ground. With that message the flight begins anew, so that its
states do not depend on the time that PX4 took to boot; only the time stamps go on.
"""

from __future__ import annotations

import socket
import time
from dataclasses import dataclass

import numpy as np

from .frames import Array
from .messages import Messages
from .px4 import (
    FIELD_FIELDS,
    IMU_FIELDS,
    PRESSURE_FIELDS,
    Decoder,
    Encoder,
    controls_of,
    load_mavlink,
)
from .sockets import WAIT, bound
from .vehicle import Reading, Vehicle

PORT = 4560
IMU_RATE = 250.0  # [Hz]
TRUTH_PERIOD = 0.02  # of HIL_STATE_QUATERNION [s]
BEAT_PERIOD = 1.0  # of HEARTBEAT and SYSTEM_TIME [s]
SILENCE = 5.0  # on the wall, before a message that PX4 does not answer [s]
OTHER_CLOCK = 1.0  # on the wall, of answers with old stamps alone [s]
NONE = -1.0  # stamp before the first sample


class Gone(Exception):
    """PX4 has closed the connection."""


@dataclass
class Stamps:
    """Times of the newest values that were sent [s]."""

    pressure: float = NONE
    field: float = NONE
    fix: float = NONE
    truth: float = NONE
    beat: float = NONE


class Px4Link:
    """One PX4 after another, on one port."""

    def __init__(self, vehicle: Vehicle, messages: Messages | None = None) -> None:
        mavlink = load_mavlink()
        self.vehicle = vehicle
        self.messages = messages or Messages()
        self._mavlink = mavlink
        self._encoder = Encoder(mavlink, vehicle.setup.home)
        self._steps = vehicle.steps_for(1.0 / IMU_RATE)
        self._begin()

    def _begin(self) -> None:
        self._decoder = Decoder(self._mavlink)
        self._stamps = Stamps()
        self._throttles: Array = np.zeros(self.vehicle.motors)
        self._offset = 0.0  # of the time stamps against the vehicle's time [s]
        self._sent = 0  # stamp of the last HIL_SENSOR [us]
        self._by_stamp = True  # answers are known by their stamps
        self.locked = False

    # --- messages -------------------------------------------------------------------------------

    def outgoing(self) -> bytes:
        """All messages that are due now. HIL_SENSOR is last, since PX4 answers to it."""
        reading, stamps = self.vehicle.read(), self._stamps
        now = self._offset + reading.time
        micros = round(now * 1e6)
        packets, self._sent = b"", micros
        if now - stamps.beat >= BEAT_PERIOD or stamps.beat == NONE:
            stamps.beat = now
            packets += self._encoder.heartbeat() + self._encoder.system_time(micros)
        if stamps.truth == NONE or now - stamps.truth > TRUTH_PERIOD - 0.5 * self.vehicle.dt:
            stamps.truth = now
            packets += self._encoder.truth(reading, micros)
        if reading.fix_stamp != stamps.fix:
            stamps.fix = reading.fix_stamp
            packets += self._encoder.fix(reading, micros)
        return packets + self._encoder.sensor(reading, micros, self._fields(reading))

    def _fields(self, reading: Reading) -> int:
        """Bits of the sensors with a new sample."""
        fields, stamps = IMU_FIELDS, self._stamps
        if reading.field_stamp != stamps.field:
            stamps.field = reading.field_stamp
            fields |= FIELD_FIELDS
        if reading.barometer_stamp != stamps.pressure:
            stamps.pressure = reading.barometer_stamp
            fields |= PRESSURE_FIELDS
        return fields

    def incoming(self, data: bytes) -> bool:
        """Takes bytes of PX4; whether they had actuator controls for the last HIL_SENSOR.

        Controls for an earlier one, sent while PX4 was booting, count as commands, not as answer.
        """
        answered = False
        answers = self._decoder.take(data)
        if self._decoder.bad:
            self.messages.warn("bad", "bytes that are no MAVLink message; ignored")
        for answer in answers:
            controls = controls_of(answer, self.vehicle.motors)
            if controls.bad:
                self.messages.warn("not finite", "a control is not finite: its motor stops")
            old = controls.lockstep and self._by_stamp and 0 < answer.time_usec < self._sent
            if not self.locked:
                self._lock(controls.lockstep)
            self._throttles = controls.throttles
            answered = answered or not old
        return answered

    def _lock(self, lockstep: bool) -> None:
        """The first actuator controls: the flight begins."""
        self.messages.say("flying   with PX4 in lockstep")
        if not lockstep:
            self.messages.warn(
                "without lockstep",
                "PX4 is built without lockstep: its clock is its own; build it for SITL",
            )
        self._offset += self.vehicle.time
        self.vehicle.reset()
        self._stamps = Stamps()
        self.locked = True

    # --- connection -----------------------------------------------------------------------------

    def serve(self, port: int, seconds: float) -> None:
        """Flies until the simulated time since the lock is over; after a PX4 waits for the next."""
        with bound(socket.SOCK_STREAM, port) as door:
            self.messages.say(f"waiting  for PX4 on TCP 127.0.0.1:{door.getsockname()[1]}")
            while not (self.locked and self.vehicle.time >= seconds):
                try:
                    link, _ = door.accept()
                except TimeoutError:
                    continue
                link.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                self.vehicle.reset()
                self._begin()
                with link:
                    try:
                        self._fly(link, seconds)
                    except (Gone, ConnectionError):
                        self.messages.say("waiting  PX4 is gone; for the next one")

    def _fly(self, link: socket.socket, seconds: float) -> None:
        while not (self.locked and self.vehicle.time >= seconds):
            self.vehicle.advance(self._throttles, self._steps)
            link.settimeout(None)  # a PX4 that does not read yet
            link.sendall(self.outgoing())
            self._await_answer(link)

    def _await_answer(self, link: socket.socket) -> None:
        """Waits for actuator controls; before the first ones at most one period on the wall."""
        begun, told = time.monotonic(), False
        while True:
            waited = time.monotonic() - begun
            left = WAIT if self.locked else self._steps * self.vehicle.dt - waited
            if left <= 0.0:
                return
            link.settimeout(left)
            try:
                data = link.recv(65536)
            except TimeoutError:
                if self.locked and waited > SILENCE and not told:
                    self.messages.say("waiting  PX4 does not answer")
                    told = True
                continue
            if not data:
                raise Gone
            if self.incoming(data):
                return
            if self.locked and waited > OTHER_CLOCK:
                self.messages.warn("other stamps", "PX4's stamps are not ours; any controls count")
                self._by_stamp = False
                return
