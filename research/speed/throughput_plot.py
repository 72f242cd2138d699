"""Figures 7 and 8 of the paper: throughput above processor use, over a number."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullLocator
from numpy.typing import NDArray

from research.common.plots import panels
from research.speed import paper_tables


def two_panels(title: str, x: str, ticks: Sequence[int], base: int) -> tuple[Figure, NDArray[Any]]:
    """A figure, its axes of rates and of use.

    Args:
        title: of the picture; the paper's computers are appended.
        base: of the logarithmic axis x.
    """
    figure, axes = panels(2, 1, (9, 9), sharex=True, height_ratios=(3, 2))
    rates, use = axes.flat
    rates.set_title(f"{title}\n{paper_tables.machines_line()}", fontsize=9)
    rates.set(ylabel="(a) environment steps a second", yscale="log")
    rates.set_xscale("log", base=base)
    use.set(ylabel="(b) CPU use [%]", ylim=(0, 105), xlabel=x, xticks=ticks)
    use.xaxis.set_minor_locator(NullLocator())
    use.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.0f}"))
    return figure, axes.flat


def curve(
    axes: Sequence[Any], xs: Sequence[int], means: Sequence[dict[str, Any]], label: str, **look: Any
) -> None:
    """Rates with their intervals, and processor use where it was measured."""
    look |= {"marker": "o", "markersize": 3.5}
    spread = [m["interval"] for m in means]
    axes[0].errorbar(xs, [m["rate"] for m in means], spread, capsize=3, label=label, **look)
    if "cpu_use" in means[0]:
        axes[1].plot(xs, [100.0 * m["cpu_use"] for m in means], **look)
