"""The identification: flights in, a vehicle with intervals out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from skybody import InputError
from skybody.arguments import allowed_words
from skybody.imports.channels import Samples
from skybody.look.flight import Array

from .fit import Fit, Problem
from .intervals import Interval, covariance, intervals_of, is_open
from .judge import Errors, errors_of
from .parameters import Model, Scales, parameters_of
from .record import Record
from .replay import WARM, Prediction, Replayer
from .residuals import Residuals
from .screening import command_rate, good_at, kept_time, screen
from .start import TOLD, Start, clock_offset, start_values
from .vehicle import Vehicle
from .windows import FIT_LENGTH, LENGTH, Measured, Track, Windows, cut

MOST_WINDOWS = 400  # for the fit
TEST_WINDOWS = 400
LEAST_WINDOWS = 8
HELD_OUT = 0.25  # last part of each flight, without flights of their own for it
FAST_ENOUGH = 120.0  # rate of commands from which on they are complete [1/s]
LEAST_OFFSET = 0.005  # of clocks that is mended [s]
CLOCKS = 0.09  # greatest offset of clocks that is mended [s]
PASSES = 3


@dataclass(frozen=True)
class Options:
    """Options of the identification."""

    windows: int = MOST_WINDOWS
    """Greatest number of windows that are fitted."""
    threads: int = 0
    """Of the replays; 0: one per processor."""
    fixed: tuple[str, ...] = ()
    """Names of parameters that keep their nominal values."""


@dataclass
class Identified:
    """The result."""

    model: Model
    x: Array  # identified coordinates
    intervals: list[Interval]
    covariance: Array  # of the coordinates of the free parameters
    errors: dict[str, Errors]  # of held-out windows: identified, nominal, scaled
    curves: dict[str, tuple[Prediction, Measured]]  # of the same, predicted and measured
    train: Windows
    test: Windows
    test_by_flight: bool
    start: dict[str, float]  # start values of the fit
    notes: list[str] = field(default_factory=list)

    @property
    def values(self) -> dict[str, float]:
        """Identified values by name."""
        return self.model.values(self.x)


Say = Callable[[str], None]


def prepared(records: Sequence[Record], vehicle: Vehicle, notes: list[str]) -> list[Track]:
    """Flights that were screened, with one clock each."""
    tracks = []
    for record in records:
        screened = screen(record, vehicle)
        notes += screened.notes
        track = Track(screened.record, vehicle.spin_by_mass)
        if record.has_pose:
            offset = clock_offset(track)
            if abs(offset) > CLOCKS:
                raise InputError(
                    f"{record.path}: the clocks of poses and gyroscope differ by more than "
                    f"{CLOCKS:g} s, or one of them is of another flight; align the log, or check "
                    "the axes of both in the map"
                )
            if abs(offset) < LEAST_OFFSET:
                offset = 0.0  # `delay.imu` takes it
            else:
                notes.append(
                    f"{record.path.name}: the clock of commands and IMU is {1e3 * offset:.0f} ms "
                    "ahead of the poses; corrected"
                )
            track = Track(shifted(screened.record, -offset), vehicle.spin_by_mass)
        tracks.append(track)
    return tracks


def shifted(record: Record, by: float) -> Record:
    """A flight whose commands and onboard sensors have other times."""

    def later(samples: Samples | None) -> Samples | None:
        return None if samples is None else Samples(samples.time + by, samples.values)

    command = later(record.command)
    assert command is not None
    gyro, force, voltage = later(record.gyro), later(record.force), later(record.voltage)
    return replace(record, command=command, gyro=gyro, force=force, voltage=voltage)


def scales_of(tracks: Sequence[Track]) -> Scales:
    """Means over the good parts of all flights."""
    records = [track.record for track in tracks]
    law = records[0].law
    if any(record.law.kind != law.kind for record in records):
        raise InputError("flights have commands of several kinds: shares and rotor speeds")
    command = np.concatenate([r.command.values[good_at(r, r.command.time)] for r in records])
    voltages = [r.voltage.values[good_at(r, r.voltage.time)] for r in records if r.voltage]
    voltage = float(np.mean(np.concatenate(voltages))) if len(voltages) == len(records) else 0.0
    return Scales(float(np.mean(command)), voltage, law)


def identify(
    vehicle: Vehicle,
    flights: Sequence[Record],
    tests: Sequence[Record],
    options: Options,
    say: Say,
) -> Identified:
    """Identifies a vehicle.

    Args:
        vehicle: the nominal one.
        flights: to fit.
        tests: to judge; none: the last quarter of each of the flights.
        options: of the identification.
        say: gets the lines of progress.

    Raises:
        InputError: flights are not usable.
    """
    notes: list[str] = []
    tracks = prepared(flights, vehicle, notes)
    held = prepared(tests, vehicle, notes)
    scales = scales_of(tracks)
    say(f"{len(tracks)} flights, {sum(kept_time(t.record) for t in tracks):.0f} s that can be used")
    start, model = begin(vehicle, tracks, scales, notes)
    # Commands that are not complete are weighed by their effect over whole windows.
    length = LENGTH if "log.detail" in model.names else FIT_LENGTH
    train, test = windows_of(tracks, held, options, length)
    say(f"{len(train)} windows to fit, {len(test)} held out")
    replayer = Replayer(vehicle, options.threads)
    residuals = Residuals(model, train, replayer)
    x = np.zeros(len(model.parameters))
    for k, parameter in enumerate(model.parameters):
        if parameter.name in start and parameter.name not in options.fixed:
            x[k] = np.clip(parameter.coordinate(start[parameter.name]), *parameter.bounds)
    if unknown := [name for name in options.fixed if name not in model.names]:
        raise InputError(
            f"--fix {unknown[0]}: no parameter{allowed_words(unknown[0], model.names)}"
        )
    free = [k for k, p in enumerate(model.parameters) if p.name not in options.fixed]
    fit, full = search(residuals, x, free, say)
    spread = covariance(full, model.parameters, train)
    made = Identified(
        model, fit.x, intervals_of(model, fit.x, full, spread, options.fixed), spread,
        {}, {}, train, test, bool(tests), start, notes,
    )  # fmt: skip
    judge(made, Residuals(model, test, replayer), x)
    return made


def begin(
    vehicle: Vehicle, tracks: Sequence[Track], scales: Scales, notes: list[str]
) -> tuple[dict[str, float], Model]:
    """Start values, and the model of the quantities that the logs show."""
    records = [track.record for track in tracks]
    has = {
        "voltage": scales.is_share and scales.voltage > 0.0,
        "gyro": any(r.gyro is not None for r in records),
        "force": any(r.force is not None for r in records),
        "pose": any(r.has_pose for r in records),
        "detail": False,
    }
    found: Start = start_values(Model(vehicle, parameters_of(vehicle, scales, has), scales), tracks)
    rate = min(command_rate(record) for record in records)
    if found.told < TOLD and rate < FAST_ENOUGH:
        has["detail"] = True
        notes.append(
            f"commands were logged {rate:.0f} times a second and explain {100.0 * found.told:.0f} "
            "% of the turning: the log lacks the commands between its rows. Inertias, "
            "moment constants and the centre of mass stay nominal; log commands at 500 Hz or more"
        )
    elif found.told < TOLD:
        notes.append(
            f"commands explain {100.0 * found.told:.0f} % of the turning: the flights are calm"
        )
    model = Model(vehicle, parameters_of(vehicle, scales, has), scales)
    return {k: v for k, v in found.values.items() if k in model.names}, model


def windows_of(
    tracks: Sequence[Track], held: Sequence[Track], options: Options, length: float
) -> tuple[Windows, Windows]:
    """Windows to fit, of some length [s], and to judge."""
    train = cut(tracks, 0.5 * length, length)
    if held:
        test = cut(held, 0.1, LENGTH)
    else:
        test = cut(tracks, 0.1, LENGTH)
        ends = [quantile_of(test.begin[test.flight == k]) for k in range(len(tracks))]
        test = test.some(test.begin >= np.array(ends)[test.flight])
        # No window of the fit contains data of the held-out windows.
        train = train.some(train.begin + length + 2.0 * WARM < np.array(ends)[train.flight])
    for windows, name in ((train, "to fit"), (test, "to judge by")):
        if len(windows) < LEAST_WINDOWS:
            raise InputError(
                f"the flights have {len(windows)} windows of {windows.length:g} s {name}; "
                f"allowed: at least {LEAST_WINDOWS}; give longer flights"
            )
    return thinned(train, options.windows), thinned(test, TEST_WINDOWS)


def thinned(windows: Windows, most: int) -> Windows:
    """At most so many windows, evenly."""
    if len(windows) <= most:
        return windows
    return windows.some(np.unique(np.linspace(0, len(windows) - 1, most).astype(int)))


def quantile_of(begins: Array) -> float:
    """Where the held-out part of a flight begins [s]."""
    return float(np.quantile(begins, 1.0 - HELD_OUT)) if len(begins) else np.inf


def search(residuals: Residuals, x: Array, free: list[int], say: Say) -> tuple[Fit, Fit]:
    """The fit of the parameters that are told, and before it that of all.

    Parameters that the data do not tell keep their nominal values, and the rest is fitted anew.
    """
    problem = Problem(residuals, free)
    fit = problem.solve(x)
    for number in range(PASSES - 1):
        problem.rescale(fit.x, fit.starts)
        fit = problem.solve(fit.x, fit.starts)
        say(f"pass {number + 2}: cost {fit.cost:.0f}")
    spread = covariance(fit, residuals.model.parameters, residuals.windows)
    parameters = residuals.model.parameters
    dull = [k for k, s in zip(fit.free, np.sqrt(np.diag(spread)), strict=True)
            if is_open(parameters[k], float(s))]  # fmt: skip
    if not dull:
        return fit, fit
    told = Problem(residuals, [k for k in free if k not in dull])
    told.deviations = problem.deviations
    nominal = fit.x.copy()
    nominal[dull] = 0.0
    return told.solve(nominal, fit.starts), fit


def judge(made: Identified, residuals: Residuals, start: Array) -> None:
    """Errors on held-out windows: identified, nominal, and nominal with the mean thrust right."""
    nominal = np.zeros(len(made.x))
    plain = residuals.without_detail()
    scaled = nominal.copy()
    k = next(k for k, n in enumerate(made.model.names) if n in ("command.speed", "thrust_constant"))
    scaled[k] = start[k]
    cases = {
        "identified": (residuals, made.x), "nominal": (plain, nominal),
        "nominal, thrust scaled": (plain, scaled),
    }  # fmt: skip
    for name, (used, x) in cases.items():
        made.curves[name] = used.open_loop(x)
        made.errors[name] = errors_of(made.curves[name], residuals.windows)
