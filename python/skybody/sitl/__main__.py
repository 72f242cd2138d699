"""`skybody sitl`: an autopilot flies a robot of a scenario, in lockstep, on this machine alone.

skybody sitl ardupilot hover --frame x-reversed     # then: arducopter --model JSON:127.0.0.1
skybody sitl px4 hover_crazyflie                    # then: PX4 with PX4_SIM_MODEL=none_iris
skybody sitl betaflight hover_crazyflie --pilot hold --program obj/betaflight_4.6.0_SITL
skybody sitl betaflight racing --pilot policy --program obj/betaflight_4.6.0_SITL
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Sequence
from pathlib import Path

from skybody import Error
from skybody.command_line import CommandLine, real, report_error, whole
from skybody.program import module_command, run_program

from . import ardupilot_link, px4_link
from .ardupilot_link import ArdupilotLink
from .betaflight_link import BetaflightLink, Pilot
from .betaflight_pilot import HoldPilot
from .betaflight_policy import SHIPPED, PolicyPilot
from .betaflight_program import BetaflightProgram, enter_own_network, settings_for
from .frames import HOME, Home
from .messages import Messages
from .motors import FRAMES
from .px4_link import Px4Link
from .vehicle import Setup, Vehicle

FOREVER = math.inf


def parser() -> argparse.ArgumentParser:
    """Options of the command."""
    made = CommandLine(
        prog="skybody sitl",
        description="Flies a robot of a scenario with an autopilot, in lockstep: docs/sitl.md.",
        epilog=(__doc__ or "").partition("\n\n")[2],
    )
    add = made.add_argument
    add("autopilot", choices=list(FRAMES), metavar="AUTOPILOT", help=" or ".join(FRAMES))
    add("scenario", metavar="SCENARIO", help="YAML file, or name of a shipped scenario")
    add("--robot", default="", help="robot to fly; may be left out if there is one")
    add("--frame", default="", help="frame type; default: by the places of the rotors")
    add("--start", choices=("ground", "air"),
        help="at rest on the ground below the start (default), or as the scenario begins "
        "(default of --pilot policy)")  # fmt: skip
    add("--home", type=home, default=HOME, metavar="LAT,LON,ALT",
        help="place of the world's origin [deg, deg, m]")  # fmt: skip
    add("--port", type=whole(0, 65535), help="default: 9002 of ardupilot, 4560 of px4; 0: any")
    add("--seconds", type=real(0, 1e9), default=FOREVER, help="simulated time; default: Ctrl-C")
    add("--seed", type=whole(0, 2**63 - 1), default=0, help="of the episode; default: 0")
    add("--set", dest="overrides", action="append", default=[], metavar="PATH=VALUE",
        help="as skybody run; repeatable")  # fmt: skip
    only = made.add_argument_group("betaflight")
    only.add_argument("--program", type=Path, help="Betaflight's SITL, to be started here")
    only.add_argument("--pilot", choices=("none", "hold", "policy"), default="none",
        help="hold: arms, takes off, holds --height by the throttle stick; policy: flies the "
        "scenario's task by --policy, from the air")  # fmt: skip
    only.add_argument("--policy", default=SHIPPED, metavar="POLICY",
        help="of rates and thrust: shipped (default), policy.h5, or training run")  # fmt: skip
    only.add_argument("--factor", type=real(0.01, 4), default=0.5,
        help="simulated time over that on the wall; default: 0.5")  # fmt: skip
    only.add_argument("--cli", action="append", default=[], metavar="LINE",
        help="line for Betaflight's console before the flight; repeatable")  # fmt: skip
    only.add_argument("--shared-network", action="store_true",
        help="do not start Betaflight in a network of its own")  # fmt: skip
    only.add_argument("--height", type=real(0.1, 100), default=1.0, help="[m]; default: 1")
    return made


def home(text: str) -> Home:
    """An argparse type: LAT,LON,ALT."""
    limits = ((-89.9, 89.9), (-180.0, 180.0), (-500.0, 10_000.0))
    words = text.split(",")
    if len(words) != 3:
        raise argparse.ArgumentTypeError(f"`{text}` has {len(words)} parts; allowed: LAT,LON,ALT")
    return Home(*(real(*limit)(word) for word, limit in zip(words, limits, strict=True)))


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command."""
    made = parser()
    options = made.parse_args(arguments)
    frames = FRAMES[options.autopilot]
    by_policy = options.autopilot == "betaflight" and options.pilot == "policy"
    options.start = options.start or ("air" if by_policy else "ground")
    if by_policy and options.start == "ground":
        made.error("--start ground: --pilot policy begins in the air, as the scenario does")
    if options.frame and options.frame not in frames:
        made.error(f"--frame: no frame `{options.frame}`; allowed: {', '.join(frames)}")
    try:
        if options.program is not None and not options.shared_network:
            words = sys.argv[1:] if arguments is None else arguments
            enter_own_network(module_command("skybody.sitl", *words))
        return fly(options)
    except (Error, ValueError, OSError) as error:
        return report_error(str(error))


def fly(options: argparse.Namespace) -> int:
    """Serves the autopilot; at the end prints the time and a hash of all states."""
    setup = Setup(
        scenario=options.scenario,
        robot=options.robot,
        frame=options.frame,
        overrides=tuple(options.overrides),
        seed=options.seed,
        on_ground=options.start == "ground",
        home=options.home,
    )
    vehicle = Vehicle(options.autopilot, setup)
    messages = Messages(sys.stdout)
    messages.say(f"robot    {vehicle.robot} of {vehicle.compiled.name}, {vehicle.motors} motors")
    messages.say(f"frame    {vehicle.frame}; set in the autopilot: {vehicle.settings}")
    if vehicle.added:
        messages.say(f"sensors  added without noise: {', '.join(vehicle.added)}")
    try:
        SERVERS[options.autopilot](vehicle, messages, options)
    finally:
        problems = messages.summary()
        messages.say(f"time     {vehicle.time:.3f} s{f' ({problems})' if problems else ''}")
        messages.say(f"hash     {vehicle.hash()}")
    return 0


def serve_ardupilot(vehicle: Vehicle, messages: Messages, options: argparse.Namespace) -> None:
    """Flies with ArduPilot."""
    port = ardupilot_link.PORT if options.port is None else options.port
    ArdupilotLink(vehicle, messages).serve(port, options.seconds)


def serve_px4(vehicle: Vehicle, messages: Messages, options: argparse.Namespace) -> None:
    """Flies with PX4."""
    port = px4_link.PORT if options.port is None else options.port
    Px4Link(vehicle, messages).serve(port, options.seconds)


def serve_betaflight(vehicle: Vehicle, messages: Messages, options: argparse.Namespace) -> None:
    """Flies with Betaflight."""
    pilot, lines = pilot_of(vehicle, options)
    link = BetaflightLink(vehicle, pilot, options.factor, messages)
    if options.program is None:
        link.serve(options.seconds, None)
    else:
        settings = [*settings_for(vehicle.frame), *lines, *options.cli]
        with BetaflightProgram(options.program, settings) as program:
            link.serve(options.seconds, program)
    if isinstance(pilot, PolicyPilot):
        say_infos(vehicle, messages)


def say_infos(vehicle: Vehicle, messages: Messages) -> None:
    """Prints the info values of the task after the last step."""
    for channel in vehicle.compiled.info_channels:
        values = vehicle.simulation.info[channel.first : channel.first + channel.count]
        messages.say(f"info     {channel.name} {' '.join(f'{value:g}' for value in values)}")


def pilot_of(vehicle: Vehicle, options: argparse.Namespace) -> tuple[Pilot | None, list[str]]:
    """The pilot, and lines of Betaflight's console that it needs."""
    if options.pilot == "hold":
        return HoldPilot(vehicle, options.height), []
    if options.pilot == "policy":
        pilot = PolicyPilot(vehicle, options.policy)
        return pilot, pilot.settings()
    return None, []


SERVERS = {"ardupilot": serve_ardupilot, "px4": serve_px4, "betaflight": serve_betaflight}

if __name__ == "__main__":
    run_program(main)
