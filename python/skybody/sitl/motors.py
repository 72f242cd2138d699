"""Orders and spins of the motors of autopilots, and the robot's rotors that they mean."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

LARGEST_ERROR = 25.0  # between a motor's bearing and that of its rotor [deg]
LEAST_LIFT = 0.5  # share of a rotor's thrust that is upwards

REVERSE = "reverse each `direction` in a copy of the model's rotors file"
CCW, CW = 1, -1  # spin, seen from above

Motor = tuple[float, int]  # bearing clockwise from the front [deg], spin

QUAD_X: tuple[Motor, ...] = ((45, CCW), (-135, CCW), (-45, CW), (135, CW))
QUAD_PLUS: tuple[Motor, ...] = ((90, CCW), (-90, CCW), (0, CW), (180, CW))
HEXA_X: tuple[Motor, ...] = ((90, CW), (-90, CCW), (-30, CW), (150, CCW), (30, CCW), (-150, CW))
# ArduPilot's X_REV has another order than its X.
ARDUPILOT_X_REVERSED: tuple[Motor, ...] = ((135, CCW), (45, CW), (-135, CW), (-45, CCW))


def reversed_spins(motors: Sequence[Motor]) -> tuple[Motor, ...]:
    """The same motors, each with the other spin."""
    return tuple((bearing, -spin) for bearing, spin in motors)


@dataclass(frozen=True)
class Frame:
    """A frame type of an autopilot."""

    motors: tuple[Motor, ...]  # in the order of the values in its packets
    settings: str  # of the autopilot for this frame


FRAMES: dict[str, dict[str, Frame]] = {
    "ardupilot": {
        "x": Frame(QUAD_X, "FRAME_CLASS 1, FRAME_TYPE 1"),
        "plus": Frame(QUAD_PLUS, "FRAME_CLASS 1, FRAME_TYPE 0"),
        "hexa-x": Frame(HEXA_X, "FRAME_CLASS 2, FRAME_TYPE 1"),
        "x-reversed": Frame(ARDUPILOT_X_REVERSED, "FRAME_CLASS 1, FRAME_TYPE 18"),
        "plus-reversed": Frame(reversed_spins(QUAD_PLUS), "FRAME_CLASS 1, FRAME_TYPE 6"),
    },
    "px4": {
        "x": Frame(QUAD_X, "CA_ROTORn_KM: 0, 1 positive; 2, 3 negative"),
        "plus": Frame(QUAD_PLUS, "CA_ROTORn_KM: 0, 1 positive; 2, 3 negative"),
        "hexa-x": Frame(HEXA_X, "CA_ROTORn_KM: 1, 3, 4 positive; 0, 2, 5 negative"),
        "x-reversed": Frame(reversed_spins(QUAD_X), "CA_ROTORn_KM: 2, 3 positive; 0, 1 negative"),
        "plus-reversed": Frame(
            reversed_spins(QUAD_PLUS), "CA_ROTORn_KM: 2, 3 positive; 0, 1 negative"
        ),
        "hexa-x-reversed": Frame(
            reversed_spins(HEXA_X), "CA_ROTORn_KM: 0, 2, 5 positive; 1, 3, 4 negative"
        ),
    },
    # The packet's four values are its motors 2, 3, 4 and 1.
    "betaflight": {
        "x": Frame(QUAD_X, "mixer QUADX, yaw_motors_reversed OFF"),
        "plus": Frame(QUAD_PLUS, "mixer QUADP, yaw_motors_reversed OFF"),
        "x-reversed": Frame(reversed_spins(QUAD_X), "mixer QUADX, yaw_motors_reversed ON"),
        "plus-reversed": Frame(reversed_spins(QUAD_PLUS), "mixer QUADP, yaw_motors_reversed ON"),
    },
}


class RotorPlace(Protocol):
    """The part of `skybody._native.Rotor` that counts here."""

    @property
    def position(self) -> list[float]: ...
    @property
    def axis(self) -> list[float]: ...
    @property
    def direction(self) -> float: ...


def bearings(rotors: Sequence[RotorPlace]) -> list[float]:
    """Bearings of hubs about their centre, clockwise from the front [deg]."""
    x0, y0 = (sum(rotor.position[k] for rotor in rotors) / len(rotors) for k in range(2))
    return [
        math.degrees(math.atan2(y0 - rotor.position[1], rotor.position[0] - x0)) for rotor in rotors
    ]


def rotor_order(autopilot: str, frame: str, rotors: Sequence[RotorPlace]) -> list[int]:
    """The robot's rotor of each motor of the autopilot's frame.

    Args:
        autopilot, frame: keys of FRAMES.
        rotors: of one robot, in its rotors file's order.

    Raises:
        ValueError: number, places or spins of the rotors are not the frame's.
    """
    motors = FRAMES[autopilot][frame].motors
    order = order_by_place(motors, rotors)
    if order is None:
        wanted = ", ".join(f"{bearing:.0f}" for bearing, _ in motors)
        found = ", ".join(f"{bearing:.0f}" for bearing in bearings(rotors)) or "none"
        raise ValueError(
            f"frame `{frame}` of {autopilot} has motors at {wanted} deg clockwise from the front, "
            f"the robot has rotors at {found}; allowed: --frame "
            f"{', '.join(fitting_frames(autopilot, rotors)) or 'none fits this robot'}"
        )
    same = same_spins(motors, order, rotors)
    if not all(same):
        raise ValueError(spin_problem(autopilot, frame, rotors, all_of_them=not any(same)))
    return order


def spin_problem(
    autopilot: str, frame: str, rotors: Sequence[RotorPlace], all_of_them: bool
) -> str:
    """The text of the error about spins that differ from the frame's."""
    remedies = [
        f"--frame {name}, and in the autopilot {FRAMES[autopilot][name].settings}"
        for name in fitting_frames(autopilot, rotors)
    ]
    return (
        f"{'all' if all_of_them else 'some'} rotors spin the other way than the motors of frame "
        f"`{frame}` of {autopilot}; remedy: "
        f"{'; or '.join(remedies) or REVERSE}"
    )


def order_by_place(motors: Sequence[Motor], rotors: Sequence[RotorPlace]) -> list[int] | None:
    """The rotor nearest to each motor; None if they do not fit one to one."""
    if len(motors) != len(rotors) or any(rotor.axis[2] < LEAST_LIFT for rotor in rotors):
        return None
    found = bearings(rotors)
    order = []
    for bearing, _ in motors:
        errors = [abs((other - bearing + 180.0) % 360.0 - 180.0) for other in found]
        nearest = min(range(len(errors)), key=errors.__getitem__)
        if errors[nearest] > LARGEST_ERROR:
            return None
        order.append(nearest)
    return order if len(set(order)) == len(order) else None


def same_spins(
    motors: Sequence[Motor], order: Sequence[int], rotors: Sequence[RotorPlace]
) -> list[bool]:
    """Whether each motor's rotor spins as it does."""
    return [
        spin * rotors[index].direction > 0 for (_, spin), index in zip(motors, order, strict=True)
    ]


def fitting_frames(autopilot: str, rotors: Sequence[RotorPlace]) -> list[str]:
    """Frames of the autopilot with the places and spins of the rotors."""
    fitting = []
    for name, frame in FRAMES[autopilot].items():
        order = order_by_place(frame.motors, rotors)
        if order is not None and all(same_spins(frame.motors, order, rotors)):
            fitting.append(name)
    return fitting


def usual_frame(autopilot: str, rotors: Sequence[RotorPlace]) -> str:
    """The frame of the rotors' places with the autopilot's own spins.

    Raises:
        ValueError: none has motors at these places.
    """
    for name, frame in FRAMES[autopilot].items():
        if order_by_place(frame.motors, rotors) is not None:
            return name
    number = len(rotors)
    raise ValueError(
        f"{autopilot} has no frame for a robot with {number} rotor{'' if number == 1 else 's'} at "
        f"these places; allowed: {', '.join(FRAMES[autopilot])} (docs/sitl.md)"
    )
