"""A recorded flight: one episode of a flight log (docs/flight-log.md)."""

from __future__ import annotations

import re
import tempfile
from functools import cached_property
from pathlib import Path

import h5py
import numpy as np
from numpy.typing import NDArray

from skybody import CompiledScenario, InputError

from .motion import Array as Array
from .motion import Motion, Overview
from .motion import rotation_of as rotation_of
from .rows import Rows

FORMAT = "skybody flight log"
VERSION = 1
RECORDING = "skybody-replay"  # format of `skybody hash --record`
# Keys of scenario files whose values name files, relative to the scenario's folder.
FILE_KEYS = re.compile(r"^(\s*(?:- )?(?:model|rotors|file|reference)): (\S+)$", re.MULTILINE)


def texts(values: object) -> list[str]:
    """Texts of an HDF5 attribute or dataset."""
    array = np.atleast_1d(np.asarray(values, dtype=object))
    return [v.decode() if isinstance(v, bytes) else str(v) for v in array]


class Flight(Motion):
    """One episode of a flight log. Rows are the states after the reset and after each action."""

    def __init__(
        self, log: str | Path, episode: int | None = None, *, has_bodies: bool = True
    ) -> None:
        """Opens a log.

        Args:
            log: flight.h5 of `skybody run`, or a folder that contains it.
            episode: its number, from 1; None: the first one.
            has_bodies: False: also opens a log of sensors alone (`skybody import`).

        Raises:
            InputError: the file is no flight log, or has no such episode.
        """
        self.path = log_file(log)
        self._file = _open(self.path)
        names = sorted(self._file["episodes"])
        name = f"{episode:04d}" if episode is not None else (names or [""])[0]
        if name not in names:
            there = f"it has {', '.join(str(int(n)) for n in names)}" if names else "it has none"
            wanted = 1 if episode is None else episode
            raise InputError(f"{self.path}: no episode {wanted}; {there}")
        self.episode = int(name)
        self._rows: dict[str, Rows] = {}
        self._group = self._file["episodes"][name]
        if has_bodies and "bodies" not in self._group:
            raise InputError(f"{self.path}: episode {self.episode} has no bodies to draw")

    # --- identity -------------------------------------------------------------------------------

    @property
    def scenario(self) -> str:
        """The scenario's name."""
        return str(self._file.attrs["scenario"])

    @property
    def episodes(self) -> list[int]:
        """Numbers of the log's episodes, from 1."""
        return sorted(int(name) for name in self._file["episodes"])

    @property
    def version(self) -> str:
        """Of the Skybody that wrote the log; `?`: not in the log."""
        versions = self._file.get("versions")
        return str(versions.attrs.get("skybody", "?")) if versions is not None else "?"

    @cached_property
    def compiled(self) -> CompiledScenario:
        """The flight's scenario.

        Raises:
            InputError: its files have changed or are gone.
        """
        return _compile(self._file, self.path)

    # --- data -----------------------------------------------------------------------------------

    @property
    def data(self) -> h5py.Group:
        """The episode's datasets, to be read by parts; docs/flight-log.md describes them."""
        return self._group

    @property
    def attributes(self) -> h5py.AttributeManager:
        """The log's attributes, such as `policy` and `seed`."""
        return self._file.attrs

    @cached_property
    def time(self) -> Array:
        """Of each row, since the reset [s]."""
        return np.asarray(self._group["time"][:], dtype=np.float64)

    @cached_property
    def body_names(self) -> list[str]:
        """ROBOT.LINK of each body."""
        return texts(self._group["bodies"].attrs["items"])

    @cached_property
    def bodies(self) -> Array:
        """Rows x bodies x 13: position (W) [m], quaternion w x y z (W from B), velocity (W) [m/s],
        angular velocity (B) [rad/s].
        """
        return np.asarray(self._group["bodies"][:], dtype=np.float64)

    @cached_property
    def rotor_names(self) -> list[str]:
        """ROBOT.ROTOR of each rotor; empty: none was recorded."""
        return (
            texts(self._group["rotor_speed"].attrs["columns"]) if self._has("rotor_speed") else []
        )

    @cached_property
    def rotor_speed(self) -> Array:
        """Rows x rotors [rad/s]."""
        if not self._has("rotor_speed"):
            return np.zeros((len(self.time), 0))
        return np.asarray(self._group["rotor_speed"][:], dtype=np.float64)

    @cached_property
    def goals(self) -> dict[str, Array]:
        """By the name of the body that has it: rows x 4, position (W) [m] and yaw [rad]."""
        return self.goals_in(np.arange(len(self.time)))

    @cached_property
    def goal_columns(self) -> dict[str, int]:
        """Index of the goal of each body that has one; of several the first counts."""
        if not self._has("goal"):
            return {}
        names = texts(self._group["goal"].attrs["items"])
        return {name: names.index(name) for name in names}

    def rows(self, name: str) -> Rows:
        """Rows of a dataset of numbers, read by parts; of width 0 if the log does not have it."""
        if name not in self._rows:
            known = self._group[name] if self._has(name) else np.zeros((len(self.time), 0))
            self._rows[name] = Rows(known)
        return self._rows[name]

    @cached_property
    def overview(self) -> Overview:
        """Rows of all of it, at most MOST."""
        return super().overview

    def turns(self, time: float) -> Array:
        """Angle of each rotor since the reset [rad], from the speeds of the overview."""
        seen, angles = self.overview, self._turns
        row = int(np.clip(np.searchsorted(seen.time, time) - 1, 0, len(angles) - 1))
        return np.asarray(angles[row] + seen.rotor_speed[row] * (time - seen.time[row]))

    @cached_property
    def _turns(self) -> Array:
        seen = self.overview
        steps = seen.rotor_speed[:-1] * np.diff(seen.time)[:, None]
        return np.concatenate([np.zeros((1, steps.shape[1])), np.cumsum(steps, axis=0)])

    @cached_property
    def touching(self) -> NDArray[np.bool_]:
        """Rows in which something touches the ground, an obstacle or another robot."""
        if not self._has("touching"):
            return np.zeros(len(self.time), bool)
        return np.asarray(self._group["touching"][:] != 0)

    @cached_property
    def events(self) -> list[tuple[float, str]]:
        """Times [s] and texts, such as `terminated` or `drawn: PATH = VALUE`."""
        rows = self._group["events"][:] if self._has("events") else []
        return [(float(row["time"]), texts(row["text"])[0]) for row in rows]

    @cached_property
    def drawn(self) -> dict[str, float]:
        """Values of the episode's parameters by path."""
        if "params" not in self._file or not self._has("params"):
            return {}
        paths = texts(self._file["params"]["paths"][:])
        return dict(zip(paths, self._group["params"][:].tolist(), strict=True))

    def series(self, name: str) -> tuple[Array, str]:
        """A value of each row by its name, and its unit.

        Args:
            name: a column of info, sensors, action, command, observation, q or u, or `reward`.

        Raises:
            InputError: there is no such column.
        """
        known = ["reward"]
        if name == "reward":
            return np.asarray(self._group["reward"][:]), ""
        for dataset in ("info", "sensors", "command", "action", "observation", "q", "u"):
            columns = self.columns(dataset)
            names = [column for column, _ in columns]
            if name in names:
                k = names.index(name)
                return np.asarray(self._group[dataset][:, k], dtype=np.float64), columns[k][1]
            known += names
        raise InputError(
            f"{self.path}: no value `{name}`; there are: {', '.join(dict.fromkeys(known))}"
        )

    def columns(self, dataset: str) -> list[tuple[str, str]]:
        """Names and units of a dataset's columns; none if the log does not have it."""
        if not self._has(dataset):
            return []
        attributes = self._group[dataset].attrs
        return list(zip(texts(attributes["columns"]), texts(attributes["units"]), strict=True))

    # --- notebooks ------------------------------------------------------------------------------

    def _repr_html_(self) -> str:
        """The flight as Jupyter shows it."""
        from .embed import html_of

        return html_of(self)

    def close(self) -> None:
        """Closes the file; what was read stays."""
        self._file.close()

    def _has(self, dataset: str) -> bool:
        return dataset in self._group


def open_flight(argument: str, *, has_bodies: bool = True) -> Flight:
    """Opens `LOG` or `LOG:EPISODE` of a command line; as Flight(), also for errors."""
    path, episode = log_and_episode(argument)
    return Flight(path, episode, has_bodies=has_bodies)


def log_file(log: str | Path) -> Path:
    """The file of a log that is given as a file, or as a folder with flight.h5."""
    return Path(log) / "flight.h5" if Path(log).is_dir() else Path(log)


def log_and_episode(argument: str) -> tuple[str, int | None]:
    """The parts of `LOG:EPISODE` of a command line; None: there is no number."""
    path, _, number = argument.rpartition(":")
    return (path, int(number)) if path and number.isdecimal() else (argument, None)


def _open(path: Path) -> h5py.File:
    try:
        log = h5py.File(path)
    except FileNotFoundError:
        raise InputError(f"{path}: no such file; `skybody run` writes flight.h5") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read as a flight log ({error})") from None
    (found,) = texts(log.attrs.get("format", ""))
    if found == RECORDING:
        raise InputError(
            f"{path}: a recording of many environments has no flight; `skybody run` writes "
            "flight.h5"
        )
    if not found.startswith(FORMAT) or "episodes" not in log:
        raise InputError(f"{path}: is no flight log; `skybody run` writes flight.h5")
    if found != f"{FORMAT} {VERSION}":
        version = found.removeprefix(FORMAT).strip() or "without a number"
        raise InputError(
            f"{path}: is a flight log of version {version}; allowed: {VERSION}; read it with the "
            "Skybody that wrote it"
        )
    return log


def _compile(log: h5py.File, path: Path) -> CompiledScenario:
    """The scenario's file if it still is the one that was flown, else the log's own text."""
    file, wanted = Path(str(log.attrs["scenario_file"])), str(log.attrs["scenario_hash"])
    for scenario in (file, str(log.attrs["scenario"])):
        try:
            compiled = CompiledScenario(scenario)
        except InputError:
            continue
        if f"{compiled.scenario_hash:016x}" == wanted:
            return compiled
    text = FILE_KEYS.sub(
        lambda found: _absolute(found, file.parent), str(log.attrs["scenario_text"])
    )
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / file.name
        copy.write_text(text)
        try:
            return CompiledScenario(copy)
        except InputError as error:
            raise InputError(f"{path}: its scenario cannot be loaded any more: {error}") from None


def _absolute(found: re.Match[str], folder: Path) -> str:
    file = folder / found.group(2).strip("\"'")
    return f"{found.group(1)}: {file if file.exists() else found.group(2)}"
