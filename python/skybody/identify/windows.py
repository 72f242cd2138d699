"""Windows of flights: measured starts, commands and samples."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from skybody.imports import motion
from skybody.imports.channels import Samples
from skybody.look.flight import Array

from . import rotation
from .attitude import attitudes, into_world
from .record import Mask, Mean, Record, Rows
from .replay import SAMPLE, STEP, WARM
from .screening import good_at

LENGTH = 0.5  # of a window to judge by [s]
FIT_LENGTH = 0.15  # of a window to fit: disturbances that no command tells have little time [s]
SLOW = 4.0  # moving mean of commands [s]
SPREAD = 0.02  # of starts about their grid [s]
GOLDEN = 0.6180339887498949
EDGE = 0.06  # delays that the data around a window must cover [s]
LEAST_DRAG = 0.05  # by which a velocity is felt [1/s]
DERIVATIVE = 0.1  # window of derivatives [s]


class Track:
    """The measurements of a flight at any time."""

    def __init__(self, record: Record, spin_by_mass: float = 0.0) -> None:
        """
        Args:
            record: the flight.
            spin_by_mass: of the nominal vehicle [rad/(s kg)].
        """
        self.record, self._spin_by_mass = record, spin_by_mass
        self._slow: Mean | None = None
        self.command = Mean(record.command, held=True)
        self.voltage = Mean(record.voltage) if record.voltage is not None else None
        self.gyro = Mean(record.gyro) if record.gyro is not None else None
        self.force = Mean(record.force) if record.force is not None else None
        self.position = Mean(record.position) if record.position is not None else None
        quaternion = record.quaternion
        self.velocity = self._velocity()
        if quaternion is None:
            quaternion = attitudes(record)
        self.quaternion = Mean(quaternion)
        rates = motion.angular_velocities(quaternion.time, quaternion.values, DERIVATIVE)
        self.rate = self.gyro or Mean(Samples(quaternion.time, rates))

    def slow_command(self, times: Array) -> Array:
        """Means of the commands over SLOW about times, of good stretches alone."""
        command = self.record.command
        if self._slow is None:
            good = good_at(self.record, command.time)[:, None].astype(float)
            kept = np.where(good > 0.0, command.values, 0.0)
            self._slow = Mean(Samples(command.time, np.concatenate([kept, good], axis=1)))
        sums = self._slow(times - 0.5 * SLOW, SLOW)
        return np.asarray(sums[..., :-1] / np.maximum(sums[..., -1:], 1e-6))

    def _velocity(self) -> Mean | None:
        record = self.record
        if record.velocity is not None:
            return Mean(record.velocity)
        if record.position is None:
            return None
        place = record.position
        return Mean(Samples(place.time, motion.derivative(place.time, place.values, DERIVATIVE)))

    def drift(self, times: Array, bias: Array, drag: float) -> Array:
        """Horizontal velocities in B by the rotors' drag that the accelerometer feels.

        Args:
            times: (n,) [s].
            bias: of the accelerometer [m/s^2].
            drag: constant of a rotor [N s^2/(m rad)].

        Returns:
            (n, 3) [m/s]; 0 if there is hardly any drag.
        """
        made = np.zeros((len(times), 3))
        rate = self._spin_by_mass * drag
        if self.force is not None and rate > LEAST_DRAG:
            felt = self.force(times - 0.5 * DERIVATIVE, DERIVATIVE) - bias
            made[:, :2] = -felt[:, :2] / rate
        return made

    def attitude(self, times: Array) -> Array:
        """Unit quaternions at times."""
        found = self.quaternion.at(times)
        return np.asarray(found / np.linalg.norm(found, axis=-1, keepdims=True))


@dataclass(frozen=True)
class Measured:
    """Measurements of n windows, with the identified offsets of the sensors."""

    position: Array  # (n, samples, 3)
    quaternion: Array
    rate: Array
    force: Array


class Windows:
    """Windows of several flights."""

    def __init__(self, tracks: Sequence[Track], flight: Rows, begin: Array, length: float) -> None:
        """
        Args:
            tracks: the flights.
            flight: (n,), index of the flight of each window.
            begin: (n,), its start [s].
            length: of all windows [s].
        """
        self.tracks, self.flight, self.begin = list(tracks), flight, begin
        self.length, self.samples = length, round(length / SAMPLE)
        self.has_pose = np.array([t.record.has_pose for t in tracks], bool)[flight]
        self.has_force = np.array([t.force is not None for t in tracks], bool)[flight]

    def __len__(self) -> int:
        return len(self.begin)

    def some(self, chosen: Rows | Mask) -> Windows:
        """Some of them, by their index or a mask."""
        return Windows(self.tracks, self.flight[chosen], self.begin[chosen], self.length)

    def _collect(self, value: object, shape: tuple[int, ...]) -> Array:
        """value(track, begin) of each flight, in the order of the windows."""
        made = np.zeros((len(self), *shape))
        for k, track in enumerate(self.tracks):
            rows = self.flight == k
            if rows.any():
                made[rows] = value(track, self.begin[rows])  # type: ignore[operator]
        return made

    def commands(self, delay: float, detail: float | None = None) -> tuple[Array, Array]:
        """Commands (n, steps, rotors) and voltages (n, steps, 1) from WARM before the starts.

        Args:
            delay: from a command in the log to its effect [s].
            detail: share of the differences between the rotors' commands, about their moving
                means over SLOW, that is used; the means are taken as balanced. None: commands as
                they are.
        """
        steps = round((WARM + self.length) / STEP)
        offsets = STEP * np.arange(steps) - WARM - delay
        rotors = self.tracks[0].record.command.values.shape[1]

        def command(track: Track, begin: Array) -> Array:
            times = begin[:, None] + offsets
            found = track.command(times, STEP)
            if detail is None:
                return found
            apart = found - track.slow_command(times + 0.5 * STEP)
            mean = apart.mean(axis=-1, keepdims=True)
            return np.asarray(found.mean(axis=-1, keepdims=True) + detail * (apart - mean))

        def voltage(track: Track, begin: Array) -> Array:
            times = begin[:, None] + offsets
            return track.voltage.at(times) if track.voltage else np.full((*times.shape, 1), np.nan)

        return self._collect(command, (steps, rotors)), self._collect(voltage, (steps, 1))

    def starts(self, values: Mapping[str, float]) -> Array:
        """Measured states at the starts, (n, 13)."""
        delay, bias = values.get("delay.imu", 0.0), vector(values, "gyro.bias")
        force_bias, drag = vector(values, "accelerometer.bias"), values.get("drag.rotor", 0.0)
        tilt = rotation.of_vector(vector(values, "pose.tilt"))

        def state(track: Track, begin: Array) -> Array:
            made = np.zeros((len(begin), 13))
            made[:, 2] = 1.0
            if track.position is not None and track.velocity is not None:
                made[:, :3] = track.position.at(begin)
                made[:, 7:10] = track.velocity.at(begin)
                made[:, 3:7] = rotation.product(track.attitude(begin), rotation.inverse(tilt))
            else:
                made[:, 3:7] = track.attitude(begin)
                drift = track.drift(begin + delay, force_bias, drag)
                made[:, 7:10] = into_world(made[:, 3:7], drift)
            shift = delay if track.gyro is not None else 0.0
            made[:, 10:] = track.rate.at(begin + shift) - (bias if track.gyro is not None else 0.0)
            return made

        return self._collect(state, (13,))

    def measured(self, values: Mapping[str, float]) -> Measured:
        """Measurements at the samples, without the offsets of the sensors."""
        delay = values.get("delay.imu", 0.0)
        gyro_bias, force_bias = vector(values, "gyro.bias"), vector(values, "accelerometer.bias")
        tilt = rotation.of_vector(vector(values, "pose.tilt"))
        times = SAMPLE * np.arange(1, self.samples + 1)

        def position(track: Track, begin: Array) -> Array | float:
            return track.position.at(begin[:, None] + times) if track.position else 0.0

        def quaternion(track: Track, begin: Array) -> Array:
            found = track.attitude(begin[:, None] + times)
            if track.record.has_pose:
                return rotation.product(found, rotation.inverse(tilt))
            first = track.attitude(begin)[:, None]
            return rotation.product(rotation.inverse(first), found)

        def rate(track: Track, begin: Array) -> Array:
            if track.gyro is None:
                return track.rate.at(begin[:, None] + times)
            return track.gyro.at(begin[:, None] + times + delay) - gyro_bias

        def force(track: Track, begin: Array) -> Array | float:
            if track.force is None:
                return 0.0
            return track.force(begin[:, None] + times - SAMPLE + delay, SAMPLE) - force_bias

        return Measured(
            self._collect(position, (self.samples, 3)),
            self._collect(quaternion, (self.samples, 4)),
            self._collect(rate, (self.samples, 3)),
            self._collect(force, (self.samples, 3)),
        )


def vector(values: Mapping[str, float], name: str) -> Array:
    """Three values NAME_x, NAME_y, NAME_z; absent ones are 0."""
    return np.array([values.get(f"{name}_{axis}", 0.0) for axis in "xyz"])


def cut(tracks: Sequence[Track], stride: float, length: float) -> Windows:
    """Windows of all usable parts of flights.

    Args:
        tracks: the flights.
        stride: between starts [s].
        length: of a window [s].
    """
    begins = [starts_of(track, stride, length) for track in tracks]
    flight = np.repeat(np.arange(len(tracks)), [len(b) for b in begins])
    return Windows(tracks, flight, np.concatenate(begins), length)


def starts_of(track: Track, stride: float, length: float = LENGTH) -> Array:
    """Starts of windows that hold no bad stretch [s]."""
    first, last = track.record.span()
    begins = np.arange(first + WARM + EDGE, last - length - EDGE - SPREAD, stride)
    # Between samples noise is averaged: starts at one phase of them would pull the delays.
    begins += SPREAD * ((GOLDEN * np.arange(len(begins))) % 1.0)
    good = np.ones(len(begins), bool)
    for low, high, _ in track.record.bad:
        good &= (begins + length + EDGE < low) | (begins - WARM - EDGE > high)
    return np.asarray(begins[good])
