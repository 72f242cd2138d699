"""`skybody ros1` and `skybody ros2`: options, help and errors that both have."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from skybody import Error, Simulation
from skybody.command_line import CommandLine, real, report_error, whole
from skybody.program import INTERRUPTED

from .bridge import Bridge
from .bridge_map import BridgeMap, read_map
from .commands import COMMANDS
from .states import SENSORS, STATES

Spin = Callable[[Bridge, BridgeMap, argparse.Namespace], None]


def tables() -> str:
    """The parts that a map may name."""
    lines = ["parts of `publish` (from) and their types:"]
    for name, state in STATES.items():
        lines.append(f"  {name:<14}{', '.join(state.types)}: {state.meaning}")
    lines.append(f"  SENSOR, SENSOR.CHANNEL, IMAGE: {', '.join(SENSORS)}")
    lines.append("parts of `command` (to):")
    for name, command in COMMANDS.items():
        lines.append(f"  {name:<14}{command.meaning}: {', '.join(command.readers)}")
    return "\n".join(lines)


def parser(version: int) -> argparse.ArgumentParser:
    """Options of the command for a version of ROS: 1 or 2."""
    made = CommandLine(
        prog=f"skybody ros{version}",
        description=f"Runs a scenario as a node of ROS {version} (docs/ros.md).",
        epilog=tables(),
    )
    add = made.add_argument
    add("scenario", help="name of a shipped scenario, or a YAML file")
    add("--map", type=Path, required=True, metavar="FILE", help="topics (docs/ros.md)")
    add("--name", default="skybody", help="of the node; default: skybody")
    add("--seed", type=whole(0, 2**63 - 1), default=0, help="of the episodes; default: 0")
    add("--real-time", type=real(0.01, 100.0), metavar="FACTOR",
        help="run by the clock; default: lockstep")  # fmt: skip
    add("--set", dest="overrides", action="append", default=[], metavar="PATH=VALUE",
        help="as skybody run; repeatable")  # fmt: skip
    return made


def run(version: int, load: Callable[[], Any], spin: Spin, arguments: Sequence[str] | None) -> int:
    """Runs a node until Ctrl-C.

    Args:
        load: loads the library of ROS, or raises InputError.
        spin: makes the node, and runs it until it is shut down.

    Returns:
        The exit code.
    """
    options = parser(version).parse_args(arguments)
    try:
        table = read_map(options.map)
        load()
        simulation = Simulation(
            options.scenario, table.control, overrides=options.overrides, seed=options.seed
        )
        spin(Bridge(simulation, table), table, options)
    except KeyboardInterrupt:
        print("interrupted")
        return INTERRUPTED
    except (Error, ValueError) as error:
        return report_error(str(error))
    return 0


def say_ready(bridge: Bridge, options: argparse.Namespace) -> None:
    """The line that tells that the node is there."""
    factor = options.real_time
    mode = "in lockstep" if factor is None else f"{factor:g} x real time"
    print(f"node     /{options.name}: {bridge.simulation.compiled.name}, {mode}", flush=True)
