"""Five robots as agents of PettingZoo. `python examples/pettingzoo_formation.py [--episodes 3]`

Each agent has its own observation, action and reward; all fly in one world. The network that comes
with the scenario is shared: it gives every agent's action from that agent's part of `env.state()`.
"""

import argparse

import numpy as np
from skybody.agents import commanded_by
from skybody.multi_agent import ParallelEnv
from skybody.train.policy_file import read_policy, shipped_policy

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--episodes", type=int, default=3)
options = parser.parse_args()
env = ParallelEnv("formation_learn", seed=1)
policy = read_policy(shipped_policy("formation_learn"))
robots = dict(zip(env.possible_agents, env.compiled.agents, strict=True))
for episode in range(options.episodes):
    env.reset()
    returns = dict.fromkeys(env.agents, 0.0)
    while env.agents:
        joint = policy(env.state()[None])[0].astype(np.float32)
        actions = {agent: joint[commanded_by(env.compiled, robots[agent])] for agent in env.agents}
        _, rewards, terminations, _, infos = env.step(actions)
        for agent, reward in rewards.items():
            returns[agent] += reward
    ends = "terminated" if any(terminations.values()) else "truncated"
    print(f"episode {episode + 1} {ends}, success {infos[agent]['success']:.0f}, returns", end=" ")
    print(", ".join(f"{agent} {value:.1f}" for agent, value in returns.items()))
