"""An IMU in hover's observation without any code, trained as flat rows and as a dictionary.

    python examples/imu_observation.py [--steps 100000] [--envs 64] [--seed 0]

The scenario key `observe` adds the IMU's channels to the observation of the task `hover`: the
angular rate for the policy, the specific force for the critic only (`last_info["privileged"]`).
Stable-Baselines3's PPO learns from a Box, then from a Dict. 10^5 steps show that both can be
trained, but hovering by rotor speeds takes some millions (docs/results/learning_speed.md).
"""

import argparse

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
    envs = SkybodyVecEnv("hover", count, seed=seed, overrides=OVERRIDES, dict_observations=as_dict)
    return VecMonitor(envs)


def mean_return(model: PPO, seed: int, as_dict: bool) -> float:
    """Mean return of 32 episodes without exploration."""
    return evaluate_policy(model, environments(32, seed, as_dict), n_eval_episodes=32)[0]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--steps", type=int, default=100_000)
    parser.add_argument("--envs", type=int, default=64)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    torch.set_num_threads(1)  # a small network: more threads wait for one another
    for kind, policy in (("Box", "MlpPolicy"), ("Dict", "MultiInputPolicy")):
        as_dict = kind == "Dict"
        settings = {"n_steps": 32, "batch_size": 512, "n_epochs": 5, "seed": given.seed}
        envs = environments(given.envs, given.seed, as_dict)
        model = PPO(policy, envs, device="cpu", **settings)
        before = mean_return(model, given.seed + 1, as_dict)
        model.learn(given.steps)
        after = mean_return(model, given.seed + 1, as_dict)
        print(f"{kind}: {given.steps} steps, mean return {before:.1f} before, {after:.1f} after")


if __name__ == "__main__":
    run_program(main)
