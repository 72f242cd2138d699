"""Start values: lags and delays by search, the rest by linear regression at each of them.

In the manner of J. Eschmann, D. Albani, G. Loianno, "Data-Driven System Identification of
Quadrotors Subject to Motor Delays", 2024 (arXiv 2404.07837).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from skybody.imports import motion
from skybody.imports.channels import Samples
from skybody.look.flight import Array

from .parameters import Model
from .record import Mask, Mean
from .rotation import into_body
from .windows import Track, starts_of

LAGS = (0.005, 0.01, 0.02, 0.03, 0.045, 0.06, 0.08, 0.11, 0.15)  # tried [s]
DELAYS = tuple(np.arange(-0.01, 0.0501, 0.005))  # tried [s]
STEP = 0.005  # of the grid [s]
SMOOTH = 0.03  # window of derivatives and means [s]
DULL_LAG = 0.04  # of small brushed and brushless motors [s]
TOLD = 0.65  # share of the angular acceleration's variance from which on inertias are taken


@dataclass(frozen=True)
class Grid:
    """Values of all flights on a common grid of STEP; flights are apart by gaps of the lag."""

    command: Array  # (n, rotors)
    voltage: Array  # (n,) [V]
    force: Array  # (n, 3) [m/s^2]
    turning: Array  # (n, 3), angular acceleration [rad/s^2]
    drift: Array  # (n, 2), velocity along x and y of B [m/s], or the specific force of its drag
    used: Mask  # (n,), rows of good stretches
    begins: list[int]  # first row of each flight


@dataclass(frozen=True)
class Start:
    """Start values, and how well the commands explain the turning about x and y (0 to 1)."""

    values: dict[str, float]
    told: float


def grid_of(tracks: Sequence[Track]) -> Grid:
    """Samples flights."""
    parts, begins, count = [], [], 0
    for track in tracks:
        first, last = track.record.span()
        times = np.arange(first + SMOOTH, last - SMOOTH, STEP)
        parts.append((*values_of(track, times), used_of(track, times)))
        begins.append(count)
        count += len(times)
    command, voltage, force, turning, drift, used = (
        np.concatenate(column) for column in zip(*parts, strict=True)
    )
    return Grid(command, voltage, force, turning, drift, used.astype(bool), begins)


def values_of(track: Track, times: Array) -> tuple[Array, ...]:
    """Commands, voltages, specific forces, angular accelerations and drift at times."""
    command = track.command(times - 0.5 * STEP, STEP)
    voltage = track.voltage.at(times)[:, 0] if track.voltage else np.zeros(len(times))
    rate = track.rate(times - 0.5 * SMOOTH, SMOOTH)
    turning = motion.derivative(times, rate, SMOOTH)
    if track.force is not None:
        force = track.force(times - 0.5 * SMOOTH, SMOOTH)
    else:
        assert track.velocity is not None
        push = motion.derivative(times, track.velocity.at(times), 2.0 * SMOOTH)
        push[:, 2] += 9.81
        force = into_body(track.attitude(times), push)
    if track.velocity is not None:
        drift = into_body(track.attitude(times), track.velocity.at(times))[:, :2]
    else:
        drift = force[:, :2]
    return command, voltage, force, turning, drift


def used_of(track: Track, times: Array) -> Mask:
    """Rows within windows that may be used."""
    good = np.ones(len(times), bool)
    for low, high, _ in track.record.bad:
        good &= (times < low - 0.1) | (times > high + 0.1)
    return good


def lagged(command: Array, lag: float, begins: Sequence[int]) -> Array:
    """Commands behind a first-order lag, flight by flight."""
    made = np.empty_like(command)
    keep = np.exp(-STEP / lag)
    starts = set(begins)
    state = command[0]
    for row, value in enumerate(command):
        state = value if row in starts else keep * state + (1.0 - keep) * value
        made[row] = state
    return made


def delayed(values: Array, delay: float) -> Array:
    """Rows later by a whole number of steps; the last ones come first."""
    return np.roll(values, round(delay / STEP), axis=0)


def regression(columns: Sequence[Array], target: Array, used: Mask) -> tuple[Array, float]:
    """Coefficients by least squares, and the explained share of the variance."""
    design = np.stack(columns, axis=1)[used]
    wanted = target[used]
    found: Array = np.asarray(np.linalg.lstsq(design, wanted, rcond=None)[0], dtype=np.float64)
    rest = wanted - design @ found
    return found, 1.0 - float(np.var(rest)) / max(float(np.var(wanted)), 1e-12)


def start_values(model: Model, tracks: Sequence[Track]) -> Start:
    """Start values; parameters that are not in them begin at their nominal values."""
    grid, vehicle = grid_of(tracks), model.vehicle
    begins = grid.begins
    lags = {lag: lagged(grid.command, lag, begins) for lag in LAGS}
    arms = np.array([[hub.position[1], -hub.position[0]] for hub in vehicle.hubs])
    best = (-np.inf, LAGS[0], 0.0, 0.0)
    for lag, smooth in lags.items():
        for delay in DELAYS:
            _, speeds, k_f, fitted = speeds_at(model, grid, delayed(smooth, delay))
            moments = k_f * speeds**2 @ arms
            shares = [turning_regression(grid, moments[:, k], k)[1] for k in range(2)]
            best = max(best, (sum(shares) + fitted, lag, delay, max(shares)))
    _, lag, delay, told = best
    found, speeds, k_f, _ = speeds_at(model, grid, delayed(lags[lag], delay))
    found |= turning_values(model, grid, speeds, k_f, arms)
    if told < TOLD:  # lag and delay mean little then
        lag, delay = DULL_LAG, 0.01
    return Start(found | {"tau_up": lag, "tau_down": lag, "delay.command": delay}, told)


def speeds_at(
    model: Model, grid: Grid, smooth: Array
) -> tuple[dict[str, float], Array, float, float]:
    """The law of the commands by the specific force along z.

    Args:
        model: the parameters.
        grid: of the flights.
        smooth: commands behind a lag and a delay, (n, rotors).

    Returns:
        Start values; speeds of the rotors (n, rotors) [rad/s]; the thrust constant; and the
        explained share of the force's variance.
    """
    vehicle, force = model.vehicle, grid.force[:, 2]
    level = float(np.mean(force[grid.used]))
    k_f, rotors = vehicle.rotor("thrust_constant"), len(vehicle.hubs)
    if not model.scales.is_share:
        (slope,), told = regression([(smooth**2).sum(axis=1)], force, grid.used)
        k_f = max(float(slope) * vehicle.mass, 0.05 * k_f)
        return {"thrust_constant": k_f}, smooth, k_f, told
    found, told = thrust_regression(grid, smooth, model.scales.share)
    values = {"command.speed": float(np.sqrt(vehicle.mass * level / (rotors * k_f)))}
    # thrust / level = (1 + slope x + curve x^2)^2, to the second order.
    slope = float(np.clip(0.5 * found[1] / level, 0.3, 2.5))
    curve = float(np.clip(0.5 * (found[2] / level - slope**2), -0.3, 0.3))
    values |= {"command.slope": slope, "command.curve": curve}
    if "command.voltage" in model.names:
        power = float(found[3] * model.scales.voltage / level / 2.0 / slope)
        values["command.voltage"] = float(np.clip(power, 0.0, 2.5))
    x = smooth / model.scales.share - 1.0
    speeds = values["command.speed"] * np.maximum(1.0 + slope * x + curve * x * x, 0.0)
    return values, speeds, k_f, told


def turning_regression(grid: Grid, moment: Array, axis: int) -> tuple[Array, float]:
    """The angular acceleration by the rotors' moment, a constant one, and that of the drag.

    Returns:
        Coefficients, and the share of the variance that only the moment explains.
    """
    rest = [np.ones(len(moment)), *grid.drift.T]
    target, used = grid.turning[:, axis], grid.used
    found, told = regression([moment, *rest], target, used)
    without = regression(rest, target, used)[1]
    return found, (told - without) / max(1.0 - without, 1e-12)


def thrust_regression(grid: Grid, smooth: Array, share: float) -> tuple[Array, float]:
    """The specific force along z by the commands, to the second order, and the voltage."""
    x = smooth / share - 1.0
    voltage = grid.voltage - grid.voltage[grid.used].mean()
    columns = [np.ones(len(x)), x.mean(axis=1), (x * x).mean(axis=1), voltage]
    return regression(columns, grid.force[:, 2], grid.used)


def turning_values(
    model: Model, grid: Grid, speeds: Array, k_f: float, arms: Array
) -> dict[str, float]:
    """Inertias, moment constant and centre of mass of the angular accelerations."""
    vehicle, used = model.vehicle, grid.used
    thrust = k_f * speeds**2
    nominal = {a: vehicle.nominal[vehicle.path(f"inertia[{k}]")] for k, a in enumerate("xyz")}
    made: dict[str, float] = {}
    ones = np.ones(len(thrust))
    weight = vehicle.mass * vehicle.gravity
    for k, axis in enumerate("xy"):
        moment = thrust @ arms[:, k]
        (gain, rest, *_), told = turning_regression(grid, moment, k)
        # In the mean the moment about the centre of mass is none.
        offset = float(np.mean(moment[used]) / weight) if gain <= 0.0 else -rest / gain / weight
        made["com.y" if axis == "x" else "com.x"] = float(offset if axis == "x" else -offset)
        if told > TOLD and gain > 0.0:
            made[f"inertia.{axis}"] = 1.0 / gain
    mean = np.sqrt(np.prod([made.get(f"inertia.{a}", nominal[a]) / nominal[a] for a in "xy"]))
    drag = (speeds**2) @ -vehicle.directions
    spin = motion_of(speeds) @ -vehicle.directions
    (k_m, k_j, _), told = regression([drag, spin, ones], grid.turning[:, 2], used)
    if told > TOLD and k_m > 0.0:
        made["moment_constant"] = float(k_m * nominal["z"] * mean)
        if k_j > 0.0:
            made["rotor_inertia"] = float(k_j * nominal["z"] * mean)
    return made


def motion_of(speeds: Array) -> Array:
    """Accelerations of rotors [rad/s^2]."""
    return np.gradient(speeds, STEP, axis=0)


def clock_offset(track: Track) -> float:
    """How far the clock of the gyroscope is ahead of the clock of the poses [s].

    It is where the gyroscope agrees best with the rates of the attitude; 0: one of them is missing.
    """
    record = track.record
    if record.gyro is None or record.quaternion is None:
        return 0.0
    turns = record.quaternion
    rates = Mean(Samples(turns.time, motion.angular_velocities(turns.time, turns.values, 0.05)))
    gyro = Mean(record.gyro)
    begins = starts_of(track, 0.05)
    if len(begins) == 0:
        return 0.0
    wanted = rates.at(begins)
    shifts = np.arange(-0.1, 0.1001, 0.001)
    errors = [float(np.var(gyro.at(begins + shift) - wanted, axis=0).sum()) for shift in shifts]
    return float(shifts[int(np.argmin(errors))])
