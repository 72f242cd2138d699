"""Command lines of Skybody's Python programs; errors have the form of those of `skybody run`."""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Callable
from typing import Any, NoReturn

from .arguments import allowed_words

INVALID = 2  # exit code of invalid input


class CommandLine(argparse.ArgumentParser):
    """An argument parser whose errors are one line: `error: --x: PROBLEM; see ... --help`."""

    def __init__(self, **arguments: Any) -> None:
        kept: dict[str, Any] = {"formatter_class": argparse.RawDescriptionHelpFormatter}
        super().__init__(**(kept | arguments))

    def error(self, message: str) -> NoReturn:
        """Prints the message and exits with 2."""
        raise SystemExit(report_error(f"{self._in_our_words(message)}; see `{self.prog} --help`"))

    def _in_our_words(self, message: str) -> str:
        message = message.removeprefix("argument ")
        if missing := re.fullmatch("the following arguments are required: (.*)", message):
            return f"{missing[1]} is missing"
        if extra := re.fullmatch(r"unrecognized arguments: (\S+).*", message, re.DOTALL):
            if not extra[1].startswith("-"):
                return f"unexpected argument `{extra[1]}`"
            word = extra[1].partition("=")[0]
            return f"unknown option `{word}`{allowed_words(word, [*self._option_string_actions])}"
        return message.replace("expected one argument", "is given without its value")


def report_error(text: str) -> int:
    """Prints an error and returns the exit code; a text with file and line has the word already."""
    print(text if re.search("(^|: )error: ", text) else f"error: {text}", file=sys.stderr)
    return INVALID


def whole(low: int, high: int) -> Callable[[str], int]:
    """An argparse type: a whole number in low..high, also as 2e6."""

    def read(text: str) -> int:
        try:
            value = parse_whole(text)
        except ValueError:
            raise argparse.ArgumentTypeError(
                f"`{text}` is not a whole number; allowed: {low}..{high}"
            ) from None
        if problem := range_problem(value, low, high):
            raise argparse.ArgumentTypeError(problem)
        return value

    return read


def range_problem(value: int, low: int, high: int) -> str:
    """Text about a number out of range; empty if it is in the range."""
    return "" if low <= value <= high else f"{value} is out of range; allowed: {low}..{high}"


def real(low: float, high: float) -> Callable[[str], float]:
    """An argparse type: a finite number in low..high."""

    def read(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            raise argparse.ArgumentTypeError(
                f"`{text}` is not a number; allowed: {low:g}..{high:g}"
            ) from None
        if not low <= value <= high:  # also for NaN
            raise argparse.ArgumentTypeError(f"{text} is out of range; allowed: {low:g}..{high:g}")
        return value

    return read


def parse_whole(text: str) -> int:
    """A whole number, also as 2e6. Raises ValueError for other texts."""
    try:
        return int(text)
    except ValueError:
        value = float(text)
        if not value.is_integer():  # also for infinities and NaN
            raise ValueError(f"{text} is not a whole number") from None
        return int(value)
