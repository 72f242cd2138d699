"""Flights as they were: `Flight` opens a log, `skybody render` makes films of it."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .flight import Flight

__all__ = ["Flight"]


def __getattr__(name: str) -> Any:
    if name in __all__:  # at its first use: environments draw without h5py
        return importlib.import_module(".flight", __name__).Flight
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
