"""RLlib's PPO learns to hover, on environments that are stepped in C++.

    python examples/rllib_ppo.py [--iterations 20] [--envs 64] [--runners 0] [--address local]

Prints steps and mean return after each iteration. With the --address of a cluster, runners are
distributed over its machines.
"""

import argparse
import time
from typing import Any

from ray.rllib.algorithms.ppo import PPOConfig
from ray.rllib.connectors.env_to_module import MeanStdFilter
from skybody.program import run_program
from skybody.ray.cluster import ADDRESS_HELP, LOCAL, cluster
from skybody.ray.rllib import environments


def config(scenario: str, envs: int, runners: int) -> PPOConfig:
    """PPO's configuration: 32 steps of every environment between two updates."""
    made: PPOConfig = environments(PPOConfig(), scenario, envs, runners=runners)
    normalize = {"env_to_module_connector": lambda env, spaces, device: MeanStdFilter()}
    made.env_runners(rollout_fragment_length=32, **normalize)
    made.rl_module(model_config={"fcnet_hiddens": [64, 64], "fcnet_activation": "tanh"})
    batch = 32 * envs * max(1, runners)
    sizes = {"minibatch_size": min(512, batch), "train_batch_size_per_learner": batch}
    made.training(lr=1e-3, gamma=0.98, lambda_=0.95, clip_param=0.2, num_epochs=2, **sizes)
    return made.training(vf_clip_param=float("inf")).debugging(seed=1, log_level="ERROR")


def summary(result: dict[str, Any]) -> dict[str, float]:
    """Steps and mean return of an iteration's result."""
    runners = result["env_runners"]
    steps, value = runners["num_env_steps_sampled_lifetime"], runners.get("episode_return_mean")
    return {"steps": float(steps), "return": float("nan") if value is None else float(value)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--iterations", type=int, default=20)
    parser.add_argument("--envs", type=int, default=64, help="environments of each runner")
    parser.add_argument("--runners", type=int, default=0, help="0: in the learner's process")
    parser.add_argument("--scenario", default="hover_learn")
    parser.add_argument("--address", default=LOCAL, help=ADDRESS_HELP)
    given = parser.parse_args()
    with cluster(given.address):
        algorithm = config(given.scenario, given.envs, given.runners).build_algo()
        begin = time.perf_counter()
        for _ in range(given.iterations):
            found = summary(algorithm.train())
            rate = found["steps"] / (time.perf_counter() - begin)
            print(f"{found['steps']:9,.0f} steps, {rate:7,.0f} steps/s", end=", ")
            print(f"return {found['return']:.1f}", flush=True)
        algorithm.stop()


if __name__ == "__main__":
    run_program(main)
