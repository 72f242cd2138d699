"""Tuning: its draws, flights, counts and files, and that it improves the gains."""

from __future__ import annotations

import dataclasses
import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from skybody import CompiledScenario
from skybody.tune import TuneError, TuneOptions, Vehicle, tune
from skybody.tune.commands import COMMAND_PERIOD, PROGRAMS, make_program, normalized
from skybody.tune.cost import LOST, costs_of
from skybody.tune.draws import (
    LEAST_LIFT,
    MOVING,
    TURNING,
    DrawRanges,
    lift_of,
    make_draws,
    nominal,
    scaled,
)
from skybody.tune.flight import Flights, Flyer
from skybody.tune.gains import find_gains
from skybody.tune.margins import GainMargin, Margins, margins_of
from skybody.tune.report import fallen_margins, gains_yaml, report, table, write
from skybody.tune.vehicle import entries_of, uses_of

ROOT = Path(__file__).resolve().parents[2]
QUICK = TuneOptions(evaluations=33, population=16, draws=2, margins=False)


@pytest.fixture(scope="module")
def vehicle() -> Vehicle:
    return Vehicle("hummingbird")


@pytest.fixture(scope="module")
def compiled(vehicle: Vehicle) -> CompiledScenario:
    return vehicle.compile()


def generator(seed: int = 0) -> np.random.Generator:
    return np.random.Generator(np.random.PCG64(seed))


def test_gains_are_better_than_the_defaults_on_draws_that_the_search_has_not_seen(
    vehicle: Vehicle,
) -> None:
    tuned = tune(vehicle, dataclasses.replace(QUICK, evaluations=193, draws=4))
    assert tuned.after.cost < 0.85 * tuned.before.cost  # a sixth of the search finds this much
    assert tuned.after.lost == 0
    assert tuned.better_draws >= 30  # of 32


def test_the_same_options_give_the_same_gains_on_any_number_of_threads(vehicle: Vehicle) -> None:
    first, second = (
        tune(vehicle, dataclasses.replace(QUICK, num_threads=threads)) for threads in (1, 2)
    )
    assert first.after.parameters == second.after.parameters
    assert first.history == second.history
    assert np.array_equal(first.after.costs.total, second.after.costs.total)


def test_another_seed_gives_other_gains(vehicle: Vehicle) -> None:
    first, second = (tune(vehicle, dataclasses.replace(QUICK, seed=seed)) for seed in (0, 1))
    assert first.after.parameters != second.after.parameters


def test_a_candidates_flight_does_not_depend_on_its_neighbours(
    compiled: CompiledScenario,
) -> None:
    program, gains = make_program(compiled), find_gains(compiled)
    draws = make_draws(compiled, 3, generator(), DrawRanges())
    points = generator(1).normal(0.0, 0.3, (2, len(gains)))
    with Flyer(compiled, program, draws, 2) as both, Flyer(compiled, program, draws, 1) as one:
        together = both.fly(gains, points)
        alone = one.fly(gains, points[1:])
    assert np.array_equal(together.errors[:, 3:], alone.errors)
    assert np.array_equal(together.rotor_commands[:, 3:], alone.rotor_commands)


def test_written_gains_are_those_that_were_flown_and_can_be_included(
    vehicle: Vehicle, tmp_path: Path
) -> None:
    tuned = tune(vehicle, QUICK)
    files = write(tuned, tmp_path, "quad")
    assert [f.name for f in files] == ["gains.yaml", "report.json", "step_response.png"]
    scenario = tmp_path / "mine.yaml"
    scenario.write_text("include: [hover_hummingbird, gains.yaml]\n")
    flown = CompiledScenario(str(scenario))
    assert flown.action_channels[0].name == "position"
    for controller, parameters in tuned.after.parameters.items():
        for name, values in parameters.items():
            for k, value in enumerate(values):
                path = f"robots.quad.controllers.{controller}.{name}[{k}]"
                assert flown.param_info(path)[0] == pytest.approx(value, rel=1e-5)
    assert json.loads(files[1].read_text()) == report(tuned)
    assert files[2].read_bytes().startswith(b"\x89PNG")


def test_gains_for_slow_rotors_cost_in_a_file_what_they_cost_in_the_search() -> None:
    """Default gains of geometric are reduced for these rotors; given gains are not."""
    options = TuneOptions(evaluations=33, margins=False)
    tuned = tune(Vehicle("vehicle", chain="geometric,ctbt"), options)
    written = ", ".join(entries_of(tuned.uses, tuned.after.parameters))
    again = tune(
        Vehicle("vehicle", chain=f"[{written}]"), dataclasses.replace(options, evaluations=1)
    )
    # Five digits are written.
    assert again.before.cost == pytest.approx(tuned.after.cost, rel=1e-3)
    assert tuned.after.cost < tuned.before.cost


def test_parameters_of_the_chain_stay_in_the_written_file() -> None:
    chain = (
        "[{plugin: position, name: guide}, {plugin: attitude, parameters: {max_rate: [6, 6, 3]}}, "
        "{plugin: ctbr}]"
    )
    tuned = tune(Vehicle("hummingbird", chain=chain), QUICK)
    text = gains_yaml(tuned, "bird")
    assert "plugin: position, name: guide, parameters: {kp: [" in text
    assert "max_rate: [6, 6, 3], gain: [" in text
    assert "  bird:\n" in text
    assert [use.name for use in tuned.uses] == ["guide", "attitude", "ctbr"]
    assert "delay" not in text
    assert "cost" in table(tuned)


def test_what_is_zero_or_fixed_is_no_gain() -> None:
    chain = "[{plugin: attitude}, {plugin: ctbr, parameters: {kd: [0, 0, 0]}}]"
    compiled = Vehicle("hummingbird", chain=chain).compile()
    names = [gain.name for gain in find_gains(compiled).groups]
    assert names == ["attitude.gain[0]", "attitude.gain[2]", "ctbr.kp[0]", "ctbr.kp[2]"]
    fixed = find_gains(compiled, ["attitude.gain"])
    assert [gain.name for gain in fixed.groups] == ["ctbr.kp[0]", "ctbr.kp[2]"]


def test_a_point_of_the_search_scales_the_defaults_within_their_bounds(
    compiled: CompiledScenario,
) -> None:
    gains = find_gains(compiled)
    defaults = nominal(compiled, gains.paths)
    assert np.array_equal(gains.values(np.zeros(len(gains))), defaults)
    doubled = gains.values(np.full(len(gains), np.log(2.0)))
    assert doubled == pytest.approx(2.0 * defaults, rel=1e-12)


def test_draws_cover_their_ranges_and_begin_with_the_nominal_vehicle(
    compiled: CompiledScenario,
) -> None:
    ranges = DrawRanges(mass=0.2, wind=4.0)
    draws = make_draws(compiled, 40, generator(), ranges)
    assert np.array_equal(draws.values[0], nominal(compiled, draws.paths))
    column = next(k for k, path in enumerate(draws.paths) if path.endswith(".mass"))
    shares = draws.values[1:, column] / draws.values[0, column]
    assert np.all(np.abs(shares - 1.0) <= 0.2)
    assert (
        shares.min() < 0.83 and shares.max() > 1.17
    )  # 40 equal parts of the range, one draw of each
    wind = [draws.paths.index(f"effects.wind.velocity[{k}]") for k in range(2)]
    speed = np.linalg.norm(draws.values[:, wind], axis=1)
    assert speed.max() <= 4.0 and speed.max() > 3.8
    again = make_draws(compiled, 40, generator(), ranges)
    assert np.array_equal(draws.values, again.values)


def test_no_draw_is_too_heavy_for_its_rotors() -> None:
    compiled = Vehicle("crazyflie").compile()  # lifts 1.27 times its weight
    assert lift_of(compiled) == pytest.approx(1.27, abs=0.005)
    draws = make_draws(compiled, 40, generator(), DrawRanges(mass=0.3))
    mass = next(k for k, path in enumerate(draws.paths) if path.endswith(".mass"))
    thrust = next(k for k, path in enumerate(draws.paths) if path.endswith(".thrust_constant"))
    share = draws.values[:, [thrust, mass]] / draws.values[0, [thrust, mass]]
    lifts = lift_of(compiled) * share[:, 0] / share[:, 1]
    assert lifts.min() == pytest.approx(LEAST_LIFT)


@pytest.mark.parametrize("chain", ["position,attitude,ctbr", "attitude,ctbr", "ctbr"])
def test_every_level_has_a_flight_that_its_chain_takes(chain: str) -> None:
    compiled = Vehicle("hummingbird", chain=chain).compile()
    program = make_program(compiled)
    assert program.level == chain.split(",")[0]
    actions = normalized(compiled, program.commands)
    assert actions.shape == (len(program.times), compiled.action_size)
    gains = find_gains(compiled)
    draws = make_draws(compiled, 1, generator(), DrawRanges())
    with Flyer(compiled, program, draws) as flyer:
        flights = flyer.fly(gains, np.zeros((1, len(gains))))
    assert flights.lost_at[0] == flights.steps
    assert float(costs_of(program, flights).total[0]) < 5.0


def test_derivatives_of_the_path_are_those_of_its_positions() -> None:
    class Channel:
        low = (0.0,) * 17

    class Taken:
        action_channels = (Channel,)

    commands = PROGRAMS["trajectory"](Taken()).commands  # type: ignore[arg-type]
    path = commands[-400:]  # seconds 4.2 to 8.2: fully on the path
    for order in range(4):
        value, rate = path[:, 3 * order : 3 * order + 3], path[:, 3 * order + 3 : 3 * order + 6]
        central = (value[2:] - value[:-2]) / (2.0 * COMMAND_PERIOD)
        # Error of central differences: h^2/6 times the third derivative, at most 2.3^3 times the
        # rate.
        assert np.abs(central - rate[1:-1]).max() < 2e-4 * 2.3 ** (order + 1)


def flights_of(errors: np.ndarray, lost_at: int | None = None) -> Flights:
    steps, n = errors.shape[:2]
    return Flights(
        errors,
        np.zeros((steps, n, 3)),
        np.full((steps, n, 4), 0.5),
        np.zeros((steps, n), bool),
        np.full(n, steps if lost_at is None else lost_at),
    )


def test_a_flight_without_error_costs_nothing_and_a_lost_one_most(
    compiled: CompiledScenario,
) -> None:
    program = make_program(compiled)
    steps = len(program.times)
    perfect = costs_of(program, flights_of(np.zeros((steps, 1, 4))))
    assert perfect.total[0] == 0.0
    constant = costs_of(program, flights_of(np.full((steps, 1, 4), 0.1)))
    assert constant.terms["step"][0] == pytest.approx(0.1)
    assert constant.terms["path"][0] == pytest.approx(0.1)
    assert constant.terms["overshoot"][0] == pytest.approx(0.1)
    awful = costs_of(program, flights_of(np.full((steps, 1, 4), 1e6)))
    assert awful.total[0] == LOST
    early = costs_of(program, flights_of(np.full((steps, 1, 4), np.nan), lost_at=10))
    late = costs_of(program, flights_of(np.full((steps, 1, 4), np.nan), lost_at=700))
    assert LOST < late.total[0] < early.total[0]


def test_scaled_vehicles_differ_in_the_gain_of_one_loop_alone(compiled: CompiledScenario) -> None:
    paths = ["gravity[2]", "robots.vehicle.rotors[0].thrust_constant"]
    inertia = next(p for p in compiled.param_paths if p.endswith(".inertia[0]"))
    values = np.array([-9.81, 1e-6, 0.01])
    turning = scaled([*paths, inertia], values, TURNING, 2.0)
    assert turning == pytest.approx([-9.81, 1e-6, 0.005])  # the same thrust turns it twice as much
    moving = scaled([*paths, inertia], values, MOVING, 2.0)
    # Thrust over inertia and thrust over weight are unchanged; thrust over mass is doubled.
    assert moving == pytest.approx([-19.62, 2e-6, 0.02])


def test_twice_the_gains_leave_half_the_margin() -> None:
    vehicle = Vehicle("hummingbird", chain="ctbr")
    gains = find_gains(vehicle.compile())
    once = margins_of(vehicle, gains, np.zeros(len(gains)))
    twice = margins_of(vehicle, gains, np.full(len(gains), np.log(2.0)))
    # The tried factors are 5.7 % apart.
    assert twice.turning.up == pytest.approx(0.5 * once.turning.up, rel=0.12)
    assert twice.delay < once.delay


def test_latency_that_is_flown_is_no_margin_any_more(vehicle: Vehicle) -> None:
    gains = find_gains(vehicle.compile())
    slow = dataclasses.replace(vehicle, latency=vehicle.latency + 0.010)
    zero = np.zeros(len(gains))
    # In steps of 1 ms.
    assert margins_of(slow, gains, zero).delay == pytest.approx(
        margins_of(vehicle, gains, zero).delay - 0.010, abs=0.0011
    )


@pytest.mark.parametrize(
    ("vehicle", "message"),
    [
        (Vehicle("no_such.urdf"), "no_such.urdf: no such file"),
        (Vehicle("no_such"), "error: the file `no_such` does not exist; give a URDF by its path"),
        (Vehicle("qdrone"), "error: the file `qdrone` does not exist; did you mean `qdrone2`?"),
        (Vehicle("hover.yaml"), "hover.yaml: a YAML file; `skybody tune` takes a robot's URDF"),
        (Vehicle("/"), "/: a folder; give a file in it"),
        (Vehicle("qdrone2", rotors="none.yaml"), "--rotors none.yaml: no such file"),
        (Vehicle("qdrone2", chain="position;ctbr"), "--chain is 'position;ctbr'; it must be names"),
        (Vehicle("qdrone2", chain="position,ctbr"), "between them belongs `attitude`"),
        (Vehicle("qdrone2", chain="srt"), "the chain begins at `srt`; gains are fitted to chains"),
        (Vehicle("pad"), "pad has no rotors file: give one by --rotors FILE"),
        (
            Vehicle("qdrone2", chain="[{plugin: ctbr, parameters: {kp: [1, 1, -1]}}]"),
            "qdrone2, --chain [{plugin: ctbr, parameters: {kp: [1, 1, -1]}}]: error: `kp[2]` is -1",
        ),
        (
            Vehicle(
                "qdrone2",
                chain="[{plugin: position, parameters: {position_max: [0.5, 5, 3]}},"
                " {plugin: attitude}, {plugin: ctbr}]",
            ),
            "value 0 of `position` is commanded from -0.8 to 1 over the flight, but the chain ",
        ),
    ],
)
def test_mistakes_are_errors_with_a_remedy(vehicle: Vehicle, message: str) -> None:
    with pytest.raises(TuneError, match=re.escape(message)):
        tune(vehicle, QUICK)


@pytest.mark.parametrize(
    "change",
    [{"seed": -1}, {"evaluations": 0}, {"population": 3}, {"draws": 0}],
)
def test_options_out_of_range_are_errors(change: dict[str, int]) -> None:
    name, value = next(iter(change.items()))
    with pytest.raises(TuneError, match=f"{name} is {value}; allowed:"):
        dataclasses.replace(QUICK, **change)


def test_a_gain_that_there_is_not_cannot_be_fixed(compiled: CompiledScenario) -> None:
    with pytest.raises(TuneError, match=re.escape("--fix ctbr.ki: the chain has no such gain")):
        find_gains(compiled, ["ctbr.ki"])


def test_the_latency_is_no_part_of_the_chain(compiled: CompiledScenario) -> None:
    assert [use.plugin for use in uses_of(compiled)] == ["position", "attitude", "ctbr"]


def test_the_program_hands_the_command_line_over(tmp_path: Path) -> None:
    program = ROOT / "build/release/bin/skybody"
    if not program.exists():
        pytest.skip("the program is not built")

    def run(*arguments: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [program, "tune", *arguments],
            capture_output=True,
            text=True,
            cwd=tmp_path,
            env={"SKYBODY_PYTHON": sys.executable, "PYTHONPATH": ":".join(filter(None, sys.path))},
            check=False,
        )

    assert "usage: skybody tune" in run("--help").stdout
    refused = run("no_such.urdf")
    assert (refused.returncode, refused.stderr) == (2, "error: no_such.urdf: no such file\n")
    assert run("qdrone2", "--candidates", "x").returncode == 2
    assert list(tmp_path.iterdir()) == []
    done = run("hummingbird", "--candidates", "2", "--draws", "1", "--out", "here")
    assert done.returncode == 0, done.stderr
    assert {f.name for f in (tmp_path / "here").iterdir()} == {
        "gains.yaml",
        "report.json",
        "step_response.png",
    }


def test_margins_that_fall_while_the_cost_does_are_told(vehicle: Vehicle) -> None:
    tuned = tune(vehicle, QUICK)
    assert tuned.after.cost < tuned.before.cost
    moving = GainMargin(np.inf, 0.2)
    wide = Margins(GainMargin(8.0, 0.1), moving, 0.050)
    narrow = Margins(GainMargin(3.0, 0.1), moving, 0.030)
    before, after = (
        dataclasses.replace(outcome, margins=margins)
        for outcome, margins in ((tuned.before, wide), (tuned.after, narrow))
    )
    told = fallen_margins(dataclasses.replace(tuned, before=before, after=after))
    assert told == [
        "turning gain, up from 8.00 (+18.1 dB) to 3.00 (+9.5 dB)",
        "delay margin from 50 ms to 30 ms",
    ]
    assert fallen_margins(dataclasses.replace(tuned, before=after, after=before)) == []


def test_limits_of_the_chains_laws_are_counted(vehicle: Vehicle) -> None:
    chain = (
        "[{plugin: position, parameters: {max_acceleration_side: 0.5}}, "
        "{plugin: attitude}, {plugin: ctbr}]"
    )
    tight = dataclasses.replace(vehicle, chain=chain).compile()
    program, gains = make_program(tight), find_gains(tight)
    with Flyer(tight, program, make_draws(tight, 1, generator(), DrawRanges())) as flyer:
        flights = flyer.fly(gains, np.zeros((1, len(gains))))
    assert costs_of(program, flights).terms["limited"][0] > 0.1
