"""The vehicles that both policies fly, and the terms that are switched one at a time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from research.transfer.raptor_flights import EIGHT, HOVER, Course
from research.transfer.raptor_policies import CLIP

SCENARIO = "vehicles"
START = (
    "{{plugin: start, parameters: {{robot: quad, position_min: [-{0}, -{0}, {1}], "
    "position_max: [{0}, {0}, {2}], yaw_min: -0.7, yaw_max: 0.7, rotor_speed: hover}}}}"
)
AIR = (  # no ground, and no end but that of the measurement
    "contact.ground=false",
    "stepping.horizon=1000000",
    "task={plugin: hover, parameters: {robot: quad, target: [0, 0, 3, 0], tilt_max: 3.14159, "
    "yaw_max: 4, bound: 1000}}",
)
RAPTOR, OURS, OURS_RAPTOR = "RAPTOR", "ours, `scaling`", "ours, `raptor`"
POLICIES = (RAPTOR, OURS, OURS_RAPTOR)


@dataclass(frozen=True)
class Vehicles:
    """A model that starts from many places, or vehicles drawn by a preset of `vehicle`."""

    name: str
    model: str = ""
    preset: str = ""
    flights: int = 100

    def overrides(self, reach: float = 1.0) -> tuple[str, ...]:
        """Of scenario `vehicles`. @param reach of the start along each axis [m]"""
        start = START.format(reach, 3.0 - reach, 3.0 + reach)
        draw = f"{{plugin: vehicle, parameters: {{robot: quad, preset: {self.preset}}}}}, "
        model = f"robots.quad.model=models/{self.model}/{self.model}.urdf"
        chosen = (model,) if self.model else ()
        return (*AIR, *chosen, f"randomization=[{draw if self.preset else ''}{start}]")


def drawn_in_training(preset: str) -> str:
    """The override of scenario `vehicles` that draws 1,000 vehicles by another preset."""
    fleet = f"{{plugin: vehicle, parameters: {{robot: quad, fleet: 1000, preset: {preset}}}}}"
    return f"randomization=[{fleet}, {START.format(1, 2, 4)}]"


DRAWN = Vehicles("1,000 drawn, preset `raptor`", preset="raptor", flights=1000)
WIDE = Vehicles("1,000 drawn, preset `scaling`", preset="scaling", flights=1000)
CRAZYFLIE = Vehicles("crazyflie", model="crazyflie")
HUMMINGBIRD = Vehicles("hummingbird", model="hummingbird")
QDRONE2 = Vehicles("qdrone2", model="qdrone2")
FLEETS = (DRAWN, WIDE, CRAZYFLIE, HUMMINGBIRD, QDRONE2)
COURSES = (HOVER, EIGHT)

INERTIA = {"rotors[*].inertia": 0.0}
AIR_FORCES = {"rotors[*].drag_constant": 0.0, "rotors[*].rolling_moment_constant": 0.0}


@dataclass(frozen=True)
class Variant:
    """A pair of flights in which one term differs."""

    name: str
    changes: Mapping[str, float] = field(default_factory=dict)  # factors of robot `quad`'s values
    period: int = 10  # of actions [ms]
    dt: float = 0.01  # of L2F's steps [s]; at most the period
    clip: tuple[float, float] = CLIP
    as_thrust: bool = False
    reach: float = 1.0  # of the start along each axis [m]


PLAIN = Variant("as they are")
FINE = Variant("steps of L2F of 1 ms", dt=0.001)
NO_INERTIA = Variant("no inertia of the rotors", INERTIA)
NO_DRAG = Variant("no drag of the rotors", AIR_FORCES)
NEITHER = Variant("neither inertia nor drag", {**INERTIA, **AIR_FORCES})
SLOW = Variant("lag of 50 and 100 ms", {"rotors[*].tau_up": 4.0, "rotors[*].tau_down": 4.0})
STRONG = Variant("thrust to weight 2.0", {"rotors[*].max_speed": 1.2547})
STRONG_ONLY = Variant(
    "thrust to weight 2.0, no inertia of the rotors", {**INERTIA, "rotors[*].max_speed": 1.2547}
)
ROTORS = (PLAIN, NO_INERTIA, NO_DRAG, NEITHER)
VARIANTS: tuple[tuple[Vehicles, str, Course, tuple[Variant, ...]], ...] = (
    (
        DRAWN,
        RAPTOR,
        HOVER,
        (
            PLAIN,
            FINE,
            Variant("actions at 50 Hz", period=20),
            Variant("actions at 200 Hz", period=5, dt=0.005),
            Variant("actions are shares of the thrust", as_thrust=True),
            Variant("errors not clipped", clip=(100.0, 100.0)),
            Variant("starts up to 0.5 m off", reach=0.5),
            Variant("lag a quarter", {"rotors[*].tau_up": 0.25, "rotors[*].tau_down": 0.25}),
        ),
    ),
    (WIDE, RAPTOR, EIGHT, ROTORS),
    (WIDE, OURS, EIGHT, ROTORS),
    (CRAZYFLIE, RAPTOR, HOVER, (*ROTORS, SLOW, STRONG, STRONG_ONLY)),
    (CRAZYFLIE, OURS_RAPTOR, EIGHT, ROTORS),
    (HUMMINGBIRD, RAPTOR, EIGHT, ROTORS),
    (QDRONE2, RAPTOR, EIGHT, ROTORS),
)
