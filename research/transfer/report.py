"""Page and pictures of the transfer to other simulators."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from research.common.machine import machine_line
from research.common.pages import head, markdown_table
from research.common.plots import panels, save
from research.common.trials import interval
from research.transfer.references import COUNT, TRIAL_COUNT

Arrays = Mapping[str, Any]
Row = dict[str, Any]
ENGINE_TITLES = {
    "mujoco": "MuJoCo",
    "bullet": "Bullet",
    "rotorpy": "RotorPy",
    "skybody": "Skybody",
}
FORM_TITLES = {
    "rotor_speed": "rotor speeds (700 inputs, 4 outputs)",
    "modular": "force (680 inputs, 3 outputs)",
}
POLICY_TITLES = {"shipped": "shipped", "drawn": "trained on drawn vehicles"}
CONDITION_TITLES = {"plain": "plain", "hidden": "all errors"}
FOREIGN = ("mujoco", "bullet", "rotorpy")
GOAL = 0.10  # [m]
PAPER_MEAN, PAPER_RMS = 20.2, 26.2  # of the paper's nine flights [cm]
LAPS_GATES = 15  # of a race: three laps


# --- numbers ------------------------------------------------------------------------------------


def by_seed(row: Row, name: str = "mean") -> list[float]:
    """Mean over the references of each seed [cm]."""
    count = references(row)
    return [100.0 * float(x) for x in np.reshape(row[name], (-1, count)).mean(axis=1)]


def references(row: Row) -> int:
    """Number of references of a row, which has that many flights for each seed."""
    return COUNT if len(row["mean"]) % COUNT == 0 else TRIAL_COUNT


def root_mean_square(row: Row) -> float:
    """Over all flights of a row [cm]."""
    return 100.0 * float(np.sqrt(np.mean(np.square(row["rms"]))))


def cell(row: Row | None) -> str:
    """Mean, interval over the seeds, RMS [cm], failures."""
    if row is None:
        return "-"
    means = by_seed(row)
    spread = f" ± {interval(means):.1f}" if len(means) > 1 else ""
    failed = f", {row['failed']} failed" if row["failed"] else ""
    return f"{np.mean(means):.1f}{spread} ({root_mean_square(row):.1f}){failed}"


def chosen(rows: list[Row], **labels: str) -> Row | None:
    """The row with these labels."""
    fits = (row for row in rows if all(row[name] == value for name, value in labels.items()))
    return next(fits, None)


def engines(rows: list[Row]) -> list[str]:
    """Engines that flew, in the order of the page."""
    flown = {row["engine"] for row in rows}
    return [name for name in ENGINE_TITLES if name in flown]


# --- tables -------------------------------------------------------------------------------------


def main_table(rows: list[Row]) -> str:
    """Forms, policies and conditions against engines."""
    table: list[list[Any]] = [
        ["action", "policy", "condition", *(ENGINE_TITLES[name] for name in engines(rows))]
    ]
    for form, title in FORM_TITLES.items():
        for policy, policy_title in POLICY_TITLES.items():
            for condition, condition_title in CONDITION_TITLES.items():
                labels = {"form": form, "policy": policy, "condition": condition}
                cells = [cell(chosen(rows, engine=e, **labels)) for e in engines(rows)]
                table.append([title, policy_title, condition_title, *cells])
    return markdown_table(table, (0, 1, 2))


def reference_table(rows: list[Row], form: str, policy: str) -> str:
    """Mean and RMS of each reference over the seeds [cm], as the paper's Table V."""
    flown = engines(rows)
    table: list[list[Any]] = [["reference", *(ENGINE_TITLES[name] for name in flown)]]
    parts = [
        chosen(rows, engine=name, form=form, policy=policy, condition="hidden") for name in flown
    ]
    count = references(next(part for part in parts if part is not None))
    for k in range(count):
        cells = []
        for part in parts:
            assert part is not None
            mean = 100.0 * float(np.mean(part["mean"][k::count]))
            rms = 100.0 * float(np.sqrt(np.mean(np.square(part["rms"][k::count]))))
            cells.append(f"{mean:.1f} / {rms:.1f}")
        table.append([str(k + 1), *cells])
    return markdown_table(table)


def parts_table(rows: list[Row]) -> str:
    """Each part of the hidden condition alone, in Skybody."""
    names = ["plain", "errors of the model", "wind", "sensors and delay", "hidden"]
    table: list[list[Any]] = [["condition", *FORM_TITLES.values()]]
    for name in names:
        labels = {"engine": "skybody", "policy": "shipped", "condition": name}
        cells = [cell(chosen(rows, form=form, **labels)) for form in FORM_TITLES]
        table.append([CONDITION_TITLES.get(name, f"{name} alone"), *cells])
    return markdown_table(table)


def race_table(rows: list[Row]) -> str:
    """Gates, touches and times of the races."""
    names = f"condition | races | gates passed of {LAPS_GATES} | touched a gate | missed a gate"
    table: list[list[Any]] = [head(f"{names} | median time of a whole race [s]")]
    for row in rows:
        passed = np.array(row["passed"])
        groups = (
            [float(part.mean()) for part in np.array_split(passed, 5)] if len(passed) > 9 else []
        )
        spread = f" ± {interval(groups):.1f}" if groups else ""
        times = [x for x in row["seconds"] if x is not None]
        median = f"{np.median(times):.2f}" if times else "-"
        title = CONDITION_TITLES[row["condition"]]
        touched, missed = row["touched"], row["missed"]
        table.append([title, len(passed), f"{passed.mean():.1f}{spread}", touched, missed, median])
    return markdown_table(table)


def worst(rows: list[Row], policy: str) -> float:
    """Greatest mean error of other engines and of both forms, with all errors [cm]."""
    found = [
        float(np.mean(by_seed(row)))
        for row in rows
        if (row["condition"], row["policy"]) == ("hidden", policy) and row["engine"] in FOREIGN
    ]
    return max(found, default=float("nan"))


def verdict(rows: list[Row]) -> str:
    """Whether the goal is met in each foreign engine."""
    drawn, shipped = worst(rows, "drawn"), worst(rows, "shipped")
    kept = "met" if drawn < 100.0 * GOAL else "missed"
    return f"""\
The goal is a mean error below {100.0 * GOAL:.0f} cm over the nine references, in each other engine,
for both forms of action, with all errors that are listed below. It is {kept} by policies that were
trained on drawn vehicles: the worst mean is {drawn:.1f} cm. The worst mean of the shipped policies,
trained with the nominal mass and thrust, is {shipped:.1f} cm."""


# --- pictures -----------------------------------------------------------------------------------


def draw(answers: Mapping[str, Arrays], folder: Path) -> None:
    """The nine flights of each engine with all errors, by the policies of drawn vehicles."""
    for engine, title in ENGINE_TITLES.items():
        forms = {
            form: answers[name]
            for form in FORM_TITLES
            if (name := f"{engine}-{form}-drawn-hidden") in answers
        }
        if forms:
            picture(forms, title, folder / f"transfer_{engine}.png")


def picture(forms: Mapping[str, Arrays], title: str, path: Path) -> None:
    """Nine panels from above, of the first seed."""
    figure, axes = panels(3, 3, (9.0, 9.4), sharex=True, sharey=True)
    colors = {"rotor_speed": "tab:blue", "modular": "tab:orange"}
    names = {"rotor_speed": "rotor speeds", "modular": "force"}
    for k, axis in enumerate(axes.flat):
        flown = {form: answer for form, answer in forms.items() if k < len(answer["flown"])}
        for form, answer in flown.items():
            path_of = answer["flown"][k]
            axis.plot(*path_of.T[:2], color=colors[form], linewidth=1.0, label=names[form])
        if flown:
            wanted = next(iter(flown.values()))["wanted"][k]  # the same for all forms
            axis.plot(*wanted.T[:2], "k", linewidth=0.9, dashes=(4, 3), label="reference")
        axis.set_title(f"reference {k + 1}", fontsize=10)
        axis.set_aspect("equal")
    for axis in axes[-1]:
        axis.set_xlabel("x [m]")
    for axis in axes[:, 0]:
        axis.set_ylabel("y [m]")
    axes[0, 0].legend(fontsize=8, loc="upper left")
    figure.suptitle(f"{title}, all errors, trained on drawn vehicles, first seed, seen from above")
    save(figure, path)


# --- the page -----------------------------------------------------------------------------------


def page(content: dict[str, Any]) -> str:
    """The page."""
    rows = content["flights"]
    versions = dict.fromkeys(row["version"] for row in rows)
    left_out = "".join(
        f"\nLeft out, because it is not installed here: {ENGINE_TITLES[name]}.\n"
        for name in content["left_out"]
    )
    pictures = "\n\n".join(
        f"![Nine flights in {ENGINE_TITLES[name]}](images/transfer_{name}.png)"
        for name in engines(rows)
        if name in FOREIGN
    )
    return f"""# Policies in other simulators

{machine_line(content["machine"])}; {", ".join(versions)}

    {content["command"]}
{left_out}
{verdict(rows)}

## Errors

Mean distance to the reference from 3 s on, over nine references of 30 s each [cm]; ± is the 95 %
interval over seeds; in brackets the RMS.

{main_table(rows)}

{TEXT}

{pictures}

## Nine references

By the policies that were trained on drawn vehicles, as the paper's Table V.

{per_reference(rows)}

The paper flew nine references with a real vehicle: mean {PAPER_MEAN} cm, RMS {PAPER_RMS} cm.

## Causes

{CAUSES}

{parts_table(rows)}

## Races

{RACES}

{race_table(content["races"])}

## Method

{METHOD}
"""


def per_reference(rows: list[Row]) -> str:
    """Tables of both policies that were trained on drawn vehicles."""
    tables = []
    for form, title in FORM_TITLES.items():
        name = title.partition(" (")[0]
        if chosen(rows, form=form, policy="drawn", condition="hidden"):
            table = reference_table(rows, form, "drawn")
            tables.append(f"Mean / RMS with actions of {name}, all errors [cm]:\n\n{table}")
    return "\n\n".join(tables)


TEXT = """\
- **plain**: the engine's own motion, nominal constants, still air. One seed.
- **all errors**: mass, each axis of inertia, thrust and lag are off by up to 10 % (uniform, one
  draw for each flight), each rotor's thrust by another 2 %. Wind of 2 m/s from a random side, gusts
  of 2 m/s. Poses at 120 Hz arrive after 15 ms with noise of 1 mm and 0.3 degrees; the gyroscope has
  noise of 0.02 rad/s and a bias of up to 0.01 rad/s. Five seeds.
- **shipped**: `trajectory` and `trajectory_modular`, trained with drawn inertia, rotor drag and
  lag, but with the nominal mass and thrust, in still air and without delay.
- **trained on drawn vehicles**: the same tasks, with mass, thrust, inertia and lag drawn by
  +-13 %, rotor drag by +-50 %, wind of up to 3 m/s along x and y, gusts, and commands that act
  5 to 30 ms late (`research/transfer/scenarios/trajectory_drawn.yaml` and
  `trajectory_modular_drawn.yaml`, `skybody train FILE --seed 1`: ten million steps, three minutes
  for both on two shared cores).
- **Skybody**: the same flights, with the same draws and the same estimator, in this engine."""

CAUSES = """\
The shipped policies in Skybody, with each part of the errors alone [cm]. A policy has no integral:
thrust that does not carry the weight leaves a constant error of the height. This error does not
depend on the engine, and a policy that was trained with drawn masses and thrusts avoids most of
it."""

RACES = """\
The shipped policy of [racing](../../tasks/racing/README.md) for collective thrust and body rates,
at 50 Hz, on 50 courses with gates moved by up to 0.2 m, over three laps. Gates are boxes; a race
counts until the vehicle touches one, or crosses a gate's plane beside its opening. Starts are at
rest before the first gate. ± is the 95 % interval over five groups of ten."""

METHOD = """\
- Each adapter (`research/transfer/engine_*.py`) builds the vehicle from `qdrone2.urdf` and
  `rotors.yaml` by a reader of its own. MuJoCo gets MJCF; its adapter has thrust, drag torque, rotor
  drag, gyroscopic moment, and the lag in closed form. Bullet's own loader reads the URDF; thrust
  acts at the hubs, and the lag is Euler's. RotorPy gets parameters: its rotors, its drag, its one
  lag for both directions. No adapter has rolling or spin-up moments. Rotors that follow a rising
  command faster than a falling one push harder under noise, those of RotorPy do not: a flight there
  is about 1 cm lower, which raises the error of some flights and lowers that of others.
- All engines step by 2 ms. A policy acts at 100 Hz. For the force a foreign attitude loop runs at
  500 Hz by nominal constants: RotorPy's own (`cmd_acc`), else a PD on the matrices' difference.
- Estimates are a user's of motion capture: velocity is the slope of a line through the last eight
  positions, brought to the present by the acceleration of attitude and commanded thrust. The
  attitude is the latest poses', turned on by the gyroscope.
- The policy is evaluated from its policy.h5 in NumPy, and its rows are built by
  `research/transfer/observation.py` and `race.py`. A test compares rows and actions with the
  engine's own.
- References have the sizes, phases and heights of the paper's public code, at peak speeds of 0.41
  to 1.03 m/s, as in the scenario `trajectory_flights`; their heading is fixed. A flight starts
  within 0.5 m (0.25 m in height) of its reference."""
