"""evaluation.json of a checkpoint, as written by evaluate.py."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from skybody.train.json_file import read_json

Check = Callable[[Any], bool]


def _is_number(value: Any) -> bool:
    """Whether it is a finite number, and not a bool."""
    return type(value) in (int, float) and abs(value) <= sys.float_info.max


def _is_number_or_null(value: Any) -> bool:
    return value is None or _is_number(value)


def _is_count(value: Any) -> bool:
    return type(value) is int and 0 <= value < 2**63


def _is_text(value: Any) -> bool:
    return isinstance(value, str)


def _is_flag(value: Any) -> bool:
    return isinstance(value, bool)


COLUMNS: dict[str, Check] = {  # of evaluation.csv
    "steps": _is_count,
    "wall_clock": _is_number,
    "episodes": _is_count,
    "return_mean": _is_number,
    "return_std": _is_number,
    "return_cv": _is_number_or_null,
    "position_error_median": _is_number_or_null,
    "position_error_mean": _is_number_or_null,
    "position_error_p95": _is_number_or_null,
    "length_mean": _is_number,
    "success_share": _is_number,
    "reached_share": _is_number_or_null,
    "parameter_hash": _is_text,
}
_LISTS: dict[str, Check] = {  # one value per episode
    "returns": _is_number,
    "position_errors": _is_number_or_null,
    "failed": _is_flag,
}


def read_evaluation(checkpoint: Path) -> dict[str, Any] | None:
    """The evaluation of a checkpoint; None if there is none, or if it is damaged."""
    try:
        found = read_json(checkpoint / "evaluation.json")
    except (FileNotFoundError, ValueError):
        return None
    return found if isinstance(found, dict) and _is_whole(found) else None


def _is_whole(found: dict[str, Any]) -> bool:
    """Whether it has all fields that are read, each of the right type."""
    for name, check in COLUMNS.items():
        if name not in found or not check(found[name]):
            return False
    for name, check in _LISTS.items():
        values = found.get(name)
        if not isinstance(values, list) or len(values) != found["episodes"]:
            return False
        if not all(map(check, values)):
            return False
    return True
