"""Looks for mistakes of a log: units, frozen values, gaps, impossible commands."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from skybody import InputError
from skybody.imports import motion
from skybody.imports.channels import Samples
from skybody.look.flight import Array

from .record import SHARE, SPEED, Mask, Mean, Record
from .vehicle import Vehicle

GAP = 0.05  # longest time between samples [s]
LEAST_TIME = 1.0  # that must be left of a flight [s]
STILL = 0.1  # longest time without a change [s]
SHOCK = 60.0  # specific force of a collision [m/s^2]
SPIN = 40.0  # fastest turn that is no crash [rad/s]
NEAR_GROUND = 0.15  # height above the lowest place [m]
RAREST = 0.2  # longest usual time between commands [s]
Stretch = tuple[float, float, str]


@dataclass
class Screened:
    """A flight without its bad stretches, and remarks."""

    record: Record
    notes: list[str] = field(default_factory=list)


def screen(record: Record, vehicle: Vehicle) -> Screened:
    """Checks a flight.

    Raises:
        InputError: units are mixed up, or nothing is left of the flight.
    """
    check_times(record)
    check_ranges(record)
    bad = [*gaps(record), *frozen(record), *impossible(record), *not_flying(record)]
    made = Screened(record.without(merged(bad)))
    if kept_time(made.record) < LEAST_TIME:
        raise InputError(
            f"{record.path}: less than {LEAST_TIME:g} s can be used: {reasons(made.record)}"
        )
    check_units(made.record, vehicle)
    for reason, length in lengths(made.record).items():
        made.notes.append(f"{record.path.name}: {length:.1f} s left out: {reason}")
    if (full := saturated(made.record)) > 0.02:
        made.notes.append(
            f"{record.path.name}: a rotor is at full command in {100.0 * full:.0f} % of the flight"
        )
    return made


def merged(bad: list[Stretch]) -> list[Stretch]:
    """Stretches of one reason that touch become one."""
    made: list[Stretch] = []
    for begin, end, reason in sorted(bad, key=lambda s: (s[2], s[0])):
        if made and made[-1][2] == reason and begin <= made[-1][1] + 0.3:
            made[-1] = (made[-1][0], max(made[-1][1], end), reason)
        else:
            made.append((begin, end, reason))
    return made


def lengths(record: Record) -> dict[str, float]:
    """Lengths of the parts that are left out [s], by reason, without those that the user cut."""
    first, last = record.span()
    made: dict[str, float] = {}
    for begin, end, reason in record.bad:
        if np.isfinite(begin) and np.isfinite(end):
            length = max(0.0, min(end, last) - max(begin, first))
            made[reason] = made.get(reason, 0.0) + length
    return made


def reasons(record: Record) -> str:
    """All reasons in words."""
    found = sorted(lengths(record).items(), key=lambda item: -item[1])
    return ", ".join(f"{length:.1f} s {reason}" for reason, length in found) or "FROM and UNTIL"


def kept_time(record: Record) -> float:
    """Time without bad stretches [s]."""
    first, last = record.span()
    times = np.arange(first, last, 0.01)
    return 0.01 * float(np.count_nonzero(good_at(record, times)))


def good_at(record: Record, times: Array) -> Mask:
    """Which times are in no bad stretch."""
    good = np.ones(len(times), bool)
    for begin, end, _ in record.bad:
        good &= (times < begin) | (times > end)
    return good


def good_values(record: Record, samples: Samples) -> Array:
    """Values outside of bad stretches."""
    return np.asarray(samples.values[good_at(record, samples.time)])


def runs(time: Array, wrong: Mask, reason: str, least: float = 0.0) -> list[Stretch]:
    """Stretches in which all rows are wrong, of at least some length [s]."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], wrong, [False]]).astype(int)))
    pairs = edges.reshape(-1, 2)
    return [
        (float(time[a]), float(time[min(b, len(time) - 1)]), reason)
        for a, b in pairs
        if time[min(b, len(time) - 1)] - time[a] >= least
    ]


def series(record: Record) -> dict[str, Samples]:
    """Commands and fast measurements by name."""
    named = {
        "commands": record.command, "position": record.position, "attitude": record.quaternion,
        "gyroscope": record.gyro, "accelerometer": record.force,
    }  # fmt: skip
    return {name: samples for name, samples in named.items() if samples is not None}


def gaps(record: Record) -> list[Stretch]:
    """Times without samples."""
    made: list[Stretch] = []
    for name, samples in series(record).items():
        wide = np.flatnonzero(np.diff(samples.time) > GAP)
        made += [
            (float(samples.time[k]), float(samples.time[k + 1]), f"gaps in {name}") for k in wide
        ]
    return made


def frozen(record: Record) -> list[Stretch]:
    """Values that stand still, or lie on a straight line: the log had no new ones."""
    made: list[Stretch] = []
    for name, samples in series(record).items():
        time, values = samples.time, samples.values
        still = (np.diff(values, axis=0) == 0.0).all(axis=1)
        moving = values[:-1].any(axis=1) if name == "commands" else np.ones(len(still), bool)
        made += runs(time[:-1], still & moving, f"frozen {name}", STILL)
        if name in ("commands", "gyroscope"):
            made += runs(time[1:-1], straight(time, values), f"interpolated {name}", STILL)
    return made


def straight(time: Array, values: Array) -> Mask:
    """Inner rows in which all columns continue their line, without standing still."""
    slopes = np.diff(values, axis=0) / np.maximum(np.diff(time), 1e-9)[:, None]
    bends = np.abs(np.diff(slopes, axis=0))
    sizes = np.abs(slopes[1:]) + np.abs(slopes[:-1])
    return np.asarray((bends <= 2e-3 * sizes).all(axis=1) & (sizes > 0.0).any(axis=1))


def impossible(record: Record) -> list[Stretch]:
    """Commands beyond their range, and shocks."""
    made: list[Stretch] = []
    command = record.command
    if record.law.kind == SHARE:
        beyond = (command.values < -1e-3) | (command.values > 1.0 + 1e-3)
        wrong: Mask = np.asarray(beyond.any(axis=1))
        text = f"commands beyond {record.law.low:g} ... {record.law.high:g}"
        made += runs(command.time, wrong, text)
    for samples, most, text in (
        (record.force, SHOCK, "collision"),
        (record.gyro, SPIN, "tumbling"),
    ):
        if samples is not None:
            hard = np.linalg.norm(samples.values, axis=1) > most
            # Wrong units are told apart from shocks by their share.
            if np.mean(hard) < 0.2:
                made += [(a - 0.2, b + 0.2, text) for a, b, _ in runs(samples.time, hard, text)]
    return made


def not_flying(record: Record) -> list[Stretch]:
    """Parts on the ground, or with motors that do not carry."""
    command = record.command
    mean = command.values.mean(axis=1)
    level = float(np.median(mean[mean > 0.05 * np.max(np.clip(mean, 0.0, 1e6))]))
    made = runs(command.time, mean < 0.4 * level, "motors do not carry", 0.02)
    if record.position is not None:
        height = record.position.values[:, 2]
        low = float(np.min(height)) + NEAR_GROUND
        if np.max(height) > low + NEAR_GROUND:
            made += runs(record.position.time, height < low, "on or near the ground")
    return [(begin - 0.3, end + 0.3, reason) for begin, end, reason in made]


def saturated(record: Record) -> float:
    """Share of the good rows with a rotor at full command."""
    if record.law.kind != SHARE:
        return 0.0
    return float(np.mean((good_values(record, record.command) > 0.995).any(axis=1)))


def check_times(record: Record) -> None:
    """Raises InputError if commands are too rare: their times have another unit."""
    steps = np.diff(record.command.time)
    if len(steps) and np.median(steps) > RAREST:
        raise InputError(
            f"{record.path}: commands come every {np.median(steps):.3g} s, allowed: {RAREST:g} s: "
            "times seem to be in ms or us; correct the `unit` of `time` in the map"
        )


def check_ranges(record: Record) -> None:
    """Raises InputError if commands do not fit the range of the map."""
    if record.law.kind != SHARE:
        return
    values, law = record.command.values, record.law
    if not values.any():
        raise InputError(
            f"{record.path}: all commands are {law.low:g}: the motors never run in this log; give "
            "the part with the flight, or correct the columns of rotor_speed in the map"
        )
    beyond = float(np.mean((values > 1.001).any(axis=1)))
    most = law.low + float(np.max(values)) * (law.high - law.low)
    if beyond > 0.95 or np.max(values) < 0.02:
        raise InputError(
            f"{record.path}: commands go up to {most:g}, but the map's range is {law.low:g} ... "
            f"{law.high:g}: another unit (PWM, microseconds, shares, rpm); correct `range` and "
            "`law` of rotor_speed in the map"
        )


def check_units(record: Record, vehicle: Vehicle) -> None:
    """Raises InputError if the data say that a unit is another one."""
    check_voltage(record)
    check_force(record, vehicle)
    check_gyro(record)
    check_position(record)
    check_speeds(record, vehicle)


def check_voltage(record: Record) -> None:
    """Raises InputError if the battery's voltage is too high for volts."""
    if record.voltage is None:
        return
    found = float(np.median(record.voltage.values))
    if found > 200.0:
        raise wrong_unit(record, "the voltage", found, "V", "mV", "voltage")


def wrong_unit(
    record: Record, quantity: str, value: float, unit: str, other: str, name: str
) -> InputError:
    """The error of a unit, with its remedy."""
    return InputError(
        f"{record.path}: {quantity} is {value:.3g} {unit} in the mean: the log seems to have "
        f"{other}; say so by --unit {name}={other}, or in the map"
    )


def check_force(record: Record, vehicle: Vehicle) -> None:
    """Raises InputError if the accelerometer does not show gravity in the mean of a flight."""
    if record.force is None:
        return
    found = float(np.median(np.linalg.norm(good_values(record, record.force), axis=1)))
    share = found / vehicle.gravity
    units = {(0.05, 0.2): "g", (5.0, 20.0): "m/s^2", (5e-5, 2e-4): "g", (500.0, 2e4): "mg"}
    for (low, high), unit in units.items():
        if low < share < high:
            raise wrong_unit(record, "the accelerometer", found, "m/s^2", unit, "accelerometer")
    if not 0.6 < share < 1.6:
        raise InputError(
            f"{record.path}: the accelerometer shows {found:.3g} m/s^2 in the mean of a flight; "
            f"allowed: about {vehicle.gravity:.3g}; check its columns and unit in the map"
        )


def check_gyro(record: Record) -> None:
    """Raises InputError if the gyroscope does not turn as the attitude, or too fast for rad/s."""
    if record.gyro is None:
        return
    spread = float(np.sqrt(np.mean(good_values(record, record.gyro) ** 2)))
    if record.quaternion is None:
        if spread > 20.0:
            raise wrong_unit(record, "the gyroscope", spread, "rad/s", "deg/s", "gyro")
        return
    turns = record.quaternion
    rates = Samples(turns.time, motion.angular_velocities(turns.time, turns.values, 0.1))
    wanted = float(np.sqrt(np.mean(good_values(record, rates) ** 2)))
    times = record.gyro.time[good_at(record, record.gyro.time)]
    smooth = float(np.sqrt(np.mean(Mean(record.gyro)(times - 0.05, 0.1) ** 2)))
    if smooth > 15.0 * wanted:
        raise wrong_unit(record, "the gyroscope", spread, "rad/s", "deg/s", "gyro")
    if smooth < wanted / 15.0:
        raise wrong_unit(record, "the gyroscope", spread, "rad/s", "rad/s", "gyro")


def check_position(record: Record) -> None:
    """Raises InputError if positions move too fast for metres."""
    if record.position is None:
        return
    place = record.position
    speed = motion.derivative(place.time, place.values, 0.2)
    fast = float(np.median(np.linalg.norm(speed[good_at(record, place.time)], axis=1)))
    if fast > 60.0:
        raise InputError(
            f"{record.path}: the vehicle moves at {fast:.3g} m/s: positions seem to be in mm or "
            "cm; correct the `unit` of `position` in the map"
        )


def check_speeds(record: Record, vehicle: Vehicle) -> None:
    """Raises InputError if rotor speeds do not carry the weight in the mean of a flight."""
    if record.law.kind != SPEED:
        return
    speeds = good_values(record, record.command)
    lift = vehicle.rotor("thrust_constant") * float(np.mean((speeds**2).sum(axis=1)))
    share = lift / (vehicle.mass * vehicle.gravity)
    if not 0.2 < share < 5.0:
        seems = "; rpm would fit: `unit: rpm`" if 30.0 < share < 300.0 else ""
        raise InputError(
            f"{record.path}: rotors of {np.mean(speeds):.4g} rad/s in the mean would carry "
            f"{share:.3g} times the weight by the model: the commands have another unit, such as "
            f"PWM{seems}; correct `unit`, `law` and `range` of rotor_speed in the map"
        )


def command_rate(record: Record) -> float:
    """New commands per second: rows at which a command leaves its line or its level."""
    time, values = record.command.time, record.command.values[:, 0]
    good = good_at(record, time)
    if good.sum() < 10:
        return float(len(time) / (time[-1] - time[0]))
    slopes = np.diff(values) / np.maximum(np.diff(time), 1e-9)
    bends = np.abs(np.diff(slopes))
    sizes = np.abs(slopes[1:]) + np.abs(slopes[:-1])
    new = (bends > 2e-2 * sizes) & good[1:-1]
    held = (slopes[1:] == 0.0) & (slopes[:-1] != 0.0)  # the end of a held value counts once
    steps = np.median(np.diff(time))
    return float(np.count_nonzero(new & ~held) / (np.count_nonzero(good[1:-1]) * steps))
