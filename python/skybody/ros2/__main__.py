"""`skybody ros2`: a scenario as a node of ROS 2.

skybody ros2 trajectory_ctbr --map map.yaml             # each command makes one step
skybody ros2 hover --map map.yaml --real-time 1         # as fast as the clock on the wall
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from skybody import Error, Simulation
from skybody.command_line import CommandLine, real, report_error, whole
from skybody.program import INTERRUPTED, run_program

from .bridge import Bridge
from .bridge_map import read_map
from .commands import COMMANDS
from .node import Node, load_rclpy
from .states import SENSORS, STATES


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


def parser() -> argparse.ArgumentParser:
    """Options of the command."""
    made = CommandLine(
        prog="skybody ros2",
        description="Runs a scenario as a node of ROS 2 (docs/ros2.md).",
        epilog=tables(),
    )
    add = made.add_argument
    add("scenario", help="name of a shipped scenario, or a YAML file")
    add("--map", type=Path, required=True, metavar="FILE", help="topics (docs/ros2.md)")
    add("--name", default="skybody", help="of the node; default: skybody")
    add("--seed", type=whole(0, 2**63 - 1), default=0, help="of the episodes; default: 0")
    add("--real-time", type=real(0.01, 100.0), metavar="FACTOR",
        help="run by the clock; default: lockstep")  # fmt: skip
    add("--set", dest="overrides", action="append", default=[], metavar="PATH=VALUE",
        help="as skybody run; repeatable")  # fmt: skip
    return made


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command."""
    options = parser().parse_args(arguments)
    try:
        return spin(options)
    except (Error, ValueError) as error:
        return report_error(str(error))


def spin(options: argparse.Namespace) -> int:
    """Runs the node until Ctrl-C."""
    table = read_map(options.map)
    rclpy = load_rclpy()
    simulation = Simulation(
        options.scenario, table.control, overrides=options.overrides, seed=options.seed
    )
    bridge = Bridge(simulation, table)
    rclpy.init(args=[])
    try:
        node = Node(bridge, table, options.name, options.real_time)
        mode = "in lockstep" if options.real_time is None else f"{options.real_time:g} x real time"
        print(f"node     /{options.name}: {simulation.compiled.name}, {mode}", flush=True)
        rclpy.spin(node.node)
    except KeyboardInterrupt:
        print("interrupted")
        return INTERRUPTED
    except rclpy.executors.ExternalShutdownException:
        pass  # a signal other than Ctrl-C has ended it
    finally:
        rclpy.try_shutdown()
    return 0


if __name__ == "__main__":
    run_program(main)
