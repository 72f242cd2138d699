"""Body rates and thrust as sticks of Betaflight's acro mode, and its settings for that. No I/O."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .betaflight import HIGH, MIDDLE
from .vehicle import Vehicle

Reals = NDArray[np.float64]

AXES = ("roll", "pitch", "yaw")
# Roll right, nose down and clockwise are positive sticks; B has x forward, y left, z up.
STICK_SIGNS = np.array([1.0, 1.0, -1.0])
HALF = 500.0  # travel of a stick to either side [us]
THROTTLE_LOW = 1010  # `min_check`, the stick of no thrust; below it Betaflight may arm [us]
RATE_UNIT = 10.0  # of `roll_rc_rate` [deg/s]
LARGEST_RATE = 1990.0  # [deg/s]

# Motor share of the whole travel for each deg/s (P), and for each deg/s^2 (D), of a gain of 1.
P_UNIT, D_UNIT = 0.032029e-3, 0.000529e-3
LARGEST_GAIN = 250
YAW_SHARE = 0.25  # largest share of yaw, so that it leaves the motors' range to roll and pitch

# A linear response: filters, feedforward and all that changes gains in flight are switched off.
LINEAR = (
    "feature AIRMODE",
    "set rates_type = ACTUAL",
    "set thr_mid = 50",
    "set thr_expo = 0",
    "set throttle_limit_type = OFF",
    "set throttle_boost = 0",
    "set thrust_linear = 150",
    "set motor_idle = 0",
    "set min_command = 1000",
    "set mixer_type = LEGACY",
    "set rc_smoothing = OFF",
    "set simplified_pids_mode = OFF",
    "set simplified_gyro_filter = OFF",
    "set simplified_dterm_filter = OFF",
    "set gyro_lpf1_static_hz = 0",
    "set gyro_lpf1_dyn_min_hz = 0",
    "set gyro_lpf2_static_hz = 0",
    "set dterm_lpf1_dyn_min_hz = 0",
    "set dterm_lpf1_type = PT1",
    "set dterm_lpf2_static_hz = 0",
    "set yaw_lowpass_hz = 0",
    "set anti_gravity_gain = 0",
    "set iterm_relax = OFF",
    "set tpa_rate = 0",
    "set tpa_low_rate = 0",
    "set abs_control_gain = 0",
    "set crash_recovery = OFF",
    "set runaway_takeoff_prevention = OFF",
    "set yaw_spin_recovery = OFF",
    "set gyro_overflow_detect = OFF",
    "set small_angle = 180",
    "set pidsum_limit = 1000",
    f"set pidsum_limit_yaw = {1000 * YAW_SHARE:.0f}",
)
# Betaflight's `thrust_linear` makes the thrust nearly linear in a motor's command, so that rates
# change no thrust, and gains not with the throttle (pid.c). Speeds by commands, commands by sticks:
LINEARIZATION = 1.5
COMPENSATION = LINEARIZATION - 0.5 * LINEARIZATION**2
SHARES = np.linspace(0.0, 1.0, 4001)
SPEEDS = SHARES * (1.0 + LINEARIZATION * (1.0 - SHARES) ** 2)
COMMANDS = SHARES / (1.0 + COMPENSATION * (1.0 - SHARES) ** 2)

PROCESS_DENOMINATOR = 4  # control steps of 2 kHz, each with at most one new state
DERIVATIVE_TIME = 0.005  # of the derivative's filter, as `ctbr` has it [s]


@dataclass(frozen=True)
class RateSticks:
    """Maps of rates and thrust to sticks."""

    max_rates: tuple[float, float, float]  # of full sticks, about x, y, z [deg/s]
    full_thrust: float  # of all rotors [N]

    @staticmethod
    def of(rates: Sequence[float], full_thrust: float) -> RateSticks:
        """Full sticks for these rates [rad/s], up to the next 10 deg/s.

        Raises:
            ValueError: a rate is beyond Betaflight's.
        """
        degrees = [math.degrees(rate) for rate in rates]
        if max(degrees) > LARGEST_RATE:
            raise ValueError(
                f"a rate of {max(degrees):.0f} deg/s is beyond Betaflight's {LARGEST_RATE:.0f}"
            )
        x, y, z = (RATE_UNIT * math.ceil(rate / RATE_UNIT - 1e-9) for rate in degrees)
        return RateSticks((x, y, z), full_thrust)

    def channels(self, thrust: float, rates: ArrayLike) -> list[float]:
        """Roll, pitch, throttle and yaw [us].

        Args:
            thrust: along z of B [N].
            rates: (3,) B [rad/s].
        """
        shares = STICK_SIGNS * np.degrees(np.asarray(rates)) / np.array(self.max_rates)
        roll, pitch, yaw = MIDDLE + HALF * np.clip(shares, -1.0, 1.0)
        return [float(roll), float(pitch), throttle_stick(thrust / self.full_thrust), float(yaw)]

    def settings(self) -> list[str]:
        """Lines of Betaflight's console for these maps."""
        lines = [f"set min_check = {THROTTLE_LOW}"]
        for axis, rate in zip(AXES, self.max_rates, strict=True):
            lines += [f"set {axis}_rc_rate = {rate / RATE_UNIT:.0f}"]
            lines += [f"set {axis}_srate = {rate / RATE_UNIT:.0f}", f"set {axis}_expo = 0"]
        return lines


def throttle_stick(share: float) -> float:
    """The throttle stick [us] for a share of the full thrust, the square of the speed's share."""
    speed = math.sqrt(min(max(share, 0.0), 1.0))
    travel = np.interp(np.interp(speed, SPEEDS, SHARES), COMMANDS, SHARES)
    return THROTTLE_LOW + (HIGH - THROTTLE_LOW) * float(travel)


def speed_slope(speed: float) -> float:
    """Change of a motor's share of the greatest speed for that of its command, at this share."""
    command = float(np.interp(speed, SPEEDS, SHARES))
    return 1.0 + LINEARIZATION * (1.0 - command) * (1.0 - 3.0 * command)


def gain_lines(kp: ArrayLike, kd: ArrayLike, authority: ArrayLike) -> list[str]:
    """Lines that give Betaflight's rate loop these gains, without integral and feedforward.

    Args:
        kp: (3,) angular acceleration for each rad/s of error [1/s].
        kd: (3,) that for each rad/s^2 of the body.
        authority: (3,) angular acceleration for the whole travel of the commands [rad/s^2].
    """
    per_degree = np.degrees(1.0) * np.asarray(authority)
    lines = [f"set dterm_lpf1_static_hz = {1.0 / (2.0 * math.pi * DERIVATIVE_TIME):.0f}"]
    lines += [f"set pid_process_denom = {PROCESS_DENOMINATOR}"]
    for k, axis in enumerate(AXES):
        p = _gain(np.asarray(kp)[k] / (P_UNIT * per_degree[k]))
        d = _gain(np.asarray(kd)[k] / (D_UNIT * per_degree[k]))
        lines += [f"set p_{axis} = {p}", f"set i_{axis} = 0", f"set d_{axis} = {d}"]
        lines += [f"set f_{axis} = 0", f"set d_max_{axis} = 0"]
    return lines


def _gain(value: float) -> int:
    return int(min(max(round(value), 0), LARGEST_GAIN))


def authority_of(vehicle: Vehicle, share: float) -> Reals:
    """Angular acceleration of a robot for the whole travel of its motors, roll, pitch, yaw.

    The motors' shares of the greatest speed change by the same amount, about `share`, each with the
    sign of its axis. [rad/s^2]
    """
    compiled, robot = vehicle.compiled, vehicle.robot
    rotors = [r for r in compiled.rotors if r.name.startswith(f"{robot}.")]
    centre = np.mean([rotor.position for rotor in rotors], axis=0)
    torque = np.zeros(3)
    for index, rotor in enumerate(rotors):
        speed, lift, drag = (
            vehicle.simulation.rotor_parameter(index, name, robot)
            for name in ("max_speed", "thrust_constant", "moment_constant")
        )
        slope = 2.0 * share * speed**2  # of the squared speed
        x, y = np.abs(np.asarray(rotor.position) - centre)[:2]
        torque += slope * np.array([y * lift, x * lift, drag])
    return np.asarray(torque / inertia_of(vehicle))


def inertia_of(vehicle: Vehicle) -> Reals:
    """Nominal moments of inertia of the body that carries the rotors [kg m^2]."""
    start = f"robots.{vehicle.robot}.links."
    paths = [p for p in vehicle.compiled.param_paths if p.startswith(start) and ".inertia[" in p]
    first = paths[0].partition(".inertia[")[0]
    return np.array([vehicle.compiled.param_info(f"{first}.inertia[{k}]")[0] for k in range(3)])
