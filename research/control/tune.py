"""Each vehicle's gains before and after `skybody tune`.

    python -m research run tune [--quick] [--out DIR]

Each vehicle is tuned with the command's defaults. Costs are means over 32 held-out vehicles and
winds. Third-party vehicles are read from shared/data/urdf, in a folder beside the project.
"""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

from skybody.tune import TuneOptions, Vehicle, tune
from skybody.tune.picture import draw
from skybody.tune.report import report

from research.common.machine import facts, machine_line
from research.common.options import Options
from research.common.pages import head, markdown_table, write_page
from research.common.places import ROOT

PAGE = "tune"

MODELS = ROOT / "scenarios/models"
OTHERS = [folder / "shared/data/urdf" for folder in ROOT.parents]  # a work tree is deeper
SHIPPED = ("qdrone2", "crazyflie", "hummingbird", "firefly", "vehicle")
SHIPPED += ("qdrone2_boom", "qdrone2_payload", "firefly_arm")
FOREIGN = ("cf2p", "cf2x", "racer")
LONGEST = 60.0  # [s] limit of a tuning on two cores
PICTURE = "cf2p"


def vehicles() -> list[Vehicle]:
    """The vehicles that are available."""
    found = [Vehicle(name) for name in SHIPPED]
    for name in FOREIGN:
        urdf = next((f / f"{name}.urdf" for f in OTHERS if (f / f"{name}.urdf").is_file()), None)
        if urdf is not None:
            found.append(Vehicle(str(urdf), rotors=str(MODELS / name / "rotors.yaml")))
    return found


def measure(quick: bool, folder: Path) -> list[dict[str, Any]]:
    """A report of each vehicle, with processor seconds."""
    rows = []
    options = TuneOptions(evaluations=65) if quick else TuneOptions()
    for vehicle in vehicles()[: 1 if quick else None]:
        began = time.process_time()
        tuned = tune(vehicle, options)
        row = {"name": vehicle.name, "processor_seconds": time.process_time() - began}
        rows.append(report(tuned) | row | {"vehicle": vehicle.name})  # no path of this machine
        print(vehicle.name, f"{tuned.before.cost:.3f} -> {tuned.after.cost:.3f}", flush=True)
        if vehicle.name == PICTURE:
            draw(tuned, folder / "images/tune.png")
    return rows


def is_good(rows: list[dict[str, Any]]) -> bool:
    """Whether every vehicle flies better with its own gains, and tuning is fast enough."""
    return all(
        row["after"]["cost"] < row["before"]["cost"]
        and row["after"]["lost"] <= row["before"]["lost"]
        and row["processor_seconds"] < 2 * LONGEST
        for row in rows
    )


def gain(value: float | None) -> str:
    return "> 32" if value is None else f"{value:.2g}"


def margins(outcome: dict[str, Any]) -> list[str]:
    found = outcome["margins"]
    delay = found["delay_s"]
    return [
        *(
            f"{gain(found[loop]['up'])}, {gain(found[loop]['down'])}"
            for loop in ("turning", "moving")
        ),
        "> 320" if delay is None else f"{1000 * delay:.0f}",
    ]


def cost_table(rows: list[dict[str, Any]]) -> str:
    names = "vehicle | cost, default | tuned | path [m], default | tuned | lost, default | tuned"
    table = [head(f"{names} | better on | s, wall | s, processor")]
    for row in rows:
        before, after = row["before"], row["after"]
        cells = [row["vehicle"], *(f"{one['cost']:.3f}" for one in (before, after))]
        cells += [f"{one['terms']['path']:.3f}" for one in (before, after)]
        cells += [before["lost"], after["lost"], f"{row['better_on']} of {row['held_out_draws']}"]
        seconds = [f"{row[name]:.0f}" for name in ("seconds", "processor_seconds")]
        table.append([*cells, *seconds])
    return markdown_table(table)


def margin_table(rows: list[dict[str, Any]]) -> str:
    heading = ["turning", "moving", "delay [ms]"]
    table = [["vehicle", *heading, *(f"{word}, tuned" for word in heading)]]
    table += [[row["vehicle"], *margins(row["before"]), *margins(row["after"])] for row in rows]
    return markdown_table(table)


def gain_table(rows: list[dict[str, Any]]) -> str:
    names = [(c, p) for c, parameters in rows[0]["after"]["gains"].items() for p in parameters]
    table = [["vehicle", *(f"`{c}.{p}`" for c, p in names)]]
    for row in rows:
        gains = row["after"]["gains"]
        table.append(
            [row["vehicle"], *(", ".join(f"{v:.3g}" for v in gains[c][p]) for c, p in names)]
        )
    return markdown_table(table)


def page(results: dict[str, Any]) -> str:
    """The page of the results."""
    rows = results["rows"]
    verdict = "cost less with their own gains" if is_good(rows) else "DO NOT ALL COST LESS"
    return f"""# Gains before and after `skybody tune`

{machine_line(results["facts"])}

    .venv/bin/python -m research run tune

Chain position, attitude, ctbr; {rows[0]["candidates"]} candidates, seed {rows[0]["seed"]}, a
latency of {1000 * rows[0]["latency_s"]:g} ms before the rotors ([tune.md](../tune.md) says what is
flown and what counts). Costs are means over {rows[0]["held_out_draws"]} vehicles and winds that the
search has not seen; `path` is the RMS error on the smooth path. All vehicles {verdict}. Joints of
`qdrone2_boom`, `qdrone2_payload` and `firefly_arm` hang free.

{cost_table(rows)}

`s, processor` is summed over threads: two cores that have nothing else to do need half of it.

Factors on a loop's gain, up and down, and delay beyond the latency, at which a small step no longer
dies out. The search makes gains costly that do not bear 2, 0.5 and 10 ms. A joint that hangs free
goes on swinging, which counts as a step that does not die out.

{margin_table(rows)}

The gains.

{gain_table(rows)}

![cf2p before and after](images/tune.png)
"""


def main() -> int:
    options = Options(__doc__, __name__).given()
    results = {"facts": facts(), "rows": measure(options.quick, options.out)}
    write_page(options.out, PAGE, page(results), results)
    return 0 if options.quick or is_good(results["rows"]) else 1
