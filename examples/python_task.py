"""A custom task in Python, trained with PPO: follow a circle with thrust and body rates.

    python examples/python_task.py [--steps 200000] [--envs 16] [--seed 0]

Environments are stepped in C++ on several threads; observations and rewards are NumPy code, below.
Stable-Baselines3's PPO learns the task; the mean return is printed before and after.
"""

from __future__ import annotations

import argparse
import time

import numpy as np
import torch
from gymnasium.spaces import Box
from numpy.typing import NDArray
from skybody.program import run_program
from skybody.python_task import PythonTask, PythonTaskVectorEnv
from skybody.sb3_adapter import VectorEnvForSb3
from skybody.simulation import EnvStates, SimulationPool
from stable_baselines3 import PPO

RADIUS, HEIGHT, PERIOD = 1.0, 1.5, 4.0  # m, m, s
START = 0.3  # m: largest offset of starts from the circle's first point, per axis
LOST = 2.0  # m from the moving point: ends the episode

OVERRIDES = [
    "randomization=[{plugin: start, parameters: {"
    f"position_min: [{RADIUS - START}, {-START}, {HEIGHT - START}], "
    f"position_max: [{RADIUS + START}, {START}, {HEIGHT + START}]}}}}]"
]


def to_body(rotation: NDArray[np.float64], vector: NDArray[np.float64]) -> NDArray[np.float64]:
    """World vectors (n, 3) in body axes; quaternions (n, 4) w x y z, world from body."""
    w, v = rotation[:, :1], -rotation[:, 1:]
    twice = 2 * np.cross(v, vector)
    turned: NDArray[np.float64] = vector + w * twice + np.cross(v, twice)
    return turned


class FollowCircle(PythonTask):
    """Follow a point that moves around a circle. Actions: thrust and three body rates."""

    control = "ctbr"
    physics_steps = 20  # 50 actions a second
    horizon = 300  # 6 s: one round and a half
    observation_space = Box(-np.inf, np.inf, (15,), np.float32)
    action_space = Box(-1, 1, (4,), np.float32)

    def setup(self, pool: SimulationPool) -> None:
        compiled = pool.compiled
        mass = pool.param(0, f"robots.{compiled.robots[0]}.links.base_link.mass")
        self.weight = mass * 9.81

    def command(self, actions: NDArray[np.float32], states: EnvStates) -> NDArray[np.float64]:
        """Action 0 is level flight: thrust around the weight [N], rates in rad/s."""
        thrust = self.weight * (1 + 0.5 * actions[:, :1])
        return np.hstack([thrust, actions[:, 1:] * [3.0, 3.0, 1.5]])

    def reference(self, states: EnvStates) -> list[NDArray[np.float64]]:
        """The point's position, velocity and acceleration, (n, 3) each."""
        rate = 2 * np.pi / PERIOD
        phase = rate * states.times
        cos, sin, none = RADIUS * np.cos(phase), RADIUS * np.sin(phase), np.zeros_like(phase)
        position = np.stack([cos, sin, none + HEIGHT], axis=1)
        velocity = rate * np.stack([-sin, cos, none], axis=1)
        return [position, velocity, rate**2 * np.stack([-cos, -sin, none], axis=1)]

    def error(self, states: EnvStates) -> NDArray[np.float64]:
        """Distance to the point, (n,) [m]."""
        away = states.positions[:, 0] - self.reference(states)[0]
        distance: NDArray[np.float64] = np.linalg.norm(away, axis=1)
        return distance

    def observation(self, states: EnvStates) -> NDArray[np.float64]:
        """In body axes: the point's relative motion, up, its acceleration, own rates."""
        position, velocity, acceleration = self.reference(states)
        rotation = states.rotations[:, 0]
        up = np.tile([0.0, 0.0, 1.0], (len(rotation), 1))
        return np.hstack(
            [
                to_body(rotation, position - states.positions[:, 0]),
                to_body(rotation, velocity - states.velocities[:, 0]),
                to_body(rotation, up),
                to_body(rotation, acceleration) / 3,
                states.angular_velocities[:, 0] / 3,
            ]
        )

    def reward(self, states: EnvStates, actions: NDArray[np.float32]) -> NDArray[np.float64]:
        """1 at the point; less with distance and for large actions."""
        effort: NDArray[np.float32] = np.square(actions).sum(axis=1)
        value: NDArray[np.float64] = np.exp(-2 * self.error(states)) - 0.02 * effort
        return value

    def terminated(self, states: EnvStates) -> NDArray[np.bool_]:
        return self.error(states) > LOST

    def info(self, states: EnvStates) -> dict[str, NDArray[np.float64]]:
        return {"error": self.error(states)}


def evaluate(model: PPO, episodes: int = 32, seed: int = 1000) -> tuple[float, float]:
    """Mean return, and mean distance in the last second [m], of the policy's mean actions."""
    with_ends = PythonTaskVectorEnv(
        FollowCircle(), "hover", episodes, seed=seed, autoreset="next_step", overrides=OVERRIDES
    )
    observation, _ = with_ends.reset()
    returns, going = np.zeros(episodes), np.ones(episodes, np.bool_)
    errors = []
    for step in range(FollowCircle.horizon):
        actions, _ = model.predict(observation, deterministic=True)
        observation, reward, terminated, truncated, info = with_ends.step(actions)
        returns += np.where(going, reward, 0)
        going &= ~(terminated | truncated)
        if step >= FollowCircle.horizon - 50:
            errors.append(np.where(going, info["error"], LOST))
    with_ends.close()
    return float(returns.mean()), float(np.mean(errors))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--steps", type=int, default=200_000, help="actions of the training")
    parser.add_argument("--envs", type=int, default=16, help="number of environments")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()

    torch.set_num_threads(1)  # small networks: more threads wait for one another
    envs = PythonTaskVectorEnv(
        FollowCircle(),
        "hover",
        options.envs,
        seed=options.seed,
        autoreset="same_step",
        overrides=OVERRIDES,
    )
    model = PPO(
        "MlpPolicy",
        VectorEnvForSb3(envs),
        n_steps=128,
        batch_size=512,
        n_epochs=8,
        learning_rate=lambda left: 1e-3 * left + 1e-5,
        gamma=0.97,
        policy_kwargs={"log_std_init": -0.7},
        seed=options.seed,
        device="cpu",
    )
    before = evaluate(model)
    start = time.perf_counter()
    model.learn(options.steps)
    seconds = time.perf_counter() - start
    after = evaluate(model)
    envs.close()
    print(f"{'':8}{'return':>8}{'error in the last second':>28}")
    for name, (value, error) in (("before", before), ("after", after)):
        print(f"{name:8}{value:8.1f}{error:26.3f} m")
    print(f"{options.steps} actions in {seconds:.0f} s, seed {options.seed}")


if __name__ == "__main__":
    run_program(main)
