"""Skybody's own rows on the peers' work, through its vector environment as a user has it.

Each of our steps also gives observation, reward, ends and resets; peers return 13 states. Two
threads unless a row says one; K = 1 is one physics step per call.
"""

from __future__ import annotations

import functools
import json
import pathlib
import re
import subprocess
from collections.abc import Callable

import measure
import numpy as np
import skybody
import vehicle
from numpy.typing import NDArray
from skybody.program import run_program

PROGRAMS = pathlib.Path(__file__).resolve().parents[2] / "build" / "release" / "bin"
DIFFERS = "rotor lag and drag, observation, reward, ends and resets included; float32 rows"
FORMATIONS = {2: "formation_2", 5: "formation", 10: "formation_10", 20: "formation_20"}
# The payload without features that no peer has: its IMU and drawn constants.
PLAIN = (
    "sensors=[]",
    "randomization=[{plugin: start, parameters: {robot: quad, position_min: [-5, -5, 1.5], "
    "position_max: [5, 5, 3]}}]",
)


# Observation and reward of hover for one of the robots, without ends.
ONE_ROBOT = "{plugin: hover, parameters: {robot: quad1, bound: 1000, tilt_max: 3.1}}"
LIMIT_DIFFERS = "no engine: hand-written loop over arrays, one vehicle, no ground, no checks"
FLIGHT = 100  # physics steps of a check, and again with more thrust
Array = NDArray[np.float64]
SECTION = r"(.+), K=(\d+), (\d) threads?$"


def peer() -> measure.Peer:
    return measure.Peer("Skybody", skybody.versions()["skybody"], "tree dynamics", DIFFERS)


def action(largest: float, load: float = 0.0) -> float:
    """Hover action, for a controller whose action 1 is the speed `largest` [rad/s]."""
    return 2.0 * vehicle.qdrone2().hover_speed(load) / largest - 1.0


def in_flight(robots: int) -> tuple[str, ...]:
    """Overrides with which an action of zero is hover speed, and episodes end before vehicles of
    drawn mass reach the ground.
    """
    largest = 2.0 * vehicle.qdrone2().hover_speed()
    motors = (
        f"robots.quad{robot + 1}.controllers.motors.parameters.max_speed={largest:.1f}"
        for robot in range(robots)
    )
    return ("stepping.horizon=1000", *motors)


def climbing(compiled: skybody.CompiledScenario) -> list[int]:
    """Indices of the upward speeds of the robots in an environment's observation."""
    names = ("velocity", *(f"{robot}.velocity" for robot in compiled.robots))
    return [channel.first + 2 for channel in compiled.observation_channels if channel.name in names]


def check(
    reset: Callable[[], object],
    fly: Callable[[float, int], Array],
    hold: float,
    substeps: int,
    drawn: bool,
) -> None:
    """Checks, as for the peers, that vehicles hover and that they climb on a tenth more thrust.

    fly(command, steps): the upward speeds of all vehicles after that many steps of a command.
    With drawn constants vehicles drift, and some tip over in their episode of 1 s, while falling
    ones would be at 5 m/s in the middle. Of those the median counts, and nine tenths must climb.
    """
    speeds = np.abs(fly(hold, 1))
    speed, most = (np.median(speeds), 4.0) if drawn else (speeds.max(), 0.05)
    measure.require(bool(speed < most), f"hovering vehicles were at {speed:.3g} m/s")
    reset()
    steps = FLIGHT // substeps
    before = fly(hold, steps)
    more = fly((hold + 1.0) * 1.1**0.5 - 1.0, steps)
    seconds = steps * substeps * vehicle.DT
    # The drift continues; and if thrust is not weight, its tenth is not a tenth of the weight.
    climb = (more - 2.0 * before) / (1.0 + before / (measure.GRAVITY * seconds))
    for speed in np.quantile(climb, (0.05, 0.95) if drawn else (0.0, 1.0)):
        measure.require_climb(float(speed), seconds - vehicle.qdrone2().tau_up)  # the rotors lag


def row(
    effort: measure.Effort,
    scenario: str,
    hold: float,
    mode: str,
    *,
    envs: int,
    threads: int = 2,
    robots: int = 1,
    substeps: int = 1,
    task: str = "hover",
    overrides: tuple[str, ...] = (),
    differs: str = "",
    drawn: bool = False,
) -> None:
    """drawn: masses or thrusts are drawn anew in some episodes, so that vehicles drift."""
    vec = skybody.make_vec(
        scenario, envs, num_threads=threads, infos=False, overrides=overrides, joint=robots > 1
    )
    try:
        vec.reset()
        actions = np.full(vec.action_space.shape or (), hold, np.float32)
        upwards = climbing(vec.compiled)

        def fly(command: float, steps: int) -> Array:
            actions[:] = command
            for _ in range(steps):
                observations = vec.step(actions)[0]
            return observations.reshape(envs, -1)[:, upwards].astype(float)

        peer().row(
            lambda: vec.step(actions),
            effort,
            mode=f"make_vec, {threads} thread{'s' if threads > 1 else ''}{mode}",
            cores=threads,
            envs=envs,
            robots=robots,
            substeps=substeps,
            task=task,
            differs=differs,
            unit="environment steps/s" if task == "engine" else "physics steps/s",
            check=functools.partial(check, vec.reset, fly, hold, substeps, drawn),
        )
    finally:
        vec.close()


def hover(effort: measure.Effort, envs: int, threads: int, task: str = "hover") -> None:
    row(effort, "hover", action(2300.0), "", envs=envs, threads=threads, task=task)


def single(effort: measure.Effort) -> None:
    """One environment without a batch."""
    world = skybody.Simulation("hover")
    world.reset()
    hold = np.full(4, action(2300.0), np.float32)

    def call() -> None:
        world.step(hold)
        _ = world.observation, world.reward
        if world.status:
            world.reset()

    upwards = climbing(world.compiled)

    def fly(command: float, steps: int) -> Array:
        hold[:] = command
        for _ in range(steps):
            call()
        return np.array(world.observation, float)[upwards]

    peer().row(
        call,
        effort,
        mode="Simulation, 1 thread",
        cores=1,
        check=functools.partial(check, world.reset, fly, float(hold[0]), 1, False),
    )


def several(effort: measure.Effort, envs: int, threads: int) -> None:
    """Ten physics steps per call (peers: a hundred); each call returns the last state."""
    row(
        effort,
        "hover",
        action(2300.0),
        ", 10 steps an action",
        envs=envs,
        threads=threads,
        substeps=10,
        overrides=("stepping.action_repeat=10",),
    )


def rk4(effort: measure.Effort, envs: int, threads: int) -> None:
    row(
        effort,
        "hover",
        action(2300.0),
        ", rk4",
        envs=envs,
        threads=threads,
        overrides=("stepping.integrator=rk4",),
        differs="Runge-Kutta of order 4",
    )


def payload(effort: measure.Effort, envs: int, plain: bool, substeps: int = 1) -> None:
    threads = min(envs, 2)
    mode = ", without IMU and drawn constants" if plain else ", as shipped"
    row(
        effort,
        "payload",
        action(2246.0, vehicle.payload().mass),
        mode + (f", {substeps} steps an action" if substeps > 1 else ""),
        envs=envs,
        threads=threads,
        substeps=substeps,
        task="payload",
        overrides=(
            f"stepping.action_repeat={substeps}",
            f"stepping.horizon={1000 // substeps}",  # one second: vehicles stay in the air
            *(PLAIN if plain else ()),
        ),
        differs="" if plain else "noisy IMU; constants drawn in each 10th episode",
        drawn=not plain,
    )


def formation(effort: measure.Effort, robots: int, threads: int) -> None:
    row(
        effort,
        FORMATIONS[robots],
        0.0,
        ", joint observation",
        envs=measure.ROBOT_WORLDS,
        threads=threads,
        robots=robots,
        task="robots",
        overrides=in_flight(robots),
        differs="episodes of 1 s; contact between vehicles; joint observation; drawn constants",
        drawn=True,
    )


def program(
    effort: measure.Effort,
    scenario: str,
    mode: str,
    *,
    envs: int,
    robots: int,
    threads: int = 1,
    short: bool = False,
) -> None:
    """`skybody bench`: the same steps from C++; short: without the joint observation."""
    command = [str(PROGRAMS / "skybody"), "bench", scenario, "--envs", str(envs)]
    seconds = max(0.1, effort.seconds)  # the program starts slowly: fewer, longer trials
    command += ["--threads", str(threads), "--seconds", str(seconds), "--json"]
    overrides = in_flight(robots) if robots > 1 else ()
    if overrides:
        command += ["--actions", "zero"]
    for override in (*overrides, *((f"task={ONE_ROBOT}",) if short else ())):
        command += ["--set", override]
    rates = []
    for _ in range(max(2, round(effort.trials * effort.seconds / seconds))):
        done = subprocess.run(command, check=True, capture_output=True, text=True)
        rates.append(float(json.loads(done.stdout)["physics_steps_per_second"]))
    peer().line(
        rate=max(rates),
        mode=f"C++, skybody bench, {threads} thread{'s' if threads > 1 else ''}{mode}",
        cores=threads,
        envs=envs,
        robots=robots,
        substeps=1,
        task="hover" if robots == 1 else "robots",
        differs=DIFFERS,
        unit="physics steps/s",
    )


# --- the limit ----------------------------------------------------------------------------------


def limit_lines(sections: int) -> list[str]:
    """The first tables that bench_limit prints; it is stopped after them."""
    command = ["stdbuf", "-oL", str(PROGRAMS / "bench_limit")]
    lines: list[str] = []
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as program:
        assert program.stdout is not None
        for line in program.stdout:
            if re.match(SECTION, line):
                sections -= 1
                if sections < 0:
                    program.terminate()
                    break
            lines.append(line)
    return lines


def limit(effort: measure.Effort) -> None:
    """Its best loop at each number of environments; on two threads only in a full run."""
    lines = limit_lines(2 if effort.quick else 8)
    header = next(line for line in lines if line.startswith("million"))
    sizes = [int(size) for size in header.split("environments")[1].split()]
    found, task, cores = measure.Peer("limit", "", "no engine", LIMIT_DIFFERS), "", 0
    best: dict[tuple[str, int, int], tuple[float, str]] = {}
    for line in lines:
        if section := re.match(SECTION, line):
            task = section[1] if section[2] == "1" else ""
            cores = int(section[3])
        elif task in ("hover", "payload") and (rates := re.match(r"  (.+?)  +([\d. ]+)$", line)):
            for envs, rate in zip(sizes, rates[2].split(), strict=True):
                key = (task, cores, envs)
                best[key] = max(best.get(key, (0.0, "")), (1e6 * float(rate), rates[1]))
    for (task, cores, envs), (rate, loop) in best.items():
        found.line(
            rate=rate,
            mode=f"C++, {loop}, {cores} thread{'s' if cores > 1 else ''}",
            cores=cores,
            envs=envs,
            robots=1,
            substeps=1,
            task=task,
            differs=LIMIT_DIFFERS,
            unit="physics steps/s",
        )


def main() -> None:
    parser = measure.parser(__doc__)
    parser.add_argument("--limit", action="store_true", help="only measure the limit (bench_limit)")
    options = parser.parse_args()
    effort = measure.effort(parser, options)
    measure.use_cores(2)
    attempt, some = peer().attempt, functools.partial
    if options.limit:
        attempt("limit", some(limit, effort))
        return
    for envs in effort.sizes():
        attempt(f"hover, {envs}", some(hover, effort, envs, min(envs, 2)))
    for envs in (1, 1024):
        attempt(f"hover, {envs}, 10", some(several, effort, envs, min(envs, 2)))
    attempt("Simulation", some(single, effort))
    for envs in (64, 1024):
        attempt(f"hover, {envs}, 1 thread", some(hover, effort, envs, 1))
        for threads in (1, 2):
            attempt(f"hover, {envs}, rk4, {threads}", some(rk4, effort, envs, threads))
    for plain in (False, True):
        for envs in (1, 1024) if effort.quick else (1, 128, 1024, 8192):
            attempt(f"payload, {envs}", some(payload, effort, envs, plain))
        attempt("payload, 10", some(payload, effort, 1024, plain, substeps=10))
    attempt("engine", some(hover, effort, 1024, 2, "engine"))
    attempt("C++, hover", some(program, effort, "hover", "", envs=1024, robots=1))
    for robots, scenario in FORMATIONS.items():
        for threads in (1, 2):
            attempt(f"{robots} robots", some(formation, effort, robots, threads))
        many = some(program, effort, scenario, envs=measure.ROBOT_WORLDS, robots=robots)
        for threads in (1, 2):
            what = f"C++, {robots} robots, {threads}"
            attempt(what, some(many, ", joint observation", threads=threads))
        attempt(f"C++, {robots}, short", some(many, ", no joint observation", short=True))


if __name__ == "__main__":
    run_program(main)
