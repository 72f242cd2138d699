"""A figure for the README of each effect: its simulated result and its equation.

    python -m research run effect_figures [EFFECT]... [--quick] [--out FOLDER]

Writes effects/EFFECT/figure.png. Points and full lines are measured in simulations; dashed lines
are the equations of the README.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray
from skybody import Simulation

from research.common.options import Options
from research.common.places import RESULTS, ROOT
from research.common.plots import panels, save
from research.common.programs import RunError

PAGE = "effects/*/README.md"

Floats = NDArray[np.float64]
HOVER = 1391.0  # rad/s: QDrone2's rotors carry its weight
THRUST_CONSTANT = 1.9533e-6  # N s^2/rad^2, of QDrone2
GRAVITY = 9.81
HIGH = 50.0  # m: far above the ground
TAU = 2.0 * np.pi
STILL = ([1, 0, 0, 0], [0, 0, 0], [0, 0, 0])  # rotation, velocity, angular velocity


def flying(effects: str, *more: str, scenario: str = "hover") -> Simulation:
    """A QDrone2 in equilibrium, at the start of an episode.

    @param effects  the scenario's list, as YAML
    """
    overrides = ["randomization=[]", f"robots[0].pose.position=[0, 0, {HIGH}]", *more]
    simulation = Simulation(scenario, "rotor_speed", overrides=[*overrides, f"effects=[{effects}]"])
    simulation.reset()
    return simulation


def mass(simulation: Simulation) -> float:
    return float(simulation.mass_properties("base_link").mass)


def acceleration(simulation: Simulation, z: float = HIGH, velocity: object = (0, 0, 0)) -> Floats:
    """Acceleration of the base at a height, level, with its rotors at hover speed [m/s^2], W.

    Held inputs are computed at the beginning of a step, so one step is made first.
    """
    level, _, still = STILL
    simulation.teleport([0, 0, z], level, velocity, still)
    simulation.command(np.full(4, HOVER))
    simulation.advance(1)
    return np.asarray(simulation.accelerations().udot[0:3])


def thrust_ratio(simulation: Simulation, z: float, velocity: object = (0, 0, 0)) -> float:
    """Thrust over hover thrust: the rotors' drag acts only across the axis."""
    return float(1.0 + acceleration(simulation, z, velocity)[2] / GRAVITY)


def over_time(
    simulation: Simulation, steps: int, every: int, look: Callable[[], Floats]
) -> tuple[Floats, Floats]:
    """Times [s] and the values of look() at these times."""
    times, values = [0.0], [look()]
    for k in range(every, steps + 1, every):
        simulation.advance(every)
        times.append(k * 0.001)
        values.append(look())
    return np.asarray(times), np.asarray(values)


def info(simulation: Simulation, name: str, count: int = 1) -> Floats:
    """An info value of an effect."""
    simulation.evaluate()
    place = 0
    for channel in simulation.compiled.info_channels:
        if channel.name == name:
            return np.array(simulation.info[place : place + count])
        place += channel.count
    raise KeyError(name)


# --- the effects ----------------------------------------------------------------------------------


def battery(axes: Axes) -> None:
    simulation = flying("{plugin: battery, parameters: {capacity: 0.15}}")
    simulation.command(np.full(4, HOVER))
    names = ("battery.charge", "battery.voltage")
    t, v = over_time(
        simulation, 20000, 100, lambda: np.concatenate([info(simulation, n) for n in names])
    )
    axes.plot(t, v[:, 1], label="voltage [V]")
    axes.set(xlabel="hovering [s]", ylabel="voltage [V]")
    other = axes.twinx()
    other.plot(t, v[:, 0], color="C1", label="charge")
    other.set(ylabel="charge", ylim=(0, 1.05))
    axes.legend(loc="lower left")
    other.legend(loc="upper right")


def blade_flapping(axes: Axes) -> None:
    lift, flapping = 0.02, 2e-6
    simulation = flying(
        "{plugin: blade_flapping, parameters: "
        f"{{flapping: {flapping}, translational_lift: {lift}, axial_drag: 1e-5}}}}"
    )
    speeds = np.linspace(0.0, 15.0, 16)
    up = [acceleration(simulation, velocity=(v, 0, 0))[2] for v in speeds]
    axes.plot(speeds, up, "o", label="level flight")
    axes.plot(speeds, 4 * lift * speeds**2 / mass(simulation), "k--", label="equation")
    climb = [acceleration(simulation, velocity=(0, 0, v))[2] for v in speeds]
    axes.plot(speeds, climb, "s", label="climb")
    axes.plot(speeds, -4 * 1e-5 * HOVER * speeds / mass(simulation), "k--")
    axes.set(xlabel="speed [m/s]", ylabel="acceleration along z [m/s$^2$]")


def body_drag(axes: Axes) -> None:
    speeds = np.linspace(0.0, 20.0, 21)
    for linear, quadratic in ((0.1, 0.0), (0.0, 0.01), (0.1, 0.01)):
        simulation = flying(
            "{plugin: body_drag, parameters: "
            f"{{linear: [0, 0, {linear}], quadratic: [0, 0, {quadratic}]}}}}"
        )
        down = [-acceleration(simulation, velocity=(0, 0, v))[2] for v in speeds]
        axes.plot(speeds, down, "o", label=f"linear {linear:g}, quadratic {quadratic:g}")
        force = (linear + quadratic * speeds) * speeds
        axes.plot(speeds, force / mass(simulation), "k--")
    axes.set(xlabel="speed along the axis [m/s]", ylabel="deceleration [m/s$^2$]")


def ceiling_effect(axes: Axes) -> None:
    radius, ceiling = 0.1, 60.0
    simulation = flying(
        f"{{plugin: ceiling_effect, parameters: {{height: {ceiling}, radius: {radius}}}}}"
    )
    hub = hub_height(simulation)
    ratios = np.linspace(0.2, 3.0, 30)
    got = [thrust_ratio(simulation, ceiling - r * radius - hub) for r in ratios]
    gamma = (1 + np.sqrt(1 + 1 / (8 * ratios**2))) / 2
    axes.plot(ratios, got, "o", label="constant_power")
    axes.plot(ratios, gamma ** (2 / 3), "k--", label="equation")
    axes.set(xlabel="distance / radius", ylabel="thrust / thrust without a ceiling")


def downwash(axes: Axes) -> None:
    for distance in (1.0, 2.0, 3.0):
        simulation = Simulation(
            "downwash_pair", "rotor_speed", overrides=["randomization=[]", "stepping.horizon=0"]
        )
        simulation.reset()
        hover = np.asarray(simulation.rotor_speeds)[:4]
        places = np.linspace(-1.0, 1.0, 41)
        got = []
        for x in places:
            for robot, position in (("lower", [x, 0, 20.0]), ("upper", [0, 0, 20.0 + distance])):
                simulation.teleport(position, *STILL, robot=robot)
                simulation.command(hover, robot)
            simulation.advance(1)
            got.append(-simulation.accelerations().udot[2] * mass_of_lower(simulation))
        axes.plot(places, got, label=f"{distance:g} m below")
    axes.set(xlabel="beside the upper vehicle's axis [m]", ylabel="force downwards [N]")


def dryden(axes: Axes) -> None:
    simulation = flying(
        "{plugin: dryden, parameters: {height: 20, airspeed: 5}}", "stepping.horizon=0"
    )

    def look() -> Floats:
        simulation.teleport(position=[0, 0, HIGH], velocity=[0, 0, 0])
        return info(simulation, "dryden.velocity", 3)

    t, v = over_time(simulation, 60000, 10, look)
    for k, name in enumerate(("along", "across", "up")):
        axes.plot(t[1:], v[1:, k], label=name, linewidth=0.8)
    axes.set(xlabel="time [s]", ylabel="velocity of the air [m/s]")


def ground_effect(axes: Axes) -> None:
    radius = 0.1
    constant = THRUST_CONSTANT * radius**2 / 16
    simulation = flying(f"{{plugin: ground_effect, parameters: {{radius: {radius}}}}}")
    other = flying(
        f"{{plugin: ground_effect, parameters: {{form: gzdrl, ground_constant: {constant}}}}}"
    )
    hub = hub_height(simulation)
    ratios = np.linspace(0.6, 4.0, 35)
    for simulated, name in ((simulation, "cheeseman_bennett"), (other, "gzdrl")):
        heights = ratios * radius - hub
        got = [thrust_ratio(simulated, z) for z in heights if z > 0.06]
        axes.plot(ratios[heights > 0.06], got, "o", label=name)
    axes.plot(ratios, 1 / (1 - 1 / (4 * ratios) ** 2), "k--", label="equations")
    axes.plot(ratios, 1 + 1 / (16 * ratios**2), "k--")
    axes.set(xlabel="height of the hub / radius", ylabel="thrust / thrust far from the ground")


def motor(axes: Axes) -> None:
    constants = "torque_constant: 0.0055, resistance: 0.1, voltage: 16.8"
    for limit in (30, 15):
        simulation = flying(f"{{plugin: motor, parameters: {{{constants}, max_current: {limit}}}}}")
        t, w = steps_of_command(simulation)
        axes.plot(t, w, label=f"at most {limit} A")
    t, w = steps_of_command(flying(""))
    axes.plot(t, w, "k--", label="without: the lag")
    axes.set(xlabel="time [s]", ylabel="speed of a rotor [rad/s]")


def rotor_failure(axes: Axes) -> None:
    for kind in ("off", "stuck", "partial"):
        simulation = flying(
            "{plugin: rotor_failure, parameters: "
            f"{{kind: {kind}, rotors: [back_left], earliest: 0.1, latest: 0.1}}}}"
        )
        thrust = thrust_of_failing(simulation, kind)
        simulation.command(np.full(4, HOVER))
        t, f = over_time(simulation, 100, 1, thrust)
        simulation.command(np.full(4, 1800.0))
        t2, f2 = over_time(simulation, 200, 1, thrust)
        axes.plot(np.concatenate([t, t[-1] + t2]), np.concatenate([f, f2]), label=kind)
    axes.set(xlabel="time [s]", ylabel="thrust of the rotor [N]")


def thrust_curve(axes: Axes) -> None:
    diameter, a1, a2 = 0.2, -0.4, -0.5
    simulation = flying(
        "{plugin: thrust_curve, parameters: {thrust: [0, 0, 1.9533e-6], "
        f"thrust_by_advance: [{a1}, {a2}], diameter: {diameter}}}}}"
    )
    speeds = np.linspace(0.0, 25.0, 26)
    got = [thrust_ratio(simulation, HIGH, (0, 0, v)) for v in speeds]
    j = speeds / (HOVER / TAU * diameter)
    axes.plot(j, got, "o", label="climb with hover speed of the rotors")
    axes.plot(j, 1 + a1 * j + a2 * j**2, "k--", label="equation")
    axes.set(xlabel="advance ratio", ylabel="thrust / thrust at rest")


PROBE = "{plugin: body_drag, parameters: {linear: [1, 1, 1]}}"


def felt_wind(simulation: Simulation, z: float = HIGH) -> Floats:
    """Wind speed from the drag of a body at rest: 1 N s/m."""
    for rotor in range(4):
        simulation.set_param(f"robots.quad.rotors[{rotor}].drag_constant", 0.0)
    return acceleration(simulation, z) * mass(simulation)


def wind(axes: Axes) -> None:
    heights = np.linspace(0.5, 40.0, 40)
    for profile in ("uniform", "power", "logarithmic"):
        simulation = flying(
            f"{{plugin: wind, parameters: {{velocity: [5, 0, 0], profile: {profile}}}}}, {PROBE}"
        )
        got = [felt_wind(simulation, z)[0] for z in heights]
        axes.plot(got, heights, "o", markersize=3, label=profile)
    axes.plot(5 * (heights / 10) ** (1 / 7), heights, "k--", label="equations")
    axes.plot(5 * np.log(heights / 0.04572) / np.log(10 / 0.04572), heights, "k--")
    axes.set(xlabel="wind [m/s]", ylabel="height [m]")


def wind_table(axes: Axes) -> None:
    rows = np.array([[0, 0, 0, 0], [1, 3, 1, 0], [2, 3, -1, 0.5], [4, 0, 0, 0]], float)
    with tempfile.TemporaryDirectory() as folder:
        table = Path(folder) / "wind.csv"
        lines = [",".join(map(repr, row)) for row in rows.tolist()]
        table.write_text("\n".join(["t,x,y,z", *lines]) + "\n")
        simulation = flying(f"{{plugin: wind_table, parameters: {{file: {table}}}}}, {PROBE}")
    times = np.arange(0.0, 5.0, 0.05)
    got = []
    for _ in times:
        got.append(felt_wind(simulation))
        simulation.advance(49)
    for k, name in enumerate("xyz"):
        axes.plot(times, np.asarray(got)[:, k], color=f"C{k}", label=name)
        axes.plot(rows[:, 0], rows[:, k + 1], "o", color=f"C{k}")
    axes.set(xlabel="time [s]", ylabel="wind [m/s]; dots: the table")


# --- parts ----------------------------------------------------------------------------------------


def hub_height(simulation: Simulation) -> float:
    """Height of the hubs above the base's origin [m]."""
    return float(simulation.param("robots.quad.rotors[0].position[2]"))


def mass_of_lower(simulation: Simulation) -> float:
    return float(simulation.param("robots.lower.links.base_link.mass"))


def _rotor(simulation: Simulation, i: int) -> Callable[[], Floats]:
    return lambda: np.asarray(simulation.rotor_speeds)[i]


def thrust_of_failing(simulation: Simulation, kind: str) -> Callable[[], Floats]:
    """Thrust of the rotor back_left [N]; `kind` as in the effect's parameters."""
    speed = _rotor(simulation, 2)

    def thrust() -> Floats:
        has_failed = info(simulation, "rotor_failure.failed", 4)[2] > 0.0
        gain = 0.5 if kind == "partial" and has_failed else 1.0
        return np.asarray(gain * THRUST_CONSTANT * speed() ** 2)

    return thrust


def steps_of_command(simulation: Simulation) -> tuple[Floats, Floats]:
    """The speed of a rotor whose command steps up and down."""
    times, speeds = [], []
    for part, command in enumerate((HOVER, 2000.0, 800.0)):
        simulation.command(np.full(4, command))
        t, w = over_time(simulation, 150, 1, _rotor(simulation, 0))
        times.append(0.15 * part + t)
        speeds.append(w)
    return np.concatenate(times), np.concatenate(speeds)


DRAWN = (battery, blade_flapping, body_drag, ceiling_effect, downwash, dryden, ground_effect)
DRAWN += (motor, rotor_failure, thrust_curve, wind, wind_table)
FIGURES: dict[str, Callable[[Axes], None]] = {draw.__name__: draw for draw in DRAWN}


def main() -> int:
    options = (
        Options(__doc__, __name__, "only `body_drag`")
        .add("effects", nargs="*", metavar="EFFECT", help=f"of {', '.join(FIGURES)}")
        .given()
    )
    names = options.effects or (["body_drag"] if options.quick else list(FIGURES))
    if unknown := [name for name in names if name not in FIGURES]:
        raise RunError(f"no effect `{unknown[0]}`; there are {', '.join(FIGURES)}")
    for name in names:
        figure, (row,) = panels(1, 1, (6.4, 3.6))
        axes = row[0]
        FIGURES[name](axes)
        if not axes.get_legend():
            axes.legend()
        own = options.out == RESULTS  # no other folder is given
        path = ROOT / "effects" / name / "figure.png" if own else options.out / f"{name}.png"
        save(figure, path, 110)
        print(path, flush=True)
    return 0
