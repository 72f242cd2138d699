"""A simulation that commands advance and whose states are read: a bridge without middleware."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from skybody import InputError, Simulation

from .bridge_map import BridgeMap, Row
from .commands import COMMANDS, SHARES
from .frames import Reals
from .messages import AnyMessage
from .states import SENSORS, STATES, Fill, filler


class Bridge:
    """Rows of a map, with the simulation behind them.

    Commands wait until each row of the map's `command` has one; then `advance` makes a step.
    """

    def __init__(self, simulation: Simulation, table: BridgeMap) -> None:
        """Expands `{robot}` in topics and resets the simulation.

        Raises:
            InputError: a row does not fit the scenario.
        """
        self.simulation = simulation
        robots = simulation.compiled.robots
        self.publish = [one for row in table.publish for one in expanded(row, robots)]
        self.command = [one for row in table.command for one in expanded(row, robots)]
        self.fills: list[Fill] = [self._fill_of(row) for row in self.publish]
        for row in self.command:
            self._check_command(row)
        self._waiting: dict[int, Reals] = {}
        self._due = [0.0] * len(self.publish)
        simulation.reset()

    # --- commands -------------------------------------------------------------------------------

    def take(self, number: int, message: Any) -> str:
        """Keeps the command of a row.

        Returns:
            Why it is refused; empty: it is taken.
        """
        row = self.command[number]
        read = COMMANDS[row.part].readers[row.type]
        values = read(message)
        if read in SHARES:
            values[0] *= self._largest_thrust(row.robot)
        wanted = self._size(row)
        if values.shape != (wanted,):
            return f"{row.topic}: {values.size} numbers; allowed: {wanted}"
        if row.part != "action" and not np.isfinite(values).all():
            return f"{row.topic}: a number is not finite; the last command stays"
        self._waiting[number] = values
        return ""

    @property
    def is_ready(self) -> bool:
        """Whether each row has a command that no step has used."""
        return len(self._waiting) == len(self.command)

    def advance(self) -> None:
        """One step under the commands; after the end of an episode the next one begins."""
        simulation = self.simulation
        if simulation.terminated or simulation.truncated:
            self.reset()
            return
        if all(row.part == "action" for row in self.command) and self.command:
            simulation.step(np.asarray(self._waiting[0], np.float32))
        else:
            for number, values in self._waiting.items():
                simulation.command(values, self.command[number].robot)
            simulation.advance(simulation.compiled.action_repeat)
            simulation.evaluate()
        self._waiting = {}

    def reset(self, seed: int | None = None) -> None:
        """Begins the next episode; waiting commands go."""
        self._waiting = {}
        if seed is None:
            self.simulation.reset()
        else:
            self.simulation.reset(seed)
        self.make_due()

    def restore(self, saved: Any) -> None:
        """Back to a saved state; waiting commands go."""
        self._waiting = {}
        self.simulation.restore(saved)
        self.make_due()

    # --- states ---------------------------------------------------------------------------------

    def due(self) -> list[int]:
        """Rows of `publish` whose message is due now."""
        now = self.simulation.time
        found = [k for k, time in enumerate(self._due) if now >= time - 1e-9]
        for k in found:
            rate = self.publish[k].rate
            period = 1.0 / rate if rate > 0.0 else 0.0
            # On a grid of its own, so that a rate between those of steps holds on average.
            self._due[k] = max(self._due[k] + period, now)
        return found

    def make_due(self) -> None:
        """All messages are due: the time has gone back, or someone asks for them again."""
        self._due = [self.simulation.time] * len(self.publish)

    def fill(self, number: int, message: Any) -> None:
        """Writes a row's message, with its frame; the stamp is the caller's."""
        row = self.publish[number]
        if hasattr(message, "header"):
            message.header.frame_id = row.frame or default_frame(row)
        self.fills[number](message, self.simulation, row)

    # --- checks ---------------------------------------------------------------------------------

    def _fill_of(self, row: Row) -> Fill:
        fill = filler(row)
        if fill is None:
            raise InputError(
                f"{row.topic}: `{row.part}` as {row.type}: there is no such row; parts are "
                f"{', '.join(STATES)}, or a sensor or image as {', '.join(SENSORS)}"
            )
        message = AnyMessage()
        try:
            fill(message, self.simulation, row)
        except ImportError:
            return fill  # the node says which package is missing
        except (ValueError, KeyError) as error:
            raise InputError(f"{row.topic}: {error}") from None
        return fill

    def _check_command(self, row: Row) -> None:
        if row.part == "action" and len(self.command) > 1:
            raise InputError(f"{row.topic}: an action is that of all robots: one row alone")
        self._size(row)

    def _size(self, row: Row) -> int:
        if row.part == "action":
            return int(self.simulation.compiled.action_size)
        try:
            return int(self.simulation.command_size(row.robot))
        except ValueError as error:
            raise InputError(f"{row.topic}: {error}") from None

    def _largest_thrust(self, robot: str) -> float:
        """Nominal largest thrust of all rotors of a robot [N]."""
        compiled = self.simulation.compiled
        name = robot or compiled.robots[0]
        rotors = [rotor for rotor in compiled.rotors if rotor.name.startswith(f"{name}.")]
        speeds = [
            compiled.param_info(f"robots.{name}.rotors[{k}].max_speed")[0]
            for k in range(len(rotors))
        ]
        return float(sum(r.thrust_constant * w**2 for r, w in zip(rotors, speeds, strict=True)))


def expanded(row: Row, robots: list[str]) -> list[Row]:
    """The row, or one for each robot if the topic contains `{robot}`."""
    if "{robot}" not in row.topic:
        return [row]
    return [
        dataclasses.replace(
            row,
            topic=row.topic.replace("{robot}", robot),
            robot=robot,
            body=row.body.replace("{robot}", robot),
            part=row.part.replace("{robot}", robot),
        )
        for robot in robots
    ]


def default_frame(row: Row) -> str:
    """The frame of a row: of the table, or the sensor's name."""
    if row.part in STATES:
        return STATES[row.part].frame
    return row.part.split(".")[0]
