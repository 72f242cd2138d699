"""Workers that are refused, with a local stand-in for Ray; test_ray.py uses Ray itself."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest
from skybody._native import CompiledScenario, versions
from skybody.ray import slices
from skybody.ray.cluster import ClusterError
from skybody.ray.slices import RaySlices, Setup, stamps
from skybody.train.hyperparameters import native_defaults


class Here:
    """The part of `ray` that starts workers; each reports `changes` in the compared values."""

    exceptions = SimpleNamespace(RayTaskError=KeyError, RayActorError=KeyError)

    def __init__(self, **changes: str) -> None:
        self.changes = changes

    def remote(self, **_: Any) -> Any:
        return lambda worker: SimpleNamespace(remote=lambda *a: self._begun(worker(*a)))

    def _begun(self, worker: Any) -> Any:
        found = {**worker.prepare(), **self.changes}
        return SimpleNamespace(prepare=SimpleNamespace(remote=lambda: found))

    def get(self, answer: Any) -> Any:
        return answer


@pytest.fixture(scope="module")
def setup(hover: CompiledScenario) -> Setup:
    hyper = dict(vars(native_defaults("fast-ppo")))
    return Setup(
        "hover", [], [], f"{hover.scenario_hash:016x}", hyper | {"minibatch": 100}, 0, 1000
    )


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"instruction set": "v2"}, "has instruction set v2, this one v3 or v4: networks have"),
        ({"skybody": "0.0.1"}, "has skybody 0.0.1, this one .*: install the same on all machines"),
        ({"scenario": "hover 0123"}, "has scenario hover 0123, this one hover "),
        ({"plugin hover": "9"}, "has plugin hover 9, this one "),
    ],
)
def test_a_worker_with_other_bits_is_refused(
    changes: dict[str, str], message: str, setup: Setup, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(slices, "versions", lambda: {**versions(), "instruction set": "v4"})
    RaySlices(Here(), setup, 8, 2, 1)
    with pytest.raises(ClusterError, match=message):
        RaySlices(Here(**changes), setup, 8, 2, 1)


def test_sets_with_fused_multiply_add_may_be_mixed(
    hover: CompiledScenario, monkeypatch: pytest.MonkeyPatch
) -> None:
    def found(instruction_set: str) -> dict[str, str]:
        of_set = {**versions(), "instruction set": instruction_set}
        monkeypatch.setattr(slices, "versions", lambda: of_set)
        return stamps("hover", "0", hover)

    assert found("v3") == found("v4")
    assert found("v2") != found("v4")
