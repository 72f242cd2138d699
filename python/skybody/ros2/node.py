"""The node of ROS 2 around a bridge. Needs rclpy, of the user's own ROS."""

from __future__ import annotations

import contextlib
import functools
import importlib
from collections.abc import Iterator
from typing import Any

from skybody import InputError
from skybody.ros import node
from skybody.ros.bridge import Bridge
from skybody.ros.bridge_map import BridgeMap
from skybody.ros.messages import message_class, service_class
from skybody.ros.node import CLOCK, DEPTH, answer

WAKE = 0.5  # s, period of the timer that wakes `spin` to check for a shutdown
REMEDY = "source the setup of a ROS 2 workspace that has it"


def load_rclpy() -> Any:
    """rclpy.

    Raises:
        InputError: there is none.
    """
    try:
        return importlib.import_module("rclpy")
    except ImportError as error:
        raise InputError(f"there is no rclpy ({error}): {REMEDY}") from None


@contextlib.contextmanager
def until_shutdown() -> Iterator[None]:
    """Ends its block without an error if a signal other than Ctrl-C has shut rclpy down."""
    try:
        yield
    except Exception:
        if load_rclpy().ok():
            raise


class Node(node.Node):
    """Topics, services and parameters of a bridge on rclpy."""

    def __init__(self, bridge: Bridge, table: BridgeMap, name: str, factor: float | None) -> None:
        """Makes publishers, subscriptions, services; publishes the first states.

        Args:
            name: of the node.
            factor: of simulated time over the clock on the wall; None: lockstep.

        Raises:
            InputError: a message is not installed.
        """
        find = functools.partial(message_class, remedy=REMEDY)
        super().__init__(bridge, table, factor, find)
        self.node = load_rclpy().create_node(name, allow_undeclared_parameters=True)
        self._publishers = [
            self.node.create_publisher(kind, row.topic, DEPTH)
            for kind, row in zip(self._classes, bridge.publish, strict=True)
        ]
        if table.clock:
            self._clock = self.node.create_publisher(find(CLOCK), "/clock", DEPTH)
        for number, row in enumerate(bridge.command):
            take = functools.partial(self.take, number)
            self.node.create_subscription(find(row.type), row.topic, take, DEPTH)
        self._add_services()
        self.node.add_on_set_parameters_callback(self._set_parameters)
        if factor is not None:
            self.node.create_timer(self.period, self.tick)
        self.send_states()

    def spin(self) -> None:
        """Runs callbacks until rclpy is shut down."""
        rclpy = load_rclpy()
        # rclpy's handler of SIGTERM wakes `spin` and then ends the context. If `spin` looks between
        # the two, it waits again, and nothing but a timer wakes it. The node's own clock may be
        # `/clock`, which stands still in lockstep.
        steady = rclpy.clock.Clock(clock_type=rclpy.clock.ClockType.STEADY_TIME)
        self.node.create_timer(WAKE, lambda: None, clock=steady)
        rclpy.spin(self.node)

    def _publish(self, number: int, message: Any) -> None:
        self._publishers[number].publish(message)

    def _publish_clock(self, message: Any) -> None:
        self._clock.publish(message)

    def _warn(self, text: str) -> None:
        self.node.get_logger().warning(text)

    def _add_services(self) -> None:
        trigger = service_class("std_srvs/srv/Trigger", REMEDY)
        for name, act in self.acts().items():
            self.node.create_service(trigger, f"~/{name}", answering(act))
        set_bool = service_class("std_srvs/srv/SetBool", REMEDY)
        self.node.create_service(set_bool, "~/pause", self._pause)

    def _pause(self, request: Any, response: Any) -> Any:
        return answer(lambda: self.pause(bool(request.data)), response)

    def _set_parameters(self, parameters: Any) -> Any:
        """Parameters of the node are randomizable values of the simulation, by their paths."""
        result = importlib.import_module("rcl_interfaces.msg").SetParametersResult(successful=True)
        for parameter in parameters:
            if parameter.name == "use_sim_time":
                continue
            if problem := self.set_parameter(parameter.name, parameter.value):
                result.successful, result.reason = False, problem
        return result


def answering(act: Any) -> Any:
    """A handler of Trigger that calls `act`."""
    return lambda _, response: answer(act, response)
