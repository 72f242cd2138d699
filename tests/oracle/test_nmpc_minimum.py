"""The first inputs of `nmpc` against SciPy's minimum of the same cost.

The engine runs one real-time iteration per call. With the state held by a tiny physics step, the
iterations converge to the minimum. SciPy minimises the cost over the bounded inputs by a
quasi-Newton method (L-BFGS-B) from differences of the cost only: no derivatives, no condensing, no
active set. The prediction is implemented here in NumPy from the README, with rotation matrices in
place of quaternions and SciPy's rotations for exponential and logarithm.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import skybody
from rigid_body import Reals, Vehicle, read_vehicle
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

ROOT = Path(__file__).resolve().parents[2]
GRAVITY = np.array([0.0, 0.0, -9.81])
NODES, STEP = 4, 0.06
TARGET = np.array([0.3, -0.2, 1.1])  # at rest, yaw 0
WEIGHTS = np.repeat([200.0, 10.0, 10.0, 0.5], 3)  # the defaults: position, velocity, turn, rates
INPUT_WEIGHT, TERMINAL = 5.0, 5.0


@dataclass
class State:
    """Position, velocity (W), attitude (W from B), rates (B), shares of full thrust."""

    position: Reals
    velocity: Reals
    attitude: Reals
    rates: Reals
    share: Reals


class Model:
    """The prediction model of the README, for a vehicle whose rotors all point along z."""

    def __init__(self, vehicle: Vehicle) -> None:
        c = {name: values[0] for name, values in vehicle.constants.items()}  # all rotors alike
        full = c["thrust_constant"] * c["max_speed"] ** 2
        arms = vehicle.hubs - vehicle.com
        reaction = -vehicle.directions * c["moment_constant"] / c["thrust_constant"]
        torque = np.stack([arms[:, 1], -arms[:, 0], reaction]) * full
        self.inertia = vehicle.inertia
        self.lift = full / vehicle.mass  # [m/s^2] of one rotor
        self.spin = np.linalg.solve(vehicle.inertia, torque)
        self.hover = 9.81 / (4.0 * self.lift)
        speed = c["max_speed"] * np.sqrt(self.hover)
        self.drag = np.array([1.0, 1.0, 0.0]) * 4.0 * c["drag_constant"] * speed / vehicle.mass
        self.tau_up, self.tau_down = c["tau_up"], c["tau_down"]

    def gyro(self, w: Reals) -> Reals:
        return np.linalg.solve(self.inertia, np.cross(w, self.inertia @ w))

    def after(self, x: State, u: Reals) -> State:
        h = STEP
        ratio = np.where(u > x.share, self.tau_up, self.tau_down) / h
        decay = np.exp(-1.0 / ratio)
        gap, mean = x.share - u, (1.0 - decay) * ratio
        share, second = u + gap * mean, u + gap * 2.0 * ratio * (1.0 - mean)
        middle = x.rates + h / 2 * (self.spin @ second - self.gyro(x.rates))
        half = x.attitude @ Rotation.from_rotvec(h / 4 * (x.rates + middle)).as_matrix()
        push = np.array([0.0, 0.0, self.lift * share.sum()])
        # v_m contains its own drag: (1 + h/2 D) R_m^T v_m = R_m^T (v + h/2 g) + h/2 push.
        air = (half.T @ (x.velocity + h / 2 * GRAVITY) + h / 2 * push) / (1 + h / 2 * self.drag)
        velocity = x.velocity + h * (GRAVITY + half @ (push - self.drag * air))
        return State(
            x.position + h / 2 * (x.velocity + velocity),
            velocity,
            x.attitude @ Rotation.from_rotvec(h * middle).as_matrix(),
            x.rates + h * (self.spin @ share - self.gyro(middle)),
            u + gap * decay,
        )

    def cost(self, start: State, inputs: Reals, share: float) -> float:
        """Cost of the inputs.

        @param share  factor on the weights of position and velocity (README: the cosine)
        """
        total, x = 0.0, start
        weights = WEIGHTS * np.repeat([share, share, 1.0, 1.0], 3)
        for k, u in enumerate(inputs.reshape(NODES, 4)):
            total += INPUT_WEIGHT * np.sum((u - self.hover) ** 2)
            x = self.after(x, u)
            turn = Rotation.from_matrix(x.attitude).as_rotvec()
            error = np.concatenate([x.position - TARGET, x.velocity, turn, x.rates])
            total += (TERMINAL if k == NODES - 1 else 1.0) * float(weights @ error**2)
        return total


def by_scipy(model: Model, start: State) -> Reals:
    cosine = start.attitude[2, 2]
    share = max(0.01, (0.5 + 0.5 * cosine) ** 2)
    found = minimize(
        lambda inputs: model.cost(start, inputs, share),
        np.full(4 * NODES, model.hover),
        method="L-BFGS-B",
        bounds=[(0.0, 1.0)] * (4 * NODES),
        options={"maxiter": 2000, "maxfun": 100000, "ftol": 1e-15, "gtol": 1e-9},
    )
    return found.x[:4]


def by_skybody(vehicle: Vehicle, start: State) -> Reals:
    """The commands [shares] after many iterations at one state."""
    guide = (
        f"{{plugin: nmpc, parameters: {{horizon: {NODES}, node_step: {STEP}, period: 1, "
        "max_disturbance: 0, max_angular_disturbance: 0}}"
    )
    speed = float(vehicle.constants["max_speed"][0] * np.sqrt(start.share[0]))
    sim = skybody.Simulation(
        "hover",
        control=f"[{guide}, {{plugin: srt}}]",
        overrides=[
            "stepping.dt=1e-6",
            "randomization=[]",
            "contact.ground=false",
            f"robots.quad.rotor_speed={speed!r}",
        ],
    )
    sim.reset()
    x, y, z, w = Rotation.from_matrix(start.attitude).as_quat()
    sim.teleport(
        position=start.position,
        rotation=[w, x, y, z],
        velocity=start.velocity,
        angular_velocity=start.rates,
    )
    sim.command(np.concatenate([TARGET, np.zeros(14)]))
    assert sim.advance(60)  # 60 us: the vehicle moves by less than 0.1 mm
    return (np.asarray(sim.rotor_commands) / vehicle.constants["max_speed"][0]) ** 2


STARTS = {
    "gentle": State(
        np.array([0.25, -0.1, 1.0]),
        np.array([0.2, 0.1, -0.1]),
        Rotation.from_rotvec([0.1, -0.05, 0.1]).as_matrix(),
        np.array([0.2, -0.1, 0.1]),
        np.full(4, 0.4),
    ),
    "at the rotors' limits": State(
        np.array([-0.5, 0.4, 0.8]),
        np.array([-1.0, 0.5, -1.0]),
        Rotation.from_rotvec([0.5, -0.4, 0.6]).as_matrix(),
        np.array([2.0, -1.0, 1.0]),
        np.full(4, 0.3),
    ),
}


@pytest.mark.parametrize("name", STARTS)
def test_first_inputs_are_those_of_the_least_cost(name: str) -> None:
    vehicle = read_vehicle(ROOT / "scenarios/models/qdrone2")
    start = STARTS[name]
    expected = by_scipy(Model(vehicle), start)
    found = by_skybody(vehicle, start)
    at_limits = int(np.sum((expected < 1e-6) | (expected > 1.0 - 1e-6)))
    assert (at_limits > 0) == (name != "gentle"), "the case tests what its name says"
    # Gauss-Newton omits the dynamics' second derivatives only in the Hessian, so its fixed point is
    # the minimum. SciPy stops at the resolution of the cost's differences: 1e-4 of full thrust.
    np.testing.assert_allclose(found, expected, atol=1e-3)
