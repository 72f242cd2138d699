"""Commands of a test flight, for each level at which a chain may begin."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from skybody._native import CompiledScenario

from .vehicle import COMMAND_PERIOD, ROBOT, START, TuneError

Rows = NDArray[np.float64]

WAIT = 0.2  # [s] before the step
STEP_TIME = 3.0  # [s] from the step to the path
PATH_TIME = 5.0  # [s]


@dataclass(frozen=True)
class Motion:
    """Motion of all environments at one moment, one row each."""

    position: Rows
    """(n, 3), W [m]"""
    rotation: Rows
    """(n, 4), W from B"""
    velocity: Rows
    """(n, 3), W [m/s]"""
    rates: Rows
    """(n, 3), B [rad/s]"""


@dataclass(frozen=True)
class Program:
    """Commands of a flight, and the wanted motion of the vehicle."""

    level: str
    names: tuple[str, ...]
    units: tuple[str, ...]
    commands: Rows
    """(steps, values), in the units of the level."""
    targets: Rows
    """(steps, tracked)"""
    scale: Rows
    """(tracked,): size of the step; errors are divided by it."""
    lost: float
    """Errors beyond this multiple of the scale are a failure."""
    tracked: Callable[[Motion], Rows]
    """(n, tracked): current values of the tracked quantities."""
    angles: tuple[int, ...]
    """Tracked values that are angles, whose errors wrap around."""
    step_begin: int
    step_end: int

    @property
    def times(self) -> Rows:
        return np.asarray(np.arange(len(self.commands)) * COMMAND_PERIOD, np.float64)

    def error(self, row: int, motion: Motion) -> Rows:
        """(n, tracked), in units of the scale."""
        difference = self.tracked(motion) - self.targets[row]
        for k in self.angles:
            difference[:, k] = (difference[:, k] + np.pi) % (2.0 * np.pi) - np.pi
        return np.asarray(difference / self.scale)


def make_program(compiled: CompiledScenario) -> Program:
    """The flight for the level at which the chain begins.

    Raises:
        TuneError: there is no flight for that level, or there are several chains.
    """
    channels = compiled.action_channels
    if len(channels) != 1:
        raise TuneError(
            f"the controllers make {len(channels)} chains; one chain of one vehicle can be tuned"
        )
    level = channels[0].name
    if level not in PROGRAMS:
        raise TuneError(
            f"the chain begins at `{level}`; gains are fitted to chains that begin at "
            + ", ".join(PROGRAMS)
            + ": put controllers before it that lead there (`skybody modes`)"
        )
    return PROGRAMS[level](compiled)


def normalized(compiled: CompiledScenario, commands: Rows) -> NDArray[np.float32]:
    """Commands as actions in [-1, 1]. Raises TuneError if the first controller would clip one."""
    channel = compiled.action_channels[0]
    low, high = np.array(channel.low), np.array(channel.high)
    # Values without a range in actions, such as the jerk of `trajectory`, keep the chain's value.
    has_range = high > low
    span = np.where(has_range, high - low, 1.0)
    actions = np.where(has_range, 2.0 * (commands - low) / span - 1.0, 0.0)
    if np.any(np.abs(actions) > 1.0 + 1e-6):
        k = int(np.argmax(np.max(np.abs(actions), axis=0)))
        raise TuneError(
            f"value {k} of `{channel.name}` is commanded from {np.min(commands[:, k]):.3g} to "
            f"{np.max(commands[:, k]):.3g} over the flight, but the chain takes {low[k]:.3g} to "
            f"{high[k]:.3g}: widen its range in --chain"
        )
    return np.asarray(np.clip(actions, -1.0, 1.0), np.float32)


def _times() -> tuple[Rows, Rows, int, int]:
    """Times of commands, times since the path's start, first row of the step and of the path."""
    begin = round(WAIT / COMMAND_PERIOD)
    end = begin + round(STEP_TIME / COMMAND_PERIOD)
    count = end + round(PATH_TIME / COMMAND_PERIOD)
    times: Rows = np.asarray(np.arange(count) * COMMAND_PERIOD, np.float64)
    return times, np.maximum(times - times[end], 0.0), begin, end


def _cosines(t: Rows, order: int) -> Rows:
    """Derivative `order` of the path (steps, 3): sums of 1 - cos, at rest at its start."""
    size = np.array([0.9, 0.35, 0.15])
    rate = np.array([1.15, 2.3, 1.725])  # [rad/s]: a figure of eight, peak 1.3 m/s, 2 m/s^2
    phase = rate * t[:, None]
    # The derivatives of 1 - cos repeat with period 4: sin, cos, -sin, -cos.
    shape = (np.sin(phase), np.cos(phase), -np.sin(phase), -np.cos(phase))
    value = 1.0 - np.cos(phase) if order == 0 else shape[(order - 1) % 4]
    moving = (t > 0.0)[:, None]
    return np.where(moving, size * rate**order * value, 0.0)


STEP = np.array([1.0, -0.7, 0.6])  # [m]
YAW_STEP = 0.8  # [rad]


def _positions() -> tuple[list[Rows], Rows, int, int]:
    """Position and its derivatives up to the fourth (steps, 3) each, yaw."""
    times, on_path, begin, end = _times()
    stepped = (np.arange(len(times)) >= begin)[:, None]
    orders = [_cosines(on_path, order) for order in range(5)]
    orders[0] = np.array(START) + np.where(stepped, STEP, 0.0) + orders[0] * [-1.0, 1.0, -1.0]
    for order in range(1, 5):
        orders[order] = orders[order] * [-1.0, 1.0, -1.0]
    yaw = np.where(stepped[:, 0], YAW_STEP, 0.0)
    return orders, yaw, begin, end


def yaw_of(rotation: Rows) -> Rows:
    """Heading of quaternions (n, 4) [rad]."""
    w, x, y, z = rotation.T
    yaw: Rows = np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return yaw


def _place(motion: Motion) -> Rows:
    return np.column_stack([motion.position, yaw_of(motion.rotation)])


def _positional(level: str, commands: Rows) -> Program:
    orders, heading, begin, end = _positions()
    return Program(
        level=level,
        names=("x", "y", "z", "yaw"),
        units=("m", "m", "m", "rad"),
        commands=commands,
        targets=np.column_stack([orders[0], heading]),
        scale=np.array([1.0, 1.0, 1.0, 1.0]),
        lost=4.0,
        tracked=_place,
        angles=(3,),
        step_begin=begin,
        step_end=end,
    )


def _position(compiled: CompiledScenario) -> Program:
    del compiled
    orders, yaw, _, _ = _positions()
    return _positional("position", np.column_stack([orders[0], yaw]))


def _trajectory(compiled: CompiledScenario) -> Program:
    orders, yaw, _, _ = _positions()
    commands = np.column_stack([*orders, yaw, np.zeros_like(yaw)])
    points = len(compiled.action_channels[0].low) // commands.shape[1]
    if points != 1:
        raise TuneError(
            f"the chain takes {points} points of `trajectory` ahead; gains are fitted to chains "
            "that take one"
        )
    return _positional("trajectory", commands)


def _velocity(compiled: CompiledScenario) -> Program:
    """Steps of velocity and back, then the path's velocity."""
    del compiled
    orders, _, begin, end = _positions()
    rows = np.arange(len(orders[0]))
    moving = ((rows >= begin) & (rows < end))[:, None]
    velocity = orders[1] + np.where(moving, STEP, 0.0)
    rate = np.where(moving[:, 0], 0.5, 0.0)
    targets = np.column_stack([velocity, rate])
    return Program(
        level="velocity_tracking",
        names=("vx", "vy", "vz", "yaw rate"),
        units=("m/s", "m/s", "m/s", "rad/s"),
        commands=targets,
        targets=targets,
        scale=np.ones(4),
        lost=8.0,
        tracked=lambda motion: np.column_stack([motion.velocity, motion.rates[:, 2]]),
        angles=(),
        step_begin=begin,
        step_end=end,
    )


def _hover_thrust(compiled: CompiledScenario) -> float:
    """Nominal weight [N]."""
    mass = sum(
        compiled.param_info(path)[0]
        for path in compiled.param_paths
        if path.startswith(f"robots.{ROBOT}.links.") and path.endswith(".mass")
    )
    return mass * float(np.linalg.norm(compiled.gravity))


def _attitude(compiled: CompiledScenario) -> Program:
    """A tilted attitude with a heading, then waves of roll and pitch."""
    times, _, begin, _ = _times()
    end = begin + round(1.2 / COMMAND_PERIOD)  # longer, and it would fall far
    stepped = np.arange(len(times)) >= begin
    angles = np.column_stack([np.where(stepped, 0.3, 0.0)] * 2 + [np.where(stepped, 0.8, 0.0)])
    waves = np.arange(len(times)) >= end
    since = np.maximum(times - times[end], 0.0)
    angles[waves, 0] = 0.3 * np.cos(4.0 * since[waves])
    angles[waves, 1] = 0.3 * np.cos(5.0 * since[waves])
    thrust = np.full(len(times), _hover_thrust(compiled))
    commands = np.column_stack([thrust, _quaternions(angles)])
    values = len(compiled.action_channels[0].low)
    commands = np.column_stack([commands, np.zeros((len(times), values - 5))])
    return Program(
        level="attitude",
        names=("roll", "pitch", "yaw"),
        units=("rad", "rad", "rad"),
        commands=commands,
        targets=angles,
        scale=np.array([0.3, 0.3, 0.8]),
        lost=6.0,
        tracked=lambda motion: _angles(motion.rotation),
        angles=(0, 1, 2),
        step_begin=begin,
        step_end=end,
    )


def _rates(compiled: CompiledScenario) -> Program:
    """Short steps of the body's rates that return to the start, then waves."""
    times, _, begin, _ = _times()
    end = begin + round(0.6 / COMMAND_PERIOD)
    rows = np.arange(len(times))
    turning = np.where((rows >= begin) & (rows < end), 1.0, 0.0)
    since = np.maximum(times - times[end], 0.0)
    waves = np.where(rows >= end, 1.0, 0.0)
    rates = np.column_stack(
        [
            turning * 1.0 - waves * np.sin(5.0 * since),
            -turning * 0.8 + waves * np.sin(6.0 * since),
            turning * 0.5 + waves * 0.5 * np.sin(3.0 * since),
        ]
    )
    thrust = np.full(len(times), _hover_thrust(compiled))
    return Program(
        level="ctbr",
        names=("p", "q", "r"),
        units=("rad/s", "rad/s", "rad/s"),
        commands=np.column_stack([thrust, rates]),
        targets=rates,
        scale=np.array([1.0, 0.8, 0.5]),
        lost=20.0,
        tracked=lambda motion: motion.rates.copy(),
        angles=(),
        step_begin=begin,
        step_end=end,
    )


def _quaternions(angles: Rows) -> Rows:
    """W from B of roll, pitch, yaw (n, 3): rotations about x, then y, then z of W."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(angles.T / 2.0), np.sin(angles.T / 2.0)
    return np.column_stack(
        [
            cr * cp * cy + sr * sp * sy,
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
        ]
    )


def _angles(rotation: Rows) -> Rows:
    """Roll, pitch and yaw of quaternions (n, 4)."""
    w, x, y, z = rotation.T
    roll = np.arctan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    pitch = np.arcsin(np.clip(2.0 * (w * y - x * z), -1.0, 1.0))
    return np.column_stack([roll, pitch, yaw_of(rotation)])


PROGRAMS: dict[str, Callable[[CompiledScenario], Program]] = {
    "position": _position,
    "trajectory": _trajectory,
    "velocity_tracking": _velocity,
    "attitude": _attitude,
    "ctbr": _rates,
}
