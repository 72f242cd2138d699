"""Errors of eight controllers on four references, undisturbed and disturbed.

    python -m research run control_table [--quick] [--out DIR]

Each flight is one of `skybody run hover --reference NAME` with the chain, the effects and the draws
of its row and column, 20 s of a QDrone2 after approach and ramp. The log contains the scenario as
flown.
"""

from __future__ import annotations

import json
import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import yaml

from research.common.machine import facts, machine_line
from research.common.options import Options
from research.common.pages import markdown_table, write_page
from research.common.places import ROOT
from research.common.plots import panels, save
from research.common.programs import run_skybody

PAGE = "control_table"

ROTORS = yaml.safe_load((ROOT / "scenarios/models/qdrone2/rotors.yaml").read_text())
MOST_SPEED = float(ROTORS["defaults"]["max_speed"])  # of a rotor [rad/s]
SECONDS = 20.0  # of a flight that counts

# Unbounded positions, and accelerations as laws that `--reference` itself puts before a chain.
WIDE = "position_min: [-100, -100, -100], position_max: [100, 100, 100]"
PUSH = "max_acceleration_side: 30, max_acceleration_up: 30, max_acceleration_down: 8"
FOLLOWS = f"{WIDE}, {PUSH}"
IMU = (
    "sensors=[{plugin: imu, name: imu, parameters: {robot: quad, accelerometer_noise: 0.004, "
    "gyroscope_noise: 0.0003}}]"
)
CHAINS = {
    "position": f"[{{plugin: position, parameters: {{signal: trajectory, {FOLLOWS}}}}}, "
    "{plugin: attitude, parameters: {feed_forward: true}}, {plugin: ctbr}]",
    "force": f"[{{plugin: flatness, parameters: {{output: acceleration, kp: [6, 6, 9], "
    f"kd: [4, 4, 5.4], {FOLLOWS}}}}}, {{plugin: acceleration, parameters: {{{PUSH}}}}}, "
    "{plugin: force}, {plugin: attitude}, {plugin: ctbr}]",
    "flatness": f"[{{plugin: flatness, parameters: {{output: attitude, kp: [6, 6, 9], "
    f"kd: [4, 4, 5.4], {FOLLOWS}}}}}, {{plugin: attitude, parameters: {{feed_forward: true}}}}, "
    "{plugin: ctbr}]",
    "geometric": f"[{{plugin: geometric, parameters: {{{FOLLOWS}}}}}, {{plugin: ctbt}}]",
    "sliding_mode": f"[{{plugin: sliding_mode, parameters: {{{FOLLOWS}}}}}, {{plugin: ctbt}}]",
    "lqr": f"[{{plugin: lqr, parameters: {{{FOLLOWS}}}}}, {{plugin: ctbt}}]",
    "indi": f"[{{plugin: indi, parameters: {{{FOLLOWS}}}}}]",
    "nmpc": f"[{{plugin: nmpc, parameters: {{preview: true, {WIDE}}}}}, {{plugin: srt}}]",
}
WITH_IMU = {
    "indi": f"[{{plugin: indi, parameters: {{measured: imu, {FOLLOWS}}}}}]",
    "nmpc": f"[{{plugin: nmpc, parameters: {{preview: true, measured: imu, {WIDE}}}}}, "
    "{plugin: srt}]",
}
REFERENCES = {  # title, value of `--reference`, seconds before errors count
    "circle": ("circle, 2 m/s", "circle", 8.0),
    "lissajous": ("the paper's Lissajous, 1.25 m/s", "lissajous", 8.0),
    "step": ("step of 1 m", "step", 8.0),
    "figure_eight_fast": ("figure of eight, 10 m/s", "figure_eight_fast", 10.0),
}
DISTURBANCES = {
    "nothing": ("nothing", []),
    "heavier": (
        "10 % heavier",
        [
            "randomization=[{plugin: draw, name: load, parameters: {what: "
            "[robots.quad.links.base_link.mass], distribution: choice, values: [1.1], "
            "form: scale}}]"
        ],
    ),
    "wind": (
        "wind of 5 m/s, gusts of 3 m/s",
        [
            "effects=[{plugin: wind, parameters: {velocity: [4, 3, 0], gust_speed: 3, "
            "gust_duration: 1, gust_interval: 3}}, {plugin: body_drag, parameters: "
            "{linear: [0.05, 0.05, 0.08], quadratic: [0.02, 0.02, 0.04]}}]"
        ],
    ),
    "rotor": (
        "a rotor at 80 %",
        [
            "effects=[{plugin: rotor_failure, parameters: {rotors: ['0'], kind: partial, "
            "earliest: 0, latest: 0, thrust_gain: 0.8, moment_gain: 0.8}}]"
        ],
    ),
}
GOALS = [  # controllers, reference, disturbance, maximum [cm]
    (("nmpc", "geometric", "indi"), "lissajous", "nothing", 2.0),
    (("indi", "nmpc"), "lissajous", "wind", 10.0),
    (("indi", "nmpc"), "figure_eight_fast", "nothing", 15.0),
]
PUBLISHED = """| controller | flight | RMS | source |
| --- | ---: | ---: | ---: |
| GzDRL's policies, sim-to-real | nine flights, 0.72 m/s | 26.2 cm | the GzDRL paper |
| INDI with flatness | 12.9 m/s, 2.1 g | 6.6 cm | Tal and Karaman, arXiv 1809.04048 |
| NMPC beside flatness-based control, both with INDI and drag model | up to 20 m/s | 78 % less | \
Sun et al., arXiv 2109.01365 |
"""


@dataclass
class Flight:
    """Results of one flight: errors in the last `SECONDS`, or the reason of an early end."""

    controller: str
    reference: str
    disturbance: str
    imu: bool
    rms: float  # [cm]
    largest: float  # [cm]
    effort: float  # cubed rotor speeds over those in hover
    saturated: float  # share of steps
    end: str
    time: np.ndarray  # [s]
    position: np.ndarray
    goal: np.ndarray
    power: np.ndarray

    def facts(self) -> dict[str, Any]:
        names = ("controller", "reference", "disturbance", "imu", "rms", "largest", "effort")
        return {name: getattr(self, name) for name in (*names, "saturated", "end")}


def fly(controller: str, reference: str, disturbance: str, imu: bool, seconds: float) -> Flight:
    _, name, begin = REFERENCES[reference]
    chain = (WITH_IMU if imu else CHAINS)[controller]
    overrides = [f"robots.quad.controllers={chain}", "robots.quad.pose.position=[0,0,1.5]"]
    overrides += ["randomization=[]", "stepping.dt=0.001", "stepping.action_repeat=1"]
    overrides += DISTURBANCES[disturbance][1] + ([IMU] if imu else [])
    steps = round((begin + seconds) / 0.001)
    with tempfile.TemporaryDirectory() as folder:
        words = ("run", "hover", "--reference", name, "--steps", str(steps), "--no-picture")
        run_skybody(*words, "--out", folder, overrides=overrides)
        with h5py.File(f"{folder}/flight.h5") as log:
            return read(log["episodes/0001"], controller, reference, disturbance, imu, begin)


def read(
    episode: h5py.Group, controller: str, reference: str, disturbance: str, imu: bool, begin: float
) -> Flight:
    time = episode["time"][:]
    counts = time > begin
    position, goal = episode["bodies"][:, 0, :3], episode["goal"][:, 0, :3]
    distance = 100.0 * np.linalg.norm(position - goal, axis=1)[counts]
    speed, asked = episode["rotor_speed"][:], episode["rotor_command"][:]
    power = np.mean((speed / speed[0]) ** 3, axis=1)  # the flight begins in hover
    is_at_limit = ((asked <= 0.0) | (asked >= (1.0 - 1e-9) * MOST_SPEED)).any(axis=1)
    return Flight(
        controller,
        reference,
        disturbance,
        imu,
        float(np.sqrt(np.mean(distance**2))) if counts.any() else np.nan,
        float(distance.max()) if counts.any() else np.nan,
        float(power[counts].mean()) if counts.any() else np.nan,
        float(is_at_limit[counts].mean()) if counts.any() else np.nan,
        episode["events"][-1]["text"].decode(),
        time,
        position,
        goal,
        power,
    )


def cell(flight: Flight) -> str:
    if not flight.end.startswith("stopped"):
        return f"{flight.end.split(':')[0]} at {flight.time[-1]:.1f} s"
    text = f"{flight.rms:.2f}" if flight.rms < 10.0 else f"{flight.rms:.0f}"
    return text + (f" ({100.0 * flight.saturated:.0f} %)" if flight.saturated >= 0.005 else "")


def table(flights: list[Flight], reference: str) -> str:
    rows = [["controller", *(title for title, _ in DISTURBANCES.values()), "effort"]]
    for controller in dict.fromkeys((f.controller, f.imu) for f in flights):
        own = {
            f.disturbance: f
            for f in flights
            if (f.controller, f.imu) == controller and f.reference == reference
        }
        name = controller[0] + (", IMU with noise" if controller[1] else "")
        effort = f"{own['nothing'].effort:.2f}"
        rows.append([name, *(cell(own[d]) for d in DISTURBANCES), effort])
    return markdown_table(rows)


def goals(flights: list[Flight]) -> list[str]:
    """A line for each goal, with the measured value."""
    lines = []
    for controllers, reference, disturbance, most in GOALS:
        found = [
            f
            for f in flights
            if f.controller in controllers and f.reference == reference
            if f.disturbance == disturbance
        ]
        values = ", ".join(f"{f.controller}{' (IMU)' if f.imu else ''} {f.rms:.2f}" for f in found)
        met = all(f.rms < most for f in found)
        lines.append(
            f"- below {most:g} cm on {REFERENCES[reference][0]}, {DISTURBANCES[disturbance][0]}: "
            f"{'met' if met else 'not met'} ({values})"
        )
    return lines


def draw(flights: list[Flight], reference: str, file: Path) -> None:
    """Path, error and effort of each controller: undisturbed above, in wind below."""
    figure, axes = panels(2, 3, (15, 8.5))
    for row, disturbance in zip(axes, ("nothing", "wind"), strict=True):
        shown = [f for f in flights if f.reference == reference and f.disturbance == disturbance]
        _, _, begin = REFERENCES[reference]
        for flight in shown:
            if flight.imu:
                continue
            counts = flight.time > begin
            line = {"linewidth": 1.0, "label": flight.controller}
            row[0].plot(flight.position[counts, 0], flight.position[counts, 1], **line)
            error = 100.0 * np.linalg.norm(flight.position - flight.goal, axis=1)
            row[1].semilogy(flight.time[counts], np.maximum(error[counts], 1e-3), **line)
            row[2].plot(flight.time[counts], flight.power[counts], **line)
        goal = shown[0].goal[shown[0].time > begin]
        row[0].plot(goal[:, 0], goal[:, 1], color="black", linewidth=0.8, linestyle="--")
        row[0].set_ylabel(f"{DISTURBANCES[disturbance][0]}\n\ny [m]")
        row[0].set_aspect("equal", adjustable="datalim")
        row[0].set_xlabel("x [m]")
        row[1].set_ylabel("error [cm]")
        row[2].set_ylabel("cubed rotor speeds over hover's")
        for panel in row[1:]:
            panel.set_xlabel("time [s]")
    axes[0, 1].legend(ncol=2, fontsize=8)
    figure.suptitle(REFERENCES[reference][0])
    save(figure, file, 70)


def write(flights: list[Flight], found: dict[str, Any], out: Path) -> None:
    page = [
        "# Eight controllers, four references, three disturbances",
        "",
        machine_line(found),
        "",
        "    .venv/bin/python -m research run control_table",
        "",
        f"RMS of the distance to the reference [cm] of a QDrone2 over {SECONDS:g} s after approach "
        "and ramp, evaluated at each millisecond, by default gains; in brackets the share of steps "
        "in which a rotor's command is at a limit. Effort: cubed rotor speeds over those in hover, "
        "undisturbed. What each chain is stands in the script; `--reference` in "
        "[references.md](../references.md).",
        "",
    ]
    for reference, (title, _, _) in REFERENCES.items():
        image = f"images/control_table/{reference}.png"
        draw(flights, reference, out / image)
        page += [f"## {title[0].upper()}{title[1:]}", "", table(flights, reference), ""]
        page += [f"![Path, error and effort: {title}]({image})", ""]
    page += ["## Goals", "", *goals(flights), ""]
    page += ["## Published figures of such controllers, on real vehicles", ""]
    page += [PUBLISHED]
    content = {"facts": found} | {"flights": [json.dumps(flight.facts()) for flight in flights]}
    write_page(out, PAGE, "\n".join(page), content)


def main() -> int:
    options = Options(__doc__, __name__).given()
    found = facts()
    seconds = 4.0 if options.quick else SECONDS
    cases = [
        (controller, reference, disturbance, imu, seconds)
        for chains, imu in ((CHAINS, False), (WITH_IMU, True))
        for controller in (list(chains)[:1] if options.quick else chains)
        for reference in REFERENCES
        for disturbance in DISTURBANCES
    ]
    with ThreadPoolExecutor() as pool:
        flights = list(pool.map(lambda case: fly(*case), cases))
    write(flights, found, options.out)
    return 0
