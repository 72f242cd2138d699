"""C++ learners from Python: slices held by Python objects, and the trainer's view of them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from measurements import module
from skybody._native import (
    CompiledScenario,
    Error,
    Gradient,
    Ppo,
    PpoSlices,
    SlicesLost,
    hyperparameters,
)
from skybody.train.hyperparameters import UsageError, with_settings
from skybody.train.learner import Saved
from skybody.train.native_learners import FastPpo, GradientLearner
from skybody.train.presets import preset

SETTINGS = ["envs=20", "rollout_steps=16", "minibatch=100"]
HYPER = with_settings(preset("hover_learn", "fast-ppo").hyper, SETTINGS)
GRADIENT = preset("hover_learn", "gradient").hyper
TOTAL = 100_000


class HeldHere:
    """All slices in this process, in parts; call number `dies_at` simulates a dead part."""

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


def test_a_part_that_dies_while_it_is_replaced_is_replaced_again(
    compiled: CompiledScenario, monkeypatch: pytest.MonkeyPatch
) -> None:
    held = HeldHere(compiled, [4, 4], HYPER, dies_at=9)
    replace = held.replace

    def replace_or_die() -> None:
        replace()
        if held.replaced == 1:
            raise SlicesLost("it is dead again")

    monkeypatch.setattr(held, "replace", replace_or_die)
    assert hash_of(compiled, held) == hash_of(compiled)
    assert held.replaced == 2


def test_gradients_of_another_size_are_refused(compiled: CompiledScenario) -> None:
    held = HeldHere(compiled, [8], HYPER)

    class Short:
        def __getattr__(self, method: str) -> Any:
            def call(*arguments: Any) -> list[Any]:
                found = getattr(held, method)(*arguments)
                if method != "find_gradients":
                    return found
                return [(sums, policy[:-1], value) for sums, policy, value in found]

            return call

    learner = FastPpo(compiled, HYPER, 1, 1, TOTAL, Short())
    with pytest.raises(ValueError, match="a gradient of the policy"):
        learner.iterate()


def put(learner: Any, saved: Saved) -> None:
    learner.restore(saved.state, saved.environments)


def test_a_restored_learner_goes_on_with_the_same_bits(compiled: CompiledScenario) -> None:
    first = FastPpo(compiled, HYPER, 1, 1, TOTAL)
    first.iterate()
    second = FastPpo(compiled, HYPER, 1, 1, TOTAL)
    for _ in range(3):
        second.iterate()
    put(second, first.save())
    for learner in (first, second):
        learner.iterate()
    assert first.native_hash == second.native_hash
    assert first.steps == second.steps == 640


def test_the_state_of_other_hyper_parameters_is_refused(compiled: CompiledScenario) -> None:
    first = FastPpo(compiled, HYPER, 1, 1, TOTAL)
    other = FastPpo(compiled, with_settings(HYPER, ["hidden=8,8"]), 1, 1, TOTAL)
    with pytest.raises(Error, match="other hyper-parameters"):
        put(other, first.save())


def test_slices_that_there_are_not_are_refused(compiled: CompiledScenario) -> None:
    with pytest.raises(Error, match="slices 6 to 9 are wanted; allowed: 0 to 7"):
        PpoSlices(compiled, vars(HYPER), 1, TOTAL, 6, 4)


def test_a_value_out_of_range_is_refused_with_the_range() -> None:
    with pytest.raises(UsageError, match="hyper-parameter discount = 2: allowed is 0 to 1"):
        with_settings(HYPER, ["discount=2"]).check()


@pytest.mark.parametrize(
    "algorithm, values, message",
    [
        ("fast-ppo", {"physics_steps": 3}, "no hyper-parameter `physics_steps`"),
        ("gradient", {"clip_range": 0.1}, "no hyper-parameter `clip_range`"),
        ("gradient", {"learning_rat": 0.1}, "did you mean `learning_rate`"),
        ("fast-ppo", {"minibatch": 3_000_000_000}, "minibatch = 3000000000: allowed is 2 to 1e"),
        ("fast-ppo", {"hidden": [4] * 64}, "hidden = 64 sizes: allowed is at most 63, as a policy"),
        ("gradient", {"hidden": [4] * 64}, "hidden = 64 sizes: allowed is at most 63, as a policy"),
        ("fast-ppo", {"envs": "many"}, "envs = many: allowed is 1 to"),
        ("fast-ppo", {"observation_clip": 0.0}, "observation_clip = 0: allowed is 0.001 to"),
    ],
)
def test_a_value_that_a_learner_does_not_take_is_named(
    algorithm: str, values: dict[str, object], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        hyperparameters(algorithm, values)


def test_a_rollout_with_more_rows_than_can_be_counted_is_refused(
    compiled: CompiledScenario,
) -> None:
    hyper = with_settings(HYPER, ["envs=16000000", "rollout_steps=100000"])
    with pytest.raises(Error, match="a rollout has 1600000000000 rows"):
        FastPpo(compiled, hyper, 1, 1, TOTAL)


def test_the_manual_has_the_list_of_hyper_parameters_as_it_is() -> None:
    script = module("hyperparameters")
    assert script.page() == script.TARGET.read_text(), "scripts/update_docs.sh writes it anew"


def test_both_learners_stamp_their_policies_and_count_their_steps(
    compiled: CompiledScenario,
) -> None:
    small = ["envs=16", "rollout_steps=8"]
    learners = (
        Ppo(compiled, vars(with_settings(HYPER, ["minibatch=64", *small])), 1, TOTAL, 1),
        Gradient(
            compiled,
            vars(with_settings(preset("hover_learn", "gradient").hyper, small)),
            1,
            TOTAL,
            1,
        ),
    )
    for learner in learners:
        reports = [learner.iterate() for _ in range(2)]
        assert reports[1]["steps"] == learner.steps > reports[0]["steps"]
        parts = ("environment_seconds", "inference_seconds", "update_seconds")
        assert all(reports[1][part] > 0.0 for part in parts)
        assert learner.policy()["scenario_hash"] == f"{compiled.scenario_hash:016x}"


def test_gradient_has_the_same_bits_on_any_number_of_threads_and_after_a_restore(
    compiled: CompiledScenario,
) -> None:
    hyper = with_settings(GRADIENT, ["envs=16", "rollout_steps=8"])
    one, two, restored = (
        GradientLearner(compiled, hyper, 1, threads, TOTAL) for threads in (1, 2, 1)
    )
    one.iterate()
    put(restored, one.save())
    one.iterate()
    restored.iterate()
    two.iterate()
    two.iterate()
    assert one.native_hash == two.native_hash == restored.native_hash
