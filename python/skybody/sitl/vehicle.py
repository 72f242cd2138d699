"""A robot of a scenario under direct control of an autopilot's motor values."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from skybody import CompiledScenario, Simulation

from .frames import HOME, Array, Home
from .motors import FRAMES, rotor_order, usual_frame
from .sensed import sensor_of, with_missing_sensors

CLEARANCE = 1e-6  # depth of the first touch of the ground [m]


@dataclass(frozen=True)
class Setup:
    """Choices for a flight."""

    scenario: str
    robot: str = ""  # may be empty if there is only one
    frame: str = ""  # empty: by the places of the rotors
    overrides: tuple[str, ...] = ()
    seed: int = 0
    on_ground: bool = True  # begin at rest on the ground below the start
    home: Home = HOME


@dataclass(frozen=True)
class Reading:
    """Sensors and true motion at one time. Axes: B x forward, y left, z up; W z up; SI units."""

    time: float  # since the start [s]
    specific_force: Array  # (3,) of the IMU, B [m/s^2]
    angular_rate: Array  # (3,) of the IMU, B [rad/s]
    pressure: float  # [Pa]
    pressure_altitude: float  # [m]
    barometer_stamp: float  # time of the sample [s]
    field: Array  # (3,) magnetic field, B [uT]
    field_stamp: float  # [s]
    fix_position: Array  # (3,) of the GNSS antenna, W [m]
    fix_velocity: Array  # (3,) W [m/s]
    fix_stamp: float  # [s]
    position: Array  # (3,) true, W [m]
    rotation: Array  # (4,) true, w x y z, W from B
    velocity: Array  # (3,) true, W [m/s]
    turn_rate: Array  # (3,) true, B [rad/s]


class Vehicle:
    """The simulation behind a link to an autopilot.

    Raises:
        InputError: mistakes in the scenario.
        ValueError: the robot is not there, or its rotors do not fit the frame.
    """

    def __init__(self, autopilot: str, setup: Setup) -> None:
        first = CompiledScenario(setup.scenario, list(setup.overrides))
        self.robot = chosen_robot(first, setup.robot)
        self.setup = setup
        rotors = [r for r in first.rotors if r.name.startswith(f"{self.robot}.")]
        self.frame = setup.frame or usual_frame(autopilot, rotors)
        self.settings = FRAMES[autopilot][self.frame].settings
        self._order = rotor_order(autopilot, self.frame, rotors)
        sensors, self.added = with_missing_sensors(first, self.robot, setup.home.altitude)
        place = f"robots.{self.robot}"
        direct = [f"{place}.controllers=[{{plugin: throttle}}]"]
        if setup.on_ground:
            direct.append(f"{place}.rotor_speed=0")
        self._simulation = Simulation(
            setup.scenario, overrides=[*setup.overrides, *direct, *sensors], seed=setup.seed
        )
        self.compiled = self._simulation.compiled
        self._names = {
            kind: f"sensors.{sensor_of(self.compiled, kind, self.robot)}"
            for kind in ("imu", "barometer", "gnss", "magnetometer")
        }
        self.motors = len(self._order)
        self.reset()

    @property
    def dt(self) -> float:
        """Physics step [s]."""
        return self.compiled.dt

    @property
    def time(self) -> float:
        """Since the start [s]."""
        return self.steps * self.dt

    @property
    def simulation(self) -> Simulation:
        """The simulation; changes of its state change the flight."""
        return self._simulation

    def reset(self) -> None:
        """Begins the first episode of the seed anew, with rotors at rest on the ground."""
        self._simulation.reset(self.setup.seed)
        self.steps = 0
        self._hash = hashlib.blake2b(digest_size=8)
        self._command = np.zeros(self.motors)
        if self.setup.on_ground:
            self._put_on_ground()

    def steps_for(self, period: float) -> int:
        """The number of physics steps nearest to a period [s], at least 1."""
        return max(1, round(period / self.dt))

    def advance(self, throttles: ArrayLike, steps: int) -> None:
        """Physics steps under motor values.

        Args:
            throttles: (motors,) in the autopilot's order, shares of the greatest speed, limited
                to [0, 1]; NaN stands for 0.

        Raises:
            Error: the physics diverged.
        """
        values = np.clip(np.nan_to_num(np.asarray(throttles, np.float64), nan=0.0), 0.0, 1.0)
        self._command[self._order] = values[: self.motors]
        self._simulation.command(self._command, self.robot)
        if not self._simulation.advance(steps):
            raise ValueError(f"the flight ended: {self._simulation.fault_reason}")
        self.steps += steps
        self._add_to_hash()

    def read(self) -> Reading:
        """Sensors and motion now."""
        state, names = self._simulation.state, self._names
        base = self._simulation.base(self.robot)
        return Reading(
            time=self.time,
            specific_force=state(f"{names['imu']}.specific_force"),
            angular_rate=state(f"{names['imu']}.angular_rate"),
            pressure=float(state(f"{names['barometer']}.pressure")),
            pressure_altitude=float(state(f"{names['barometer']}.altitude")),
            barometer_stamp=float(state(f"{names['barometer']}.stamp")),
            field=state(f"{names['magnetometer']}.field"),
            field_stamp=float(state(f"{names['magnetometer']}.stamp")),
            fix_position=state(f"{names['gnss']}.position"),
            fix_velocity=state(f"{names['gnss']}.velocity"),
            fix_stamp=float(state(f"{names['gnss']}.stamp")),
            position=base.position,
            rotation=base.rotation,
            velocity=base.velocity,
            turn_rate=base.angular_velocity,
        )

    def extra(self, kind: str, channel: str) -> Array | None:
        """A channel of the robot's first sensor of another kind; None if it has none."""
        name = sensor_of(self.compiled, kind, self.robot)
        return None if name is None else self._simulation.state(f"sensors.{name}.{channel}")

    def hash(self) -> str:
        """Hash of the base's motion and the rotors' speeds after every `advance`."""
        return self._hash.hexdigest()

    def _add_to_hash(self) -> None:
        base = self._simulation.base(self.robot)
        parts: Iterable[Array] = (
            base.position,
            base.rotation,
            base.velocity,
            base.angular_velocity,
            self._simulation.rotor_speeds,
        )
        for part in parts:
            self._hash.update(part.tobytes())

    # --- start ----------------------------------------------------------------------------------

    def _put_on_ground(self) -> None:
        """Lowers the robot, level, until it touches something."""
        base = self._simulation.base(self.robot)
        w, _, _, z = base.rotation
        heading = np.array([w, 0.0, 0.0, z]) if w or z else np.array([1.0, 0.0, 0.0, 0.0])
        start = np.array(base.position)
        low, high = -1.0, float(start[2])
        if not self._touches(start, heading, low):
            raise ValueError(
                f"robot `{self.robot}` has no collision shape to stand on; --start air begins "
                "where the scenario does"
            )
        while high - low > CLEARANCE:
            middle = 0.5 * (low + high)
            if self._touches(start, heading, middle):
                low = middle
            else:
                high = middle
        self._touches(start, heading, low)

    def _touches(self, start: Array, heading: Array, height: float) -> bool:
        """Puts the base at a height, and says whether the robot touches anything there."""
        place = np.array([start[0], start[1], height])
        still = np.zeros(3)
        self._simulation.teleport(place, heading, still, still, self.robot)
        return any(
            contact.body.startswith(f"{self.robot}.") for contact in self._simulation.contacts()
        )


def chosen_robot(compiled: CompiledScenario, robot: str) -> str:
    """The name of the robot to fly.

    Raises:
        ValueError: there is none of this name, or several and none is named.
    """
    names = compiled.robots
    if robot in names:
        return robot
    if not robot and len(names) == 1:
        return names[0]
    problem = f"no robot `{robot}`" if robot else f"{len(names)} robots"
    raise ValueError(f"{compiled.name}: {problem}; allowed: --robot {' or '.join(names)}")
