"""The folder of one training run: its configuration and its tables."""

from __future__ import annotations

import csv
import dataclasses
import io
import json
import shlex
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, get_type_hints

from skybody._native import CompiledScenario, InputError
from skybody.train import files
from skybody.train.algorithms import algorithm_of
from skybody.train.checkpoint import checkpoint_folders
from skybody.train.evaluation_file import COLUMNS, read_evaluation
from skybody.train.hyperparameters import Hyperparameters, UsageError, from_dict
from skybody.train.json_file import read_json, wrong_kinds

_FIXED = ("algorithm", "seed", "scenario_hash")  # determine bits, with the hyper-parameters


@dataclass(frozen=True)
class Config:
    """All settings of a run: those that its result depends on, and the others."""

    scenario: str  # as given: a name or a file
    overrides: list[str]  # of the scenario, PATH=VALUE
    plugin_path: list[str]  # all plugin folders ever used, for messages; not searched
    algorithm: str
    seed: int
    total_steps: int
    checkpoint_every: int  # environment steps
    threads: int  # of environments and C++ learners; 0: one per processor; changes no bits
    eval_episodes: int  # per checkpoint; 0: none
    eval_seed: int
    hyper: Hyperparameters
    scenario_name: str = ""
    scenario_hash: str = ""  # 16 hex digits
    scenario_text: str = ""  # resolved YAML
    versions: dict[str, str] = dataclasses.field(default_factory=dict)
    searched: list[str] = dataclasses.field(default_factory=list)  # given now; not written

    def write(self, run: Path) -> None:
        """Writes config.json."""
        values = dataclasses.asdict(self)
        del values["searched"]
        text = json.dumps(values, indent=2)
        files.write_file(run / "config.json", (text + "\n").encode())

    def check_trained_with(self, meta: dict[str, Any], checkpoint: Path) -> None:
        """Raises UsageError if a checkpoint's stamps differ in a value that changes bits."""
        pairs = {name: (meta[name], getattr(self, name)) for name in _FIXED}
        now = json.loads(json.dumps(vars(self.hyper)))  # tuples become lists, as in the file
        for name in now | meta["hyper"]:
            pairs[f"hyper.{name}"] = (meta["hyper"].get(name), now.get(name))
        changed = [f"{k} ({was} then, {is_} now)" for k, (was, is_) in pairs.items() if was != is_]
        if changed:
            raise UsageError(
                f"--resume: config.json is not what {checkpoint / 'meta.json'} was trained with: "
                f"{', '.join(changed)}; put the old values back, or begin a new run in another "
                "folder"
            )

    @staticmethod
    def read(run: Path) -> Config:
        """Reads config.json. Raises UsageError if there is none."""
        path = run / "config.json"
        if not path.exists():
            raise UsageError(f"--resume: {path} does not exist, so there is no run to go on with")
        try:
            values = read_json(path)
            if not isinstance(values, dict):
                raise ValueError("no map")
            kinds = {**get_type_hints(Config), "hyper": dict[str, Any]}
            del kinds["searched"]
            if wrong := wrong_kinds(values, kinds):
                raise ValueError(", ".join(wrong))
            defaults = algorithm_of(values["algorithm"]).defaults()
            hyper = from_dict(values["hyper"], defaults)
            return Config(**{**values, "hyper": hyper, "searched": []})
        except (ValueError, TypeError) as error:
            raise UsageError(
                f"{path} is damaged or of another version ({error}): the run cannot go on"
            ) from error


def is_unbegun(run: Path) -> bool:
    """Whether a folder is empty, or left by a run that was killed before writing config.json."""
    left = {path.name: path for path in run.iterdir()}
    if not left:
        return True
    ours = (files.LOCK, "checkpoints", "progress.csv")
    begun = (".config.json.", ".progress.csv.", "events.out.tfevents.")
    return (
        files.LOCK in left
        and all(name in ours or name.startswith(begun) for name in left)
        and all(path.name.startswith(".partial-") for path in run.glob("checkpoints/*"))
        and not read_table(run / "progress.csv")
    )


def load_recorded(
    record: Path, scenario: str, overrides: list[str], plugin_path: list[str]
) -> CompiledScenario:
    """Loads the scenario named in a file of a run.

    Raises:
        UsageError: it cannot be loaded. The message omits the reasons, because they quote files,
            and a run folder from elsewhere may name any file.
    """
    try:
        return CompiledScenario(scenario, overrides, plugin_path)
    except InputError as error:
        words = ["skybody", "check", scenario]
        words += [word for override in overrides for word in ("--set", override)]
        raise UsageError(
            f"{record}: the scenario cannot be loaded; `{shlex.join(words)}` says why"
        ) from error


class ProgressTable:
    """progress.csv: one row per rollout, with the columns of the first row."""

    def __init__(self, run: Path, resumed_at: int) -> None:
        """Drops rows of rollouts after `resumed_at` steps: they are repeated."""
        self._path = run / "progress.csv"
        rows = [row for row in read_table(self._path) if int(row["steps"]) <= resumed_at]
        self._columns: list[str] = list(rows[0]) if rows else []
        files.write_file(self._path, csv_bytes(self._columns, rows, header=bool(rows)))

    def append(self, row: dict[str, Any]) -> None:
        """Adds a row."""
        header = not self._columns
        self._columns = self._columns or list(row)
        with files.naming(self._path), self._path.open("ab") as file:
            file.write(csv_bytes(self._columns, [row], header))


def write_evaluations(run: Path) -> list[dict[str, Any]]:
    """Writes evaluation.csv from the checkpoints' evaluations; returns its rows."""
    found = [read_evaluation(folder) for folder in checkpoint_folders(run)]
    rows = [row for row in found if row is not None]
    if rows:
        files.write_file(run / "evaluation.csv", csv_bytes(list(COLUMNS), rows))
    return rows


def read_table(path: Path) -> list[dict[str, str]]:
    """Rows of a CSV file by column; a truncated last row is left out.

    Raises ValueError, which names the file, if a row does not have the form that training writes.
    """
    if not path.exists():
        return []
    try:
        whole = files.read_file(path).decode().rpartition("\n")[0]
        reader, rows = csv.DictReader(io.StringIO(whole)), []
        for row in reader:
            _check_row(reader.line_num, row)
            rows.append(row)
    except (ValueError, csv.Error) as error:
        raise ValueError(
            f"{path} is damaged ({error}): mend it, or remove it, which loses its rows only"
        ) from error
    return rows


def _check_row(number: int, row: dict[str, str]) -> None:
    """Raises ValueError if a row has too few or too many values, or values that are not numbers."""
    if None in row or None in row.values() or not row.get("steps", "").isdecimal():
        raise ValueError(f"line {number} is no row of a table with a column `steps`")
    for name, text in row.items():
        if name != "parameter_hash" and text:
            try:
                float(text)
            except ValueError:
                raise ValueError(f"line {number}: `{name}` is `{text}`, not a number") from None


def csv_bytes(columns: Sequence[str], rows: Iterable[dict[str, Any]], header: bool = True) -> bytes:
    """A table as CSV; keys without a column are left out."""
    buffer = io.StringIO()
    writer = csv.DictWriter(buffer, columns, extrasaction="ignore", lineterminator="\n")
    if header:
        writer.writeheader()
    writer.writerows(rows)
    return buffer.getvalue().encode()
