"""The legend of a whole figure."""

from __future__ import annotations

from typing import Any

HEIGHT = 0.08  # of the figure, where the layout does not measure the legend


def legend_above(figure: Any, handles: Any, labels: list[str], columns: int, **style: Any) -> None:
    """Draws a legend above all panels of a figure with the layout `constrained`.

    Matplotlib leaves room for it since 3.7; Debian 12 has 3.6.
    """
    style["ncols"] = columns
    try:
        figure.legend(handles, labels, loc="outside upper center", **style)
    except ValueError:
        figure.legend(handles, labels, loc="upper center", **style)
        figure.get_layout_engine().set(rect=(0.0, 0.0, 1.0, 1.0 - HEIGHT))
