"""Pieces of C: numbers, tables, comments."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

WIDTH = 100  # columns of a line


def number(value: float | np.floating[Any]) -> str:
    """A float's literal, which reads back as the same bits."""
    text = f"{np.float32(value):.9g}"
    return f"{text}f" if "." in text or "e" in text else f"{text}.0f"


def table(name: str, values: ArrayLike) -> str:
    """A constant array of floats."""
    floats = np.asarray(values, np.float32).ravel()
    body = ", ".join(number(value) for value in floats)
    lines = textwrap.wrap(body, WIDTH - 4, initial_indent="    ", subsequent_indent="    ")
    return f"static const float {name}[{len(floats)}] = {{\n" + "\n".join(lines) + "};\n"


def comment(text: str, indent: str = "") -> str:
    """A comment of one line or several."""
    text = text.replace("*/", "* /")
    lines = textwrap.wrap(f"/* {text} */", WIDTH - len(indent))
    return "\n".join(indent + ("   " if k else "") + line for k, line in enumerate(lines))


def arguments(words: Iterable[str]) -> str:
    """Words of a call, which may go over several lines."""
    lines = textwrap.wrap(", ".join(words), WIDTH - 10)
    return ("\n" + " " * 6).join(lines)
