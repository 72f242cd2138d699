"""Downwash and ground effect: samples of recorded flights, and the engine's values.

The logs of neural-swarm are CSV: time [us], position and velocity, acceleration with gravity (W),
quaternion x y z w, thrusts, PWM as shares, battery voltage and more.
"""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from functools import cache
from itertools import product
from pathlib import Path

import numpy as np
from skybody import InputError, Simulation

from research.real.recorded_flights import Reals

SWAPS = "data/training/datacollection21_06_16_2020/swap_ss"
TAKEOFFS = (
    "data/training/datacollection21_06_16_2020/takeoff_s",
    "data/training/datacollection20_12_20_2019/takeoff_landing_small",
)
VEHICLES = ("cf50", "cf51")
# Thrust of a rotor in grams by the share of PWM p and the voltage over 4.2 V v, from a stand
# (defaultcf.txt there): 1, p, v, p^2, p v.
THRUST = (11.093358483549203, -39.08104165843915, -9.525647087583181, 20.573302305476638,
          38.42885066644033)  # fmt: skip
LAG = 0.16  # share of the way to the command in a row of 10 ms, as in that repository
GRAVITY = 9.81
GRAMS = 1000.0 / GRAVITY  # of 1 N
HEIGHTS = np.array([0.2, 0.25, 0.3, 0.35, 0.4])  # between two Crazyflies [m]
DISTANCES = {"0 to 3 cm": (0.0, 0.03), "6 to 10 cm": (0.06, 0.10), "15 to 20 cm": (0.15, 0.20)}
HUB_HEIGHTS = np.array([0.042, 0.05, 0.06, 0.07, 0.085, 0.1, 0.15, 0.2, 0.3])  # [m]
HUB_AT_REST = 0.039  # of the shipped model on its box [m]
FREE_HEIGHT, FREE_DISTANCE, FREE_BELOW = 0.3, 0.3, 0.1  # from ground, jet, upper vehicle [m]
RADIUS = 0.0231348  # of a rotor [m]
CIRCLE = 0.067  # around the four rotors: the hubs' distance from the centre, and RADIUS [m]
SHIPPED = f"radius: {RADIUS}"  # constants of downwash: the default ones
SPREADS = np.linspace(0.0, 0.03, 61)  # candidates of gzdrl [m]
STARTS = np.linspace(0.0005, 0.01, 39)  # [m^2]
LEAST_SAMPLES = 10  # of a bin


@dataclass(frozen=True)
class Log:
    """A flight, one row per 10 ms."""

    time: Reals  # [s]
    position: Reals  # (rows, 3), W [m]
    specific: Reals  # acceleration with gravity along z, W [m/s^2]
    lift: Reals  # component along z of the thrust by the curve [N]


def read(file: Path) -> Log:
    """Reads a log.

    Raises:
        InputError: it is missing.
    """
    if not file.is_file():
        raise InputError(f"{file}: no such file; needed: a checkout of aerorobotics/neural-swarm")
    rows = np.loadtxt(file, delimiter=",", skiprows=1)
    rows = rows[np.isfinite(rows[:, :23]).all(axis=1)]
    x, y = rows[:, 10], rows[:, 11]
    force = lagged(thrust(rows[:, 18:22], rows[:, 22:23] / 4.2).sum(axis=1)) / GRAMS
    time = 1e-6 * (rows[:, 0] - rows[0, 0])
    upright = 1.0 - 2.0 * (x * x + y * y)
    return Log(time, rows[:, 1:4], rows[:, 9], force * upright)


def thrust(share: Reals, voltage: Reals) -> Reals:
    """Thrusts [g] by the curve of the stand."""
    one, p, v, pp, pv = THRUST
    return one + p * share + v * voltage + pp * share**2 + pv * share * voltage


def lagged(values: Reals) -> Reals:
    """Values behind a lag of first order."""
    made = values.copy()
    for row in range(1, len(values)):
        made[row] = made[row - 1] + LAG * (values[row - 1] - made[row - 1])
    return made


def downwash_samples(folder: Path, first: int) -> Reals:
    """Vertical distance below another Crazyflie [m], horizontal distance [m], force along z [g].

    Args:
        first: 0: flights 0, 2, ...; 1: the others.
    """
    found: list[Reals] = []
    for number in range(first, len(list((folder / SWAPS).glob(f"{VEHICLES[0]}_*.csv"))), 2):
        pair = [read(folder / SWAPS / f"{name}_{number:02d}.csv") for name in VEHICLES]
        masses = []
        relative = []
        for own, other in (pair, pair[::-1]):
            there = [np.interp(own.time, other.time, column) for column in other.position.T]
            to_other = np.stack(there, axis=1) - own.position
            relative.append(to_other)
            masses.append(mass_of(own, to_other))
        if all(np.isnan(masses)):
            continue
        for own, to_other, mass in zip(pair, relative, masses, strict=True):
            weight = mass if np.isfinite(mass) else np.nanmean(masses)
            force = weight * own.specific - own.lift
            distance = np.hypot(to_other[:, 0], to_other[:, 1])
            rows = np.stack([to_other[:, 2], distance, GRAMS * force], axis=1)
            found.append(rows[own.position[:, 2] > FREE_HEIGHT])
    if not found:
        raise InputError(f"{folder / SWAPS}: has no flights of {' and '.join(VEHICLES)}")
    return np.concatenate(found)


def mass_of(log: Log, to_other: Reals) -> float:
    """Mass by the parts of a flight outside the jet of the other vehicle [kg]; NaN: none."""
    outside = (to_other[:, 2] < -FREE_BELOW) | (np.hypot(*to_other[:, :2].T) > FREE_DISTANCE)
    free = outside & (log.position[:, 2] > FREE_HEIGHT)
    if free.sum() < LEAST_SAMPLES:
        return float("nan")
    return float(log.lift[free].mean() / log.specific[free].mean())


def ground_samples(folder: Path) -> tuple[Reals, Reals]:
    """Heights of the hubs above the ground [m], and the thrust over that of the curve."""
    files = [file for part in TAKEOFFS for file in sorted((folder / part).glob("cf*.csv"))]
    if not files:
        raise InputError(f"{folder / TAKEOFFS[0]}: has no flights")
    heights, gains = [], []
    for file in files:
        log = read(file)
        rest = float(log.position[:, 2].min())
        free = log.position[:, 2] > rest + FREE_HEIGHT
        mass = log.lift[free].mean() / log.specific[free].mean()
        # On the ground the legs carry a part: only rows above the height at rest.
        flying = (log.lift > 0.5 * mass * GRAVITY) & (log.position[:, 2] > rest + 0.005)
        heights.append(log.position[flying, 2] - rest + HUB_AT_REST)
        gains.append(mass * log.specific[flying] / log.lift[flying])
    return np.concatenate(heights), np.concatenate(gains)


def binned(at: Reals, values: Reals, edges: Reals) -> tuple[Reals, Reals, Reals]:
    """Means of arguments and values between edges, and numbers of samples; no empty bins."""
    place = np.digitize(at, edges) - 1
    bins = [k for k in range(len(edges) - 1) if (place == k).sum() >= LEAST_SAMPLES]
    means = [[at[place == k].mean(), values[place == k].mean()] for k in bins]
    counts = [float((place == k).sum()) for k in bins]
    table = np.array(means).reshape(-1, 2)
    return table[:, 0], table[:, 1], np.array(counts)


# --- the engine -------------------------------------------------------------------------------


def simulation(effect: str, *names: str) -> Simulation:
    """Hovering Crazyflies under one effect."""
    robots = "\n".join(
        f"  - {{name: {name}, model: models/crazyflie/crazyflie.urdf, rotor_speed: hover, "
        f"pose: {{position: [0, 0, {5 + k}]}}, controllers: [{{plugin: rotor_speed}}]}}"
        for k, name in enumerate(names)
    )
    task = f"{{plugin: watch, parameters: {{robot: {names[0]}, link: base_link}}}}"
    text = (
        "name: effect\nstepping: {dt: 0.001, action_repeat: 1}\ncontact: {ground: false}\n"
        f"robots:\n{robots}\neffects: [{effect}]\ntask: {task}\n"
    )
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "effect.yaml"
        file.write_text(text, encoding="utf-8")
        made = Simulation(file)
    made.reset()
    return made


@cache
def downwash_pair(constants: str) -> Simulation:
    """Two Crazyflies, with constants of downwash as in YAML."""
    return simulation(f"{{plugin: downwash, parameters: {{{constants}}}}}", "lower", "upper")


def downwash_force(constants: str, distance: float, height: float) -> float:
    """Force on the lower of two hovering Crazyflies [g]; negative: down."""
    pair = downwash_pair(constants)
    pair.reset()
    speeds = pair.rotor_speeds
    for name, place in (("lower", (0.0, 0.0, 5.0)), ("upper", (distance, 0.0, 5.0 + height))):
        pair.teleport(position=place, velocity=[0.0] * 3, robot=name)
    half = len(speeds) // 2
    pair.command(speeds[:half], "lower")
    pair.command(speeds[half:], "upper")
    pair.advance(1)
    mass = pair.mass_properties("base_link", "lower").mass
    return float(mass * pair.base("lower").velocity[2] / pair.compiled.dt * GRAMS)


def fitted_downwash(samples: Reals) -> str:
    """Constants of form gzdrl with the least squares on bins of samples, as in YAML."""
    rows = []
    for near, far in DISTANCES.values():
        beside = (samples[:, 1] >= near) & (samples[:, 1] < far)
        at, measured, _ = binned(samples[beside, 0], samples[beside, 2], HEIGHTS)
        rows += [(0.5 * (near + far), h, m) for h, m in zip(at, measured, strict=True)]
    distance, height, force = np.array(rows).T
    best, least = (0.0, 0.0, 0.0), np.inf
    for spread, start in product(SPREADS, STARTS):
        shape = np.exp(-0.5 * (distance**2 / (spread * height + start)) ** 2)
        most = max(float(-(shape @ force) / (shape @ shape)), 0.0)
        error = float(((force + most * shape) ** 2).sum())
        if error < least:
            best, least = (most / GRAMS, float(spread), float(start)), error
    most, spread, start = best
    return f"form: gzdrl, force: {most:.4f}, spread: {spread:.4f}, start: {start:.5f}"


def ground_gain(heights: Reals, radius: float) -> Reals:
    """Gains of thrust at heights of the hubs [m] by form cheeseman_bennett of a radius [m]."""
    effect = f"{{plugin: ground_effect, parameters: {{radius: {radius}}}}}"
    own = simulation(effect, "quad")
    hub = own.compiled.rotors[0].position[2]
    gains = []
    for height in heights:
        own.reset()
        own.teleport(position=[0.0, 0.0, height - hub], velocity=[0.0] * 3)
        own.command(own.rotor_speeds)
        own.advance(1)
        gains.append(float(own.state("robots.quad.rotors[0].thrust_gain")))
    return np.array(gains)
