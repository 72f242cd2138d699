"""PPO in one file, as in CleanRL: hover by thrust and body rates. `python examples/ppo.py`"""

import argparse

import skybody
import torch
from torch.distributions import Normal

STEPS, EPOCHS, BATCHES, DISCOUNT, LAMBDA, CLIP = 32, 4, 8, 0.97, 0.95, 0.2


def network(inputs: int, outputs: int) -> torch.nn.Sequential:
    hidden = (torch.nn.Linear(inputs, 64), torch.nn.Tanh(), torch.nn.Linear(64, 64))
    return torch.nn.Sequential(*hidden, torch.nn.Tanh(), torch.nn.Linear(64, outputs))


parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument("--iterations", type=int, default=200, help="of 32 steps of every environment")
parser.add_argument("--envs", type=int, default=256)
options = parser.parse_args()
torch.manual_seed(1)
torch.set_num_threads(1)  # small networks: more threads wait for one another
control = ["robots.quad.controllers=[{plugin: ctbr}]"]
envs = skybody.make_vec("hover_learn", options.envs, autoreset="same_step", overrides=control)
size, actions = envs.single_observation_space.shape[0], envs.single_action_space.shape[0]
actor, critic = network(size, actions), network(size, 1)
log_std = torch.nn.Parameter(torch.full((actions,), -0.5))
optimizer = torch.optim.Adam([*actor.parameters(), *critic.parameters(), log_std], lr=2e-3)
seen = torch.as_tensor(envs.reset()[0].copy())
for iteration in range(1, options.iterations + 1):
    rows = []
    with torch.no_grad():
        for _ in range(STEPS):
            policy = Normal(actor(seen), log_std.exp())
            action = policy.sample()
            after, reward, ended, cut, _ = envs.step(action.numpy())
            value, chance = critic(seen)[:, 0], policy.log_prob(action).sum(1)
            score, going = torch.as_tensor(reward) / 10, 1 - torch.as_tensor(ended | cut).float()
            rows.append((seen, action, chance, value, score, going))
            seen = torch.as_tensor(after.copy())  # the environments use their memory again
        s, a, old, values, rewards, goings = map(torch.stack, zip(*rows, strict=True))
        gain, following, gains = torch.zeros(options.envs), critic(seen)[:, 0], []
        for t in reversed(range(STEPS)):  # generalized advantage estimation
            kept = DISCOUNT * goings[t]
            gain = rewards[t] + kept * following - values[t] + kept * LAMBDA * gain
            following, gains = values[t], [gain, *gains]
    flat = [x.flatten(0, 1) for x in (s, a, old, torch.stack(gains), torch.stack(gains) + values)]
    for batch in (b for _ in range(EPOCHS) for b in torch.randperm(len(flat[0])).chunk(BATCHES)):
        s, a, old, gain, target = (x[batch] for x in flat)
        ratio = (Normal(actor(s), log_std.exp()).log_prob(a).sum(1) - old).exp()
        gain = (gain - gain.mean()) / gain.std()
        surrogate = torch.min(ratio * gain, ratio.clamp(1 - CLIP, 1 + CLIP) * gain)
        loss = (0.5 * (critic(s)[:, 0] - target) ** 2 - surrogate).mean()
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
    if iteration % 20 == 0 or iteration == options.iterations:
        away = s[:, :3].norm(dim=1).median()  # position errors [m]
        reward = 10 * rewards.mean()
        print(f"{iteration:4d}: mean reward {reward:.2f}, {away:.2f} m away", flush=True)
