"""Gradient through the dynamics with PyTorch. `python examples/autograd.py [--iterations 100]`

The gradient of a flight is compared with central differences; then a policy learns from it."""

import argparse

import torch
from skybody import DifferentiableEnv
from skybody.program import run_program


class Transition(torch.autograd.Function):  # a step of the simulator
    @staticmethod
    def forward(ctx, env, link, action):  # `link` has no values: it joins the transitions
        ctx.env, ctx.transition = env, env.transition
        observation, reward, _, _ = env.step(action.numpy())
        return link.clone(), torch.from_numpy(observation), torch.from_numpy(reward)

    @staticmethod
    def backward(ctx, d_link, d_observation, d_reward):
        slopes = [d.numpy() for d in (d_observation, d_reward, d_link)]
        d_action, d_link = map(torch.from_numpy, ctx.env.pull_back(ctx.transition, *slopes))
        return None, d_link, d_action


def fly(env, act):
    """The mean reward of a flight of env.steps under act(t, observation)."""
    observation, rewards = torch.from_numpy(env.reset(seed=1)), [None] * env.steps
    link = torch.zeros(env.num_envs, env.state_size, dtype=torch.float64)
    for t in range(env.steps):
        link, observation, rewards[t] = Transition.apply(env, link, act(t, observation))
    return torch.stack(rewards).mean()


def main(iterations):
    torch.manual_seed(1)
    torch.set_num_threads(1)
    env = DifferentiableEnv("hover_learn", 1, steps=50)  # a second of flight
    actions = (0.21 + 0.2 * torch.randn(50, 1, 4)).requires_grad_()  # 0.21: about hover
    fly(env, lambda t, _: actions[t]).backward()
    nudge = 2.0**-7 * torch.eye(200)[41].reshape(50, 1, 4)  # the action of rotor 1 at t = 10
    up, down = (fly(env, lambda t, _, a=actions + sign * nudge: a[t]) for sign in (1, -1))
    print(f"derivative {actions.grad[10, 0, 1]:.4f}, by differences {(up - down) * 2.0**6:.4f}")
    env = DifferentiableEnv("hover_learn", 32, steps=100)
    policy = torch.nn.Sequential(torch.nn.Linear(22, 32), torch.nn.Tanh(), torch.nn.Linear(32, 4))
    adam = torch.optim.Adam(policy.parameters(), lr=5e-3)
    for iteration in range(iterations):
        reward = fly(env, lambda _, seen: 0.21 + policy(seen))
        adam.zero_grad()
        (-reward).backward()
        torch.nn.utils.clip_grad_norm_(policy.parameters(), 1.0)
        adam.step()
        if iteration % 10 == 0:
            print(f"{iteration}: mean reward {reward:.3f}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--iterations", type=int, default=100)
    run_program(lambda: main(parser.parse_args().iterations))
