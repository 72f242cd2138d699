"""Third-party libraries on our environments: copies, wrappers, learners."""

from __future__ import annotations

import copy
import pickle
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
import skybody
from gymnasium.wrappers import vector as vector_wrappers
from skybody.env import SkybodyEnv
from skybody.multi_agent import ParallelEnv

PAGE = Path(__file__).resolve().parents[2] / "docs/python.md"
COPIES: dict[str, Callable[[Any], Any]] = {
    "pickle": lambda thing: pickle.loads(pickle.dumps(thing)),
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
}
ALL_COPIES = pytest.mark.parametrize("method", COPIES)


# --- copies -----------------------------------------------------------------------------------


def flown(env: SkybodyEnv, steps: int) -> list[Any]:
    """Observations and rewards, episode after episode."""
    rows = []
    action = np.full(env.action_space.shape, 0.3, np.float32)
    for _ in range(steps):
        observation, reward, terminated, truncated, _ = env.step(action)
        rows.append((observation.tolist(), reward))
        if terminated or truncated:
            rows.append(env.reset()[0].tolist())
    return rows


@ALL_COPIES
@pytest.mark.parametrize("seed", [3, None])
def test_a_copied_environment_has_the_same_future(method: str, seed: int | None) -> None:
    env = SkybodyEnv("hover", seed=seed, overrides=["stepping.horizon=30"])
    env.reset()
    flown(env, 20)
    twin = COPIES[method](env)
    assert flown(env, 50) == flown(twin, 50)
    env.close()
    assert flown(twin, 5)


@ALL_COPIES
def test_a_copy_before_the_first_reset_is_not_reset_either(method: str) -> None:
    twin = COPIES[method](SkybodyEnv("hover", seed=5, env_id=2))
    with pytest.raises((skybody.Error, ValueError)):
        twin.step(np.zeros(4, np.float32))
    fresh = SkybodyEnv("hover", seed=5, env_id=2)
    assert np.array_equal(twin.reset()[0], fresh.reset()[0])


def test_a_copy_shares_the_scenario_which_never_changes() -> None:
    env = SkybodyEnv("hover")
    assert copy.deepcopy(env).compiled is env.compiled
    assert copy.copy(env.compiled) is env.compiled


@ALL_COPIES
@pytest.mark.parametrize("as_dict", [False, True])
def test_a_copied_team_has_the_same_future(method: str, as_dict: bool) -> None:
    team = ParallelEnv("formation_2", seed=1, dict_observations=as_dict)
    team.reset()
    twin = COPIES[method](team)
    actions = {agent: np.full(4, 0.2, np.float32) for agent in team.agents}
    for _ in range(5):
        np.testing.assert_equal(team.step(actions), twin.step(actions))


@ALL_COPIES
def test_a_copied_snapshot_puts_everything_back(method: str) -> None:
    simulation = skybody.Simulation("hover", seed=1)
    simulation.reset()
    simulation.step(np.full(4, 0.2, np.float32))
    saved = COPIES[method](simulation.save())
    before = (simulation.observation.tolist(), simulation.reward, simulation.hash())
    simulation.step(np.full(4, -0.2, np.float32))
    simulation.restore(saved)
    assert before == (simulation.observation.tolist(), simulation.reward, simulation.hash())
    assert saved.scenario_hash == simulation.compiled.scenario_hash
    with pytest.raises(ValueError, match="of another scenario"):
        skybody.Simulation("payload").restore(saved)


# --- Gymnasium --------------------------------------------------------------------------------


def test_specifications_say_when_episodes_end() -> None:
    short = ["stepping.horizon=30"]
    env = gymnasium.make("skybody/Hover-v0", overrides=short)
    assert env.spec.max_episode_steps == env.unwrapped.spec.max_episode_steps == 30
    again = gymnasium.make(env.spec)
    again.reset(seed=1)
    ends = [again.step(np.zeros(4, np.float32))[3] for _ in range(30)]
    assert ends == [False] * 29 + [True]
    envs = gymnasium.make_vec("skybody/Hover-v0", num_envs=2, overrides=short)
    assert envs.spec.max_episode_steps == 30
    # A task without an end has no time limit.
    endless = gymnasium.make("skybody/Hover-v0", overrides=["stepping.horizon=0"])
    assert endless.spec.max_episode_steps is None
    assert gymnasium.make("skybody/Hover-v0", max_episode_steps=7).spec.max_episode_steps == 7
    with pytest.raises(ValueError, match=r"flies 30: overrides=\['stepping\.horizon=9'\]"):
        gymnasium.make_vec("skybody/Hover-v0", 2, overrides=short, max_episode_steps=9)


def test_a_training_script_as_cleanrls_runs() -> None:
    """Its environments and wrappers, a rollout of PPO, and an update of the policy."""
    torch = pytest.importorskip("torch")

    def make_env(seed: int) -> Callable[[], gymnasium.Env]:
        def thunk() -> gymnasium.Env:
            env = gymnasium.make("skybody/Hover-v0", overrides=["stepping.horizon=20"], seed=seed)
            env = gymnasium.wrappers.FlattenObservation(env)
            env = gymnasium.wrappers.RecordEpisodeStatistics(env)
            env = gymnasium.wrappers.ClipAction(env)
            env = gymnasium.wrappers.NormalizeObservation(env)
            return gymnasium.wrappers.NormalizeReward(env, gamma=0.99)

        return thunk

    envs = gymnasium.vector.SyncVectorEnv([make_env(seed) for seed in range(3)])
    train_as_cleanrl(torch, envs)
    ours = gymnasium.make_vec("skybody/Hover-v0", num_envs=3, overrides=["stepping.horizon=20"])
    train_as_cleanrl(torch, vector_wrappers.RecordEpisodeStatistics(ours))


def train_as_cleanrl(torch: Any, envs: gymnasium.vector.VectorEnv) -> None:
    torch.manual_seed(1)
    inputs = int(np.prod(envs.single_observation_space.shape))
    outputs = int(np.prod(envs.single_action_space.shape))
    actor = torch.nn.Sequential(
        torch.nn.Linear(inputs, 16), torch.nn.Tanh(), torch.nn.Linear(16, outputs)
    )
    critic = torch.nn.Linear(inputs, 1)
    optimizer = torch.optim.Adam([*actor.parameters(), *critic.parameters()], lr=1e-3)
    observations, _ = envs.reset(seed=1)
    returns, losses = [], []
    for _ in range(50):
        seen = torch.as_tensor(np.array(observations), dtype=torch.float32)
        law = torch.distributions.Normal(actor(seen), 0.3)
        actions = law.sample()
        observations, rewards, _, _, infos = envs.step(actions.numpy())
        loss = -(law.log_prob(actions).sum(1) * torch.as_tensor(np.array(rewards))).mean()
        loss = loss + critic(seen).square().mean()
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        losses.append(loss.item())
        if "episode" in infos:
            returns += infos["episode"]["r"][infos["_episode"]].tolist()
    envs.close()
    assert np.isfinite(losses).all()
    assert len(returns) == 6  # three environments, two episodes each


# --- learners' libraries ----------------------------------------------------------------------


def test_supersuit_concatenates_teams() -> None:
    supersuit = pytest.importorskip("supersuit")
    team = supersuit.pettingzoo_env_to_vec_env_v1(
        ParallelEnv("formation_2", overrides=["stepping.horizon=10"])
    )
    envs = supersuit.concat_vec_envs_v1(team, 3, num_cpus=1, base_class="gymnasium")
    observations, _ = envs.reset(seed=1)
    assert observations.shape == (6, *team.observation_space.shape)  # three teams of two
    ended = 0
    for _ in range(25):
        observations, _, _, truncated, _ = envs.step(np.zeros((6, 4), np.float32))
        ended += int(np.sum(truncated))
    assert np.isfinite(observations).all()
    assert ended == 12


def test_torchrl_wraps_an_environment_and_many() -> None:
    pytest.importorskip("torchrl")
    from torchrl.envs import GymEnv, GymWrapper
    from torchrl.envs.utils import check_env_specs

    one = GymEnv("skybody/Hover-v0", overrides=["stepping.horizon=10"])
    check_env_specs(one)
    rollout = one.rollout(25, break_when_any_done=False)
    assert rollout["next", "truncated"].sum() == 2
    one.close()
    row = next(line for line in PAGE.read_text().splitlines() if line.startswith("| TorchRL"))
    _, *taken, refused = re.findall(r'"(\w+)"', row)
    assert taken == ["disabled", "same_step"]
    assert refused == skybody.make_vec("hover", 3).metadata["autoreset_mode"].name.lower()
    with pytest.raises(RuntimeError, match="must be one of SAME_STEP or DISABLED"):
        GymWrapper(skybody.make_vec("hover", 3, autoreset=refused))
    for autoreset in taken:
        envs = skybody.make_vec("hover", 3, autoreset=autoreset, overrides=["stepping.horizon=10"])
        many = GymWrapper(envs)
        rollout = many.rollout(25, break_when_any_done=False)
        assert rollout.shape == (3, 25)
        assert rollout["next", "truncated"].sum() == 6
        many.close()


def test_skrl_wraps_an_environment_and_many() -> None:
    pytest.importorskip("skrl")
    torch = pytest.importorskip("torch")
    from skrl.envs.wrappers.torch import wrap_env

    for env, count in (
        (gymnasium.make("skybody/Hover-v0"), 1),
        (skybody.make_vec("hover", 4), 4),
    ):
        wrapped = wrap_env(env, wrapper="gymnasium")
        assert wrapped.num_envs == count
        observations, _ = wrapped.reset()
        for _ in range(3):
            step = wrapped.step(torch.full((count, 4), 0.2, device=wrapped.device))
            observations, rewards = step[0], step[1]
        assert observations.shape == (count, 22)
        assert rewards.shape == (count, 1)
        wrapped.close()
