"""Open-loop replays of recorded flights of a Crazyflie by this engine and by other simulators.

    python -m research run real_flights [--flights PATH...] [--train PATH...] [--map MAP]
                                        [--vehicle FOLDER...]... [--no-peers] [--quick] [--out DIR]

Every model starts from the recorded state (motion capture; body rates by the gyroscope) and gets
the recorded motor commands, or the setpoints if it takes those. Errors are those of position,
attitude, velocity and body rates after 0.1, 0.2 and 0.5 s. All models have the same warm-up: their
rotors follow the commands of the 0.3 s before the start.

--flights: CSV files, or folders with them, as a map of `skybody import` describes (docs/imports.md;
--map, default: nanobench). --train: flights from which factors on the thrusts of the rotors are
taken; default: of each judged flight the others. A flight is never trained on itself.
--vehicle: folders of `skybody identify`; each flight is judged by the first fit that did not have
it, so that four folders that leave out one flight each judge all four. Given again for another row.
Such a folder, with A, B and C of four flights:

    skybody identify A B C --map nanobench --model crazyflie --out flights/identified/without_D
Others' models run in environments below .peers, which are made at the first run.
"""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from skybody import InputError

from research.common.machine import facts
from research.common.options import Options
from research.common.pages import write_page
from research.common.places import ROOT, shown
from research.peers.environments import Skipped
from research.real.clocks import aligned, offset
from research.real.engine import PARTS, Shipped
from research.real.errors import QUANTITIES, Figure, errors, figures
from research.real.identified import Identified
from research.real.log_detail import damped
from research.real.models import FOREIGN, Model, Still, predicted, trim
from research.real.real_flights_page import draw_errors, draw_flight, page
from research.real.recorded_flights import (
    MOTORS,
    Reals,
    Recorded,
    Stretch,
    files_of,
    read,
    read_stretch,
)
from research.real.windows import HORIZONS, STRIDE, Windows, windows_of

PAGE = "real_flights"

SHARED = ROOT.parent / "shared/data/flights/nanobench"
# Forms of rows.
PUBLISHED, TRIMMED, DAMPED = "published", "trimmed", "trimmed, damped"
FITTED, NO_MODEL = "identified", ""
TURNS = SHARED.parent / "arplab"
# Logs and their excited parts, by their own clocks [s].
STRETCHES = (
    ("log10.usd.gz", 35.0, 65.0),
    ("log15.usd.gz", 55.0, 90.0),
    ("log16.usd.gz", 32.0, 38.0),
    ("log16.usd.gz", 45.0, 49.0),
)
QUICK_STRIDE = 2.0  # between starts of windows [s]


@dataclass(frozen=True)
class Row:
    """The result of a model in one form."""

    model: Model
    form: str
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


def results(
    model: Model, windows: Sequence[Windows], train: Sequence[Recorded], detail: float | None
) -> list[Row]:
    """A model as published; if it has rotors trimmed, and with damped commands.

    Args:
        detail: of damped commands; None: there is no such row.

    Raises:
        Skipped: it is not available here.
    """
    own = [w for w in windows if model.takes(w.flight)]
    if not own:
        raise Skipped("no flight has its inputs")
    form = NO_MODEL if isinstance(model, Still) else PUBLISHED
    ones = np.ones(len(MOTORS))
    rows = [Row(model, form, own, predicted(model, own, [ones] * len(own)))]
    if model.trims:
        rows += trimmed(model, TRIMMED, own, train)
    if model.trims and model.is_damped and detail is not None:
        own = [replace(w, flight=damped(w.flight, detail)) for w in own]
        rows += trimmed(model, DAMPED, own, [damped(f, detail) for f in train])
    return rows


def trimmed(
    model: Model, form: str, windows: Sequence[Windows], train: Sequence[Recorded]
) -> list[Row]:
    """A model with factors from other flights; none if there is no other flight."""
    others = [[f for f in train if f.name != w.flight.name and model.takes(f)] for w in windows]
    if not all(others):
        return []
    factors = [trim(model, flights) for flights in others]
    return [Row(model, form, windows, predicted(model, windows, factors))]


def identified(folders: Sequence[Path], windows: Sequence[Windows]) -> Row:
    """A vehicle that was identified several times: each flight by a fit that did not have it.

    Raises:
        Skipped: all flights were parts of the fits.
    """
    models = [Identified(folder) for folder in folders]
    chosen = [(w, m) for w in windows for m in models if m.takes(w.flight)]
    firsts = {w.flight.name: (w, m) for w, m in reversed(chosen)}
    pairs = [firsts[w.flight.name] for w in windows if w.flight.name in firsts]
    if not pairs:
        raise Skipped("its fits had all flights")
    ones = np.ones(len(MOTORS))
    states = np.concatenate([predicted(model, [w], [ones]) for w, model in pairs])
    return Row(models[0], FITTED, [w for w, _ in pairs], states)


def turns(models: Sequence[Model], stride: float) -> list[Row]:
    """Results of the shared logs without poses; none if they are not there."""
    stretches = [Stretch(TURNS / name, first, last) for name, first, last in STRETCHES]
    if not all(stretch.path.exists() for stretch in stretches):
        return []
    windows = [windows_of(read_stretch(stretch), stride) for stretch in stretches]
    windows = [w for w in windows if len(w.starts)]
    rows: list[Row] = []
    for model in models:
        with contextlib.suppress(Skipped):  # the table before says so
            rows += results(model, windows, [w.flight for w in windows], None)
    return rows


def main() -> int:
    options = (
        Options(__doc__, __name__, "few windows, this engine alone")
        .add("--flights", type=Path, nargs="+", default=[SHARED], metavar="PATH")
        .add("--train", type=Path, nargs="+", default=[], metavar="PATH")
        .add("--map", default="nanobench", help="default: nanobench")
        .add("--vehicle", type=Path, nargs="+", action="append", default=[], metavar="FOLDER")
        .add("--no-peers", action="store_true", help="without other simulators")
        .given()
    )
    if options.flights == [SHARED] and not SHARED.exists():
        print(f"real_flights: {shown(SHARED)} is not there; give --flights", file=sys.stderr)
        return 2
    stride = QUICK_STRIDE if options.quick else STRIDE
    flights = [read(file, options.map) for file in files_of(options.flights)]
    clocks = {flight.name: offset(flight) for flight in flights}
    windows = [
        replace(windows_of(flight, stride), flight=aligned(flight, clocks[flight.name]))
        for flight in flights
    ]
    judged = [w for w in windows if len(w.starts)]
    if not judged:
        raise InputError(f"{options.flights[0]}: no window of these flights is fit for a replay")
    others = [read(file, options.map) for file in files_of(options.train)] if options.train else []
    train = [aligned(flight, offset(flight)) for flight in others]
    train = train or [w.flight for w in windows]
    models: list[Model] = [Still(), Shipped()]
    models += [] if options.quick or options.no_peers else list(FOREIGN)
    fits = [Identified(folder) for folders in options.vehicle for folder in folders]
    detail = next((fit.detail for fit in fits if fit.detail is not None), None)
    rows: list[Row] = []
    skipped: dict[str, str] = {}
    for model in models:
        print(f"  {model.title}", file=sys.stderr, flush=True)
        try:
            rows += results(model, judged, train, detail)
        except Skipped as why:
            skipped[model.title] = str(why)
    for folders in options.vehicle:
        try:
            last = max(
                k for k, row in enumerate(rows) if isinstance(row.model, Shipped | Identified)
            )
            rows.insert(last + 1, identified(folders, judged))
        except Skipped as why:
            skipped[str(folders[0])] = str(why)
    parts = [results(Shipped(title, k), judged, train, None)[-1] for title, k in PARTS.items()]
    images = options.out / "images"
    draw_errors(rows, images / f"{PAGE}.png")
    draw_flight(rows, images / f"{PAGE}_paths.png")
    found = {"facts": facts(), "command": options.command, "skipped": skipped}
    found |= {"detail": detail, "clocks": clocks}
    found["turns"] = turns(models, stride) if options.flights == [SHARED] else []
    found |= {"stride": stride, "is_shared": options.flights == [SHARED]}
    text = page(rows, parts, windows, found)
    content = found | {"rows": data([*rows, *parts], windows)}
    write_page(options.out, PAGE, text, content | {"turns": data(found["turns"], [])["errors"]})
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
