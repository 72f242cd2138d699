"""Multiple shooting: parameters and the starts of all windows by least squares, robustly.

The normal equations have the shape of an arrow: the start of a window matters to this window
alone. The starts are eliminated window by window (Schur complement), so that the remaining
equations are as many as the parameters.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from skybody.look.flight import Array

from .residuals import KINDS, START, Deviations, Residuals, moved, start_deviations

ROBUST = 2.5  # standard deviations from which on a residual counts less
STEPS = 12  # most of Gauss and Newton
ENOUGH = 1e-4  # relative fall of the cost at which the search ends
# Least and greatest deviations of residuals [m], [rad], [rad/s], [m/s^2].
LEAST = {"position": 1e-4, "attitude": 2e-4, "rate": 2e-3, "force": 1e-2}
MOST = {"position": 0.02, "attitude": 0.04, "rate": 0.4, "force": 0.5}


@dataclass
class Fit:
    """A minimum."""

    x: Array  # coordinates of all parameters
    starts: Array  # (n, 13)
    cost: float
    free: list[int]
    information: Array  # (free, free), of the data alone, starts eliminated
    scores: Array  # (n, free): gradient of each window, starts eliminated
    deviations: Deviations


class Problem:
    """The least squares problem."""

    def __init__(self, residuals: Residuals, free: Sequence[int]) -> None:
        self.residuals, self.free = residuals, list(free)
        self.deviations = Deviations(residuals.windows.samples)
        self._start_deviations = start_deviations(residuals.windows)
        parameters = residuals.model.parameters
        self._priors = np.array([parameters[k].prior for k in self.free])
        self._low, self._high = np.array([parameters[k].bounds for k in self.free]).T

    def solve(self, x: Array, starts: Array | None = None, steps: int = STEPS) -> Fit:
        """Searches from coordinates, by Levenberg and Marquardt's method."""
        if starts is None:
            starts = self.residuals.measured_starts(x)
        damping, cost = 1e-1, self._cost(*self.residuals.values(x, starts), x)
        for _ in range(steps):
            equations = self._equations(x, starts)
            improved = False
            for _ in range(10):
                new_x, new_starts = self._step(equations, x, starts, damping)
                new = self._cost(*self.residuals.values(new_x, new_starts), new_x)
                if new < cost:
                    improved, fall = True, (cost - new) / cost
                    x, starts, cost = new_x, new_starts, new
                    damping = max(damping / 5.0, 1e-6)
                    break
                damping *= 6.0
            if not improved or fall < ENOUGH:
                break
        equations = self._equations(x, starts)
        return Fit(x, starts, cost, self.free, equations.schur, equations.scores, self.deviations)

    def rescale(self, x: Array, starts: Array) -> None:
        """Sets the deviations to those of the residuals at a solution, by kind and sample."""
        rows, _ = self.residuals.values(x, starts)
        shaped = rows.reshape(len(rows), -1, 4, 3)
        windows = self.residuals.windows
        for k, kind in enumerate(KINDS):
            known = {"position": windows.has_pose, "force": windows.has_force}.get(kind)
            some = shaped[:, :, k] if known is None else shaped[known, :, k]
            if len(some) == 0:
                continue
            spread = 1.4826 * np.median(np.abs(some), axis=0)  # (samples, 3)
            spread = np.sqrt(np.mean(spread**2, axis=1, keepdims=True)) * np.ones((1, 3))
            # Not far above the first ones: windows that fit badly must not lose their weight.
            self.deviations.of[kind] = np.clip(spread, LEAST[kind], MOST[kind])

    def _cost(self, rows: Array, shifts: Array, x: Array) -> float:
        scaled = rows / self.deviations.row()
        loss = 2.0 * ROBUST**2 * (np.sqrt(1.0 + (scaled / ROBUST) ** 2) - 1.0)
        prior = x[self.free] / self._priors
        return float(loss.sum() + ((shifts / self._start_deviations) ** 2).sum() + (prior**2).sum())

    def _equations(self, x: Array, starts: Array) -> Equations:
        rows, by_x, by_start, start_by_x = self.residuals.derivatives(x, starts, self.free)
        _, shifts = self.residuals.values(x, starts)
        scale = 1.0 / self.deviations.row()
        scaled = rows * scale
        # The robust loss as weights, (1 + r^2 / c^2)^(-1/4) on residual and derivative.
        weight = (1.0 + (scaled / ROBUST) ** 2) ** -0.25
        r, factor = scaled * weight, (weight * scale)[:, :, None]
        a, b = by_x * factor, by_start * factor
        # Rows of the measured starts: starts - measured(x).
        pull = 1.0 / self._start_deviations
        a = np.concatenate([a, -start_by_x * pull[:, :, None]], axis=1)
        own = pull[:, :, None] * np.eye(START)
        b = np.concatenate([b, own], axis=1)
        r = np.concatenate([r, shifts * pull], axis=1)
        return Equations(a, b, r)

    def _step(
        self, equations: Equations, x: Array, starts: Array, damping: float
    ) -> tuple[Array, Array]:
        inside = x[self.free]
        equations = equations.damped(damping)
        matrix = equations.schur + np.diag(1.0 / self._priors**2)
        matrix = matrix + damping * np.diag(np.diag(matrix))
        gradient = equations.scores.sum(axis=0) + inside / self._priors**2
        step = bounded_step(matrix, gradient, self._low - inside, self._high - inside)
        new_x = x.copy()
        new_x[self.free] = inside + step
        return new_x, moved(starts, equations.starts(step))


class Equations:
    """Linear equations of all windows, with the starts eliminated."""

    def __init__(self, a: Array, b: Array, r: Array, damping: float = 0.0) -> None:
        """
        Args:
            a: derivatives by the parameters, (n, rows, p).
            b: derivatives by the starts, (n, rows, START).
            r: residuals, (n, rows).
            damping: of the starts.
        """
        self._parts = (a, b, r)
        b_t = np.swapaxes(b, 1, 2)
        inner = b_t @ b  # (n, START, START)
        inner = inner * (1.0 + damping * np.eye(START))
        cross = b_t @ a  # (n, START, p)
        pulled = (b_t @ r[:, :, None])[:, :, 0]
        self._by_x = np.linalg.solve(inner, cross)
        self._own = np.linalg.solve(inner, pulled[:, :, None])[:, :, 0]
        a_t = np.swapaxes(a, 1, 2)
        self.each = a_t @ a - np.swapaxes(cross, 1, 2) @ self._by_x  # (n, p, p)
        self.schur: Array = self.each.sum(axis=0)
        direct = (a_t @ r[:, :, None])[:, :, 0]
        self.scores: Array = direct - (np.swapaxes(cross, 1, 2) @ self._own[:, :, None])[:, :, 0]

    def damped(self, damping: float) -> Equations:
        """The same equations for shorter steps of the starts."""
        return Equations(*self._parts, damping)

    def starts(self, step: Array) -> Array:
        """Moves of the starts for a step of the parameters, (n, START)."""
        return np.asarray(-self._own - self._by_x @ step)


def bounded_step(matrix: Array, gradient: Array, low: Array, high: Array) -> Array:
    """Minimum of g d + d M d / 2 within bounds, by fixing the components that leave them."""
    step = np.zeros_like(gradient)
    held = np.zeros(len(gradient), bool)
    for _ in range(len(gradient)):
        inside = ~held
        right = -gradient[inside] - matrix[np.ix_(inside, held)] @ step[held]
        step[inside] = np.linalg.solve(matrix[np.ix_(inside, inside)], right)
        beyond = inside & ((step < low) | (step > high))
        if not beyond.any():
            break
        held |= beyond
        step = np.clip(step, low, high)
    return np.clip(step, low, high)
