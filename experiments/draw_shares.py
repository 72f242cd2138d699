"""Share of drawn inertias that are not physical for a rigid body, and are drawn again.

    .venv/bin/python experiments/draw_shares.py [--quick] [--out DIR]

Principal moments of inertia that are drawn one by one may violate the triangle inequality of a
rigid body: the sum of two must be at least the third. For the base of every shipped vehicle, and
for three ranges, 10^5 initial states are drawn; `state("redraws")` gives the share that took more
than one draw. It is compared with the same share of as many draws by NumPy.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import skybody
from numpy.typing import NDArray
from skybody.program import run_program
from throughput import (
    arguments,
    facts,
    machine_line,
    markdown_table,
    output_folder,
    write_report,
)

VEHICLES = ("hover", "hover_crazyflie", "hover_hummingbird", "hover_firefly")
RANGES = (0.05, 0.1, 0.2)
ENVS = 1000
GOOD = 5.0  # largest difference of the two shares, in standard errors


def base_path(compiled: skybody.CompiledScenario) -> str:
    """Path of the base's inertia."""
    paths = [path for path in compiled.param_paths if path.endswith(".inertia[0]")]
    return next(path for path in paths if ".links." in path)[: -len("[0]")]


def drawn(vehicle: str, path: str, spread: float, resets: int) -> NDArray[Any]:
    """Numbers of redraws (resets * ENVS,)."""
    axes = ", ".join(f"'{path}[{k}]'" for k in range(3))
    draw = (
        f"randomization=[{{plugin: draw, parameters: {{what: [{axes}], "
        f"range: [{1 - spread}, {1 + spread}], form: scale}}}}]"
    )
    envs = skybody.make_vec(vehicle, ENVS, seed=1, infos=False, overrides=[draw])
    try:
        counts = []
        for _ in range(resets):
            envs.reset()
            counts.append(np.asarray(envs.state("redraws")).copy())
        return np.concatenate(counts)
    finally:
        envs.close()


def expected(nominal: NDArray[np.float64], spread: float, count: int) -> float:
    """The share of independent draws that are not moments of inertia of a rigid body."""
    scale = np.random.default_rng(1).uniform(1 - spread, 1 + spread, (count, 3))
    axes = np.sort(scale * nominal, axis=1)
    return float(np.mean(axes[:, 0] + axes[:, 1] < axes[:, 2]))


def measure(resets: int) -> list[dict[str, Any]]:
    """One row per vehicle and range."""
    rows = []
    for vehicle in VEHICLES:
        compiled = skybody.CompiledScenario(vehicle)
        path = base_path(compiled)
        nominal = np.array([compiled.param_info(f"{path}[{k}]")[0] for k in range(3)])
        for spread in RANGES:
            redraws = drawn(vehicle, path, spread, resets)
            share, other = float(np.mean(redraws > 0)), expected(nominal, spread, len(redraws))
            error = float(np.sqrt(2 * max(other * (1 - other), 1e-9) / len(redraws)))
            rows.append(
                {
                    "vehicle": vehicle,
                    "spread": spread,
                    "starts": len(redraws),
                    "share": share,
                    "numpy": other,
                    "standard_error": error,
                    "draws": float(1 + np.mean(redraws)),
                    "most": int(1 + redraws.max()),
                }
            )
    return rows


def is_good(rows: list[dict[str, Any]]) -> bool:
    """Whether both shares agree, and no initial state ran out of draws."""
    return all(
        abs(row["share"] - row["numpy"]) <= GOOD * row["standard_error"] + 1e-6
        and row["most"] <= 64
        for row in rows
    )


def page(results: dict[str, Any]) -> str:
    """The page of the results."""
    rows = results["rows"]
    table = [["scenario", "drawn by", "again", "by NumPy", "mean draws", "most draws"]]
    for row in rows:
        table.append(
            [
                row["vehicle"],
                f"{100 * row['spread']:.0f} %",
                f"{100 * row['share']:.2f} %",
                f"{100 * row['numpy']:.2f} %",
                f"{row['draws']:.3f}",
                str(row["most"]),
            ]
        )
    verdict = "agree" if is_good(rows) else "DO NOT AGREE"
    return f"""# Bodies that are drawn again

{machine_line(results["facts"])}

    .venv/bin/python experiments/draw_shares.py

The three axes of the base's inertia are drawn one by one from [1 - s, 1 + s] times the nominal.
No rigid body has axes of which two add up to less than the third: such starts are drawn again
([contact.md](../contact.md#starts-that-overlap)), which `state("redraws")` counts.
{rows[0]["starts"]:,} starts for each row. `by NumPy`: the share of as many independent
draws. Both {verdict} within {GOOD:g} standard errors.

{markdown_table(table)}

The values that stay are those of the range that a rigid body can have: their distribution is the
one that was asked for, cut off there. One factor for all axes (`vehicle_constants`, or
`shared: true`) is never drawn again.
"""


def main() -> int:
    parser = arguments(__doc__ or "")
    options = parser.parse_args()
    folder = output_folder(parser, options)
    results = {"facts": facts(), "rows": measure(10 if options.quick else 100)}
    write_report(folder, "draw_shares", page(results), results)
    return 0 if is_good(results["rows"]) else 1


if __name__ == "__main__":
    run_program(main)
