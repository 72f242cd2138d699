"""Classes of messages and services by name; ROS 1 and ROS 2 have them in the same modules."""

from __future__ import annotations

import importlib
from typing import Any

from skybody import InputError


def message_class(name: str, remedy: str) -> Any:
    """The class of `package/msg/Type`.

    Raises:
        InputError: it is not installed.
    """
    return _class_of(name, "msg", remedy)


def service_class(name: str, remedy: str) -> Any:
    """The class of `package/srv/Type`.

    Raises:
        InputError: it is not installed.
    """
    return _class_of(name, "srv", remedy)


class AnyMessage:
    """A message with any field, for a bridge without ROS."""

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        value = [0.0] * 9 if name.endswith("covariance") else AnyMessage()
        setattr(self, name, value)
        return value


def _class_of(name: str, folder: str, remedy: str) -> Any:
    package, _, kind = name.partition(f"/{folder}/")
    try:
        return getattr(importlib.import_module(f"{package}.{folder}"), kind)
    except (ImportError, AttributeError):
        words = {"msg": "message", "srv": "service"}
        raise InputError(f"there is no {words[folder]} {name} here: {remedy}") from None
