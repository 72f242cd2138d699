"""Duration of a call of model-predictive control, and its flight errors.

    python -m research run nmpc [--quick] [--out DIR]

The time of a call is that of a physics step with one iteration of the controller, minus the median
of the steps without one. Times are processor times of this thread, so that other processes
do not count, except by their effect on caches and clock rates.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import skybody

from research.common.machine import facts, machine_line
from research.common.options import Options
from research.common.pages import head, markdown_table, write_page
from research.common.programs import RunError

PAGE = "nmpc"

PERIOD = 10  # physics steps of 1 ms between two calls: 100 Hz
NODE_STEP = 0.05  # [s]
Path = Callable[[float], np.ndarray]  # time [s] -> the 17 values of a point


def sines(centre: list[float], axes: list[tuple[float, float, float]]) -> Path:
    """A path of sines with amplitude [m], rate [rad/s] and phase of each axis."""
    amplitude, rate, phase = np.array(axes).T

    def point(t: float) -> np.ndarray:
        values = [amplitude * rate**k * np.sin(rate * t + phase + k * np.pi / 2) for k in range(5)]
        values[0] = values[0] + centre
        return np.concatenate([*values, [0.0, 0.0]])

    return point


def hover(place: list[float]) -> Path:
    return lambda t: np.concatenate([place, np.zeros(14)])


# Peak speed 1.5 m/s, as in the paper's training family; and 10.1 m/s.
LISSAJOUS = sines([0, 0, 1.5], [(1.0, 1.0, 0.0), (0.5, 2.0, 0.3), (0.2, 1.5, 0.1)])
EIGHT = sines([0, 0, 5], [(8.0, 0.9, 0.0), (4.0, 1.8, 0.0), (0.0, 1.0, 0.0)])
DRAG = "{plugin: body_drag, parameters: {linear: [0.2, 0.2, 0.2], quadratic: [0.02, 0.02, 0.03]}}"
WIND = (
    f"effects=[{DRAG}, {{plugin: wind, parameters: {{velocity: [5, 0, 0]}}}}, "
    "{plugin: dryden, parameters: {airspeed: 5}}]"
)


# With the noise and biases of world `payload`.
IMU = (
    "sensors=[{plugin: imu, parameters: {robot: quad, link: base_link, accelerometer_noise: 0.002, "
    "gyroscope_noise: 0.000175, accelerometer_bias: 0.05, gyroscope_bias: 0.003}}]"
)


@dataclass
class Flight:
    """One row of the table."""

    name: str
    path: Path
    scenario: str = "hover"
    robot: str = "quad"
    overrides: list[str] = field(default_factory=list)
    teleport: dict[str, Any] = field(default_factory=dict)
    nodes: int = 20
    measured: str = "state"
    heavier: float = 1.0
    weak: float = 1.0  # thrust constant of the first rotor, relative to the nominal one
    every: float = 0.0  # [s] between two cold starts; 0: one start
    settle: float = 2.0  # [s] excluded from errors


UPSIDE_DOWN = {"position": [0.0, 0.0, 5.0], "rotation": [0.0, 1.0, 0.0, 0.0]}
FLIGHTS = [
    Flight("hover", hover([0, 0, 1])),
    Flight("Lissajous, 1.5 m/s", LISSAJOUS),
    Flight("Lissajous, 10 % heavier", LISSAJOUS, heavier=1.1),
    Flight("Lissajous, one rotor at 80 %", LISSAJOUS, weak=0.8),
    Flight("Lissajous, wind 5 m/s and Dryden gusts", LISSAJOUS, overrides=[WIND]),
    Flight("Lissajous, wind and gusts, IMU", LISSAJOUS, overrides=[WIND, IMU], measured="imu"),
    Flight("figure of eight, 10 m/s", EIGHT),
    Flight("figure of eight, 10 m/s, IMU", EIGHT, overrides=[IMU], measured="imu"),
    Flight("figure of eight, wind and gusts", EIGHT, overrides=[WIND]),
    Flight(
        "steps of 3 m",
        hover([2, -2, 2]),
        teleport={"position": [0.0, 0.0, 1.0]},
        every=3.0,
        settle=2.5,
    ),
    Flight("upside-down starts", hover([0, 0, 5]), teleport=UPSIDE_DOWN, every=4.0, settle=3.5),
    Flight("Lissajous, horizon of 10 nodes", LISSAJOUS, nodes=10),
    Flight("figure of eight, 10 m/s, horizon of 10 nodes", EIGHT, nodes=10),
    Flight("Lissajous, horizon of 40 nodes", LISSAJOUS, nodes=40),
    Flight("Lissajous, hummingbird", LISSAJOUS, "hover_hummingbird"),
    Flight("Lissajous, crazyflie (27 g)", LISSAJOUS, "hover_crazyflie"),
    Flight("Lissajous, firefly (six rotors)", LISSAJOUS, "hover_firefly"),
]


def simulation(flight: Flight) -> skybody.Simulation:
    parameters = (
        f"preview: true, horizon: {flight.nodes}, period: {PERIOD}, measured: {flight.measured}"
    )
    guide = f"{{plugin: nmpc, parameters: {{{parameters}}}}}"
    sim = skybody.Simulation(
        flight.scenario,
        control=f"[{guide}, {{plugin: srt}}]",
        overrides=["randomization=[]", "stepping.dt=0.001", *flight.overrides],
    )
    sim.reset()
    return sim


def begin(sim: skybody.Simulation, flight: Flight) -> None:
    start = flight.path(0.0)
    where = {"position": start[:3], "velocity": start[3:6]} | flight.teleport
    sim.teleport(**where)


def fly(flight: Flight, seconds: float) -> dict[str, Any]:
    """Times [us] of steps with and without a call, and errors [m]."""
    sim = simulation(flight)
    disturb(sim, flight)
    begin(sim, flight)
    calls, others, squares = [], [], []
    since = 0.0
    for step in range(round(seconds * 1000)):
        is_call = step % PERIOD == 0
        if flight.every and is_call and since >= flight.every:
            begin(sim, flight)
            since = 0.0
        now = sim.time
        if is_call:
            sim.command(
                np.concatenate([flight.path(now + NODE_STEP * k) for k in range(flight.nodes + 1)])
            )
        before = time.thread_time_ns()
        alive = sim.advance(1)
        spent = (time.thread_time_ns() - before) / 1000.0
        if not alive:
            raise RunError(f"{flight.name}: the physics gave up at {now} s")
        (calls if is_call else others).append(spent)
        since += 0.001
        if since > flight.settle:
            squares.append(float(np.sum((sim.base().position - flight.path(sim.time)[:3]) ** 2)))
    taken = np.array(calls) - np.median(others)
    return {
        "name": flight.name,
        "calls": len(calls),
        "rms_cm": 100.0 * float(np.sqrt(np.mean(squares))),
        "worst_cm": 100.0 * float(np.sqrt(np.max(squares))),
        "failures": count(sim, "failures"),
        **{f"us_{p}": float(np.percentile(taken, p)) for p in (50, 99, 99.9, 100)},
    }


def disturb(sim: skybody.Simulation, flight: Flight) -> None:
    for path, factor in (
        ("robots.quad.links.base_link.mass", flight.heavier),
        ("robots.quad.rotors[0].thrust_constant", flight.weak),
    ):
        if factor != 1.0:
            sim.set_param(path, factor * sim.param(path))


def count(sim: skybody.Simulation, name: str) -> int:
    """A count reported by the controller."""
    sim.evaluate()
    (channel,) = (c for c in sim.compiled.info_channels if c.name.endswith(f".{name}"))
    return int(sim.info[channel.first])


HEADINGS = (
    "flight | RMS error [cm] | worst [cm] | median [us] | 99 % [us] | 99.9 % [us] | longest [us]"
    " | times real time | failed"
)
HEAD = """# nmpc: time of a call, and how well it flies

By `research/speed/nmpc.py`, which defines a call. 100 calls a second of a thousand
physics steps; a horizon of 20 nodes, 50 ms apart, and QDrone2 unless another is named; references
given for each node (`preview`); default weights for every vehicle. {machine}

"""
FOOT = """

`times real time` is the period of 10 ms over the median. Errors are of position, the first
{settle} s after each start left out (steps of 3 m: 2.5 s, upside-down starts: 3.5 s); `failed`
are calls whose program was not solved, out of all.

Bars: a median of 20 times real time (500 us) where no rotor saturates, 5 ms at 99.9 %; 2 cm on
the Lissajous without disturbance, 10 cm with wind and gusts, 15 cm on the figure of eight.
{verdict}

Wind is 5 m/s along x with Dryden turbulence (light, MIL-F-8785C) and a drag of the body of 0.2 N
s/m and 0.02 N s^2/m^2 along each axis, which the controller does not know. `IMU`: rates and
accelerations by the shipped IMU with the noise and biases of world `payload`; position, velocity
and attitude by the state.
"""


def verdict(rows: list[dict[str, Any]]) -> str:
    """The missed goals."""
    by_name = {row["name"]: row for row in rows}
    bars = {
        "Lissajous, 1.5 m/s": 2.0,
        "Lissajous, wind 5 m/s and Dryden gusts": 10.0,
        "figure of eight, 10 m/s": 15.0,
    }
    missed = [name for name, bar in bars.items() if by_name[name]["rms_cm"] > bar]
    missed += [f"median, {n}" for n in bars if by_name[n]["us_50"] > 500.0]
    missed += [f"99.9 %, {row['name']}" for row in rows if row["us_99.9"] > 5000.0]
    return "Missed: " + "; ".join(missed) + "." if missed else "All are met."


def page(found: dict[str, Any]) -> str:
    rows = found["flights"]
    table = [head(HEADINGS)]
    for row in rows:
        table.append(
            [
                row["name"],
                f"{row['rms_cm']:.2f}",
                f"{row['worst_cm']:.2f}",
                *(f"{row[f'us_{p}']:.0f}" for p in (50, 99, 99.9, 100)),
                f"{10000.0 / row['us_50']:.0f}",
                f"{row['failures']} of {row['calls']}",
            ]
        )
    return (
        HEAD.format(machine=machine_line(found["facts"]))
        + markdown_table(table)
        + FOOT.format(verdict=verdict(rows), settle=2)
    )


def main() -> int:
    options = Options(__doc__, __name__).given()
    seconds = 4.5 if options.quick else 60.0
    found: dict[str, Any] = {"facts": facts(), "seconds": seconds, "flights": []}
    for flight in FLIGHTS:
        found["flights"].append(fly(flight, seconds))
        print(found["flights"][-1], flush=True)
    write_page(options.out, PAGE, page(found), found)
    return 0
