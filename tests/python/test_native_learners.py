"""Learners in C++, from Python: slices that Python objects hold, and the trainer's view of them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from skybody._native import CompiledScenario, Error, PpoSlices, SlicesLost
from skybody.train.native_learners import FastPpo, GradientLearner
from skybody.train.presets import UsageError, preset, with_settings

SETTINGS = ["envs=20", "rollout_steps=16", "minibatch=100"]
HYPER = with_settings(preset("hover_learn", "fast-ppo"), SETTINGS)
TOTAL = 100_000


class HeldHere:
    """All slices in this process, in parts; its `dies_at`-th call finds a part dead."""

    def __init__(self, compiled: CompiledScenario, parts: list[int], hyper: Any, dies_at: int = -1):
        self.compiled, self.hyper, self.dies_at = compiled, hyper, dies_at
        ends = np.cumsum(parts).tolist()
        self.parts = list(zip([0, *ends], parts, strict=False))
        self.calls = self.replaced = 0
        self.make()

    def make(self) -> None:
        arguments = (self.compiled, vars(self.hyper), 1, TOTAL)
        self.held = [PpoSlices(*arguments, first, count) for first, count in self.parts]

    def replace(self) -> None:
        self.replaced += 1
        self.make()

    def restore(self, states: list[Any]) -> None:
        for (first, count), slices in zip(self.parts, self.held, strict=True):
            slices.restore(states[first : first + count])

    def __getattr__(self, method: str) -> Any:
        def call(*arguments: Any) -> list[Any]:
            self.calls += 1
            if self.calls == self.dies_at:
                raise SlicesLost("a part is dead")
            lists = [getattr(slices, method)(*arguments) or [] for slices in self.held]
            return [entry for part in lists for entry in part]

        return call


@pytest.fixture(scope="module")
def compiled() -> CompiledScenario:
    return CompiledScenario("hover_learn", ["stepping.horizon=40"])


def hash_of(compiled: CompiledScenario, slices: Any = None, hyper: Any = HYPER) -> int:
    learner = FastPpo(compiled, hyper, 1, 1, TOTAL, slices)
    for _ in range(4):
        learner.iterate()
    return learner.native_hash


@pytest.mark.parametrize("units", [0, 4])
@pytest.mark.parametrize("parts", [[8], [4, 4], [3, 5], [1] * 8])
def test_slices_give_the_same_bits_whoever_holds_them(
    compiled: CompiledScenario, parts: list[int], units: int
) -> None:
    hyper = with_settings(HYPER, [f"recurrent_units={units}"])
    held = HeldHere(compiled, parts, hyper)
    assert hash_of(compiled, held, hyper) == hash_of(compiled, None, hyper)


@pytest.mark.parametrize("call", [3, 4, 9, 30])
def test_an_iteration_whose_slices_are_lost_is_done_again_with_the_same_bits(
    compiled: CompiledScenario, call: int
) -> None:
    held = HeldHere(compiled, [4, 4], HYPER, dies_at=call)
    assert hash_of(compiled, held) == hash_of(compiled)
    assert held.replaced == 1


def test_a_restored_learner_goes_on_with_the_same_bits(compiled: CompiledScenario) -> None:
    first = FastPpo(compiled, HYPER, 1, 1, TOTAL)
    first.iterate()
    second = FastPpo(compiled, HYPER, 1, 1, TOTAL)
    for _ in range(3):
        second.iterate()
    second.restore(first.state(), first.environments())
    for learner in (first, second):
        learner.iterate()
    assert first.native_hash == second.native_hash
    assert first.steps == second.steps == 640


def test_the_state_of_other_hyper_parameters_is_refused(compiled: CompiledScenario) -> None:
    first = FastPpo(compiled, HYPER, 1, 1, TOTAL)
    other = FastPpo(compiled, with_settings(HYPER, ["hidden=8,8"]), 1, 1, TOTAL)
    with pytest.raises(Error, match="other hyper-parameters"):
        other.restore(first.state(), first.environments())


def test_slices_that_there_are_not_are_refused(compiled: CompiledScenario) -> None:
    with pytest.raises(Error, match="slices 6 to 9 are wanted; allowed: 0 to 7"):
        PpoSlices(compiled, vars(HYPER), 1, TOTAL, 6, 4)


def test_a_value_out_of_range_is_refused_with_the_range() -> None:
    with pytest.raises(UsageError, match="hyper-parameter discount = 2: allowed is 0 to 1"):
        with_settings(HYPER, ["discount=2"]).check()


def test_gradient_has_the_same_bits_on_any_number_of_threads_and_after_a_restore(
    compiled: CompiledScenario,
) -> None:
    hyper = with_settings(preset("hover_learn", "gradient"), ["envs=16", "rollout_steps=8"])
    one, two, restored = (
        GradientLearner(compiled, hyper, 1, threads, TOTAL) for threads in (1, 2, 1)
    )
    one.iterate()
    restored.restore(one.state(), one.environments())
    one.iterate()
    restored.iterate()
    two.iterate()
    two.iterate()
    assert one.native_hash == two.native_hash == restored.native_hash
