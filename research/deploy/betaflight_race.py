"""Policies of body rates and thrust race through our gates by Betaflight's own rate loop.

    python -m research run betaflight_race --firmware PROGRAM [--quick] [--out DIR]

`scripts/build_betaflight.sh FOLDER` builds PROGRAM. The policy's rates and thrust are the sticks of
acro mode. `POLICY` was trained with drawn gains, delays and thrusts, by

    skybody train research/deploy/scenarios/racing_sticks.yaml --seed 1 --out RUN

and the shipped one of `racing` without. Both fly the same starts and tracks in process, too, by the
controller `ctbr`. Steps of the rates show how fast both loops answer. Some races are flown twice,
since Betaflight's clock is the wall's.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from skybody import CompiledScenario, FlightPolicy, Simulation
from skybody.sitl.betaflight_link import BetaflightLink
from skybody.sitl.betaflight_policy import PolicyPilot, RatePilot
from skybody.sitl.betaflight_program import BetaflightProgram, settings_for
from skybody.sitl.vehicle import Setup, Vehicle

from research.common.machine import facts, machine_line
from research.common.pages import head, markdown_table, write_page
from research.common.places import ROOT
from research.deploy.firmware import firmware_options

PAGE = "betaflight_race"
SCENARIO, FRAME = "racing", "x-reversed"

Reals = NDArray[np.float64]
GATES = 15
FIRST_SEED, SEEDS, TWICE = 101, 5, 2
POLICY = ROOT / "research/deploy/policies/racing_sticks.h5"
POLICIES = {"racing_sticks": str(POLICY), "shipped": "shipped"}
LONGEST = 31.0  # the scenario's horizon, and a little [s]
STEPS = {"roll": (3.0, 0), "pitch": (3.0, 1), "yaw": (1.5, 2)}  # [rad/s], axis
STEP_BEGIN, STEP_END = 0.2, 0.5  # [s]


# --- races --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Race:
    """The end of one flight."""

    gates: int
    finished: bool
    time: float  # of the whole flight [s]
    lap: float  # time of the last whole lap; 0: none [s]
    failure: str  # the info that ended it; empty: none
    late: int = 0  # number of late answers of Betaflight


def result(compiled: CompiledScenario, info: NDArray[np.float32], time: float, late: int) -> Race:
    """The result by the task's infos."""
    by_name = {channel.name: float(info[channel.first]) for channel in compiled.info_channels}
    failures = [name for name, value in by_name.items() if name.startswith("failed.") and value]
    return Race(
        gates=round(by_name["gates_passed"]),
        finished=by_name["success"] > 0.5,
        time=time,
        lap=by_name["lap_time"],
        failure=", ".join(name.removeprefix("failed.") for name in failures),
        late=late,
    )


class Recorder(Vehicle):
    """A racer that keeps its motion."""

    def __init__(self, seed: int = 0) -> None:
        super().__init__("betaflight", Setup(SCENARIO, seed=seed, frame=FRAME, on_ground=False))
        self.rows: list[Reals] = []

    def advance(self, throttles: Any, steps: int) -> None:
        """As Vehicle.advance."""
        super().advance(throttles, steps)
        now = self.simulation.base()
        self.rows.append(np.concatenate([[self.time], now.position, now.angular_velocity]))


def by_betaflight(seed: int, policy: str, options: Any) -> tuple[Race, Reals]:
    """A race through Betaflight, and its rows (n, 7): time [s], position [m], rates [rad/s]."""
    vehicle = Recorder(seed)
    pilot = PolicyPilot(vehicle, policy)
    late = serve(vehicle, pilot, LONGEST, options)
    race = result(vehicle.compiled, vehicle.simulation.info, vehicle.time, late)
    return race, np.array(vehicle.rows)


def serve(vehicle: Vehicle, pilot: RatePilot, seconds: float, options: Any) -> int:
    """Flies; returns the number of late answers."""
    link = BetaflightLink(vehicle, pilot, options.factor)
    settings = [*settings_for(vehicle.frame), *pilot.settings()]
    with BetaflightProgram(options.firmware, settings) as program:
        link.serve(seconds, program)
    return int(link.messages.counts["late answers"])


def in_process(seed: int, policy: str) -> Race:
    """The same race by `ctbr`."""
    simulation = Simulation(SCENARIO, seed=seed)
    flown = FlightPolicy(simulation.compiled, policy)
    simulation.reset(seed)
    while not (simulation.terminated or simulation.truncated):
        simulation.step(flown.act(simulation))
    return result(simulation.compiled, simulation.info, simulation.time, 0)


# --- steps of the rates -------------------------------------------------------------------------


class StepPilot(RatePilot):
    """Thrust of a hover, and one step of one rate."""

    def __init__(self, vehicle: Vehicle, axis: int, rate: float) -> None:
        super().__init__(vehicle)
        self._axis, self._rate = axis, rate

    def decide(self) -> Reals:
        """As RatePilot.decide()."""
        return self.command_at(self.vehicle.time)

    def command_at(self, time: float) -> Reals:
        """The command at a time [s]."""
        command = np.array([self.weight, 0.0, 0.0, 0.0])
        command[1 + self._axis] = self._rate if time > STEP_BEGIN - 1e-9 else 0.0
        return command


@dataclass(frozen=True)
class Answer:
    """A rate's answer to a step."""

    axis: str
    loop: str
    tenth: float  # time to 10 % [ms]
    rise: float  # time to 63 % [ms]
    overshoot: float  # of the step [%]
    end: float  # mean of the last 50 ms, of the step [%]


def answer(axis: str, loop: str, times: Reals, rates: Reals, rate: float) -> Answer:
    """The numbers of an answer; NaN if a level is not reached."""
    after = times > STEP_BEGIN + 1e-9
    share, since = rates[after] / rate, 1e3 * (times[after] - STEP_BEGIN)

    def reached(level: float) -> float:
        return float(since[np.argmax(share >= level)]) if (share >= level).any() else np.nan

    return Answer(
        axis=axis,
        loop=loop,
        tenth=reached(0.1),
        rise=reached(0.63),
        overshoot=100.0 * max(0.0, float(share.max()) - 1.0),
        end=100.0 * float(share[since > since[-1] - 50.0].mean()),
    )


def answers(options: Any) -> list[Answer]:
    """Both loops' answers about each axis."""
    found = []
    for axis, (rate, k) in STEPS.items():
        vehicle = Recorder()
        pilot = StepPilot(vehicle, k, rate)
        serve(vehicle, pilot, STEP_END, options)
        rows = np.array(vehicle.rows)
        found.append(answer(axis, "Betaflight", rows[:, 0], rows[:, 4 + k], rate))
        rows = by_ctbr(pilot)
        found.append(answer(axis, "`ctbr`", rows[:, 0], rows[:, 1 + k], rate))
    return found


def by_ctbr(pilot: StepPilot) -> Reals:
    """The same step in process: rows (n, 4) of time [s] and rates [rad/s]."""
    simulation = Simulation(SCENARIO, seed=0)
    simulation.reset(0)
    rows: list[Reals] = []
    dt = simulation.compiled.dt
    while len(rows) * dt < STEP_END - 1e-9:
        simulation.command(pilot.command_at(len(rows) * dt))
        simulation.advance(1)
        rates = simulation.base().angular_velocity
        rows.append(np.concatenate([[(len(rows) + 1) * dt], rates]))
    return np.array(rows)


# --- page ---------------------------------------------------------------------------------------


def measure(options: Any) -> dict[str, Any]:
    """All flights."""
    races: list[dict[str, Any]] = []
    for name, policy in list(POLICIES.items())[: 1 if options.quick else None]:
        for seed in range(FIRST_SEED, FIRST_SEED + (1 if options.quick else SEEDS)):
            race, rows = by_betaflight(seed, policy, options)
            row: dict[str, Any] = {"policy": name, "seed": seed, "betaflight": asdict(race)}
            row["in_process"] = asdict(in_process(seed, policy))
            if len(races) < TWICE and not options.quick:
                again, other = by_betaflight(seed, policy, options)
                steps = min(len(rows), len(other))
                apart = np.linalg.norm(rows[:steps, 1:4] - other[:steps, 1:4], axis=1)
                row["again"] = {**asdict(again), "apart": float(apart.max())}
            print(row, flush=True)
            races.append(row)
    return {"races": races, "answers": [asdict(one) for one in answers(options)]}


def cells(race: dict[str, Any]) -> list[str]:
    """Gates and times of a race."""
    ended = race["failure"] or ("" if race["finished"] else "horizon")
    gates = f"{race['gates']}" + (f" ({ended})" if ended else "")
    return [gates, f"{race['time']:.2f}", f"{race['lap']:.2f}" if race["lap"] else "-"]


def race_table(races: list[dict[str, Any]]) -> str:
    """A row for each policy and seed."""
    columns = "gates | time [s] | last lap [s]"
    again = "again: gates | time [s] | last lap [s] | apart at most [m]"
    names = f"policy | seed | Betaflight: {columns} | late answers | {again}"
    rows: list[Any] = [head(f"{names} | in process: {columns}")]
    for row in races:
        twice = row.get("again")
        more = [*cells(twice), f"{twice['apart']:.2f}"] if twice else ["-"] * 4
        flown = [*cells(row["betaflight"]), row["betaflight"]["late"]]
        rows.append([f"`{row['policy']}`", row["seed"], *flown, *more, *cells(row["in_process"])])
    return markdown_table(rows)


def summary(races: list[dict[str, Any]], name: str) -> str:
    """A policy's races in words."""
    own = [row for row in races if row["policy"] == name]

    def whole(*kinds: str) -> str:
        flown = [row[kind] for row in own for kind in kinds if kind in row]
        gates = np.mean([race["gates"] for race in flown])
        finished = sum(race["finished"] for race in flown)
        return f"all {GATES} gates in {finished} of {len(flown)} races, {gates:.1f} on average"

    through, beside = whole("betaflight", "again"), whole("in_process")
    return f"- `{name}`: {through}; in process {beside}."


def answer_table(found: list[dict[str, Any]]) -> str:
    """A row for each axis and loop."""
    rows: list[Any] = [
        head("axis | loop | step [rad/s] | 10 % [ms] | 63 % [ms] | overshoot [%] | end [%]")
    ]
    for one in found:
        numbers = [f"{one[key]:.0f}" for key in ("tenth", "rise", "overshoot", "end")]
        rows.append([one["axis"], one["loop"], f"{STEPS[one['axis']][0]:g}", *numbers])
    return markdown_table(rows, text=(0, 1))


def page(about: dict[str, Any], found: dict[str, Any], options: Any) -> str:
    """The page."""
    races = found["races"]
    names = dict.fromkeys(row["policy"] for row in races)
    summaries = "\n".join(summary(races, name) for name in names)
    lines = "\n".join(f"    {line}" for line in found["settings"])
    return f"""# A learned policy races through Betaflight

{machine_line(about)}

    python -m research run {PAGE} --firmware PROGRAM --factor {options.factor:g}

Policies fly QDrone2 over the three laps of `{SCENARIO}` by the sticks of Betaflight 4.6.0 (SITL) in
acro mode (`skybody sitl betaflight {SCENARIO} --pilot policy`), at
{options.factor:g} times real time, and the same starts and tracks in process by the
controller `ctbr` of their training. `shipped` is that of `{SCENARIO}`.
`racing_sticks` was trained in
[racing_sticks.yaml](../../research/deploy/scenarios/racing_sticks.yaml), with drawn gains of the
rates, delays of 0 to 16 ms, drawn mass and thrust, and 0.1 m more room to the frames.

{summaries}

{race_table(races)}

"Again" is a second flight of the same seed, "apart" the greatest distance between the two at the
same time. Times are those of the whole flight.

## Rate loops

From a hover at {STEP_BEGIN:g} s one rate steps; times are until 10 % and 63 % of the step, "end" is
the mean of the last 50 ms until {STEP_END:g} s.

{answer_table(found["answers"])}

Roll and pitch answer alike. Yaw has at most a quarter of Betaflight's range of the motors: its
mixer takes thrust for yaw, while `ctbr` gives yaw the rest that thrust, roll and pitch leave.

## Settings

The pilot sets these values at Betaflight's console. P and D are computed: they give the gains `kp`
and `kd` of the scenario's `ctbr` about the speed of a hover.

{lines}
"""


def main() -> int:
    options = firmware_options(__doc__, __name__)
    about = facts()
    found = measure(options)
    found["settings"] = PolicyPilot(Recorder(), str(POLICY)).settings()
    write_page(options.out, PAGE, page(about, found, options), {"facts": about, **found})
    return 0
