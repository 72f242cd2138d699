"""Open-loop replays of recorded flights of a Crazyflie by this engine and by other simulators.

    python -m research run real_flights [--flights PATH...] [--train PATH...] [--map MAP]
                                        [--vehicle FOLDER...] [--no-peers] [--quick] [--out FOLDER]

Every model starts from the recorded state (motion capture; body rates by the gyroscope) and gets
the recorded motor commands, or the setpoints if it takes those. Errors are those of position,
attitude, velocity and body rates after 0.1, 0.2 and 0.5 s. All models have the same warm-up: their
rotors follow the commands of the 0.3 s before the start.

--flights: CSV files, or folders with them, as a map of `skybody import` describes (docs/imports.md;
--map, default: nanobench). --train: flights from which factors on the thrusts of the rotors are
taken; default: of each judged flight the others. A flight is never trained on itself.
--vehicle: a folder of `skybody identify`, given several times for several rows.
Others' models run in environments below .peers, which are made at the first run.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from skybody import InputError

from research.common.machine import facts
from research.common.options import Options
from research.common.pages import write_page
from research.common.places import ROOT, shown
from research.peers.environments import Skipped
from research.real.engine import PARTS, Shipped
from research.real.errors import QUANTITIES, Figure, errors, figures
from research.real.models import FOREIGN, Model, Still, predicted, trim
from research.real.real_flights_page import draw_errors, draw_flight, page
from research.real.recorded_flights import MOTORS, Reals, Recorded, files_of, read
from research.real.windows import HORIZONS, STRIDE, Windows, windows_of

PAGE = "real_flights"

SHARED = ROOT.parent / "shared/data/flights/nanobench"
PUBLISHED, TRIMMED, NO_MODEL = "published", "trimmed", ""  # forms
QUICK_STRIDE = 2.0  # between starts of windows [s]


@dataclass(frozen=True)
class Row:
    """The result of a model in one form."""

    model: Model
    form: str  # PUBLISHED, TRIMMED, or NO_MODEL
    windows: Sequence[Windows]
    states: Reals  # predicted, (windows, horizons, 13)

    @cached_property
    def errors(self) -> Reals:
        """(windows, horizons, quantities); a diverged prediction is infinitely wrong."""
        found = errors(self.states, recorded_at_horizons(self.windows))
        return np.nan_to_num(found, nan=np.inf)

    @cached_property
    def figures(self) -> dict[str, dict[str, dict[str, Figure]]]:
        """By quantity, horizon and `median` or `mean`."""
        ends = np.cumsum([len(windows.starts) for windows in self.windows])
        flights = np.split(self.errors, ends[:-1])
        found = {"median": figures(flights, np.median), "mean": figures(flights, np.mean)}
        return {
            quantity: {
                f"{horizon:g}": {
                    name: Figure(*(float(x) for x in of[:, h, q])) for name, of in found.items()
                }
                for h, horizon in enumerate(HORIZONS)
            }
            for q, quantity in enumerate(QUANTITIES)
        }


def recorded_at_horizons(windows: Sequence[Windows]) -> Reals:
    """Recorded states, (windows, horizons, 13)."""
    parts = [np.stack([w.states(horizon) for horizon in HORIZONS], axis=1) for w in windows]
    return np.concatenate(parts)


def results(model: Model, windows: Sequence[Windows], train: Sequence[Recorded]) -> list[Row]:
    """A model as published, and with trimmed rotors if it has rotors.

    Raises:
        Skipped: it is not available here.
    """
    own = [w for w in windows if model.takes(w.flight)]
    if not own:
        raise Skipped("no flight has its inputs")
    ones = np.ones(len(MOTORS))
    form = NO_MODEL if isinstance(model, Still) else PUBLISHED
    rows = [Row(model, form, own, predicted(model, own, [ones] * len(own)))]
    others = [[f for f in train if f.name != w.flight.name and model.takes(f)] for w in own]
    if model.trims and all(others):
        factors = [trim(model, flights) for flights in others]
        rows.append(Row(model, TRIMMED, own, predicted(model, own, factors)))
    return rows


def main() -> int:
    options = (
        Options(__doc__, __name__, "few windows, this engine alone")
        .add("--flights", type=Path, nargs="+", default=[SHARED], metavar="PATH")
        .add("--train", type=Path, nargs="+", default=[], metavar="PATH")
        .add("--map", default="nanobench", help="default: nanobench")
        .add("--vehicle", type=Path, action="append", default=[], metavar="FOLDER")
        .add("--no-peers", action="store_true", help="without other simulators")
        .given()
    )
    if options.flights == [SHARED] and not SHARED.exists():
        print(f"real_flights: {shown(SHARED)} is not there; give --flights", file=sys.stderr)
        return 2
    stride = QUICK_STRIDE if options.quick else STRIDE
    windows = [windows_of(read(file, options.map), stride) for file in files_of(options.flights)]
    judged = [w for w in windows if len(w.starts)]
    if not judged:
        raise InputError(f"{options.flights[0]}: no window of these flights is fit for a replay")
    train = [read(file, options.map) for file in files_of(options.train)] if options.train else []
    train = train or [w.flight for w in windows]
    models: list[Model] = [Still(), Shipped()]
    models += [] if options.quick or options.no_peers else list(FOREIGN)
    rows: list[Row] = []
    skipped: dict[str, str] = {}
    for model in models:
        print(f"  {model.title}", file=sys.stderr, flush=True)
        try:
            rows += results(model, judged, train)
        except Skipped as why:
            skipped[model.title] = str(why)
    parts = [results(Shipped(title, k), judged, train)[-1] for title, k in PARTS.items()]
    images = options.out / "images"
    draw_errors(rows, images / f"{PAGE}.png")
    draw_flight(rows, images / f"{PAGE}_paths.png")
    found = {"facts": facts(), "command": options.command, "skipped": skipped}
    found |= {"stride": stride, "is_shared": options.flights == [SHARED]}
    write_page(
        options.out, PAGE, page(rows, parts, windows, found), found | {"rows": data(rows, windows)}
    )
    return 0


def data(rows: Sequence[Row], windows: Sequence[Windows]) -> dict[str, object]:
    """The figures, and the numbers of windows."""
    return {
        "windows": {
            w.flight.name: {"used": len(w.starts), "rejected": dict(w.rejected)} for w in windows
        },
        "errors": [
            {
                "model": row.model.title,
                "form": row.form,
                "windows": len(row.states),
                "figures": {
                    quantity: {
                        horizon: {name: vars(f) for name, f in names.items()}
                        for horizon, names in horizons.items()
                    }
                    for quantity, horizons in row.figures.items()
                },
            }
            for row in rows
        ],
    }
