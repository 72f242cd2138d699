"""Flights of vehicles with known constants, as the logs of real ones: CSV, noise, offsets."""

from __future__ import annotations

import csv
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from skybody import CompiledScenario, SimulationPool
from skybody.identify.rotation import into_body, of_vector, product
from skybody.identify.vehicle import Vehicle

Reals = NDArray[np.float64]
DT = 0.001  # physics step [s]
LOOP = 2  # physics steps of a command, and of a row of the log
VOLTAGE = 3.8  # at which the law of the commands is given [V]
LOGGED = ("px", "py", "pz", "qw", "qx", "qy", "qz", "gx", "gy", "gz", "ax", "ay", "az")
MAP = """\
time: {column: t, unit: s}
robots:
  drone:
    model: models/crazyflie/crazyflie.urdf
    position: {columns: [px, py, pz], unit: m}
    quaternion: {columns: [qw, qx, qy, qz], order: wxyz}
    rotor_speed:
      columns: {front_left: m_front_left, front_right: m_front_right, back_left: m_back_left,
                back_right: m_back_right}
      law: thrust_share
      range: [0, 65535]
sensors:
  imu.angular_rate: {columns: [gx, gy, gz], unit: rad/s, axes: body}
  imu.specific_force: {columns: [ax, ay, az], unit: m/s^2, axes: body}
  battery.voltage: {columns: [vbat], unit: V}
"""
SCENARIO = """\
name: simulated
stepping: {{dt: {dt}, action_repeat: 1}}
contact: {{ground: false}}
robots:
  - name: vehicle
    model: models/crazyflie/crazyflie.urdf
    rotors: {rotors}
    pose: {{position: [0, 0, 1]}}
    rotor_speed: hover
    controllers: [{{plugin: rotor_speed}}]
effects: [{{plugin: body_drag}}]
task: {{plugin: hover}}
"""


@dataclass(frozen=True)
class Truth:
    """A drawn vehicle, with its sensors."""

    values: dict[str, float]
    """By the names of the identification; `command.*` are those of `law`."""
    law: tuple[float, float, float]
    """Speed by share e = s (V / VOLTAGE)^p: c0 + c1 e + c2 e^2 [rad/s]."""
    power: float

    def speed(self, share: Reals, voltage: Reals) -> Reals:
        """Steady speeds of rotors [rad/s]."""
        e = share * (voltage / VOLTAGE) ** self.power
        return np.asarray(self.law[0] + self.law[1] * e + self.law[2] * e * e)

    def share(self, speed: Reals, voltage: float) -> Reals:
        """Commands, 0 to 1, for speeds."""
        c0, c1, c2 = self.law
        root = np.sqrt(np.maximum(c1 * c1 - 4.0 * c2 * (c0 - speed), 0.0))
        e = (root - c1) / (2.0 * c2)
        return np.asarray(np.clip(e / (voltage / VOLTAGE) ** self.power, 0.0, 1.0))

    def command(self, share: float, voltage: float) -> dict[str, float]:
        """The values `command.*` about a mean command and voltage."""
        e = share * (voltage / VOLTAGE) ** self.power
        c0, c1, c2 = self.law
        speed = c0 + c1 * e + c2 * e * e
        return {
            "command.speed": speed,
            "command.slope": e * (c1 + 2.0 * c2 * e) / speed,
            "command.curve": e * e * c2 / speed,
            "command.voltage": self.power,
        }


def drawn(vehicle: Vehicle, rng: np.random.Generator) -> Truth:
    """A vehicle about the nominal one."""

    def around(value: float, spread: float) -> float:
        return float(value * np.exp(rng.normal(0.0, spread)))

    share, slope = rng.uniform(0.5, 0.62), rng.uniform(0.75, 1.1)
    bend = rng.uniform(0.05, 0.2)
    hover = vehicle.hover_speed
    # About the command of hover: speed (1 + slope x + bend x^2), x = e / share - 1.
    law = (hover * (1.0 - slope + bend), hover * (slope - 2.0 * bend) / share,
           hover * bend / share**2)  # fmt: skip
    tau = rng.uniform(0.02, 0.05)
    values = {
        "tau_up": tau, "tau_down": tau * rng.uniform(1.0, 1.7),
        "delay.command": DT * rng.integers(4, 20), "thrust_spread": rng.normal(0.0, 0.005),
        **inertias(vehicle, rng),
        "moment_constant": around(vehicle.rotor("moment_constant"), 0.2),
        "rotor_inertia": around(vehicle.rotor("inertia"), 0.2),
        "com.x": rng.normal(0.0, 8e-4), "com.y": rng.normal(0.0, 8e-4),
        "com.z": rng.normal(0.0, 2e-3),
        "drag.rotor": vehicle.rotor("drag_constant") * rng.uniform(0.5, 2.0),
        "drag.linear_z": vehicle.mass * rng.uniform(0.05, 0.3),
        "drag.quadratic_xy": vehicle.mass * rng.uniform(0.02, 0.1),
        "drag.quadratic_z": vehicle.mass * rng.uniform(0.02, 0.1),
        "delay.imu": 0.0,
    }  # fmt: skip
    for axis in "xyz":
        values[f"pose.tilt_{axis}"] = rng.normal(0.0, 0.01)
        values[f"gyro.bias_{axis}"] = rng.normal(0.0, 0.02)
        values[f"accelerometer.bias_{axis}"] = rng.normal(0.0, 0.1)
    return Truth({k: float(v) for k, v in values.items()}, law, float(rng.uniform(0.6, 1.2)))


def inertias(vehicle: Vehicle, rng: np.random.Generator) -> dict[str, float]:
    """Moments of inertia that a rigid body can have: none is above the sum of the others."""
    nominal = [vehicle.nominal[vehicle.path(f"inertia[{k}]")] for k in range(3)]
    x, y = (float(nominal[k] * np.exp(rng.normal(0.0, 0.12))) for k in range(2))
    ratio = np.sqrt(x * y / (nominal[0] * nominal[1])) * np.exp(rng.normal(0.0, 0.05))
    return {"inertia.x": x, "inertia.y": y, "inertia.z": min(nominal[2] * ratio, 0.97 * (x + y))}


def engine_values(vehicle: Vehicle, values: Mapping[str, float]) -> dict[str, float]:
    """The engine's parameters, by path."""
    made: dict[str, float] = {}
    for k, turn in enumerate(vehicle.directions):
        share = 1.0 + turn * values["thrust_spread"]
        of_rotor = {
            "thrust_constant": vehicle.rotor("thrust_constant") * share,
            "moment_constant": values["moment_constant"] * share,
            "drag_constant": values["drag.rotor"], "inertia": values["rotor_inertia"],
            "tau_up": values["tau_up"], "tau_down": values["tau_down"],
        }  # fmt: skip
        made |= {vehicle.rotor_path(k, name): value for name, value in of_rotor.items()}
    for k, axis in enumerate("xyz"):
        made[vehicle.path(f"com[{k}]")] = values[f"com.{axis}"]
        made[vehicle.path(f"inertia[{k}]")] = values[f"inertia.{axis}"]
        made[f"effects.body_drag.quadratic[{k}]"] = values[
            "drag.quadratic_z" if axis == "z" else "drag.quadratic_xy"
        ]
    made["effects.body_drag.linear[2]"] = values["drag.linear_z"]
    return made


class Pilot:
    """Follows a lively reference, and shakes the vehicle about all axes."""

    def __init__(self, vehicle: Vehicle, rng: np.random.Generator) -> None:
        self._vehicle = vehicle
        self._frequency = rng.uniform(0.25, 0.6, 3)
        self._phase = rng.uniform(0.0, 2.0 * np.pi, 3)
        self._shake = rng.uniform(2.0, 7.0, (3, 4))  # [Hz]
        self._shift = rng.uniform(0.0, 2.0 * np.pi, (3, 4))
        arms = np.array([[1.0, h.position[1], -h.position[0], 0.0] for h in vehicle.hubs])
        ratio = vehicle.rotor("moment_constant") / vehicle.rotor("thrust_constant")
        arms[:, 3] = -ratio * vehicle.directions
        self._mix = np.linalg.pinv(arms.T)

    def speeds(self, time: float, state: Reals) -> Reals:
        """Rotor speeds for a state (13,)."""
        v = self._vehicle
        w = 2.0 * np.pi * self._frequency
        reach = np.array([1.2, 1.2, 0.5])
        wave = w * time + self._phase
        goal = np.array([0.0, 0.0, 2.0]) + reach * np.sin(wave)
        pull = 5.0 * (goal - state[:3]) + 3.5 * (reach * w * np.cos(wave) - state[7:10])
        pull += -reach * w * w * np.sin(wave) + [0.0, 0.0, v.gravity]
        body = into_body(state[3:7], pull)
        thrust = v.mass * np.clip(body[2], 3.0, 16.0)
        # Turn the thrust's axis to the wanted pull.
        lean = np.cross([0.0, 0.0, 1.0], body / np.linalg.norm(body))
        yaw = 2.0 * np.arctan2(state[6], state[3])
        turn = np.array([lean[0], lean[1], 0.3 * np.sin(yaw - 0.8 * np.sin(0.7 * time))])
        shake = np.sin(2.0 * np.pi * self._shake * time + self._shift).sum(axis=1)
        gains = np.array([120.0, 120.0, -40.0]) * turn - np.array([16.0, 16.0, 6.0]) * state[10:]
        wanted = gains + np.array([14.0, 14.0, 8.0]) * shake
        inertia = [v.nominal[v.path(f"inertia[{k}]")] for k in range(3)]
        forces = self._mix @ np.concatenate([[thrust], inertia * wanted])
        forces[:] += 0.06 * thrust / len(forces) * np.sin(2.0 * np.pi * 1.3 * time)
        return np.asarray(np.sqrt(np.maximum(forces, 1e-4) / v.rotor("thrust_constant")))


def simulate(vehicle: Vehicle, truth: Truth, seconds: float, rng: np.random.Generator) -> Reals:
    """A flight: rows of time, state (13), commands (rotors), voltage, specific force (3)."""
    with tempfile.TemporaryDirectory() as folder:
        rotors = Path(folder) / "rotors.yaml"
        fast = {vehicle.rotor_path(k, "max_speed"): 20000.0 for k in range(len(vehicle.hubs))}
        rotors.write_text(vehicle.rotors_text({**vehicle.nominal, **fast}))
        file = Path(folder) / "simulated.yaml"
        file.write_text(SCENARIO.format(dt=DT, rotors=rotors))
        pool = SimulationPool(CompiledScenario(file), 1, num_threads=1)
    pool.reset()
    for path, value in engine_values(vehicle, truth.values).items():
        pool.set_param(0, path, value)
    pilot, rows, moved = Pilot(vehicle, rng), [], []
    waiting = round(truth.values["delay.command"] / DT)
    queue = [np.full(len(vehicle.hubs), vehicle.hover_speed)] * waiting
    for step in range(round(seconds / DT)):
        if step % LOOP == 0:
            state = state_of(pool)
            voltage = 4.0 - 0.4 * step * DT / seconds - 0.02 * np.sin(0.9 * step * DT)
            share = truth.share(pilot.speeds(step * DT, state), voltage)
            rows.append(np.concatenate([[step * DT], state, share, [voltage]]))
        queue.append(truth.speed(share, np.array(voltage)))
        pool.command(queue.pop(0)[None])
        moved.append(pool.velocities[0, 0])
        pool.advance(1)
    pool.close()
    return with_force(np.array(rows)[:-1], np.array(moved), vehicle)


def with_force(rows: Reals, velocities: Reals, vehicle: Vehicle) -> Reals:
    """Rows with the specific force at their times, by central differences."""
    places = LOOP * np.arange(1, len(rows))
    push = (velocities[places + 1] - velocities[places - 1]) / (2.0 * DT)
    push[:, 2] += vehicle.gravity
    return np.concatenate([rows[1:], into_body(rows[1:, 4:8], push)], axis=1)


def state_of(pool: SimulationPool) -> Reals:
    """Motion of the vehicle (13,)."""
    parts = (pool.positions, pool.rotations, pool.velocities, pool.angular_velocities)
    return np.concatenate([part[0, 0] for part in parts])


def write_log(
    file: Path, rows: Reals, vehicle: Vehicle, truth: Truth, rng: np.random.Generator
) -> None:
    """The flight as a CSV, with noise and offsets of its sensors."""
    v, count = truth.values, len(rows)

    def offset(name: str) -> Reals:
        return np.array([v[f"{name}_{axis}"] for axis in "xyz"])

    def noise(size: float) -> Reals:
        return rng.normal(0.0, size, (count, 3))

    tilt = np.broadcast_to(of_vector(offset("pose.tilt")), (count, 4))
    turn = product(product(rows[:, 4:8], tilt), of_vector(noise(0.003)))
    columns = np.concatenate(
        [
            rows[:, :1],
            rows[:, 1:4] + noise(0.001),
            turn,
            rows[:, 11:14] + offset("gyro.bias") + noise(0.02),
            rows[:, -3:] + offset("accelerometer.bias") + noise(0.15),
            np.round(65535.0 * rows[:, 14:18]),
            rows[:, 18:19] + rng.normal(0.0, 0.005, (count, 1)),
        ],
        axis=1,
    )
    names = ["t", *LOGGED, *(f"m_{name}" for name in vehicle.rotor_names), "vbat"]
    with file.open("w", newline="") as opened:
        writer = csv.writer(opened)
        writer.writerow(names)
        writer.writerows([[f"{x:.7g}" for x in row] for row in columns.tolist()])


def is_lost(rows: Reals) -> bool:
    """Whether a flight left its room, or tumbled."""
    return bool(np.abs(rows[:, 1:4]).max() > 6.0 or np.abs(rows[:, 11:14]).max() > 25.0)


def write_flights(
    folder: Path, vehicle: Vehicle, truth: Truth, seconds: float, rng: np.random.Generator
) -> tuple[list[Path], Path]:
    """Two flights of a vehicle, and the map of their columns."""
    files = []
    for number in (1, 2):
        file = folder / f"flight_{number}.csv"
        rows = simulate(vehicle, truth, seconds, rng)
        while is_lost(rows):  # the pilot knows the nominal vehicle alone
            rows = simulate(vehicle, truth, seconds, rng)
        write_log(file, rows, vehicle, truth, rng)
        files.append(file)
    columns = folder / "map.yaml"
    columns.write_text(MAP)
    return files, columns
