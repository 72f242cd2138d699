"""JSON files of run folders, which may come from untrusted sources."""

from __future__ import annotations

import json
from pathlib import Path
from types import GenericAlias
from typing import Any, get_args, get_origin

from skybody.train.files import read_file

WORDS: dict[object, str] = {
    int: "a whole number",
    float: "a number",
    dict[str, float]: "a map of numbers",
    list[float]: "a list of numbers",
    str: "a text",
    bool: "true or false",
    list[str]: "a list of texts",
    dict[str, str]: "a map of texts",
    dict[str, Any]: "a map",
}


def read_json(path: Path) -> Any:
    """The content of a file. Raises ValueError, without the file's name, if it is not JSON."""
    try:
        return json.loads(read_file(path))
    except RecursionError:
        raise ValueError("nested too deeply") from None


def fits(value: Any, kind: type | GenericAlias) -> bool:
    """Whether a value has a type of WORDS; nothing is converted, but an int is also a float."""
    origin, inner = get_origin(kind), get_args(kind)
    if origin is list:
        return type(value) is list and all(fits(entry, inner[0]) for entry in value)
    if origin is dict:
        return type(value) is dict and all(
            inner[1] is Any or fits(entry, inner[1]) for entry in value.values()
        )
    return type(value) is kind or (kind is float and type(value) is int)


def wrong_kinds(values: dict[str, Any], kinds: dict[str, Any]) -> list[str]:
    """For messages: keys that are missing, or have another type."""
    return [
        f"`{name}` is missing" if name not in values else f"`{name}` is not {WORDS[kind]}"
        for name, kind in kinds.items()
        if name not in values or not fits(values[name], kind)
    ]
