"""Cost of evaluating sensors relative to a step of the same scenario without them.

    python -m research run sensor_cost [--only NAMES] [--quick] [--out DIR]

`skybody bench` steps a batch on one thread with the sensor, observed so that it is evaluated, and
without it, in turns. Times are processor times, which other load affects little; the least of all
rounds counts on both sides.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from research.common.machine import facts, machine_line
from research.common.options import Options
from research.common.pages import head, markdown_table, write_page
from research.common.programs import run_bench

PAGE = "sensor_cost"
ENVS = 512
ROUNDS, SECONDS = 12, 0.4
# Errors of the IMU in scenarios/payload/payload.yaml.
IMU = (
    "accelerometer_noise: 0.002, gyroscope_noise: 0.000175, "
    "accelerometer_bias: 0.05, gyroscope_bias: 0.003"
)


@dataclass(frozen=True)
class Case:
    """Sensors of a scenario, in place of its own, and their channels."""

    name: str
    scenario: str
    sensors: str  # items of a list
    channels: str  # likewise
    most: float = 0.0  # the goal [%]; 0: none

    def overrides(self, sensed: bool) -> tuple[str, ...]:
        """The overrides with the sensors, or without."""
        return (f"sensors=[{self.sensors * sensed}]", f"observe=[{self.channels * sensed}]")

    def nanoseconds(self, sensed: bool, length: float) -> float:
        """Processor time of a step of an environment [ns]."""
        found = run_bench(self.scenario, length, envs=ENVS, overrides=self.overrides(sensed))
        return 1e9 * float(found["processor_seconds"]) / float(found["env_steps"])


def plugin(name: str, parameters: str = "") -> str:
    """An item of a list of plugins."""
    return f"{{plugin: {name}, parameters: {{{parameters}}}}}"


IMU_CHANNELS = "imu.specific_force, imu.angular_rate"
POSE_CHANNELS = "pose.position, pose.rotation"
MOTION = "ekf.position, ekf.velocity, ekf.rotation"
POSE = plugin("pose", "position_noise: 0.0005, rotation_noise: 0.002")
LOADS = f"{plugin('contact')}, {plugin('force_torque', 'joint: rod_joint')}"
LOAD_CHANNELS = "contact.force, contact.touching, force_torque.force, force_torque.moment"
CASES = (
    Case("imu, ideal", "hover", plugin("imu"), IMU_CHANNELS, 30.0),
    Case("imu, white noise and bias", "hover", plugin("imu", IMU), IMU_CHANNELS, 30.0),
    Case("imu, an ICM-42688", "hover", plugin("imu", "preset: icm42688"), IMU_CHANNELS),
    Case("imu, ideal", "payload_1khz", plugin("imu"), IMU_CHANNELS, 15.0),
    Case("imu, white noise and bias", "payload_1khz", plugin("imu", IMU), IMU_CHANNELS, 15.0),
    Case("imu, white noise and bias", "payload", plugin("imu", IMU), IMU_CHANNELS),
    Case("contact, force_torque", "payload_1khz", LOADS, LOAD_CHANNELS, 15.0),
    Case("flow", "hover", plugin("flow"), "flow.flow, flow.height", 5.0),
    Case("pose, ideal", "hover", plugin("pose"), POSE_CHANNELS, 5.0),
    Case("pose, with noise", "hover", POSE, POSE_CHANNELS),
    Case("gnss", "hover", plugin("gnss"), "gnss.position, gnss.velocity"),
    Case("barometer", "hover", plugin("barometer"), "barometer.altitude"),
    Case("magnetometer", "hover", plugin("magnetometer"), "magnetometer.field"),
    Case("rotor_speed", "hover", plugin("rotor_speed"), "rotor_speed.speed"),
    Case("contact", "hover", plugin("contact"), "contact.force, contact.touching"),
    Case(
        "imu, pose, ekf that reads both",
        "hover",
        f"{plugin('imu', IMU)}, {POSE}, {plugin('ekf', 'pose: pose')}",
        MOTION,
    ),
)


def measured(cases: tuple[Case, ...], rounds: int, length: float) -> list[dict[str, Any]]:
    """A row of each case: the times of all rounds, with the sensors and without, in turns [ns]."""
    rows = [vars(case) | {"with": [], "without": []} for case in cases]
    for turn in range(rounds):
        for case, row in zip(cases, rows, strict=True):
            for name, sensed in (("without", False), ("with", True)):
                row[name].append(case.nanoseconds(sensed, length))
            more = row["with"][-1] / row["without"][-1] - 1.0
            print(
                f"{turn + 1}/{rounds} {case.scenario}, {case.name}: {100 * more:.0f} %", flush=True
            )
    return rows


def cells(row: dict[str, Any]) -> list[str]:
    """A row of the table."""
    sensed, plain = min(row["with"]), min(row["without"])
    more = 100.0 * (sensed / plain - 1.0)
    goal = f"{row['most']:.0f} %" if row["most"] else ""
    verdict = ("met" if more <= row["most"] else "missed") if row["most"] else ""
    times = [f"{plain:.1f}", f"{sensed:.1f}", f"{more:.0f} %"]
    return [row["name"], f"`{row['scenario']}`", *times, goal, verdict]


def page(found: dict[str, Any]) -> str:
    """The page's text."""
    names = "sensors | scenario | step without [ns] | with [ns] | on top | goal | verdict"
    rows = [head(names), *map(cells, found["rows"])]
    return f"""# Cost of sensors

{machine_line(found["facts"])}

    .venv/bin/python -m research run sensor_cost

Processor time of a step of one environment: `skybody bench` with {ENVS} environments, one thread
and the actions `hold`, with the sensors and their channels in the observation and without, in
turns; the least of {found["rounds"]} rounds of {found["length"]:g} s each. A step of `hover` and
`payload_1khz` is one physics step of 1 ms, a step of `payload` ten.

{markdown_table(rows, (0, 1, 6))}

Rates are the defaults: `pose` 125 Hz, `flow` and `magnetometer` 100 Hz, `barometer` 50 Hz, `gnss`
10 Hz, the others 1 kHz. An `imu` with white noise and bias is that of `payload`.

A step of `hover` is so short that its goals allow 9 ns for an `imu` and 1.5 ns for a `pose`. White
noise takes six normal numbers a sample: Philox is about two fifths of that time, their logarithm,
sine and cosine three fifths (`perf`). `force_torque` evaluates the equations of motion once more.
"""


def main() -> int:
    names = sorted({case.name.partition(",")[0] for case in CASES})
    options = (
        Options(__doc__, __name__)
        .add("--only", nargs="+", choices=names, default=names, help="first sensors of rows")
        .given()
    )
    rounds, length = (1, 0.05) if options.quick else (ROUNDS, SECONDS)
    cases = tuple(case for case in CASES if case.name.partition(",")[0] in options.only)
    found: dict[str, Any] = {"facts": facts(), "rounds": rounds, "length": length}
    found["rows"] = measured(cases, rounds, length)
    write_page(options.out, PAGE, page(found), found)
    return 0
