"""A landing by its camera, trained by Stable-Baselines3's PPO with `MultiInputPolicy`.

    python examples/sb3_images.py [--steps 20000] [--envs 16] [--seed 0]

`landing_vision` observes a row and an image of classes (64 x 64 bytes), in a dictionary. A small
network of convolutions reads the image. `skybody train landing_vision` learns the same in a minute
or two (docs/cameras.md); here some thousand steps show how the environments are used.
"""

import argparse

import torch
from gymnasium import spaces
from skybody.program import run_program
from skybody.sb3 import SkybodyVecEnv
from stable_baselines3 import PPO
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor
from stable_baselines3.common.vec_env import VecMonitor

CLASSES = 4.0  # the greatest class


class RowAndImage(BaseFeaturesExtractor):
    """64 features of the image, and the row as it is."""

    def __init__(self, space: spaces.Dict) -> None:
        self.rows = [name for name, part in space.items() if len(part.shape) == 1]
        (self.image,) = [name for name in space if name not in self.rows]
        super().__init__(space, sum(space[name].shape[0] for name in self.rows) + 64)
        self.convolutions = torch.nn.Sequential(
            torch.nn.Conv2d(1, 16, 8, 4), torch.nn.ReLU(),
            torch.nn.Conv2d(16, 32, 4, 2), torch.nn.ReLU(),
            torch.nn.Flatten(), torch.nn.LazyLinear(64), torch.nn.ReLU(),
        )  # fmt: skip
        self.convolutions(torch.zeros(1, 1, *space[self.image].shape))

    def forward(self, observation: dict[str, torch.Tensor]) -> torch.Tensor:
        image = self.convolutions(observation[self.image].float().unsqueeze(1) / CLASSES)
        return torch.cat([image, *(observation[name] for name in self.rows)], dim=1)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--steps", type=int, default=20000)
    parser.add_argument("--envs", type=int, default=16)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args()
    torch.set_num_threads(1)  # a small network: more threads wait for one another
    envs = VecMonitor(SkybodyVecEnv("landing_vision", options.envs, seed=options.seed))
    kinds = {"features_extractor_class": RowAndImage, "normalize_images": False}
    settings = {"n_steps": 128, "policy_kwargs": kinds, "seed": options.seed, "device": "cpu"}
    model = PPO("MultiInputPolicy", envs, **settings).learn(options.steps)
    returns = [episode["r"] for episode in model.ep_info_buffer]
    print(f"{len(returns)} episodes, mean return {sum(returns) / max(len(returns), 1):.2f}")


if __name__ == "__main__":
    run_program(main)
