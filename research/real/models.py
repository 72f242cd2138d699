"""Models of the vehicle, flown open loop through windows of recorded flights."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from skybody.identify.rotation import of_vector, product

from research.common.places import ROOT
from research.common.programs import RunError, output_of
from research.peers import environments
from research.peers.environments import Skipped
from research.real import curves
from research.real.recorded_flights import MOTORS, Reals, Recorded
from research.real.windows import HORIZONS, STEP, WARM_UP, Windows, usable

HERE = Path(__file__).resolve().parent
WARM_STEPS = round(WARM_UP / STEP)
MARKS = tuple(round(horizon / STEP) for horizon in HORIZONS)
HEIGHT = 10.0  # of all starts [m]: no model touches its ground


class Model(Protocol):
    """A model of the vehicle."""

    @property
    def title(self) -> str:
        """Its name in tables."""

    @property
    def inputs(self) -> str:
        """The command that it takes, and the way from PWM to it."""

    @property
    def trims(self) -> bool:
        """Whether factors on its rotors are taken from other flights."""

    @property
    def is_damped(self) -> bool:
        """Whether a row with damped differences between commands has a meaning."""

    def takes(self, flight: Recorded) -> bool:
        """Whether the flight has the command."""

    def commands(self, windows: Windows, factors: Reals) -> Reals:
        """Its commands on the grid of windows, (windows, steps, 4).

        Args:
            factors: on the thrust of each rotor, (4,).
        """

    def thrusts(self, flight: Recorded) -> Reals:
        """Thrust over mass of each rotor that follows its command at once [m/s^2], (rows, 4).

        Raises:
            Skipped: the model is not available here.
        """

    def fly(self, starts: Reals, commands: Reals) -> Reals:
        """States at the horizons.

        Args:
            starts: (windows, 13), as Recorded.states.
            commands: of `commands`; the first WARM_STEPS turn the rotors, the body stays.

        Returns:
            (windows, horizons, 13).

        Raises:
            Skipped: the model is not available here.
        """


class Still:
    """No model at all: velocity and body rates stay."""

    title = "constant velocity and rates"
    inputs = "none"
    trims = False
    is_damped = False

    def takes(self, flight: Recorded) -> bool:
        return True

    def commands(self, windows: Windows, factors: Reals) -> Reals:
        return np.zeros((len(windows.starts), 0, 4))

    def thrusts(self, flight: Recorded) -> Reals:
        raise NotImplementedError("it has no rotors")

    def fly(self, starts: Reals, commands: Reals) -> Reals:
        return np.stack([moved(starts, horizon) for horizon in HORIZONS], axis=1)


def moved(states: Reals, seconds: float) -> Reals:
    """States after a time at constant velocity and body rates."""
    later = states.copy()
    later[:, :3] += seconds * states[:, 7:10]
    later[:, 3:7] = product(states[:, 3:7], of_vector(seconds * states[:, 10:]))
    return later


@dataclass(frozen=True)
class Foreign:
    """A model of another simulator, flown by a program in its own environment below .peers."""

    title: str
    inputs: str
    environment: str
    program: str
    dynamics: str = ""  # a model of Crazyflow
    trims: bool = True

    @property
    def takes_angles(self) -> bool:
        """Whether its commands are angles and collective thrust."""
        return self.dynamics.startswith("so_rpy")

    @property
    def is_damped(self) -> bool:
        return not self.takes_angles

    def takes(self, flight: Recorded) -> bool:
        has_voltage = bool(np.isfinite(flight.voltage).all())
        has_angles = flight.setpoint is not None or not self.takes_angles
        return (has_voltage or not self.dynamics) and has_angles

    def commands(self, windows: Windows, factors: Reals) -> Reals:
        flight = windows.flight
        if not self.dynamics:
            return windows.on_grid(np.sqrt(factors) * curves.speed(flight.pwm))
        shares = factors * curves.share(flight.pwm, flight.voltage)
        if not self.takes_angles:
            return windows.on_grid(shares)
        assert flight.setpoint is not None  # takes() says so
        thrust = shares.mean(axis=1, keepdims=True)
        return windows.on_grid(np.concatenate([flight.setpoint[:, :3], thrust], axis=1))

    def thrusts(self, flight: Recorded) -> Reals:
        k = self._constants
        if not self.dynamics:
            return np.asarray(k["thrust_constant"] / k["mass"] * curves.speed(flight.pwm) ** 2)
        shares = curves.share(flight.pwm, flight.voltage)
        return np.asarray(k["factor"] * k["thrust_max"] / k["mass"] * shares)

    def fly(self, starts: Reals, commands: Reals) -> Reals:
        return np.asarray(self._run(starts, commands)["states"])

    @cached_property
    def _constants(self) -> dict[str, Any]:
        """The constants that the program names."""
        return self._run(np.zeros((0, 13)), np.zeros((0, 0, 4)))

    def _run(self, starts: Reals, commands: Reals) -> dict[str, Any]:
        """The output of the program."""
        python = environments.python_of(self.environment)
        given: dict[str, Any] = {
            "start": starts,
            "commands": commands,
            "step": STEP,
            "dynamics": self.dynamics,
        }
        given |= {"warm_up": WARM_STEPS, "marks": np.array(MARKS)}
        variables = {**os.environ, "PYTHONPATH": str(ROOT)}
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            np.savez(folder / "input.npz", **given)
            words = [python, HERE / self.program, folder / "input.npz", folder / "output.npz"]
            try:
                output_of(words, env=variables, cwd=environments.workplace())
            except RunError as error:
                raise Skipped(environments.plain(str(error).splitlines()[-1])) from None
            with np.load(folder / "output.npz") as made:
                return dict(made)


SPEEDS = "rotor speeds by Bitcraze's curve of PWM"
SHARES = "thrust of each rotor: PWM and voltage by the firmware's table, then `pwm2force`"
ANGLES = "angles that the onboard controller asked for, and the same thrust"
FOREIGN = (
    Foreign("RotorPy `crazyflie`", SPEEDS, "rotorpy", "rotorpy_replay.py"),
    *(
        Foreign(
            f"Crazyflow `cf2x_L250`, {dynamics}",
            SHARES if dynamics == "first_principles" else ANGLES,
            "crazyflow",
            "crazyflow_replay.py",
            dynamics,
        )
        for dynamics in ("first_principles", "so_rpy", "so_rpy_rotor_drag")
    ),
)


def predicted(model: Model, all_windows: Sequence[Windows], factors: Sequence[Reals]) -> Reals:
    """States at the horizons from the recorded starts of all windows, (windows, horizons, 13).

    Args:
        factors: on the thrusts of the rotors, for the windows of each flight.
    """
    starts = np.concatenate([windows.states(0.0) for windows in all_windows])
    pairs = zip(all_windows, factors, strict=True)
    commands = np.concatenate([model.commands(windows, four) for windows, four in pairs])
    shift = starts[:, :3] - [0.0, 0.0, HEIGHT]
    starts[:, :3] -= shift
    states = model.fly(starts, commands)
    states[..., :3] += shift[:, None]
    return states


def trim(model: Model, flights: Sequence[Recorded]) -> Reals:
    """Factors by which each rotor has a quarter of the measured specific force on average, (4,).

    Args:
        flights: other flights than those that are judged.
    """
    rows = [usable(flight) for flight in flights]
    measured = [f.specific_force[r, 2] for f, r in zip(flights, rows, strict=True)]
    own = [model.thrusts(f)[r] for f, r in zip(flights, rows, strict=True)]
    quarter = np.concatenate(measured).mean() / len(MOTORS)
    return np.asarray(quarter / np.concatenate(own).mean(axis=0))
