"""Hyper-parameters: ranges shared by all learners, and the page that lists them."""

from __future__ import annotations

import dataclasses
import math

import pytest
from measurements import module
from skybody._native import CompiledScenario, hyperparameter_rows
from skybody.train import parameter_hash
from skybody.train.hyperparameters import Hyperparameters, UsageError
from training import HORIZON, SCENARIO, learner_of

SHARED = {
    name: (least, largest)
    for name, least, largest, _ in hyperparameter_rows("fast-ppo")
    if isinstance(getattr(Hyperparameters(), name, None), (int, float))
    and not isinstance(getattr(Hyperparameters(), name), bool)
}


@pytest.mark.parametrize("name", [*SHARED, "hidden"])
def test_ppo_has_the_ranges_of_fast_ppo(name: str) -> None:
    least, largest = SHARED.get(name, (1.0, 8192.0))
    beyond = (int(least) - 1, int(largest) + 1)
    if isinstance(getattr(Hyperparameters(), name), float):
        beyond = (least - 1e-9, largest + 1e-6)
    for value in beyond:
        given = (value,) if name == "hidden" else value
        with pytest.raises(UsageError, match=f"hyper-parameter {name} = .*: allowed is "):
            dataclasses.replace(Hyperparameters(), **{name: given}).check()


def test_a_gradient_norm_of_zero_is_no_limit_for_ppo() -> None:
    def trained(most: float) -> str:
        compiled = CompiledScenario(SCENARIO, [HORIZON])
        with learner_of("ppo", compiled, max_grad_norm=most) as learner:
            learner.iterate()
            return parameter_hash(learner.parameters())

    dataclasses.replace(Hyperparameters(), max_grad_norm=0.0).check()
    assert trained(0.0) == trained(1e6)
    assert trained(0.0) != trained(1e-3)


def test_what_is_no_number_is_refused() -> None:
    for value in (math.nan, math.inf):
        with pytest.raises(UsageError, match="allowed is a finite number"):
            dataclasses.replace(Hyperparameters(), log_std=value).check()


def test_the_page_lists_the_learners_hyper_parameters() -> None:
    script = module("hyperparameters")
    assert script.page() == script.TARGET.read_text(encoding="utf-8"), "scripts/update_docs.sh"
