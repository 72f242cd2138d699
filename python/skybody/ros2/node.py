"""The node of ROS 2 around a bridge. Needs rclpy, of the user's own ROS."""

from __future__ import annotations

import importlib
from typing import Any

from skybody import InputError

from .bridge import Bridge
from .bridge_map import BridgeMap
from .states import set_stamp

REMEDY = "source the setup of a ROS 2 workspace that has it"
DEPTH = 10  # of queues


def message_class(name: str) -> Any:
    """The class of `package/msg/Type`.

    Raises:
        InputError: it is not installed.
    """
    package, _, kind = name.partition("/msg/")
    try:
        return getattr(importlib.import_module(f"{package}.msg"), kind)
    except (ImportError, AttributeError):
        raise InputError(f"there is no message {name} here: {REMEDY}") from None


def service_class(name: str) -> Any:
    """The class of a service of std_srvs."""
    try:
        return getattr(importlib.import_module("std_srvs.srv"), name)
    except (ImportError, AttributeError):
        raise InputError(f"there is no service std_srvs/srv/{name} here: {REMEDY}") from None


def load_rclpy() -> Any:
    """rclpy.

    Raises:
        InputError: there is none.
    """
    try:
        return importlib.import_module("rclpy")
    except ImportError as error:
        raise InputError(f"there is no rclpy ({error}): {REMEDY}") from None


class Node:
    """Topics, services and parameters of a bridge.

    In lockstep each complete set of commands makes one step, and its states follow. With a factor
    the simulation runs at that multiple of the clock on the wall, under the last commands.
    """

    def __init__(self, bridge: Bridge, table: BridgeMap, name: str, factor: float | None) -> None:
        """Makes publishers, subscriptions, services; publishes the first states.

        Args:
            factor: of simulated time over the clock on the wall; None: lockstep.

        Raises:
            InputError: a message is not installed.
        """
        rclpy = load_rclpy()
        self.bridge, self.is_paused = bridge, False
        self.node = rclpy.create_node(name, allow_undeclared_parameters=True)
        self._saved: Any = None
        self._last: dict[int, Any] = {}
        self._classes = [message_class(row.type) for row in bridge.publish]
        self._publishers = [
            self.node.create_publisher(kind, row.topic, DEPTH)
            for kind, row in zip(self._classes, bridge.publish, strict=True)
        ]
        self._clock = None
        if table.clock:
            self._clock_class = message_class("rosgraph_msgs/msg/Clock")
            self._clock = self.node.create_publisher(self._clock_class, "/clock", DEPTH)
        for number, row in enumerate(bridge.command):
            kind = message_class(row.type)
            self.node.create_subscription(kind, row.topic, self._taker(number, factor), DEPTH)
        self._add_services()
        self.node.add_on_set_parameters_callback(self._set_parameters)
        if factor is not None:
            compiled = bridge.simulation.compiled
            period = compiled.dt * compiled.action_repeat / factor
            self.node.create_timer(period, self._tick)
        self.send_states()

    # --- steps ----------------------------------------------------------------------------------

    def _taker(self, number: int, factor: float | None) -> Any:
        def take(message: Any) -> None:
            if problem := self.bridge.take(number, message):
                self.node.get_logger().warning(problem)
                return
            self._last[number] = message
            if factor is None and self.bridge.is_ready and not self.is_paused:
                self.step()

        return take

    def _tick(self) -> None:
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
        if self._clock is not None:
            message = self._clock_class()
            set_stamp(message.clock, now)
            self._clock.publish(message)
        for number in self.bridge.due():
            message = self._classes[number]()
            self.bridge.fill(number, message)
            if hasattr(message, "header"):
                set_stamp(message.header.stamp, now)
            self._publishers[number].publish(message)

    # --- services -------------------------------------------------------------------------------

    def _add_services(self) -> None:
        trigger, set_bool = service_class("Trigger"), service_class("SetBool")
        for name, act in (
            ("reset", self._reset),
            ("step", self._step_once),
            ("save", self._save),
            ("restore", self._restore),
            ("states", self._send),
        ):
            self.node.create_service(trigger, f"~/{name}", answering(act))
        self.node.create_service(set_bool, "~/pause", self._pause)

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

    def _send(self) -> str:
        self.bridge.make_due()
        self.send_states()
        return f"{self.bridge.simulation.time:.6f} s"

    def _save(self) -> str:
        self._saved = self.bridge.simulation.save()
        return "saved"

    def _restore(self) -> str:
        if self._saved is None:
            raise ValueError("nothing was saved")
        self.bridge.simulation.restore(self._saved)
        self.bridge.make_due()
        self.send_states()
        return "restored"

    def _pause(self, request: Any, response: Any) -> Any:
        self.is_paused = bool(request.data)
        response.success, response.message = True, "paused" if self.is_paused else "goes on"
        return response

    def _set_parameters(self, parameters: Any) -> Any:
        """Parameters of the node are randomizable values of the simulation, by their paths."""
        result = importlib.import_module("rcl_interfaces.msg").SetParametersResult(successful=True)
        for parameter in parameters:
            if parameter.name == "use_sim_time":
                continue
            try:
                self.bridge.simulation.set_param(parameter.name, float(parameter.value))
            except (TypeError, ValueError) as error:
                result.successful, result.reason = False, str(error)
        return result


def answering(act: Any) -> Any:
    """A handler of Trigger that calls `act`, whose ValueError is the answer's message."""

    def handle(_: Any, response: Any) -> Any:
        try:
            response.message, response.success = act(), True
        except ValueError as error:
            response.message, response.success = str(error), False
        return response

    return handle
