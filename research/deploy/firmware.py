"""Options of the measurements that run Betaflight's program."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from skybody.sitl.betaflight_program import enter_own_network

from research.common.options import Options


def firmware_options(doc: str | None, name: str) -> argparse.Namespace:
    """The values, with `firmware` and `factor`; goes on in a network of its own.

    Args:
        doc, name: the measurement's docstring and module name, as of Options.
    """
    parser = Options(doc, name)
    parser.add("--firmware", type=Path, required=True, help="of scripts/build_betaflight.sh")
    parser.add("--factor", type=float, default=0.5, help="times real time; default: 0.5")
    options = parser.given()
    enter_own_network([sys.executable, "-m", "research", "run", parser.name, *sys.argv[1:]])
    return options
