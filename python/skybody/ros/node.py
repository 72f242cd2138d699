"""A node around a bridge, without middleware: steps, states, and the acts of its services."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any

from .bridge import Bridge
from .bridge_map import BridgeMap
from .states import set_stamp

CLOCK = "rosgraph_msgs/msg/Clock"
DEPTH = 10  # of queues


class Node(ABC):
    """Steps of a bridge by its commands; a front end sends its messages.

    In lockstep each complete set of commands makes one step, and its states follow. With a factor
    the simulation runs at that multiple of the clock on the wall, under the last commands.
    """

    def __init__(
        self, bridge: Bridge, table: BridgeMap, factor: float | None, find: Callable[[str], Any]
    ) -> None:
        """Finds the classes of all messages.

        Args:
            factor: of simulated time over the clock on the wall; None: lockstep.
            find: class of a message by its name.

        Raises:
            InputError: a message is not installed.
        """
        self.bridge, self.factor, self.is_paused = bridge, factor, False
        self._saved: Any = None
        self._last: dict[int, Any] = {}
        self._classes = [find(row.type) for row in bridge.publish]
        self._clock_class = find(CLOCK) if table.clock else None

    # --- of a front end -------------------------------------------------------------------------

    @abstractmethod
    def _publish(self, number: int, message: Any) -> None:
        """Sends the message of a row."""

    @abstractmethod
    def _publish_clock(self, message: Any) -> None:
        """Sends the clock."""

    @abstractmethod
    def _warn(self, text: str) -> None:
        """Tells why a command is refused."""

    # --- steps ----------------------------------------------------------------------------------

    @property
    def period(self) -> float:
        """Time on the wall between two steps in real time [s]; 0 in lockstep."""
        compiled = self.bridge.simulation.compiled
        step = compiled.dt * compiled.action_repeat
        return 0.0 if self.factor is None else float(step / self.factor)

    def take(self, number: int, message: Any) -> None:
        """A command has come; in lockstep the last one of a set makes a step."""
        if problem := self.bridge.take(number, message):
            self._warn(problem)
            return
        self._last[number] = message
        if self.factor is None and self.bridge.is_ready and not self.is_paused:
            self.step()

    def tick(self) -> None:
        """A step in real time, under the last commands; before the first ones nothing moves."""
        if self.is_paused or len(self._last) < len(self.bridge.command):
            self.send_states()
            return
        for number, message in self._last.items():
            self.bridge.take(number, message)
        self.step()

    def step(self) -> None:
        """One step, and its states."""
        self.bridge.advance()
        self.send_states()

    def send_states(self) -> None:
        """Publishes the clock and all messages that are due."""
        now = self.bridge.simulation.time
        if self._clock_class is not None:
            message = self._clock_class()
            set_stamp(message.clock, now)
            self._publish_clock(message)
        for number in self.bridge.due():
            message = self._classes[number]()
            self.bridge.fill(number, message)
            if hasattr(message, "header"):
                set_stamp(message.header.stamp, now)
            self._publish(number, message)

    # --- services -------------------------------------------------------------------------------

    def acts(self) -> dict[str, Callable[[], str]]:
        """Services without arguments: each returns its answer, or raises ValueError."""
        return {
            "reset": self._reset,
            "step": self._step_once,
            "save": self._save,
            "restore": self._restore,
            "states": self._send_again,
        }

    def pause(self, wanted: bool) -> str:
        """Stops or goes on."""
        self.is_paused = wanted
        return "paused" if wanted else "goes on"

    def set_parameter(self, name: str, value: Any) -> str:
        """Sets a randomizable value by its path; returns why not, or nothing."""
        try:
            self.bridge.simulation.set_param(name, float(value))
        except (TypeError, ValueError) as error:
            return str(error)
        return ""

    def _reset(self) -> str:
        self.bridge.reset()
        self._last = {}
        self.send_states()
        return f"episode {self.bridge.simulation.episode}"

    def _step_once(self) -> str:
        if not self.bridge.is_ready:
            raise ValueError("there is no command for each row yet")
        self.step()
        return f"{self.bridge.simulation.time:.6f} s"

    def _send_again(self) -> str:
        self.bridge.make_due()
        self.send_states()
        return f"{self.bridge.simulation.time:.6f} s"

    def _save(self) -> str:
        self._saved = self.bridge.simulation.save()
        return "saved"

    def _restore(self) -> str:
        if self._saved is None:
            raise ValueError("nothing was saved")
        self.bridge.restore(self._saved)
        self._last = {}
        self.send_states()
        return "restored"


def answer(act: Callable[[], str], response: Any) -> Any:
    """Fills the response of a Trigger; a ValueError of the act is the message of its failure."""
    try:
        response.message, response.success = act(), True
    except ValueError as error:
        response.message, response.success = str(error), False
    return response
