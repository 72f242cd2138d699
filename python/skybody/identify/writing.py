"""Writes the identified vehicle: URDF, rotors file, scenarios, randomization, map."""

from __future__ import annotations

import shutil
import xml.etree.ElementTree as ElementTree
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from skybody import InputError
from skybody._native import CompiledScenario, scenario_file

from .identify import Identified
from .intervals import Interval
from .parameters import LOG
from .vehicle import Vehicle

ROBOT = "quad"  # of the scenarios
LEAST_DELAY = 0.002  # that is written into scenarios [s]
WIDEST = 0.3  # relative deviation of a drawn constant
CUT = 2.0  # deviations at which draws are cut


def write_vehicle(made: Identified, folder: Path) -> list[str]:
    """Writes all files of the vehicle into a folder; the names of its scenarios."""
    model = made.model
    engine = model.engine(made.values)
    engine |= most_speeds(made)
    write_urdf(model.vehicle, engine, folder)
    source = "skybody identify, see report.md"
    text = model.vehicle.rotors_text({**model.vehicle.nominal, **engine}, source)
    (folder / "rotors.yaml").write_text(text)
    draws = randomization(made)
    (folder / "randomization.yaml").write_text("randomization:\n" + "".join(draws))
    (folder / "effects.yaml").write_text("\n".join(effects(engine)) + "\n")
    names = ["train_hover.yaml", "train_trajectory.yaml"]
    for name, text in zip(names, (hover_text(made, draws), trajectory_text(made)), strict=True):
        (folder / name).write_text(text)
    if model.scales.is_share:
        write_share_commands(made, engine, folder)
    for name in names:
        check(folder / name)
    return names


def check(file: Path) -> None:
    """Loads a scenario that was written. Raises InputError if the values make no vehicle."""
    try:
        CompiledScenario(file)
    except InputError as error:
        first = str(error).splitlines()[0].replace(f"{file.parent}/", "")
        raise InputError(f"the identified values make no vehicle: {first}") from None


def most_speeds(made: Identified) -> dict[str, float]:
    """Largest speeds of the rotors: at full command and the mean voltage."""
    model = made.model
    if not model.scales.is_share:
        return {}
    vehicle = model.vehicle
    full = np.ones((1, len(vehicle.hubs)))
    voltage = np.full((1, 1), model.scales.voltage) if model.scales.voltage > 0.0 else None
    speed = float(model.speeds(made.values, full, voltage).max())
    return {vehicle.rotor_path(k, "max_speed"): speed for k in range(len(vehicle.hubs))}


# --- URDF ---------------------------------------------------------------------------------------


def urdf_file(vehicle: Vehicle) -> Path:
    """The file of the nominal model."""
    if Path(vehicle.model).is_file():
        return Path(vehicle.model)
    folders = Path(scenario_file("hover")).parents
    return next(f / vehicle.model for f in folders if (f / vehicle.model).is_file())


def write_urdf(vehicle: Vehicle, engine: Mapping[str, float], folder: Path) -> None:
    """The nominal URDF with the identified body: all mass is in the base link."""
    source = urdf_file(vehicle)
    builder = ElementTree.TreeBuilder(insert_comments=True)
    tree = ElementTree.parse(source, ElementTree.XMLParser(target=builder))
    for link in tree.getroot().iterfind("link"):
        if (old := link.find("inertial")) is not None:
            link.remove(old)
        if link.get("name") == vehicle.link:
            link.insert(0, inertial(vehicle, engine))
    for mesh in tree.getroot().iter("mesh"):
        file = source.parent / mesh.get("filename", "")
        if file.is_file():
            (folder / "meshes").mkdir(exist_ok=True)
            shutil.copyfile(file, folder / "meshes" / file.name)
            mesh.set("filename", f"meshes/{file.name}")
    ElementTree.indent(tree)
    tree.write(folder / "vehicle.urdf", encoding="unicode", xml_declaration=True)


def inertial(vehicle: Vehicle, engine: Mapping[str, float]) -> ElementTree.Element:
    """The element `inertial`."""
    made = ElementTree.Element("inertial")
    com = " ".join(f"{engine[vehicle.path(f'com[{k}]')]:.6g}" for k in range(3))
    ElementTree.SubElement(made, "origin", xyz=com)
    ElementTree.SubElement(made, "mass", value=f"{vehicle.mass:.6g}")
    names = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    values = {name: f"{engine[vehicle.path(f'inertia[{k}]')]:.6g}" for k, name in enumerate(names)}
    ElementTree.SubElement(made, "inertia", values)
    return made


# --- scenarios ----------------------------------------------------------------------------------


def effects(engine: Mapping[str, float]) -> list[str]:
    """The drag of the body as YAML lines; none if there is no drag."""
    drag = {
        kind: [float(f"{engine[f'effects.body_drag.{kind}[{k}]']:.4g}") for k in range(3)]
        for kind in ("linear", "quadratic")
    }
    if not any(map(any, drag.values())):
        return ["effects: []"]
    parameters = f"linear: {drag['linear']}, quadratic: {drag['quadratic']}"
    return ["effects:", f"  - {{plugin: body_drag, parameters: {{{parameters}}}}}"]


def robot_lines(made: Identified, height: float, rotors: str = "") -> list[str]:
    """The robot of a scenario."""
    lines = ["robots:", f"  - name: {ROBOT}", "    model: vehicle.urdf"]
    if rotors:
        lines.append(f"    rotors: {rotors}")
    lines += [
        f"    pose: {{position: [0, 0, {height:g}]}}", "    rotor_speed: hover",
        "    controllers:",
    ]  # fmt: skip
    delay = made.values["delay.command"]
    if delay >= LEAST_DELAY:
        parameters = f"{{signal: rotor_speed, latency: {delay:.4g}}}"
        lines.append(f"      - {{plugin: delay, name: latency, parameters: {parameters}}}")
    return [*lines, "      - {plugin: rotor_speed, name: motors}"]


def hover_text(made: Identified, draws: list[str]) -> str:
    """Hover, with a spread that the data leave open."""
    lines = [
        f"# Hover with the identified {made.model.vehicle.name}; see report.md.",
        "include: hover_learn.yaml",
        f"name: {made.model.vehicle.name}_hover",
        *robot_lines(made, 1.0),
        *effects(made.model.engine(made.values)),
        "randomization:",
    ]
    start = [
        "  - plugin: start\n",
        f"    parameters: {{robot: {ROBOT}, position_min: [-2, -2, 0.5], "
        "position_max: [2, 2, 2.5], yaw_min: -0.7, yaw_max: 0.7}\n",
    ]
    return "\n".join(lines) + "\n" + "".join([*draws, *start])


def trajectory_text(made: Identified) -> str:
    """The task trajectory."""
    lines = [
        f"# Lissajous figures with the identified {made.model.vehicle.name}; see report.md.",
        "include: trajectory.yaml",
        f"name: {made.model.vehicle.name}_trajectory",
        *robot_lines(made, 0.85),
        *effects(made.model.engine(made.values)),
        "randomization:",
    ]
    last = f"  - {{plugin: lissajous, parameters: {{reference: task, robot: {ROBOT}}}}}\n"
    return "\n".join(lines) + "\n" + "".join(randomization(made)) + last


# --- randomization ------------------------------------------------------------------------------

ROTORS = f"robots.{ROBOT}.rotors[*]."
PLACES = {
    "tau_up": ROTORS + "tau_up", "tau_down": ROTORS + "tau_down",
    "moment_constant": ROTORS + "moment_constant", "rotor_inertia": ROTORS + "inertia",
    "drag.rotor": ROTORS + "drag_constant",
}  # fmt: skip


def randomization(made: Identified) -> list[str]:
    """Draws within the uncertainty of the data."""
    vehicle, lines = made.model.vehicle, []
    body = f"robots.{ROBOT}.links.{vehicle.link}."
    for interval in made.intervals:
        name, deviation = interval.name, interval.deviation
        if name in ("command.speed", "thrust_constant"):
            # Thrust goes with the square of the speed.
            share = 2.0 * deviation if name == "command.speed" else deviation
            lines.append(scale("thrust", ROTORS + "thrust_constant", share))
        elif name in PLACES:
            lines.append(scale(name.replace(".", "_"), PLACES[name], relative(made, interval)))
        elif name.startswith("inertia."):
            place = f"{body}inertia[{'xyz'.index(name[-1])}]"
            lines.append(scale(name.replace(".", "_"), place, deviation))
        elif name.startswith("com."):
            place = f"{body}com[{'xyz'.index(name[-1])}]"
            lines.append(drawn(name.replace(".", "_"), place, 0.0, deviation, "shift"))
    return [line for line in lines if line]


def relative(made: Identified, interval: Interval) -> float:
    """Relative deviation of a constant."""
    k = made.model.names.index(interval.name)
    if made.model.parameters[k].form == LOG:
        return interval.deviation
    return interval.deviation / interval.value if interval.value > 0.0 else 0.0


def scale(name: str, what: str, deviation: float) -> str:
    """A drawn factor."""
    return drawn(name, what, 1.0, min(deviation, WIDEST), "scale")


def drawn(name: str, what: str, mean: float, deviation: float, form: str) -> str:
    """A draw from a normal distribution that is cut; empty if nothing is open."""
    if deviation <= 0.0:
        return ""
    low, high = mean - CUT * deviation, mean + CUT * deviation
    return (
        f"  - plugin: draw\n    name: spread_{name}\n    parameters:\n"
        f'      what: ["{what}"]\n      distribution: normal\n'
        f"      mean: {mean:g}\n      deviation: {deviation:.4g}\n"
        f"      range: [{low:.5g}, {high:.5g}]\n      form: {form}\n      shared: true\n"
    )


# --- commands -----------------------------------------------------------------------------------


def law_coefficients(made: Identified) -> list[float]:
    """Rotor speed at the mean voltage as a polynomial of the log's command [rad/s]."""
    scales, values = made.model.scales, made.values
    low, high = scales.law.low, scales.law.high
    # x = (command - low) / ((high - low) share) - 1
    x = np.polynomial.Polynomial(
        [-low / ((high - low) * scales.share) - 1.0, 1.0 / ((high - low) * scales.share)]
    )
    law = 1.0 + values["command.slope"] * x + values["command.curve"] * x**2
    return [float(c) for c in (values["command.speed"] * law).coef]


def write_share_commands(made: Identified, engine: Mapping[str, float], folder: Path) -> None:
    """The law of the commands, for maps, and a scenario whose rotors follow commands.

    In the latter a rotor's speed is its command as a share of `max_speed`, and the effect
    `thrust_curve` has the measured thrust, so that an action of a policy is a command of the log.
    """
    scales, vehicle = made.model.scales, made.model.vehicle
    coefficients = ", ".join(f"{c:.8g}" for c in law_coefficients(made))
    voltage = f" at {scales.voltage:.4g} V" if scales.voltage > 0.0 else ""
    text = (
        f"# rotor_speed of a map (docs/imports.md), identified{voltage}.\n"
        f"law: polynomial\ncoefficients: [{coefficients}]\n"
        f"range: [{scales.law.low:g}, {scales.law.high:g}]\n"
    )
    (folder / "command_law.yaml").write_text(text)
    most = engine[vehicle.rotor_path(0, "max_speed")]
    span = scales.law.high - scales.law.low
    share = np.polynomial.Polynomial(law_coefficients(made))(
        np.polynomial.Polynomial([scales.law.low, span / most])
    )
    thrust = (engine[vehicle.rotor_path(0, "thrust_constant")] * share**2).coef
    moment = (engine[vehicle.rotor_path(0, "moment_constant")] * share**2).coef
    curve = f"thrust: [{listed(thrust)}], moment: [{listed(moment)}]"
    lines = [
        "# Hover, commanded as the log: a rotor's speed over max_speed is the command's share.",
        "include: train_hover.yaml",
        f"name: {vehicle.name}_hover_commands",
        "effects:",
        *effects(engine)[1:],
        f"  - {{plugin: thrust_curve, parameters: {{{curve}}}}}",
    ]
    (folder / "hover_commands.yaml").write_text("\n".join(lines) + "\n")
    check(folder / "hover_commands.yaml")


def listed(numbers: object) -> str:
    """Numbers with commas."""
    return ", ".join(f"{c:.6g}" for c in np.atleast_1d(np.asarray(numbers, dtype=float)))
