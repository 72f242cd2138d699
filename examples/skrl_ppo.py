"""skrl's PPO learns to hover by thrust and body rates. `python examples/skrl_ppo.py`"""

import argparse
import tempfile

import skybody
import torch
from skrl.agents.torch.ppo import PPO
from skrl.envs.wrappers.torch import wrap_env
from skrl.memories.torch import RandomMemory
from skrl.models.torch import DeterministicMixin, GaussianMixin, Model
from skrl.trainers.torch import SequentialTrainer


def network(inputs: int, outputs: int) -> torch.nn.Sequential:
    hidden = (torch.nn.Linear(inputs, 64), torch.nn.Tanh(), torch.nn.Linear(64, 64))
    return torch.nn.Sequential(*hidden, torch.nn.Tanh(), torch.nn.Linear(64, outputs))


class Actor(GaussianMixin, Model):
    def __init__(self, **spaces: object) -> None:
        Model.__init__(self, **spaces)
        GaussianMixin.__init__(self)
        self.network = network(self.num_observations, self.num_actions)
        self.log_std = torch.nn.Parameter(torch.full((self.num_actions,), -0.5))

    def compute(self, inputs: dict[str, torch.Tensor], role: str) -> tuple[torch.Tensor, dict]:
        return self.network(inputs["observations"]), {"log_std": self.log_std}


class Critic(DeterministicMixin, Model):
    def __init__(self, **spaces: object) -> None:
        Model.__init__(self, **spaces)
        DeterministicMixin.__init__(self)
        self.network = network(self.num_observations, 1)

    def compute(self, inputs: dict[str, torch.Tensor], role: str) -> tuple[torch.Tensor, dict]:
        return self.network(inputs["observations"]), {}


parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--steps", type=int, default=6400, help="of each of 256 environments")
options = parser.parse_args()
torch.set_num_threads(1)  # small networks: more threads wait for one another
control = ["robots.quad.controllers=[{plugin: ctbr}]"]
envs = wrap_env(skybody.make_vec("hover_learn", 256, seed=1, overrides=control), "gymnasium")
spaces = {"observation_space": envs.observation_space, "action_space": envs.action_space}
models = {"policy": Actor(**spaces, device="cpu"), "value": Critic(**spaces, device="cpu")}
settings = {"rollouts": 32, "learning_epochs": 4, "mini_batches": 8, "learning_rate": 2e-3}
settings |= {"discount_factor": 0.97, "rewards_shaper": lambda reward, *_: reward / 10}
settings["experiment"] = {"directory": tempfile.mkdtemp(), "write_interval": 0}
run = {"timesteps": options.steps, "headless": True, "close_environment_at_exit": False}
memory = RandomMemory(memory_size=32, num_envs=256, device="cpu")
agent = PPO(models=models, memory=memory, **spaces, device="cpu", cfg=settings)
SequentialTrainer(env=envs, agents=agent, cfg=run).train()
with torch.no_grad():  # fly by the mean actions
    seen = envs.reset()[0]
    for _ in range(200):
        seen, reward, *_ = envs.step(models["policy"].network(seen))
print(f"after 4 s {seen[:, :3].norm(dim=1).median():.2f} m away, reward {reward.mean():.2f}")
