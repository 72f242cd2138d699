"""Table and picture of hover_training.py."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import EngFormatter, FormatStrFormatter, LogLocator, NullFormatter
from numpy.typing import NDArray
from training_runs import LEARNER_COLORS, machine_line, versions_line

STYLES = ("-", "--", ":", "-.")  # by seed

HEAD = """\
# Learning to hover

`hover_learn` with each learner and the shipped hyper-parameters, those of
[`scenarios/training/hover_learn.yaml`](../../scenarios/training/hover_learn.yaml), by

    {command}

on {machine}, one run after another.

![Return and position error over steps and wall-clock time](images/hover_training.png)"""

LIMITS = """\
Limits: median below {error:g} m, at least {success:.0f} % of the episodes without failure, {times}
of wall clock. Wall clock is that of the whole command, from its start to its exit. The error is the
distance from the target, averaged over an episode's last second, over {episodes} episodes under the
deterministic policy, failed ones included; a failure is an episode that terminates or faults."""

FLIGHT = """\
## The policy in flight

The {learner} policy of seed {seed}, flown from C++ by `skybody run hover_learn --policy RUN`:

![Three episodes under the trained policy](images/hover_policy.png)

{table}

Its actions differ from those that PyTorch computes (float32, from the same checkpoint) on the
{rows:,} recorded observations by at most {difference:.1e}; allowed is {tolerance:.0e}."""


def markdown(content: dict[str, Any]) -> str:
    """The whole report."""
    head = HEAD.format(command=content["command"], machine=machine_line(content["machine"]))
    return "\n\n".join([head, _table(content), _limits(content), _flight(content), _hyper(content)])


def _table(content: dict[str, Any]) -> str:
    rows = [
        "| learner | seed | steps | wall clock [s] | median error [m] | 90 % quantile [m] "
        "| failures | within limits |",
        "| --- | ---: | ---: | ---: | ---: | ---: | ---: | --- |",
    ]
    for run in content["runs"]:
        within = "yes" if run["within_limits"] else "no"
        rows.append(
            f"| {run['learner']} | {run['seed']} | {run['steps']:,} | {run['wall_clock']:.1f} "
            f"| {run['median_error']:.4f} | {run['error_90_percent']:.4f} "
            f"| {run['failures']} of {run['episodes']} | {within} |"
        )
    return "\n".join(rows)


def _limits(content: dict[str, Any]) -> str:
    limits = content["limits"]
    times = ", ".join(f"{seconds:g} s ({name})" for name, seconds in limits["seconds"].items())
    text = LIMITS.format(
        error=limits["median_error"],
        success=100 * limits["success_share"],
        times=times,
        episodes=content["runs"][0]["episodes"],
    )
    overrides = "".join(f", `{override}`" for override in content["hover"]["overrides"])
    last = content["hover"]["curve"][-1]
    return (
        f"{text}\n\nGrey in the picture: {content['hover']['learner']} on the paper's `hover`, "
        f"with a policy at 1 kHz{overrides}, from\n"
        "[training_reproducibility_fast-ppo.md](training_reproducibility_fast-ppo.md): "
        f"median error {last['position_error_median']:.2f} m after "
        f"{last['steps']:,} steps."
    )


def _flight(content: dict[str, Any]) -> str:
    flight = content["flight"]
    return FLIGHT.format(
        learner=flight["learner"],
        seed=flight["seed"],
        table="\n".join(f"    {line}".rstrip() for line in flight["table"].splitlines()),
        rows=flight["rows"],
        difference=flight["largest_difference"],
        tolerance=flight["tolerance"],
    )


def _hyper(content: dict[str, Any]) -> str:
    lines = ["## Hyper-parameters and versions", ""]
    for learner, config in content["config"].items():
        hyper = ", ".join(f"{name} {value}" for name, value in config["hyper"].items())
        lines += [f"{learner}: {hyper}.", ""]
    config = next(iter(content["config"].values()))
    lines.append(f"Scenario hash {config['scenario_hash']}.")
    lines.append(f"Versions: {versions_line(list(content['config'].values()))}.")
    return "\n".join(lines) + "\n"


# --- the picture --------------------------------------------------------------------------------


def draw(content: dict[str, Any], out: Path) -> None:
    """Return above position error, over steps on the left and wall-clock time on the right."""
    figure = Figure(figsize=(10, 6.8), layout="constrained")
    canvas = FigureCanvasAgg(figure)
    axes = figure.subplots(2, 2, sharex="col", sharey="row")
    for column, x in enumerate(("steps", "wall_clock")):
        _draw_column(axes[:, column], content, x)
    _dress(axes, content)
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=4, fontsize=8)
    canvas.print_png(out)


def _draw_column(axes: NDArray[Any], content: dict[str, Any], x: str) -> None:
    seeds = sorted({run["seed"] for run in content["runs"]})
    for run in content["runs"]:
        style = STYLES[seeds.index(run["seed"]) % len(STYLES)]
        label = f"{run['learner']}, seed {run['seed']}"
        _draw_curve(axes, run, x, LEARNER_COLORS[run["learner"]], style, label)
    hover = content["hover"]
    label = f"{hover['learner']} on hover (1 kHz policy)"
    _draw_curve(axes, hover, x, "0.5", "-", label)


def _draw_curve(
    axes: NDArray[Any], run: dict[str, Any], x: str, color: str, style: str, label: str
) -> None:
    curve, horizon = run["curve"], run["horizon"]
    where = [point[x] for point in curve]
    look = {"color": color, "linestyle": style, "marker": "o", "markersize": 2.5, "linewidth": 1.2}
    axes[0].plot(where, [p["return_mean"] / horizon for p in curve], label=label, **look)
    axes[1].plot(where, [p["position_error_median"] for p in curve], **look)


def _dress(axes: NDArray[Any], content: dict[str, Any]) -> None:
    limits = content["limits"]
    for axis in axes.flat:
        axis.grid(alpha=0.3)
    for axis in axes[1]:
        axis.set_yscale("log")
        axis.axhline(limits["median_error"], color="0.2", linewidth=0.8, linestyle=(0, (6, 3)))
        axis.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axis.yaxis.set_minor_formatter(NullFormatter())
        axis.yaxis.set_major_formatter(FormatStrFormatter("%g"))
    axes[0, 0].set_ylabel("return / steps of the horizon")
    axes[1, 0].set_ylabel("position error [m]")
    axes[1, 0].set_title("median over episodes, last second; dashed: limit", fontsize=9)
    axes[0, 0].set_title("mean over evaluation episodes, each scenario's own reward", fontsize=9)
    axes[1, 0].set_xlabel("environment steps")
    axes[1, 0].xaxis.set_major_formatter(EngFormatter(sep=""))
    axes[1, 1].set_xscale("log")
    axes[1, 1].xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axes[1, 1].xaxis.set_minor_formatter(NullFormatter())
    axes[1, 1].xaxis.set_major_formatter(FormatStrFormatter("%g"))
    axes[1, 1].set_xlabel("wall-clock time of training [s]")
    for learner, seconds in limits["seconds"].items():
        _mark_time(axes[:, 1], learner, seconds)


def _mark_time(axes: NDArray[Any], learner: str, seconds: float) -> None:
    axis: Axes
    for axis in axes:
        axis.axvline(seconds, color=LEARNER_COLORS[learner], linewidth=0.8, linestyle=(0, (6, 3)))
    axes[0].annotate(
        f" limit, {learner}",
        (seconds, 0.02),
        xycoords=("data", "axes fraction"),
        fontsize=7,
        rotation=90,
        ha="right",
        color=LEARNER_COLORS[learner],
    )
