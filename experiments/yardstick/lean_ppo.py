"""A lean PPO (Schulman et al. 2017) in Python on the native pool: the reference for `fast-ppo`.

A rollout is `rollout_steps` steps of all environments, written to preallocated tensors.
Rows come from the pool without a copy. Observations are normalized by running statistics that are
constant from a rollout's beginning to the end of its update; rewards are divided by the
deviation of the discounted return. Values are computed after the rollout, not step by step.

Episodes end in three ways. After a termination there is no further return. After a truncation the
further return is the value function of the last observation, before the reset. After a fault
there is no further return: nothing may be learned from the state after it. During the first horizon
some environments begin anew after each rollout, so that later rollouts contain all parts of an
episode.

Policy and value function share no parameters, so that each learns from a rollout on a separate
thread: two processors are used, and the bits do not depend on their number. (PyTorch's own
threads synchronize in every operation, which at this size costs more than it gains.)
"""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import pairwise
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np
import torch
from skybody._native import Batch, CompiledScenario, Pool
from skybody.train.learner import Report, Saved, check_finite, columns_of, goal_distance, layers_of
from skybody.train.policy_file import Policy
from torch import Tensor, nn

if TYPE_CHECKING:
    from command import LeanHyperparameters

EPSILON = 1e-8
ADAM_EPSILON = 1e-5  # steps decrease with vanishing gradients, as in most implementations of PPO


class TanhBySigmoid(torch.autograd.Function):
    """tanh x = 2 sigmoid(2 x) - 1, within 2e-7; PyTorch's sigmoid takes a sixth of tanh's time."""

    @staticmethod
    def forward(context: Any, x: Tensor) -> Tensor:
        y = torch.sigmoid(2.0 * x).mul_(2.0).sub_(1.0)
        context.save_for_backward(y)
        return y

    @staticmethod
    def backward(context: Any, gradient: Tensor) -> Any:
        return torch.ops.aten.tanh_backward(gradient, *context.saved_tensors)


class Tanh(nn.Tanh):
    """The activation of both networks."""

    def forward(self, x: Tensor) -> Any:
        return TanhBySigmoid.apply(x)  # type: ignore[no-untyped-call]


class RunningMoments:
    """Mean and variance of all rows so far (Chan et al. 1979), in float64."""

    def __init__(self, size: int) -> None:
        self.mean = torch.zeros(size, dtype=torch.float64)
        self.var = torch.ones(size, dtype=torch.float64)
        self.count = torch.zeros((), dtype=torch.float64)

    def update(self, rows: Tensor) -> None:
        """Adds rows (n, size)."""
        n = rows.shape[0]
        centered = rows.double() - self.mean
        delta = centered.mean(0)
        var = centered.square_().mean(0) - delta**2
        total = self.count + n
        spread = self.count * self.var + n * var + delta**2 * (self.count * n / total)
        self.mean = self.mean + delta * (n / total)
        self.var = spread / total
        self.count = total

    def scale(self) -> Tensor:
        """1 / standard deviation."""
        return 1.0 / torch.sqrt(self.var + EPSILON)


@dataclass
class Rollout:
    """T steps of N environments; row t, i is step t of environment i."""

    observation: Tensor  # (T, N, O), from the environments
    normalized: Tensor  # (T, N, O), inputs of the networks
    action: Tensor  # (T, N, A), before clipping
    noise: Tensor  # (T, N, A), standard normal
    reward: Tensor  # (T, N)
    ended: Tensor  # (T, N), 1: the episode ended with this step
    error: Tensor  # (T, N), position error [m]

    @staticmethod
    def empty(steps: int, envs: int, observation: int, action: int) -> Rollout:
        def rows(*size: int) -> Tensor:
            return torch.full((steps, envs, *size), math.nan)

        seen, done = (rows(observation), rows(observation)), (rows(action), rows(action))
        return Rollout(*seen, *done, rows(), rows(), rows())


class LeanPpo:
    """The learner `lean-ppo`; for its methods see learner.Learner."""

    def __init__(
        self,
        compiled: CompiledScenario,
        hyper: LeanHyperparameters,
        seed: int,
        threads: int,
        total_steps: int,
    ) -> None:
        torch.set_num_threads(hyper.torch_threads)
        torch.use_deterministic_algorithms(True)
        self.hyper, self.total_steps, self.steps = hyper, total_steps, 0
        self.generator = torch.Generator().manual_seed(seed)
        sizes = (compiled.observation_size, compiled.action_size)
        self._make_networks(*sizes)
        self.moments = RunningMoments(sizes[0])
        self.return_moments = RunningMoments(1)
        self.discounted = torch.zeros(hyper.envs)  # return so far, for return_moments
        self.rollout = Rollout.empty(hyper.rollout_steps, hyper.envs, *sizes)
        self.episode_return = torch.zeros(hyper.envs)
        self.info_channels = compiled.info_channels
        self.helper = ThreadPoolExecutor(
            1, initializer=torch.set_num_threads, initargs=(hyper.torch_threads,)
        )
        self.pool = Pool(
            compiled, hyper.envs, num_threads=threads, autoreset="same_step", seed=seed
        )
        self.horizon = compiled.horizon
        self.pool.send_reset()
        self.observation = self.pool.recv().observation  # a view, read by the next step

    def _make_networks(self, observations: int, actions: int) -> None:
        hyper = self.hyper
        self.actor = perceptron([observations, *hyper.hidden, actions], 0.01, self.generator)
        if hyper.bounded_mean:
            self.actor.append(Tanh())
        self.critic = perceptron([observations, *hyper.hidden, 1], 1.0, self.generator)
        self.log_std = nn.Parameter(torch.full((actions,), hyper.log_std))
        policy, value = [*self.actor.parameters(), self.log_std], [*self.critic.parameters()]
        self.optimizers = {
            "policy": torch.optim.Adam(policy, eps=ADAM_EPSILON, fused=True),
            "value": torch.optim.Adam(value, eps=ADAM_EPSILON, fused=True),
        }

    # --- one iteration --------------------------------------------------------------------------

    def iterate(self) -> Report:
        report = Report()
        self.mean, self.scale = self.moments.mean, self.moments.scale()
        begin = perf_counter()
        with torch.no_grad():
            bootstrap = self._collect(report)
        middle = perf_counter()
        report.inference_seconds = middle - begin - report.environment_seconds
        report.losses = self._update(bootstrap)
        if self.hyper.normalizes(self.steps):
            self.moments.update(self.rollout.observation.flatten(0, 1))
        report.update_seconds = perf_counter() - middle
        self.steps += self.hyper.envs * self.hyper.rollout_steps
        self._spread_starts()
        return report

    def _collect(self, report: Report) -> list[tuple[int, Tensor, Tensor]]:
        """Fills the rollout; returns (step, environments, last observations) of truncations."""
        rollout = self.rollout
        rollout.noise.normal_(generator=self.generator)
        limits = self.hyper.noise_limits(self.steps / self.total_steps)
        deviation = self.log_std.clamp_(**limits).exp()
        truncations: list[tuple[int, Tensor, Tensor]] = []
        for t in range(self.hyper.rollout_steps):
            rollout.observation[t] = torch.from_numpy(self.observation)
            rollout.normalized[t] = self._normalized(rollout.observation[t])
            mean = self.actor(rollout.normalized[t])
            torch.addcmul(mean, rollout.noise[t], deviation, out=rollout.action[t])
            begin = perf_counter()
            self.pool.send(rollout.action[t].numpy())
            batch = self.pool.recv()
            report.environment_seconds += perf_counter() - begin
            self.observation = batch.observation
            rollout.reward[t] = torch.from_numpy(batch.reward)
            ended = batch.terminated | batch.truncated
            rollout.ended[t] = torch.from_numpy(ended)
            self.episode_return += rollout.reward[t]
            distance = goal_distance(columns_of(self.info_channels, batch.info))
            if distance is not None:
                rollout.error[t] = torch.from_numpy(distance)
            if ended.any():
                self._end_episodes(batch, ended, report)
                cut = batch.truncated & ~batch.terminated & ~batch.fault
                if cut.any():
                    lost = torch.from_numpy(np.flatnonzero(cut))
                    last = torch.from_numpy(batch.final_observation)[lost]
                    truncations.append((t, lost, last))
        report.position_error = float(rollout.error.mean())
        return truncations

    def _end_episodes(self, batch: Batch, ended: np.ndarray, report: Report) -> None:
        report.faults += int(batch.fault.sum())
        report.episode_returns += self.episode_return.numpy()[ended].tolist()
        self.episode_return[torch.from_numpy(ended)] = 0.0

    def _spread_starts(self) -> None:
        """Resets the k-th of `parts` groups after rollout k, whose last values have been used."""
        envs, steps = self.hyper.envs, self.hyper.rollout_steps
        parts = self.horizon // steps
        group = np.arange(envs) * parts // envs
        if (begins := group == self.steps // (envs * steps)).any():
            self.pool.send_reset(begins)
            self.pool.recv()
            self.observation = self.pool.observations()
            for sums in (self.discounted, self.episode_return):
                sums[torch.from_numpy(begins)] = 0.0

    def _normalized(self, observation: Tensor) -> Tensor:
        """As in policy.h5: in float64, then rounded."""
        clip = self.hyper.observation_clip
        return ((observation - self.mean) * self.scale).clamp_(-clip, clip).float()

    # --- advantages -----------------------------------------------------------------------------

    @torch.no_grad()
    def _advantages(self, truncations: list[tuple[int, Tensor, Tensor]]) -> tuple[Tensor, Tensor]:
        """Advantages and returns (T, N) by GAE (Schulman et al. 2016)."""
        hyper, rollout = self.hyper, self.rollout
        steps, envs = rollout.reward.shape
        value = torch.empty(steps + 1, envs)
        for t, rows in enumerate(rollout.normalized):
            value[t] = self.critic(rows)[:, 0]
        value[-1] = self._value(torch.from_numpy(self.observation))
        reward = rollout.reward * self._update_reward_scale()
        for t, who, last in truncations:
            reward[t, who] += hyper.discount * self._value(last)
        goes_on = (1.0 - rollout.ended) * hyper.discount
        delta = reward + goes_on * value[1:] - value[:-1]
        decay = goes_on * hyper.gae_lambda
        advantage = torch.empty_like(reward)
        following = torch.zeros(envs)
        for t in reversed(range(steps)):
            following = torch.addcmul(delta[t], decay[t], following)
            advantage[t] = following
        return advantage, advantage + value[:-1]

    def _value(self, observation: Tensor) -> Any:
        return self.critic(self._normalized(observation))[:, 0]

    def _update_reward_scale(self) -> Tensor:
        """Adds this rollout to the discounted return's statistics; 1 / their deviation."""
        if not self.hyper.normalize_rewards:
            return torch.ones(1)
        rollout = self.rollout
        returns = torch.empty_like(rollout.reward)
        for t in range(rollout.reward.shape[0]):
            self.discounted = self.discounted * self.hyper.discount + rollout.reward[t]
            returns[t] = self.discounted
            self.discounted = self.discounted * (1.0 - rollout.ended[t])
        self.return_moments.update(returns.view(-1, 1))
        return self.return_moments.scale().float()

    # --- the update -----------------------------------------------------------------------------

    def _update(self, truncations: list[tuple[int, Tensor, Tensor]]) -> dict[str, float]:
        advantage, returns = self._advantages(truncations)
        count, epochs = advantage.numel(), max(self.hyper.epochs, self.hyper.value_epochs)
        orders = [torch.randperm(count, generator=self.generator) for _ in range(epochs)]
        done = min(1.0, self.steps / self.total_steps)
        rate = self.hyper.learning_rate * (1.0 - done * (1.0 - self.hyper.final_learning_rate))
        # The value function's learning rate is constant: a lagging one misleads the policy.
        passes, full = orders[: self.hyper.value_epochs], self.hyper.learning_rate
        fit = self.helper.submit(self._fit_value, returns, passes, full)
        losses = self._improve_policy(advantage, orders[: self.hyper.epochs], rate)
        losses["value_loss"] = fit.result()
        check_finite("lean-ppo", self.parameters(), self.steps)
        error = advantage  # of the value function before the update
        losses["explained_variance"] = float(1 - error.var() / (returns.var() + EPSILON))
        losses["action_std"] = float(self.log_std.detach().exp().mean())
        losses["learning_rate"] = rate
        return losses

    def _fit_value(self, returns: Tensor, orders: list[Tensor], rate: float) -> float:
        """All gradient steps of the value function; returns the mean squared error."""
        size = self.rollout.observation.shape[2]
        data = torch.cat([self.rollout.normalized, returns[..., None]], dim=2).flatten(0, 1)
        losses = []
        for rows in [r for order in orders for r in torch.split(order, self.hyper.minibatch)]:
            part = data[rows]
            loss = (self.critic(part[:, :size])[:, 0] - part[:, size]).square().mean()
            self._descend("value", self.hyper.value_weight * loss, rate)
            losses.append(loss.detach())
        return float(torch.stack(losses).mean())

    def _improve_policy(
        self, advantage: Tensor, orders: list[Tensor], rate: float
    ) -> dict[str, float]:
        """All gradient steps of the policy; returns means of loss, KL divergence, clipped share."""
        hyper, rollout = self.hyper, self.rollout
        with torch.no_grad():  # of the noise, up to a constant that cancels in ratios
            log_probability = -0.5 * rollout.noise.square().sum(2) - self.log_std.sum()
        rest = torch.stack([log_probability, advantage], dim=2)
        data = torch.cat([rollout.normalized, rollout.action, rest], dim=2).flatten(0, 1)
        figures: list[Tensor] = []
        for order in orders:
            passed = len(figures)
            for rows in torch.split(order, hyper.minibatch):
                loss, figure = self._policy_loss(data[rows])
                self._descend("policy", loss, rate)
                figures.append(figure)
            kl = float(torch.stack(figures[passed:])[:, 1].mean())
            if hyper.target_kl and kl > 1.5 * hyper.target_kl:
                break
        means = torch.stack(figures).mean(0).tolist()
        return dict(zip(("policy_loss", "kl", "clip_fraction"), means, strict=True))

    def _policy_loss(self, data: Tensor) -> tuple[Tensor, Tensor]:
        """The clipped surrogate of one minibatch, and (loss, KL divergence, clipped share)."""
        hyper, sizes = self.hyper, [self.rollout.observation.shape[2], len(self.log_std), 1, 1]
        observation, action, old_log_probability, advantage = torch.split(data, sizes, dim=1)
        deviation, mean = torch.std_mean(advantage, correction=0)
        advantage = ((advantage - mean) / (deviation + EPSILON))[:, 0]
        noise = (action - self.actor(observation)) * torch.exp(-self.log_std)
        log_probability = -0.5 * noise.square().sum(1) - self.log_std.sum()
        log_ratio = log_probability - old_log_probability[:, 0]
        ratio = log_ratio.exp()
        clipped = ratio.clamp(1.0 - hyper.clip_range, 1.0 + hyper.clip_range)
        loss = -torch.minimum(advantage * ratio, advantage * clipped).mean()
        with torch.no_grad():
            kl = (ratio - 1.0 - log_ratio).mean()
            outside = ((ratio - 1.0).abs() > hyper.clip_range).float().mean()
            figure = torch.stack([loss, kl, outside])
        return loss - hyper.entropy_weight * self.log_std.sum(), figure

    def _descend(self, network: str, loss: Tensor, rate: float) -> None:
        optimizer = self.optimizers[network]
        group = optimizer.param_groups[0]
        group["lr"] = rate
        optimizer.zero_grad()
        torch.autograd.backward(loss)
        nn.utils.clip_grad_norm_(group["params"], self.hyper.max_grad_norm)
        optimizer.step()

    # --- checkpoints ----------------------------------------------------------------------------

    def parameters(self) -> dict[str, Tensor]:
        networks = {"actor": self.actor, "critic": self.critic}
        named = {
            f"{prefix}.{name}": value.detach()
            for prefix, network in networks.items()
            for name, value in network.state_dict().items()
        }
        return {**named, "log_std": self.log_std.detach()}

    def policy(self) -> Policy:
        mean, scale = self.moments.mean.numpy(), self.moments.scale().numpy()
        return Policy(layers_of(self.actor), mean, scale, self.hyper.observation_clip)

    def save(self) -> Saved:
        return Saved(self.parameters(), self._state(), self._environments())

    def _state(self) -> dict[str, Any]:
        return {
            "steps": self.steps,
            "parameters": self.parameters(),
            "optimizers": {name: adam.state_dict() for name, adam in self.optimizers.items()},
            "moments": vars(self.moments),
            "return_moments": vars(self.return_moments),
            "discounted": self.discounted,
            "episode_return": self.episode_return,
            "generator": self.generator.get_state(),
        }

    def _environments(self) -> bytes:
        return self.pool.save()

    def restore(self, state: dict[str, Any], environments: bytes) -> None:
        self.steps = state["steps"]
        with torch.no_grad():
            for name, parameter in self.parameters().items():
                parameter.copy_(state["parameters"][name])
        for name, adam in self.optimizers.items():
            adam.load_state_dict(state["optimizers"][name])
        vars(self.moments).update(state["moments"])
        vars(self.return_moments).update(state["return_moments"])
        self.discounted, self.episode_return = state["discounted"], state["episode_return"]
        self.generator.set_state(state["generator"])
        self.pool.restore(environments)
        self.observation = self.pool.observations()

    def close(self) -> None:
        self.helper.shutdown()
        self.pool.close()


def perceptron(sizes: list[int], last_gain: float, generator: torch.Generator) -> nn.Sequential:
    """Linear layers with tanh between; orthogonal weights (`last_gain`: the last), no biases."""
    modules: list[nn.Module] = []
    for k, (inputs, outputs) in enumerate(pairwise(sizes)):
        linear = nn.Linear(inputs, outputs)
        last = k == len(sizes) - 2
        nn.init.orthogonal_(linear.weight, last_gain if last else math.sqrt(2), generator)
        nn.init.zeros_(linear.bias)
        modules += [linear] if last else [linear, Tanh()]
    return nn.Sequential(*modules)
