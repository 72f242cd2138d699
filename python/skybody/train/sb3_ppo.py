"""PPO of Stable-Baselines3 on skybody.sb3.SkybodyVecEnv, with checkpoints between rollouts.

iterate() makes one iteration of OnPolicyAlgorithm.learn(). Between iterations the state of a run is
its networks, optimizer, statistics, generators, environments and the few values that the next
rollout reads.
"""

from __future__ import annotations

import copy
import math
import random
from collections import deque
from time import perf_counter
from typing import Any, cast

import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.logger import Logger
from stable_baselines3.common.running_mean_std import RunningMeanStd
from stable_baselines3.common.vec_env import VecEnv, VecEnvWrapper, VecMonitor, VecNormalize
from stable_baselines3.common.vec_env.base_vec_env import VecEnvObs, VecEnvStepReturn

from skybody._native import CompiledScenario
from skybody.sb3 import SkybodyVecEnv
from skybody.train.hyperparameters import Hyperparameters
from skybody.train.learner import Report, Saved, check_finite, diverged, goal_distance, layers_of
from skybody.train.policy_file import Policy
from skybody.train.sb3_policy import NoDistribution, QuickPolicy
from skybody.train.torch_errors import memory_errors

LOSSES = {  # names in the tables, by Stable-Baselines3's names
    "train/policy_gradient_loss": "policy_loss",
    "train/value_loss": "value_loss",
    "train/approx_kl": "kl",
    "train/clip_fraction": "clip_fraction",
    "train/explained_variance": "explained_variance",
    "train/std": "action_std",
    "train/learning_rate": "learning_rate",
}


class Stopwatch(VecEnvWrapper):
    """Adds up the time of the environments."""

    def __init__(self, venv: VecEnv) -> None:
        super().__init__(venv)
        self.seconds = 0.0

    def reset(self) -> VecEnvObs:
        return self.venv.reset()

    def step_async(self, actions: np.ndarray) -> None:
        begin = perf_counter()
        self.venv.step_async(actions)
        self.seconds += perf_counter() - begin

    def step_wait(self) -> VecEnvStepReturn:
        begin = perf_counter()
        result = self.venv.step_wait()
        self.seconds += perf_counter() - begin
        return result


class Moments(RunningMeanStd):
    """Running mean and variance that can be frozen."""

    frozen = False

    def update(self, arr: np.ndarray) -> None:
        if not self.frozen:
            super().update(arr)


class Collector(BaseCallback):
    """Fills the Report of a rollout, step by step."""

    def __init__(self, vec_env: SkybodyVecEnv) -> None:
        super().__init__()
        self.vec_env = vec_env
        self.report = Report()
        self._errors: list[float] = []

    def begin(self) -> Report:
        self.report, self._errors = Report(), []
        return self.report

    def _on_step(self) -> bool:
        if (distance := goal_distance(self.vec_env.last_info)) is not None:
            self._errors.append(float(distance.mean()))
        for i in np.flatnonzero(self.locals["dones"]):
            ended = self.locals["infos"][i]
            self.report.episode_returns.append(float(ended["episode"]["r"]))
            self.report.faults += ended["fault"]
        return True

    def _on_rollout_end(self) -> None:
        if self._errors:
            self.report.position_error = float(np.mean(self._errors))


class Sb3Ppo:
    """The learner `ppo`; for its methods see learner.Learner."""

    def __init__(
        self,
        compiled: CompiledScenario,
        hyper: Hyperparameters,
        seed: int,
        threads: int,
        total_steps: int,
    ) -> None:
        torch.set_num_threads(hyper.torch_threads)
        torch.use_deterministic_algorithms(True)
        self.total_steps, self.hyper = total_steps, hyper
        self.vec_env = SkybodyVecEnv(compiled, hyper.envs, num_threads=threads, seed=seed)
        self.stopwatch = Stopwatch(self.vec_env)
        self.monitor = VecMonitor(self.stopwatch)
        self.normalize = VecNormalize(
            self.monitor,
            norm_reward=hyper.normalize_rewards,
            clip_obs=hyper.observation_clip,
            gamma=hyper.discount,
        )
        statistics = cast(RunningMeanStd, self.normalize.obs_rms)
        self.moments = Moments(shape=statistics.mean.shape)
        self.normalize.obs_rms = self.moments  # type: ignore[assignment]  # SB3: dict or not
        with memory_errors():
            self.model = make_model(self.normalize, hyper, seed)
        self.model.set_logger(Logger(folder=None, output_formats=[]))
        self.collector = Collector(self.vec_env)
        _, self.callback = self.model._setup_learn(total_steps, self.collector)

    @property
    def steps(self) -> int:
        """Environment steps so far."""
        return self.model.num_timesteps

    def iterate(self) -> Report:
        try:
            # NumPy would warn of the numbers that cause this error.
            with memory_errors(), np.errstate(over="ignore", invalid="ignore"):
                report = self._iterate()
        except NoDistribution as error:
            raise diverged("ppo", "the distribution of actions", self.steps) from error
        check_finite("ppo", self.parameters(), self.steps)
        return report

    def _iterate(self) -> Report:
        model, report = self.model, self.collector.begin()
        before, begin = self.stopwatch.seconds, perf_counter()
        self.moments.frozen = not self.hyper.normalizes(self.steps)
        with torch.no_grad():
            limits = self.hyper.noise_limits(self.steps / self.total_steps)
            cast(torch.Tensor, model.policy.log_std).clamp_(**limits)
        cast(QuickPolicy, model.policy).begin_rollout()
        model.collect_rollouts(self.normalize, self.callback, model.rollout_buffer, model.n_steps)
        middle = perf_counter()
        model._update_current_progress_remaining(model.num_timesteps, self.total_steps)
        model.train()
        report.update_seconds = perf_counter() - middle
        report.environment_seconds = self.stopwatch.seconds - before
        report.inference_seconds = middle - begin - report.environment_seconds
        values = model.logger.name_to_value
        report.losses = {ours: float(values[theirs]) for theirs, ours in LOSSES.items()}
        return report

    def parameters(self) -> dict[str, torch.Tensor]:
        return {name: value.detach() for name, value in self.model.policy.state_dict().items()}

    def policy(self) -> Policy:
        statistics, policy = self.moments, self.model.policy
        hidden = layers_of(policy.mlp_extractor.policy_net)
        last = policy.action_net
        if not isinstance(last, torch.nn.Sequential):
            last = torch.nn.Sequential(last)
        return Policy(
            hidden + layers_of(last),
            statistics.mean.copy(),
            1.0 / np.sqrt(statistics.var + self.normalize.epsilon),
            self.normalize.clip_obs,
        )

    # --- checkpoints ----------------------------------------------------------------------------

    def save(self) -> Saved:
        return Saved(self.parameters(), self._state(), self.vec_env.save())

    def _state(self) -> dict[str, Any]:
        model = self.model
        return {
            "policy": model.policy.state_dict(),
            "optimizer": model.policy.optimizer.state_dict(),
            "bookkeeping": {
                "num_timesteps": model.num_timesteps,
                "n_updates": model._n_updates,
                "episode_num": model._episode_num,
                "ep_info_buffer": [_plain(info) for info in model.ep_info_buffer or ()],
                "last_obs": _tensor(model._last_obs),
                "last_original_obs": _tensor(model._last_original_obs),
                "last_episode_starts": _tensor(model._last_episode_starts),
            },
            "monitor": {
                "episode_returns": _tensor(self.monitor.episode_returns),
                "episode_lengths": _tensor(self.monitor.episode_lengths),
            },
            "normalize": {
                "returns": _tensor(self.normalize.returns),
                "old_obs": _tensor(self.normalize.old_obs),
                "old_reward": _tensor(self.normalize.old_reward),
                **_moments("obs_rms", self.normalize.obs_rms),
                **_moments("ret_rms", self.normalize.ret_rms),
            },
            "generators": generators(),
        }

    def restore(self, state: dict[str, Any], environments: bytes) -> None:
        before = copy.deepcopy(self.save())
        try:
            self._put(state, environments)
        except BaseException:
            self._put(before.state, before.environments)
            raise

    def _put(self, state: dict[str, Any], environments: bytes) -> None:
        model, book = self.model, state["bookkeeping"]
        model.policy.load_state_dict(state["policy"])
        model.policy.optimizer.load_state_dict(state["optimizer"])
        model.num_timesteps = book["num_timesteps"]
        model._n_updates, model._episode_num = book["n_updates"], book["episode_num"]
        model.ep_info_buffer = deque(book["ep_info_buffer"], maxlen=model._stats_window_size)
        model._last_obs = book["last_obs"].numpy()
        model._last_original_obs = book["last_original_obs"].numpy()
        model._last_episode_starts = book["last_episode_starts"].numpy()
        model._update_current_progress_remaining(model.num_timesteps, self.total_steps)
        for name, value in state["monitor"].items():
            setattr(self.monitor, name, value.numpy())
        saved = state["normalize"]
        for name in ("returns", "old_obs", "old_reward"):
            setattr(self.normalize, name, saved[name].numpy())
        for name in ("obs_rms", "ret_rms"):
            moments = getattr(self.normalize, name)
            moments.mean = saved[f"{name}.mean"].numpy()
            moments.var = saved[f"{name}.var"].numpy()
            moments.count = saved[f"{name}.count"]
        self.vec_env.restore(environments)
        set_generators(state["generators"])

    def close(self) -> None:
        self.normalize.close()


def make_model(env: VecEnv, hyper: Hyperparameters, seed: int) -> PPO:
    """PPO with our hyper-parameters translated to its arguments."""
    low = hyper.final_learning_rate

    def learning_rate(remaining: float) -> float:
        return hyper.learning_rate * (low + (1.0 - low) * max(0.0, remaining))

    return PPO(
        QuickPolicy,
        env,
        learning_rate=learning_rate,
        n_steps=hyper.rollout_steps,
        batch_size=hyper.minibatch,
        n_epochs=hyper.epochs,
        gamma=hyper.discount,
        gae_lambda=hyper.gae_lambda,
        clip_range=hyper.clip_range,
        ent_coef=hyper.entropy_weight,
        vf_coef=hyper.value_weight,
        max_grad_norm=hyper.max_grad_norm or math.inf,
        target_kl=hyper.target_kl or None,
        policy_kwargs={
            "net_arch": {"pi": list(hyper.hidden), "vf": list(hyper.hidden)},
            "activation_fn": torch.nn.Tanh,
            "log_std_init": hyper.log_std,
            "bounded_mean": hyper.bounded_mean,
        },
        device="cpu",
        seed=seed,
    )


def generators() -> dict[str, Any]:
    """State of the global generators that Stable-Baselines3 may use."""
    version, words, gauss = random.getstate()
    kind, keys, position, has_gauss, cached = np.random.get_state(legacy=True)  # noqa: NPY002
    return {
        "python": [version, list(words), gauss],
        "numpy": [
            kind,
            torch.from_numpy(np.asarray(keys).astype(np.int64)),
            position,
            has_gauss,
            cached,
        ],
        "torch": torch.get_rng_state(),
    }


def set_generators(state: dict[str, Any]) -> None:
    """The inverse of generators()."""
    version, words, gauss = state["python"]
    random.setstate((version, tuple(words), gauss))
    kind, keys, position, has_gauss, cached = state["numpy"]
    words32 = keys.numpy().astype(np.uint32)
    np.random.set_state((kind, words32, position, has_gauss, cached))  # noqa: NPY002
    torch.set_rng_state(state["torch"])


def _tensor(values: Any) -> torch.Tensor:
    return torch.from_numpy(np.array(values))


def _moments(name: str, moments: Any) -> dict[str, Any]:
    return {
        f"{name}.mean": _tensor(moments.mean),
        f"{name}.var": _tensor(moments.var),
        f"{name}.count": float(moments.count),
    }


def _plain(info: dict[str, Any]) -> dict[str, float]:
    return {name: float(value) for name, value in info.items()}
