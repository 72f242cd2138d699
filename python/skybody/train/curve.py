"""Learning curves as a picture: return and position error against steps and wall-clock time.

python -P -m skybody.train.curve RUN [RUN ...] [--out FILE]
"""

from __future__ import annotations

import io
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from skybody.command_line import CommandLine, report_error
from skybody.legend import legend_above
from skybody.program import run_program
from skybody.train import files
from skybody.train.requirements import demand_packages
from skybody.train.run_folder import read_table

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Columns = dict[str, NDArray[np.float64]]
ABSCISSAE = ("steps", "wall_clock")


def draw_curve(runs: list[Path], out: Path) -> None:
    """Draws the runs into one PNG; a single run's evaluations get their deviation as a band.

    If there is no position error, as in races, it draws only the returns.
    """
    from matplotlib import style

    with style.context("default"):  # independent of a matplotlibrc in the working folder
        picture = _picture_of(runs)
    files.write_file(out, picture)


def _picture_of(runs: list[Path]) -> bytes:
    """The bytes of the PNG."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure
    from matplotlib.ticker import EngFormatter

    tables = [(_columns(run / "progress.csv"), _columns(run / "evaluation.csv")) for run in runs]
    rows = 2 if any(_has_error(*pair) for pair in tables) else 1
    figure = Figure(figsize=(10, 0.5 + 3.0 * rows), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(rows, 2, sharex="col", sharey="row", squeeze=False)
    for number, (run, (training, evaluation)) in enumerate(zip(runs, tables, strict=True)):
        several = len(runs) > 1
        _draw_returns(axes[0], training, evaluation, run.name if several else "", f"C{number}")
        if rows > 1:
            _draw_errors(axes[1], training, evaluation, f"C{number}", several)
    axes[0, 0].set_ylabel("return per episode")
    axes[0, 0].set_title("mean of all episodes that ended", fontsize=9)
    for column, label in enumerate(("environment steps", "wall-clock time [s]")):
        axes[-1, column].set_xlabel(label)
    for axis in axes.flat:
        axis.grid(alpha=0.3)
    if rows > 1:
        _prepare_errors(axes[1])
    axes[-1, 0].xaxis.set_major_formatter(EngFormatter(sep=""))
    handles, labels = axes[0, 0].get_legend_handles_labels()
    legend_above(figure, handles, labels, min(4, len(labels)))
    picture = io.BytesIO()
    figure.savefig(picture, format="png")
    return picture.getvalue()


def _has_error(training: Columns, evaluation: Columns) -> bool:
    """Whether the task reports a position error."""
    return _is_known(training, "position_error") or _is_known(evaluation, "position_error_median")


def _is_known(table: Columns, name: str) -> bool:
    return bool(table) and bool(np.isfinite(table[name]).any())


def _draw_returns(
    axes: NDArray[np.object_], training: Columns, evaluation: Columns, name: str, color: str
) -> None:
    """`name`: of one run among several; empty for a single run, which also gets its deviations."""
    prefix = f"{name}: " if name else ""
    for axis, x in zip(axes, ABSCISSAE, strict=True):
        _line(axis, training, x, "return_mean", color, f"{prefix}training (with exploration)")
        if not evaluation:
            continue
        mean, deviation = evaluation["return_mean"], evaluation["return_std"]
        axis.plot(evaluation[x], mean, label=f"{prefix}evaluation, mean", **_dots(color, name))
        if not name:
            axis.fill_between(
                evaluation[x],
                mean - deviation,
                mean + deviation,
                color="C1",
                alpha=0.2,
                label="one standard deviation of its episodes",
            )


def _draw_errors(
    axes: NDArray[np.object_], training: Columns, evaluation: Columns, color: str, several: bool
) -> None:
    for axis, x in zip(axes, ABSCISSAE, strict=True):
        _line(axis, training, x, "position_error", color, None)
        if _is_known(evaluation, "position_error_median"):
            median = evaluation["position_error_median"]
            axis.plot(evaluation[x], median, **_dots(color, several))


def _dots(color: str, several: object) -> dict[str, Any]:
    return {"color": color if several else "C1", "marker": "o", "markersize": 4}


def _prepare_errors(axes: NDArray[np.object_]) -> None:
    from matplotlib.ticker import FormatStrFormatter, LogLocator, NullFormatter

    axes[0].set_ylabel("position error [m]")
    axes[0].set_title("training: mean of all steps; evaluation: last second, median", fontsize=9)
    axes[0].set_yscale("log")
    for axis in axes:
        axis.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axis.yaxis.set_minor_formatter(NullFormatter())
        axis.yaxis.set_major_formatter(FormatStrFormatter("%g"))


def _line(axis: Axes, table: Columns, x: str, y: str, color: str, label: str | None) -> None:
    if _is_known(table, y):
        good = np.isfinite(table[y])
        axis.plot(table[x][good], table[y][good], color=color, alpha=0.6, linewidth=1, label=label)


def _columns(path: Path) -> Columns:
    rows = read_table(path)
    names = [name for name in (rows[0] if rows else {}) if name != "parameter_hash"]
    return {name: np.array([float(row[name] or math.nan) for row in rows]) for name in names}


def main(arguments: list[str] | None = None) -> int:
    """The command line."""
    parser = CommandLine(
        prog="python -P -m skybody.train.curve", description=(__doc__ or "").partition("\n")[0]
    )
    parser.add_argument("run", type=Path, nargs="+", help="run folders of skybody.train")
    parser.add_argument(
        "--out", type=Path, default=Path("curve.png"), help="picture; default: curve.png"
    )
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
        return report_error(files.explain(error))
    print(options.out)
    return 0


if __name__ == "__main__":
    run_program(main)
