"""An IMU in hover's observation without any code, trained as flat rows and as a dictionary.

    python examples/imu_observation.py [--steps 100000] [--envs 64] [--seed 0]

The scenario key `observe` adds the IMU's channels to the observation of the task `hover`: the
angular rate for the policy, the specific force for the critic only (`last_info["privileged"]`).
Stable-Baselines3's PPO learns from a Box, then from a Dict; the mean return of an episode is
printed before and after. 10^5 steps show that both can be trained, but are too few to hover by
rotor speeds, which takes some millions (docs/results/learning_speed.md).
"""

from __future__ import annotations

import argparse
import time

import numpy as np
import torch
from skybody.program import run_program
from skybody.sb3 import SkybodyVecEnv
from stable_baselines3 import PPO
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.vec_env import VecMonitor

OVERRIDES = [
    "stepping={dt: 0.001, action_repeat: 10, horizon: 300}",
    "sensors=[{plugin: imu, parameters: {accelerometer_noise: 0.002, gyroscope_noise: 0.0002}}]",
    "observe=[imu.angular_rate, {channel: imu.specific_force, privileged: true}]",
]


def environments(count: int, seed: int, as_dict: bool) -> VecMonitor:
    """Hover with the IMU in its observation."""
    return VecMonitor(
        SkybodyVecEnv("hover", count, seed=seed, overrides=OVERRIDES, dict_observations=as_dict)
    )


def mean_return(model: PPO, seed: int, as_dict: bool) -> float:
    """Mean return of 32 episodes without exploration."""
    envs = environments(32, seed, as_dict)
    returns, _ = evaluate_policy(model, envs, n_eval_episodes=32)
    envs.close()
    return float(np.asarray(returns))


def train(as_dict: bool, steps: int, count: int, seed: int) -> None:
    """Trains for `steps` actions and prints a line."""
    envs = environments(count, seed, as_dict)
    policy = "MultiInputPolicy" if as_dict else "MlpPolicy"
    model = PPO(policy, envs, n_steps=32, batch_size=512, n_epochs=5, device="cpu", seed=seed)
    before, begin = mean_return(model, seed + 1, as_dict), time.perf_counter()
    model.learn(steps)
    seconds = time.perf_counter() - begin
    after = mean_return(model, seed + 1, as_dict)
    kind = "Dict" if as_dict else "Box "
    print(f"{kind}: {model.num_timesteps} steps in {seconds:.0f} s, ", end="")
    print(f"mean return {before:.1f} before, {after:.1f} after")
    envs.close()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--steps", type=int, default=100_000)
    parser.add_argument("--envs", type=int, default=64)
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    torch.set_num_threads(1)  # a small network: more threads wait for one another
    for as_dict in (False, True):
        train(as_dict, arguments.steps, arguments.envs, arguments.seed)


if __name__ == "__main__":
    run_program(main)
