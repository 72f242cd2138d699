"""A simulation that runs in real time behind a page, and can be changed while it flies."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skybody import CompiledScenario, Error, FlightPolicy, Simulation

from .sampler import Sampler

RATE = 30.0  # states per second that a page receives
LONGEST_TURN = 0.2  # of simulated time between two states, at speed 1 [s]
SPEEDS = (0.01, 20.0)  # of simulated time over that on the wall
STIFFNESS = 2.0  # of a pull: weights of the robot per metre
STRONGEST = 2.0  # pull: weights of the robot
PAUSE_AT_END = 1.0  # on the wall [s], before the next episode begins
MOST_STEPS = 10_000  # of one request
LEAST_SPAN = 1e-3  # of a slider, in its unit


@dataclass
class Control:
    """The things that a page may change at any time; guarded by Live's lock."""

    paused: bool = False
    speed: float = 1.0
    steps: int = 0  # to be made while it is paused
    reset: bool = False
    params: dict[str, float] = field(default_factory=dict)  # waiting to be set


class Live:
    """A simulation on a thread of its own.

    start(), close(), states() and change() may be called from any thread. The simulation, the
    policy and the sampler belong to the caller until start(), then to the thread alone; `_changed`
    guards the control and the state that is published.
    """

    def __init__(self, compiled: CompiledScenario, policy: str, seed: int) -> None:
        """Begins the first episode.

        Raises:
            Error: the policy cannot be read or does not fit the scenario.
        """
        self.compiled = compiled
        self._simulation = Simulation(compiled, seed=seed)
        self._policy = FlightPolicy(compiled, policy, seed)
        self._simulation.reset()
        self.sampler = Sampler(self._simulation)
        self._weights = {robot: weight_of(compiled, robot) for robot in self.sampler.bases}
        self._control = Control()
        self._text = self._policy.warning
        self._number, self._state = 0, self._state_now()
        self._changed = threading.Condition()
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def start(self) -> None:
        """Lets time run."""
        self._thread.start()

    def close(self) -> None:
        """Ends the thread, and all states()."""
        self._closed.set()
        self._thread.join()

    def states(self) -> Iterator[dict[str, Any]]:
        """The present state and all later ones, at most RATE a second."""
        seen = -1
        while not self._closed.is_set():
            with self._changed:
                while self._number == seen and not self._closed.is_set():
                    self._changed.wait(0.5)
                seen, state = self._number, self._state
            yield state

    # --- changes --------------------------------------------------------------------------------

    def change(self, wish: dict[str, Any]) -> None:
        """Changes the simulation before its next step.

        Args:
            wish: one of {pause: bool}, {step: steps}, {reset: true}, {speed: factor},
                {param: path, value: number}, {pull: body, along: [x, y, z] in W [m]}.

        Raises:
            ValueError: it is none of these, or out of range.
        """
        kinds = {
            "pause": self._pause,
            "step": self._step,
            "reset": self._reset,
            "speed": self._set_speed,
            "param": self._set_param,
            "pull": self._pull,
        }
        found = [kind for kind in kinds if kind in wish]
        if len(found) != 1:
            raise ValueError(f"a change has one of {', '.join(kinds)}; it has {sorted(wish)}")
        with self._changed:
            kinds[found[0]](wish)

    def _pause(self, wish: dict[str, Any]) -> None:
        self._control.paused = bool(wish["pause"])

    def _step(self, wish: dict[str, Any]) -> None:
        self._control.steps += int(number(wish["step"], 1, MOST_STEPS))

    def _reset(self, wish: dict[str, Any]) -> None:
        self._control.reset = bool(wish["reset"])

    def _set_speed(self, wish: dict[str, Any]) -> None:
        self._control.speed = number(wish["speed"], *SPEEDS)

    def _set_param(self, wish: dict[str, Any]) -> None:
        path = str(wish["param"])
        _, low, high, _ = self.compiled.param_info(path)
        self._control.params[path] = number(wish.get("value"), low, high)

    def _pull(self, wish: dict[str, Any]) -> None:
        body = int(number(wish["pull"], 0, len(self.sampler.body_names) - 1))
        robot = self.sampler.body_names[body].split(".")[0]
        along = [number(part, -1e3, 1e3) for part in wish.get("along", ())]
        if len(along) != 3:
            raise ValueError("`along` has three numbers")
        length = float(np.linalg.norm(along))
        weights = min(STIFFNESS, STRONGEST / max(length, 1e-9))  # per metre
        for k, part in enumerate(along):
            path = f"robots.{robot}.disturbance.force[{k}]"
            nominal = self.compiled.param_info(path)[0]
            self._control.params[path] = nominal + weights * self._weights[robot] * part

    # --- the thread -----------------------------------------------------------------------------

    def _run(self) -> None:
        """Flies until close(); an error stops the flight, and its text reaches the page."""
        try:
            self._fly()
        except (Error, ValueError) as error:
            self._text = f"stopped: {error}"
            self._publish()

    def _fly(self) -> None:
        period = self.compiled.dt * self.compiled.action_repeat
        owed = 0.0  # simulated time that is to be made [s]
        before = time.monotonic()
        while not self._closed.wait(1.0 / RATE):
            control = self._take_changes()
            now = time.monotonic()
            owed += control.speed * (now - before)
            before = now
            if control.paused:
                steps, owed = control.steps, 0.0
            else:
                steps, owed = due_steps(owed, period, control.speed)
            self._advance(steps)
            self._publish()
            if self.sampler.ending() and not control.paused:
                self._closed.wait(PAUSE_AT_END)
                self._begin()
                before, owed = time.monotonic(), 0.0

    def _take_changes(self) -> Control:
        """Applies the waiting reset and parameters; returns the control as it was."""
        with self._changed:
            taken = replace(self._control)
            self._control.steps, self._control.reset, self._control.params = 0, False, {}
        if taken.reset:
            self._begin()
        for path, value in taken.params.items():
            self._simulation.set_param(path, value)
        return taken

    def _begin(self) -> None:
        self._simulation.reset()
        self._text = self._policy.warning

    def _advance(self, steps: int) -> None:
        """Steps until the episode ends."""
        for _ in range(steps):
            if self.sampler.ending():
                break
            self._simulation.step(self._policy.act(self._simulation))
        if ending := self.sampler.ending():
            reason = self._simulation.fault_reason
            self._text = f"{ending}: {reason}" if reason else ending

    def _publish(self) -> None:
        with self._changed:
            self._number, self._state = self._number + 1, self._state_now()
            self._changed.notify_all()

    def _state_now(self) -> dict[str, Any]:
        """The present row as a page takes it."""
        row = self.sampler.row()
        return {
            "time": round(row.time, 6),
            "episode": self._simulation.episode,
            "paused": self._control.paused,
            "text": self._text,
            "poses": listed(row.poses),
            "rotors": listed(row.rotor_speed),
            "goals": listed(row.goals),
            "values": listed(row.values),
            "touching": row.touching,
        }


def due_steps(owed: float, period: float, speed: float) -> tuple[int, float]:
    """Steps to make now, and the time that is then still owed [s].

    A machine that is too slow for the speed makes the steps of LONGEST_TURN; the rest is dropped,
    so that the flight does not race when the machine has time again.

    Args:
        owed: simulated time that is to be made [s].
        period: of a step [s].
        speed: of simulated time over that on the wall.
    """
    steps, most = int(owed / period), max(1, round(speed * LONGEST_TURN / period))
    return (most, 0.0) if steps > most else (steps, owed - steps * period)


def number(value: object, low: float, high: float) -> float:
    """A finite number within bounds.

    Raises:
        ValueError: it is not.
    """
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    found = float(value) if is_number else math.nan  # type: ignore[arg-type]
    if math.isfinite(found) and low <= found <= high:
        return found
    raise ValueError(f"{value!r} is no number in {low:g}..{high:g}")


def listed(values: NDArray[np.float64]) -> list[float | None]:
    """Numbers for JSON; None for those that are not finite."""
    return [round(v, 6) if np.isfinite(v) else None for v in values.ravel().tolist()]


def weight_of(compiled: CompiledScenario, robot: str) -> float:
    """Nominal weight of a robot on Earth [N]."""
    start = f"robots.{robot}.links."
    masses = [p for p in compiled.param_paths if p.startswith(start) and p.endswith(".mass")]
    return 9.81 * sum(compiled.param_info(path)[0] for path in masses)


# --- sliders ------------------------------------------------------------------------------------

FIRST = (".mass", "gravity[2]", "effects.", "task.")  # parts of the paths that come first
HIDDEN = (".start.", ".disturbance.", "obstacles.", "couplings.")


def sliders_of(live: Live) -> list[dict[str, Any]]:
    """Parameters that a page may change: path, unit, value, and a useful range."""
    compiled = live.compiled
    paths = [p for p in compiled.param_paths if not any(part in p for part in HIDDEN)]
    paths.sort(key=lambda path: next((k for k, part in enumerate(FIRST) if part in path), 9))
    drawn = live.sampler.drawn()
    return [slider(path, drawn[path], *compiled.param_info(path)[1:]) for path in paths]


def slider(path: str, value: float, least: float, most: float, unit: str) -> dict[str, Any]:
    """A slider from a quarter to four times a value, or to a unit about zero, within bounds."""
    reach = max(abs(value), LEAST_SPAN)
    low, high = (value - reach, value + 3.0 * reach) if value > 0.0 else (value - reach, reach)
    if value == 0.0:
        low, high = -1.0, 1.0
    return {
        "path": path,
        "unit": unit,
        "value": value,
        "low": max(low, least),
        "high": min(high, most),
    }
