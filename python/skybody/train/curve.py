"""Learning curves as a picture: return and position error against steps and wall-clock time.

python -m skybody.train.curve RUN [RUN ...] [--out FILE]
"""

from __future__ import annotations

import argparse
import io
import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from skybody.program import run_program
from skybody.train import files
from skybody.train.requirements import demand_packages
from skybody.train.run_folder import read_table

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Columns = dict[str, NDArray[np.float64]]


def draw_curve(runs: list[Path], out: Path) -> None:
    """Draws the runs into one PNG; a single run's evaluations get their deviation as a band."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.ticker import EngFormatter, FormatStrFormatter, LogLocator, NullFormatter

    figure = Figure(figsize=(10, 6.5), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(2, 2, sharex="col", sharey="row")
    for number, run in enumerate(runs):
        _draw_run(axes, run, f"C{number}", several=len(runs) > 1)
    for row, label in enumerate(("return per episode", "position error [m]")):
        axes[row, 0].set_ylabel(label)
    for column, label in enumerate(("environment steps", "wall-clock time [s]")):
        axes[1, column].set_xlabel(label)
    for axis in axes.flat:
        axis.grid(alpha=0.3)
    axes[0, 0].set_title("mean of all episodes that ended", fontsize=9)
    axes[1, 0].set_title("training: mean of all steps; evaluation: last second, median", fontsize=9)
    axes[1, 0].set_yscale("log")
    for axis in (axes[1, 0].yaxis, axes[1, 1].yaxis):
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axis.set_minor_formatter(NullFormatter())
        axis.set_major_formatter(FormatStrFormatter("%g"))
    axes[1, 0].xaxis.set_major_formatter(EngFormatter(sep=""))
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=min(4, len(labels)))
    picture = io.BytesIO()
    figure.savefig(picture, format="png")
    files.write_file(out, picture.getvalue())


def _draw_run(axes: NDArray[np.object_], run: Path, color: str, several: bool) -> None:
    training, evaluation = _columns(run / "progress.csv"), _columns(run / "evaluation.csv")
    prefix = f"{run.name}: " if several else ""
    for column, x in enumerate(("steps", "wall_clock")):
        upper, lower = axes[0, column], axes[1, column]
        _line(upper, training, x, "return_mean", color, f"{prefix}training (with exploration)")
        _line(lower, training, x, "position_error", color, None)
        if not evaluation:
            continue
        mean, deviation = evaluation["return_mean"], evaluation["return_std"]
        style = {"color": color if several else "C1", "marker": "o", "markersize": 4}
        upper.plot(evaluation[x], mean, label=f"{prefix}evaluation, mean", **style)
        median = evaluation["position_error_median"]
        if np.isfinite(median).any():
            lower.plot(evaluation[x], median, **style)
        if not several:
            upper.fill_between(
                evaluation[x],
                mean - deviation,
                mean + deviation,
                color="C1",
                alpha=0.2,
                label="one standard deviation of its episodes",
            )


def _line(axis: Axes, table: Columns, x: str, y: str, color: str, label: str | None) -> None:
    if table and np.isfinite(table[y]).any():
        good = np.isfinite(table[y])
        axis.plot(table[x][good], table[y][good], color=color, alpha=0.6, linewidth=1, label=label)


def _columns(path: Path) -> Columns:
    rows = read_table(path)
    names = [name for name in (rows[0] if rows else {}) if name != "parameter_hash"]
    return {name: np.array([float(row[name] or math.nan) for row in rows]) for name in names}


def main(arguments: list[str] | None = None) -> int:
    """The command line."""
    parser = argparse.ArgumentParser(
        prog="python -m skybody.train.curve", description=(__doc__ or "").partition("\n")[0]
    )
    parser.add_argument("run", type=Path, nargs="+", help="folders that skybody.train wrote")
    parser.add_argument("--out", type=Path, default=Path("curve.png"), help="default: curve.png")
    options = parser.parse_args(arguments)
    try:
        demand_packages(["matplotlib"])
        for run in options.run:
            if not run.is_dir():
                raise ValueError(f"{run}: there is no such folder")
            if not read_table(run / "progress.csv"):
                raise ValueError(f"{run / 'progress.csv'} has no rows")
        draw_curve(options.run, options.out)
    except (OSError, ValueError) as error:
        print(f"curve: {files.explain(error)}", file=sys.stderr)
        return 2
    print(options.out)
    return 0


if __name__ == "__main__":
    run_program(main)
