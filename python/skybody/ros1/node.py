"""The node of ROS 1 around a bridge. Needs rospy, of Debian or of the user's own ROS."""

from __future__ import annotations

import functools
import importlib
from collections.abc import Callable, Iterable
from typing import Any

from skybody import InputError
from skybody.ros.bridge import Bridge
from skybody.ros.bridge_map import BridgeMap
from skybody.ros.messages import message_class, service_class
from skybody.ros.node import CLOCK, DEPTH, answer
from skybody.ros.threaded_node import ThreadedNode

REMEDY = "install its Debian package, or source the setup of a ROS 1 workspace that has it"
TRIGGERED = "std_srvs/srv/TriggerResponse"  # of services without arguments


def load_rospy() -> Any:
    """rospy, with a master that answers.

    Raises:
        InputError: there is no rospy, or no master.
    """
    try:
        rospy, rosgraph = (importlib.import_module(name) for name in ("rospy", "rosgraph"))
    except ImportError as error:
        raise InputError(f"there is no rospy ({error}): {REMEDY}") from None
    if not rosgraph.is_master_online():
        raise InputError(
            f"no ROS master answers at {rosgraph.get_master_uri()}: start `roscore`, or name "
            "another one in ROS_MASTER_URI"
        )
    return rospy


def check_names(name: str, topics: Iterable[str]) -> None:
    """Refuses names that the master would refuse.

    Args:
        name: of the node.
        topics: of the map.

    Raises:
        InputError: one is not a name of ROS 1.
    """
    names = importlib.import_module("rosgraph.names")
    if not names.is_legal_base_name(name):
        raise InputError(f"--name: is `{name}`; allowed: letters, digits and _, a letter first")
    for topic in topics:
        if not names.is_legal_name(topic):
            raise InputError(f"topic: is `{topic}`; allowed: letters, digits, _ and /")


class Node(ThreadedNode):
    """Topics and services of a bridge on rospy, whose callbacks come from many threads."""

    def __init__(self, bridge: Bridge, table: BridgeMap, name: str, factor: float | None) -> None:
        """Makes publishers, subscriptions, services; publishes the first states.

        Args:
            name: of the node.
            factor: of simulated time over the clock on the wall; None: lockstep.

        Raises:
            InputError: a message is not installed, or a name is not one of ROS 1.
        """
        check_names(name, [row.topic for row in (*bridge.publish, *bridge.command)])
        find = functools.partial(message_class, remedy=REMEDY)
        super().__init__(bridge, table, factor, find)
        self._rospy = load_rospy()
        self._rospy.init_node(name, argv=[], disable_signals=True)
        self._publishers = [
            self._rospy.Publisher(row.topic, kind, queue_size=DEPTH)
            for kind, row in zip(self._classes, bridge.publish, strict=True)
        ]
        if table.clock:
            self._clock = self._rospy.Publisher("/clock", find(CLOCK), queue_size=DEPTH)
        for number, row in enumerate(bridge.command):
            take = self.locked(functools.partial(self.take, number))
            self._rospy.Subscriber(
                row.topic, find(row.type), take, queue_size=DEPTH, tcp_nodelay=True
            )
        self._add_services()
        self.locked(self.send_states)()

    def is_over(self) -> bool:
        """Whether the node has been shut down."""
        return bool(self._rospy.is_shutdown())

    def _publish(self, number: int, message: Any) -> None:
        self._publishers[number].publish(message)

    def _publish_clock(self, message: Any) -> None:
        self._clock.publish(message)

    def _warn(self, text: str) -> None:
        self._rospy.logwarn(text)

    def _add_services(self) -> None:
        trigger = service_class("std_srvs/srv/Trigger", REMEDY)
        for name, act in self.acts().items():
            self._serve(name, trigger, answering(act, service_class(TRIGGERED, REMEDY)))
        self._serve("pause", service_class("std_srvs/srv/SetBool", REMEDY), self._pause)
        kind = service_class("dynamic_reconfigure/srv/Reconfigure", REMEDY)
        self._serve("set_parameters", kind, self._set_parameters)

    def _serve(self, name: str, kind: Any, handle: Callable[[Any], Any]) -> None:
        self._rospy.Service(f"~{name}", kind, self.locked(handle))

    def _pause(self, request: Any) -> Any:
        response = service_class("std_srvs/srv/SetBoolResponse", REMEDY)()
        return answer(lambda: self.pause(bool(request.data)), response)

    def _set_parameters(self, request: Any) -> Any:
        """Sets randomizable values by their paths, and answers with those that it has set."""
        response = service_class("dynamic_reconfigure/srv/ReconfigureResponse", REMEDY)()
        for one in request.config.doubles:
            if problem := self.set_parameter(one.name, one.value):
                self._warn(problem)
            else:
                response.config.doubles.append(one)
        return response


def answering(act: Callable[[], str], kind: Any) -> Callable[[Any], Any]:
    """A handler of Trigger that calls `act`."""
    return lambda _: answer(act, kind())
