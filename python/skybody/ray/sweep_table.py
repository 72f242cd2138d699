"""Results of a sweep: a row per trial, a row over the seeds of each setting; text, CSV and JSON."""

from __future__ import annotations

import json
import statistics
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from skybody.ray.trials import Trial
from skybody.train import files
from skybody.train.run_folder import csv_bytes

FIGURES = (
    "steps",
    "wall_clock",
    "return_mean",
    "return_cv",
    "position_error_median",
    "success_share",
    "parameter_hash",
)


def rows_of(trials: Sequence[Trial], errors: dict[str, str]) -> list[dict[str, Any]]:
    """A row for each trial; `errors` by name of the folder."""
    rows = []
    for trial in trials:
        name = trial.folder.name
        state = "failed" if name in errors else "done" if trial.finished() else "unfinished"
        rows.append(
            {
                "scenario": trial.scenario,
                **dict(setting.split("=", 1) for setting in trial.settings),
                "seed": trial.seed,
                "state": state,
                **{figure: None for figure in FIGURES},
                **trial.result(),
                "folder": name,
            }
        )
    return rows


def over_seeds(rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Means over the seeds of each setting, the best return of a scenario first."""
    settings = _settings(rows)
    groups: dict[tuple[Any, ...], list[dict[str, Any]]] = {}
    for row in rows:
        groups.setdefault((row["scenario"], *(row[name] for name in settings)), []).append(row)
    made = []
    for (scenario, *values), members in groups.items():
        done = [row for row in members if row["return_mean"] is not None]
        made.append(
            {
                "scenario": scenario,
                **dict(zip(settings, values, strict=True)),
                "seeds": f"{len(done)}/{len(members)}",
                "return_mean": _mean(done, "return_mean"),
                "return_deviation": _deviation(done, "return_mean"),
                "position_error_median": _mean(done, "position_error_median"),
                "success_share": _mean(done, "success_share"),
                "wall_clock": _mean(done, "wall_clock"),
            }
        )
    order = list(dict.fromkeys(row["scenario"] for row in made))
    return sorted(
        made,
        key=lambda row: (order.index(row["scenario"]), -(row["return_mean"] or float("-inf"))),
    )


def write(out: Path, rows: Sequence[dict[str, Any]]) -> None:
    """Writes results.csv and results.json atomically."""
    columns = list(dict.fromkeys(name for row in rows for name in row))
    files.write_file(out / "results.csv", csv_bytes(columns, rows))
    content = {"trials": list(rows), "over_seeds": over_seeds(rows)}
    files.write_file(out / "results.json", (json.dumps(content, indent=1) + "\n").encode())


def text(rows: Sequence[dict[str, Any]]) -> str:
    """over_seeds() in columns, for a terminal; scenario files by their stem, as in run folders."""
    table = [{**row, "scenario": Path(row["scenario"]).stem} for row in over_seeds(rows)]
    head = list(table[0])
    cells = [head, *([_shown(row[name]) for name in head] for row in table)]
    widths = [max(len(line[k]) for line in cells) for k in range(len(head))]
    return "\n".join(
        "  ".join(cell.rjust(width) for cell, width in zip(line, widths, strict=True)).rstrip()
        for line in cells
    )


def _settings(rows: Sequence[dict[str, Any]]) -> list[str]:
    names = list(rows[0])
    return names[names.index("scenario") + 1 : names.index("seed")]


def _values(rows: Sequence[dict[str, Any]], name: str) -> list[float]:
    return [row[name] for row in rows if row[name] is not None]


def _mean(rows: Sequence[dict[str, Any]], name: str) -> float | None:
    values = _values(rows, name)
    return statistics.fmean(values) if values else None


def _deviation(rows: Sequence[dict[str, Any]], name: str) -> float | None:
    values = _values(rows, name)
    return statistics.stdev(values) if len(values) > 1 else None


def _shown(value: Any) -> str:
    if value is None:
        return "-"
    return f"{value:.4g}" if isinstance(value, float) else str(value)
