"""Messages to the user about a link, each kind once."""

from __future__ import annotations

import sys
from collections import Counter
from typing import TextIO


class Messages:
    """Counts problems by kind and prints the first one of each."""

    def __init__(self, out: TextIO | None = None) -> None:
        self._out = out
        self.counts: Counter[str] = Counter()

    def say(self, text: str) -> None:
        """Prints a line."""
        print(text, file=self._out or sys.stderr, flush=True)

    def warn(self, kind: str, text: str) -> None:
        """Counts a problem; prints `warning: TEXT` the first time."""
        self.counts[kind] += 1
        if self.counts[kind] == 1:
            self.say(f"warning: {text}")

    def summary(self) -> str:
        """`3 lost, 1 repeated`, or empty."""
        return ", ".join(f"{number} {kind}" for kind, number in sorted(self.counts.items()))
