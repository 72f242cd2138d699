"""Slices of a PPO's environments on the machines of a cluster, for `skybody._native.Ppo`.

A worker is a Ray actor that holds some consecutive slices. The result of a slice does not depend
on its worker, and the driver adds in the order of the slices: any number of workers gives the
same bits.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from skybody._native import CompiledScenario, Error, PpoSlices, SlicesLost, versions
from skybody.ray.cluster import ClusterError

MOST_SLICES = 8  # slices of a learner; as in learn/common/slice_plan.h
INSTRUCTION_SET = "instruction set"
FUSED = ("v3", "v4")  # with fused multiply-add: networks have the same bits on these


@dataclass(frozen=True)
class Setup:
    """Everything that a worker needs to create its slices."""

    scenario: str
    overrides: list[str]
    plugin_path: list[str]
    scenario_hash: str  # 16 hex digits, of the driver's scenario
    hyper: dict[str, Any]
    seed: int
    total_steps: int


class SliceWorker:
    """Runs in its own process, on any machine."""

    def __init__(self, setup: Setup, first: int, count: int, threads: int) -> None:
        self._arguments = (setup, first, count, threads)
        self._slices: PpoSlices | None = None

    def prepare(self) -> dict[str, str]:
        """Creates the slices. Returns the values that must be the same on all machines."""
        setup, first, count, threads = self._arguments
        compiled = CompiledScenario(setup.scenario, setup.overrides, setup.plugin_path)
        found = f"{compiled.scenario_hash:016x}"
        if found == setup.scenario_hash:
            self._slices = PpoSlices(
                compiled, setup.hyper, setup.seed, setup.total_steps, first, count, threads
            )
        return stamps(setup.scenario, found, compiled)

    def call(self, method: str, *arguments: Any) -> Any:
        """Calls a method of PpoSlices."""
        return getattr(self._slices, method)(*arguments)


REMEDIES = {
    INSTRUCTION_SET: "networks have other bits there; take machines of one kind, or start Ray on "
    "all of them with SKYBODY_ISA=v2, and this command, too",
}


def stamps(scenario: str, scenario_hash: str, compiled: CompiledScenario) -> dict[str, str]:
    """Values that must be the same on all machines, by their names in messages."""
    found = versions()
    instruction_set = str(found["instruction set"])
    return {
        "skybody": str(found["skybody"]),
        INSTRUCTION_SET: " or ".join(FUSED) if instruction_set in FUSED else instruction_set,
        "scenario": f"{scenario} {scenario_hash}",
        **{f"plugin {name}": version for name, version in compiled.plugins.items()},
    }


class RaySlices:
    """All slices, on `workers` actors. Raises SlicesLost if one of them has died."""

    def __init__(self, ray: Any, setup: Setup, slices: int, workers: int, threads: int) -> None:
        """Starts the workers.

        Args:
            slices: number of slices.
            workers: number of workers, at most one per slice.
            threads: threads of each worker.

        Raises:
            ClusterError: a machine has another version, another scenario of that name, or an
                instruction set with other bits.
        """
        self._ray, self._setup, self._threads = ray, setup, threads
        cuts = [slices * k // workers for k in range(workers + 1)]
        self._parts = list(itertools.pairwise(cuts))
        self._actor = ray.remote(num_cpus=threads, max_restarts=0)(SliceWorker)
        self.workers: list[Any] = [None] * workers
        self.replaced = 0
        self._start(range(workers))

    # --- called by skybody._native.Ppo ------------------------------------------------------------

    # Lists have an entry for each slice, in the order of the slices.

    def collect(self, policy: Any, value: Any, *rest: Any) -> list[Any]:
        """Collects a rollout.

        Args:
            policy: parameters of the policy, (p,) float32.
            value: parameters of the value function, (v,) float32.
            rest: number of the iteration; mean (n,) and scale (n,) float64 of the n inputs, and the
                mean of discounted returns, for normalization.

        Returns:
            Pairs: sums over the rollout (8 + 2 n,) float64, as in learn/ppo/ppo_messages.h,
            and returns of the episodes that ended, (episodes,) float32.
        """
        return self._all("collect", self._ray.put(policy), self._ray.put(value), *rest)

    def find_advantages(self, reward_scale: float) -> list[Any]:
        """Sums of the rollout's advantages, (sums,) float64 each."""
        return self._all("find_advantages", reward_scale)

    def find_gradients(self, policy: Any, value: Any, *rest: Any) -> list[Any]:
        """Gradients of a minibatch.

        Args:
            policy: parameters of the policy, (p,) float32.
            value: parameters of the value function, (v,) float32.
            rest: numbers of the pass and of the minibatch, whether each of the two gradients is
                wanted, mean and scale of the advantages.

        Returns:
            Triples: sums (sums,) float64, gradients (p,) and (v,) float32; (0,) if not wanted.
        """
        return self._all("find_gradients", self._ray.put(policy), self._ray.put(value), *rest)

    def stagger_resets(self, iteration: int) -> None:
        self._each(lambda worker: worker.call.remote("stagger_resets", iteration))

    def save(self) -> list[Any]:
        return self._all("save")

    def restore(self, states: list[Any]) -> None:
        parts = iter(self._parts)

        def send(worker: Any) -> Any:
            first, end = next(parts)
            return worker.call.remote("restore", states[first:end])

        self._each(send)

    def replace(self) -> None:
        """Replaces each worker that does not answer by a new one."""
        dead = [k for k, worker in enumerate(self.workers) if not self._answers(worker)]
        self.replaced += len(dead)
        self._start(dead)

    # --- the actors -------------------------------------------------------------------------------

    def _start(self, places: Sequence[int]) -> None:
        for k in places:
            first, end = self._parts[k]
            self.workers[k] = self._actor.remote(self._setup, first, end - first, self._threads)
        try:
            found = [self._ray.get(self.workers[k].prepare.remote()) for k in places]
        except self._ray.exceptions.RayTaskError as error:
            raise ClusterError(f"a worker cannot begin: {error.cause}") from error
        except self._ray.exceptions.RayActorError as error:
            raise SlicesLost(f"a worker ended as it began: {error}") from error
        for of_worker in found:
            self._check(of_worker)

    def _check(self, found: dict[str, str]) -> None:
        compiled = CompiledScenario(
            self._setup.scenario, self._setup.overrides, self._setup.plugin_path
        )
        wanted = stamps(self._setup.scenario, self._setup.scenario_hash, compiled)
        for name, value in wanted.items():
            if found.get(name) != value:
                remedy = REMEDIES.get(name, "install the same on all machines")
                raise ClusterError(
                    f"a worker's machine has {name} {found.get(name)}, this one {value}: {remedy}"
                )

    def _all(self, method: str, *arguments: Any) -> list[Any]:
        lists = self._each(lambda worker: worker.call.remote(method, *arguments))
        return [entry for of_worker in lists for entry in of_worker]

    def _each(self, send: Callable[[Any], Any]) -> list[Any]:
        try:
            answers: list[Any] = self._ray.get([send(worker) for worker in self.workers])
        except self._ray.exceptions.RayTaskError as error:
            raise Error(f"a worker failed: {error.cause}") from error
        except self._ray.exceptions.RayError as error:
            raise SlicesLost(f"a worker is lost: {error}") from error
        return answers

    def _answers(self, worker: Any) -> bool:
        try:
            self._ray.get(worker.__ray_ready__.remote(), timeout=30.0)
        except (self._ray.exceptions.RayError, TimeoutError):
            return False
        return True
