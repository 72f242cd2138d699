"""Pilots at Betaflight's radio in acro mode: body rates and thrust, given by a policy."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray

from skybody import CompiledScenario
from skybody._native import PolicyNetwork
from skybody.train.policy_file import shipped_policy
from skybody.view.live import weight_of

from .betaflight import HIGH, LOW, MIDDLE
from .betaflight_pilot import GRACE, RADIO_PERIOD, SWITCH_PERIOD, hover_share
from .betaflight_rates import (
    LINEAR,
    RateSticks,
    authority_of,
    gain_lines,
    speed_slope,
    throttle_stick,
)
from .frames import Array
from .vehicle import Reading, Vehicle

SIGNAL, SHIPPED = "ctbr", "shipped"
GAINS = np.array([[20.0, 20.0, 8.0], [0.1, 0.1, 0.1]])  # kp [1/s] and kd of `ctbr` by default
ARM, RISE = 0.3, 0.6  # within a try: the switch, then the throttle [s]
TURNING = 0.5  # share of the hover's speed at which the motors have followed
READY = 50  # radio packets with turning motors before the start


class RatePilot(ABC):
    """Flies a robot by thrust and body rates, chosen at the rate of the scenario's actions.

    The vehicle is held at its start until Betaflight is armed and its motors turn as in a hover.
    """

    def __init__(self, vehicle: Vehicle) -> None:
        """Raises ValueError if the robot's command is none of rates and thrust."""
        self.vehicle = vehicle
        self.own = CompiledScenario(vehicle.setup.scenario, list(vehicle.setup.overrides))
        self.low, self.high = command_range(self.own, vehicle.robot)
        self._hover = hover_share(vehicle)  # of the full thrust
        self._speed = math.sqrt(self._hover)  # of the greatest one
        self.weight = weight_of(self.own, vehicle.robot)  # [N]
        self.sticks = RateSticks.of(self.high[1:].tolist(), self.weight / self._hover)
        period = self.own.dt * self.own.action_repeat
        self.radio_period = period / max(1, round(period / RADIO_PERIOD))
        self.ended = False
        self._command: Array = np.zeros(4)
        self._next = 0
        self._turning = 0

    @property
    def waits(self) -> bool:
        """Whether Betaflight is not ready yet."""
        return self._turning < READY

    def settings(self) -> list[str]:
        """Lines of Betaflight's console: sticks, and the gains of the scenario's `ctbr`."""
        authority = authority_of(self.vehicle, self._speed) * speed_slope(self._speed)
        kp, kd = rate_gains(self.own)
        return [*LINEAR, *self.sticks.settings(), *gain_lines(kp, kd, authority)]

    def prepare(self, time: float, throttles: Array) -> list[float]:
        """Arms, then holds the throttle of a hover."""
        since = (time - GRACE) % SWITCH_PERIOD if time > GRACE else 0.0
        turns = bool(np.all(throttles > TURNING * self._speed))
        self._turning = self._turning + 1 if turns else 0
        throttle = throttle_stick(self._hover) if turns or since > RISE else LOW
        arm = HIGH if turns or since > ARM else LOW
        return [MIDDLE, MIDDLE, throttle, MIDDLE, arm, LOW]

    def channels(self, reading: Reading, motors_turn: bool) -> list[float]:
        """Channels of the radio [us]."""
        del reading, motors_turn
        if self.vehicle.steps >= self._next:
            self._next += self.own.action_repeat
            self._command = self.decide()
        return [*self.sticks.channels(self._command[0], self._command[1:]), HIGH, LOW]

    @abstractmethod
    def decide(self) -> Array:
        """The next command: thrust [N] and rates about x, y, z of B [rad/s]."""


class PolicyPilot(RatePilot):
    """Flies the scenario's own task by a policy: its observation, its network, its actions."""

    def __init__(self, vehicle: Vehicle, policy: str) -> None:
        """policy: `shipped`, or the path of a policy.h5 or of a training run.

        Raises:
            Error: the policy cannot be read.
            ValueError: as RatePilot; or the policy has other sizes.
        """
        super().__init__(vehicle)
        file = str(shipped_policy(self.own.name)) if policy == SHIPPED else policy
        self._network = PolicyNetwork(file)
        self._action = np.zeros(0, np.float32)

    def decide(self) -> Array:
        """As RatePilot.decide(); evaluates the task first."""
        simulation = self.vehicle.simulation
        if self.vehicle.steps > 0:
            simulation.evaluate()
            self.ended = simulation.terminated or simulation.truncated
        row = with_action(self.vehicle.compiled, simulation.observation, self._action)
        self._action = self._network.act(row[None])[0]
        share = 0.5 * (1.0 + self._action.astype(np.float64))
        return np.asarray(self.low + share * (self.high - self.low))


def command_range(compiled: CompiledScenario, robot: str) -> tuple[Array, Array]:
    """Thrust and rates that the actions -1 and +1 of a robot mean [N, rad/s].

    Raises:
        ValueError: its command is another one.
    """
    index = compiled.robots.index(robot)
    channels = compiled.action_channels
    if [(c.name, c.robot) for c in channels] != [(SIGNAL, index)]:
        names = ", ".join(f"`{c.name}`" for c in channels) or "nothing"
        raise ValueError(
            f"{compiled.name}: actions command {names}; --pilot policy needs one robot with "
            f"`{SIGNAL}`, thrust and body rates (docs/control-modes.md)"
        )
    return np.array(channels[0].low), np.array(channels[0].high)


def rate_gains(compiled: CompiledScenario) -> Array:
    """kp [1/s] and kd about x, y, z, (2, 3): of the first controller with both, else GAINS."""
    paths = set(compiled.param_paths)
    for first in sorted(p for p in paths if ".controllers." in p and p.endswith(".kp[2]")):
        name = first.removesuffix(".kp[2]")
        rows = [[f"{name}.{gain}[{k}]" for k in range(3)] for gain in ("kp", "kd")]
        if all(path in paths for row in rows for path in row):
            return np.array([[compiled.param_info(path)[0] for path in row] for row in rows])
    return GAINS


def with_action(
    compiled: CompiledScenario, row: NDArray[np.float32], action: NDArray[np.float32]
) -> NDArray[np.float32]:
    """Writes the last action into the columns `action` of an observation; returns the row.

    The simulation knows no action, since Betaflight turns the rotors.

    Args:
        row: an observation, changed in place.
        action: empty before the first one.
    """
    for column in compiled.observation_columns:
        if action.size and column.source == "task" and column.name.split(".")[-1] == "action":
            row[column.first : column.first + action.size] = action
    return row
