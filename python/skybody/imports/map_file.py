"""Maps: which columns of a log are which values of a flight (docs/imports.md)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from skybody import InputError

from .keys import Keys, read_keys
from .laws import LAWS, Law
from .units import UNITS

SHIPPED = Path(__file__).parent / "maps"
AXES = ("world", "body")


@dataclass(frozen=True)
class Columns:
    """Columns of the log, and the factor that makes SI units of them."""

    place: str  # of the key in the map, for messages
    names: tuple[str, ...]
    factor: float = 1.0
    unit: str = ""  # SI
    axes: str = ""  # of vectors: `world` or `body`
    optional: bool = False  # may be missing in the log


@dataclass(frozen=True)
class Attitude:
    """A quaternion, or angles of roll, pitch and yaw (z-y'-x'')."""

    columns: Columns
    order: tuple[int, ...]  # places of w x y z among the columns; none: angles


@dataclass(frozen=True)
class Rotors:
    """Rotors by name, and the law from their columns to their speeds."""

    names: tuple[str, ...]
    columns: Columns
    law: Law


@dataclass(frozen=True)
class Robot:
    """A vehicle, or another rigid body that was recorded."""

    name: str
    model: str  # URDF
    rotors_file: str  # rotors.yaml; empty: beside the model
    topic: str  # of MCAP: messages with pose and velocities; empty: columns
    position: Columns | None
    attitude: Attitude | None
    velocity: Columns | None
    angular_velocity: Columns | None
    rotors: Rotors | None
    goal: Columns | None
    goal_yaw: Columns | None


@dataclass(frozen=True)
class Map:
    """A map of the columns of a log."""

    file: Path
    time: Columns | None  # None: the log has own times
    frame: str  # `enu`: z up, bodies x forward, y left; `ned`: z down, x forward, y right
    bridges_gaps: bool  # rows that are NaN are left out
    window: float  # of derivatives [s]
    robots: tuple[Robot, ...]
    sensors: dict[str, Columns]  # by the name of the values
    obstacles: Any  # as in a scenario; None: none


def find_map(name: str) -> Path:
    """The file of a map: itself, or the shipped one of this name.

    Raises:
        InputError: there is none.
    """
    if Path(name).exists():
        return Path(name)
    if (shipped := SHIPPED / f"{name}.yaml").is_file():
        return shipped
    raise InputError(f"no map `{name}`; give a file, or a shipped one: {', '.join(shipped_maps())}")


def shipped_maps() -> list[str]:
    """Names of the shipped maps."""
    return sorted(file.stem for file in SHIPPED.glob("*.yaml"))


def read_map(file: Path, model: str = "") -> Map:
    """Reads a map.

    Args:
        file: YAML.
        model: URDF in place of that of the only robot; empty: that of the map.

    Raises:
        InputError: the first mistake, with its key.
    """
    keys = read_keys(file)
    keys.allow("time", "frame", "gaps", "window", "robots", "sensors", "obstacles")
    listed = keys.keys("robots")
    robots = tuple(robot_of(listed.keys(name), name) for name in listed)
    if model:
        if len(robots) != 1:
            raise keys.error(f"has {len(robots)} robots; allowed with --model: one", "robots")
        robots = (replace(robots[0], model=str(Path(model).resolve()), rotors_file=""),)
    sensors = keys.keys("sensors") if "sensors" in keys else Keys(file, "sensors", {})
    return Map(
        file,
        time_of(keys.keys("time")) if "time" in keys else None,
        keys.word("frame", ("enu", "ned"), "enu"),
        keys.word("gaps", ("error", "interpolate"), "error") == "interpolate",
        keys.number("window", 0.1, 1e-3, 10.0),
        robots,
        {name: columns_of(sensors, name, None) for name in sensors},
        keys.value("obstacles") if "obstacles" in keys else None,
    )


def time_of(keys: Keys) -> Columns:
    """The column with the time."""
    keys.allow("column", "unit")
    unit = keys.word("unit", ("s", "ms", "us", "ns"), "s")
    return Columns(keys.place, (keys.text("column"),), UNITS[unit][0], "s")


def robot_of(keys: Keys, name: str) -> Robot:
    """The columns of a robot."""
    keys.allow(
        "model", "rotors", "topic", "position", "quaternion", "euler", "velocity",
        "angular_velocity", "rotor_speed", "goal", "goal_yaw",
    )  # fmt: skip
    if not name.isidentifier():
        raise keys.error("allowed as a robot's name: letters, digits and `_`")

    def columns(key: str, count: int, unit: str, axes: str = "") -> Columns | None:
        return columns_of(keys, key, count, unit, axes) if key in keys else None

    if "topic" in keys and any(k in keys for k in ("position", "quaternion", "euler", "velocity")):
        raise keys.error("has the position, attitude and velocity: leave these keys out", "topic")
    return Robot(
        name,
        keys.text("model"),
        keys.text("rotors", ""),
        keys.text("topic", ""),
        columns("position", 3, "m"),
        attitude_of(keys),
        columns("velocity", 3, "m/s", "world"),
        columns("angular_velocity", 3, "rad/s", "body"),
        rotors_of(keys.keys("rotor_speed")) if "rotor_speed" in keys else None,
        columns("goal", 3, "m"),
        columns("goal_yaw", 1, "rad"),
    )


def columns_of(
    parent: Keys, key: str, count: int | None, unit: str | None = None, axes: str = ""
) -> Columns:
    """Columns of one quantity.

    Args:
        parent: the keys around it.
        key: its own.
        count: number of columns; None: any.
        unit: SI unit of the quantity, and its default; None: any.
        axes: default of the axes of a vector; empty: it has none.
    """
    keys = parent.keys(key)
    keys.allow("columns", "unit", "optional", *(("axes",) if axes or unit is None else ()))
    allowed = [name for name, (_, si) in UNITS.items() if unit is None or si == unit]
    found = keys.word("unit", allowed, unit or "")
    factor, si = UNITS[found]
    chosen = keys.word("axes", AXES, axes) if "axes" in keys else axes
    names = keys.texts("columns", count)
    return Columns(keys.place, names, factor, si, chosen, keys.flag("optional"))


def attitude_of(keys: Keys) -> Attitude | None:
    """The quaternion or the angles of a robot; None: it has neither."""
    if "quaternion" in keys and "euler" in keys:
        raise keys.error("is given besides `quaternion`; allowed: one of them", "euler")
    if "euler" in keys:
        return Attitude(columns_of(keys, "euler", 3, "rad"), ())
    if "quaternion" not in keys:
        return None
    inner = keys.keys("quaternion")
    inner.allow("columns", "order", "optional")
    order = inner.word("order", ("wxyz", "xyzw"))
    columns = Columns(inner.place, inner.texts("columns", 4), optional=inner.flag("optional"))
    return Attitude(columns, tuple(order.index(letter) for letter in "wxyz"))


def rotors_of(keys: Keys) -> Rotors:
    """The rotors of a robot."""
    keys.allow("columns", "law", "unit", "coefficients", "range", "optional")
    rotors = keys.keys("columns")
    names = tuple(rotors.text(rotor) for rotor in rotors)
    kind = keys.word("law", tuple(LAWS), "speed")
    unit = keys.word("unit", ("rad/s", "rpm", "deg/s"), "rad/s")
    span = keys.numbers("range") if "range" in keys or "share" in kind else None
    if span is not None and not (len(span) == 2 and span[0] < span[1]):
        raise keys.error(f"is `{list(span)}`; allowed: two numbers, the lower one first", "range")
    coefficients = keys.numbers("coefficients") if kind == "polynomial" else ()
    law = Law(kind, (span[0], span[1]) if span else None, coefficients)
    columns = Columns(keys.place, names, UNITS[unit][0], "rad/s", optional=keys.flag("optional"))
    return Rotors(tuple(rotors), columns, law)
