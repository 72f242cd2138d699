"""A pilot at Betaflight's radio: arms, takes off and holds a height by the throttle stick alone."""

from __future__ import annotations

import math

from skybody.view.live import weight_of

from .betaflight import HIGH, LOW, MIDDLE
from .frames import Array
from .vehicle import Reading, Vehicle

GRACE = 5.5  # after the start; Betaflight refuses to arm in its first 5 s [s]
SWITCH_PERIOD = 1.0  # of tries to arm [s]
RADIO_PERIOD = 0.004  # [s]
CLIMB_RATE = 0.5  # of the wanted height [m/s]
STIFFNESS, DAMPING, INTEGRAL = 0.4, 0.5, 0.15  # shares of the weight per m, m/s, m s
LARGEST_TRIM = 0.3  # share of the weight


class HoldPilot:
    """Roll, pitch and yaw sticks stay in the middle: the attitude is Betaflight's."""

    radio_period = RADIO_PERIOD
    waits = False
    ended = False

    def __init__(self, vehicle: Vehicle, height: float) -> None:
        """height: of the base above its place on the ground [m]."""
        self._hover = hover_share(vehicle)
        self._ground = float(vehicle.read().position[2])
        self._goal = height
        self._wanted = 0.0
        self._trim = 0.0
        self._time: float | None = None
        self.armed = False

    def prepare(self, time: float, throttles: Array) -> list[float]:
        """Sticks at rest: it takes off from the ground, so that the vehicle is not held."""
        del time, throttles
        return [MIDDLE, MIDDLE, LOW, MIDDLE, LOW, LOW]

    def channels(self, reading: Reading, motors_turn: bool) -> list[float]:
        """Channels of the radio [us]: four sticks, arm switch, angle-mode switch.

        Args:
            motors_turn: whether Betaflight has armed.
        """
        self.armed = self.armed or (reading.time > GRACE and motors_turn)
        since = reading.time - GRACE
        on = self.armed or (since > 0.0 and since % SWITCH_PERIOD > 0.3)
        throttle = LOW + (HIGH - LOW) * self._throttle(reading) if self.armed else LOW
        return [MIDDLE, MIDDLE, throttle, MIDDLE, HIGH if on else LOW, HIGH]

    def _throttle(self, reading: Reading) -> float:
        """Share of the greatest speed."""
        step = 0.0 if self._time is None else reading.time - self._time
        self._time = reading.time
        self._wanted = min(self._goal, self._wanted + CLIMB_RATE * step)
        error = self._wanted - (float(reading.position[2]) - self._ground)
        trim = self._trim + INTEGRAL * error * step
        self._trim = min(max(trim, -LARGEST_TRIM), LARGEST_TRIM)
        climb = float(reading.velocity[2])
        lift = self._hover * (1.0 + STIFFNESS * error - DAMPING * climb + self._trim)
        return math.sqrt(min(max(lift, 0.0), 1.0))


def hover_share(vehicle: Vehicle) -> float:
    """Weight of a robot over the greatest thrust of its rotors."""
    robot, simulation = vehicle.robot, vehicle.simulation
    rotors = [r for r in vehicle.compiled.rotors if r.name.startswith(f"{robot}.")]
    thrust = sum(
        rotor.thrust_constant * simulation.rotor_parameter(index, "max_speed", robot) ** 2
        for index, rotor in enumerate(rotors)
    )
    return weight_of(vehicle.compiled, robot) / thrust
