"""Residuals of windows and their derivatives, by one batch of replays."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from skybody.look.flight import Array

from . import rotation
from .parameters import COMMAND, LOG, SENSOR, Model
from .replay import Prediction, Replayer
from .windows import Measured, Windows

KINDS = ("position", "attitude", "rate", "force")
START = 12  # numbers of a start: position, rotation vector (B), velocity, angular velocity
# Deviations of measured starts: m, rad, m/s, rad/s.
START_DEVIATION = np.repeat([0.003, 0.01, 0.1, 0.15], 3)
# Without poses the accelerometer alone tells velocity [m/s] and tilt [rad].
FREE_VELOCITY, FREE_TILT = 1.0, 0.1
START_STEP = np.repeat([1e-3, 1e-3, 1e-2, 1e-2], 3)  # of differences
VALUES = 12  # measured at each sample


def start_deviations(windows: Windows) -> Array:
    """Standard deviations of the measured starts, (n, START)."""
    made = np.tile(START_DEVIATION, (len(windows), 1))
    made[~windows.has_pose, 3:6] = FREE_TILT
    made[~windows.has_pose, 6:9] = FREE_VELOCITY
    return made


class Deviations:
    """Standard deviations of the residuals: by kind, (samples, 3) each."""

    def __init__(self, samples: int) -> None:
        values = zip(KINDS, (0.01, 0.02, 0.2, 0.5), strict=True)
        self.of = {kind: np.full((samples, 3), value) for kind, value in values}

    def row(self) -> Array:
        """(rows,), in the order of the residuals."""
        return np.concatenate([self.of[kind] for kind in KINDS], axis=1).reshape(-1)


def moved(starts: Array, shift: Array) -> Array:
    """Starts (n, 13) moved by START numbers (n, 12)."""
    made = starts.copy()
    made[:, :3] += shift[:, :3]
    made[:, 3:7] = rotation.product(starts[:, 3:7], rotation.of_vector(shift[:, 3:6]))
    made[:, 7:] += shift[:, 6:]
    return made


def between(starts: Array, measured: Array) -> Array:
    """START numbers from measured starts to starts."""
    turn = rotation.vector_of(rotation.product(rotation.inverse(measured[:, 3:7]), starts[:, 3:7]))
    return np.concatenate(
        [starts[:, :3] - measured[:, :3], turn, starts[:, 7:] - measured[:, 7:]], axis=1
    )


def differences(predicted: Prediction, measured: Measured, windows: Windows) -> Array:
    """Predicted minus measured values, (n, rows); 0 where nothing was measured."""
    turn = rotation.vector_of(
        rotation.product(rotation.inverse(measured.quaternion), predicted.quaternion)
    )
    pose = windows.has_pose[:, None, None]
    rows = np.concatenate(
        [
            np.where(pose, predicted.position - measured.position, 0.0),
            turn,
            predicted.rate - measured.rate,
            np.where(windows.has_force[:, None, None], predicted.force - measured.force, 0.0),
        ],
        axis=2,
    )
    return np.asarray(rows.reshape(len(windows), -1))


class Residuals:
    """Evaluates windows for coordinates of the parameters and starts."""

    def __init__(self, model: Model, windows: Windows, replayer: Replayer) -> None:
        self.model, self.windows, self._replayer = model, windows, replayer
        self.takes_detail = True

    def without_detail(self) -> Residuals:
        """The same windows with commands as they are."""
        made = Residuals(self.model, self.windows, self._replayer)
        made.takes_detail = False
        return made

    def values(self, x: Array, starts: Array) -> tuple[Array, Array]:
        """Differences (n, rows), and START numbers of starts from the measured ones (n, START)."""
        found = self._predict(x, starts)
        values = self.model.values(x)
        rows = differences(found, self.windows.measured(values), self.windows)
        return rows, between(starts, self.windows.starts(values))

    def measured_starts(self, x: Array) -> Array:
        """(n, 13)"""
        return self.windows.starts(self.model.values(x))

    def open_loop(self, x: Array) -> tuple[Prediction, Measured]:
        """Replays from the measured starts."""
        return (
            self._predict(x, self.measured_starts(x)),
            self.windows.measured(self.model.values(x)),
        )

    def speeds(self, x: Array) -> Array:
        """Commanded speeds of the rotors [rad/s], (n, steps, rotors)."""
        values = self.model.values(x)
        detail = values.get("log.detail") if self.takes_detail else None
        command, voltage = self.windows.commands(values["delay.command"], detail)
        known = voltage if np.isfinite(voltage).all() else None
        return self.model.speeds(values, command, known)

    def _predict(self, x: Array, starts: Array) -> Prediction:
        paths, row = self._engine(x)
        tiled = np.tile(row, (len(starts), 1))
        return self._flown(paths, tiled, starts, self.speeds(x))

    def _flown(
        self, paths: Sequence[str], rows: Array, starts: Array, commands: Array
    ) -> Prediction:
        """Replays of all windows, once or several times; without poses attitudes are relative."""
        found = self._replayer.run(paths, rows, starts, commands)
        loose = np.tile(~self.windows.has_pose, len(starts) // len(self.windows))
        first = rotation.inverse(starts[loose, None, 3:7])
        found.quaternion[loose] = rotation.product(first, found.quaternion[loose])
        return found

    def _engine(self, x: Array) -> tuple[list[str], Array]:
        made = self.model.engine(self.model.values(x))
        return list(made), np.array(list(made.values()))

    def derivatives(
        self, x: Array, starts: Array, free: Sequence[int]
    ) -> tuple[Array, Array, Array, Array]:
        """Differences and their derivatives.

        Args:
            x: coordinates.
            starts: (n, 13).
            free: indices of the parameters with derivatives.

        Returns:
            Rows (n, rows); by the parameters (n, rows, free); by the starts (n, rows, START); and
            derivatives of the measured starts by the parameters (n, START, free).
        """
        count, steps = len(self.windows), self._steps()
        paths, base = self._engine(x)
        speeds = self.speeds(x)
        rows, places, commands = [base], [starts], [speeds]
        flown = [k for k in free if self.model.parameters[k].place != SENSOR]
        for k in flown:
            other = x.copy()
            other[k] += steps[k]
            rows.append(self._engine(other)[1])
            is_command = self.model.parameters[k].place == COMMAND
            commands.append(self.speeds(other) if is_command else speeds)
            places.append(starts)
        for k in range(3, START):
            shift = np.zeros((count, START))
            shift[:, k] = START_STEP[k]
            rows.append(base)
            places.append(moved(starts, shift))
            commands.append(speeds)
        all_rows = np.repeat(np.stack(rows), count, axis=0)
        found = self._flown(paths, all_rows, np.concatenate(places), np.concatenate(commands))
        return self._assemble(x, starts, free, flown, found)

    def _assemble(
        self, x: Array, starts: Array, free: Sequence[int], flown: list[int], found: Prediction
    ) -> tuple[Array, Array, Array, Array]:
        count, steps = len(self.windows), self._steps()
        values = self.model.values(x)
        measured = self.windows.measured(values)

        def rows_of(k: int, others: Measured = measured) -> Array:
            some = slice(k * count, (k + 1) * count)
            part = Prediction(
                found.position[some], found.quaternion[some], found.rate[some], found.force[some]
            )
            return differences(part, others, self.windows)

        here = rows_of(0)
        by_x = np.zeros((count, here.shape[1], len(free)))
        by_start = np.zeros((count, here.shape[1], START))
        start_by_x = np.zeros((count, START, len(free)))
        own = self.windows.starts(values)
        for column, k in enumerate(free):
            other = x.copy()
            other[k] += steps[k]
            shifted = self.model.values(other)
            start_by_x[:, :, column] = between(self.windows.starts(shifted), own) / steps[k]
            if k in flown:
                by_x[:, :, column] = (rows_of(1 + flown.index(k)) - here) / steps[k]
            else:
                by_x[:, :, column] = (rows_of(0, self.windows.measured(shifted)) - here) / steps[k]
        for k in range(3, START):
            by_start[:, :, k] = (rows_of(1 + len(flown) + k - 3) - here) / START_STEP[k]
        for k in range(3):  # a shift of the start shifts all positions
            by_sample = by_start.reshape(count, -1, VALUES, START)
            by_sample[:, :, k, k] = self.windows.has_pose[:, None]
        return here, by_x, by_start, start_by_x

    def _steps(self) -> Array:
        """Steps of the differences by parameter, into their bounds."""
        steps = []
        for parameter in self.model.parameters:
            share = 0.02 if parameter.form == LOG else 0.02 * parameter.prior
            steps.append(max(share, 2e-4) if parameter.name.startswith("delay") else share)
        return np.array(steps)
