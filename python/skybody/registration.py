"""Gymnasium ids of the shipped scenarios: `skybody/Hover-v0` for `hover`, and so on."""

from __future__ import annotations

import copy
import importlib.util
import sys
from typing import TYPE_CHECKING

from ._native import shipped_scenarios

if TYPE_CHECKING:
    from collections.abc import Sequence
    from importlib.machinery import ModuleSpec
    from types import ModuleType

    from gymnasium.envs.registration import EnvSpec

    from ._native import CompiledScenario


def gymnasium_id(scenario: str) -> str:
    """`skybody/HoverLearn-v0` for `hover_learn`."""
    camel = "".join(word.capitalize() for word in scenario.split("_"))
    return f"skybody/{camel}-v0"


class SpecWithHorizon:
    """Adds the scenario's horizon to the specification that Gymnasium gives an environment.

    `compiled` is the environment's scenario. Registered specifications have no horizon: it would
    require reading all scenarios, and Gymnasium would add a wrapper that counts steps again.
    """

    compiled: CompiledScenario
    _spec: EnvSpec | None = None

    @property
    def spec(self) -> EnvSpec | None:
        """The specification of environments made by `gymnasium.make` or `make_vec`."""
        return self._spec

    @spec.setter
    def spec(self, given: EnvSpec | None) -> None:
        self._spec = copy.copy(given)
        if self._spec is not None and self._spec.max_episode_steps is None:
            self._spec.max_episode_steps = self.compiled.horizon or None


def register() -> None:
    """Registers all shipped scenarios with Gymnasium, now or as soon as it is imported.

    `gymnasium.make` creates a `SkybodyEnv`, `gymnasium.make_vec` a `SkybodyVectorEnv`. A second
    call does nothing.
    """
    if sys.modules.get("gymnasium") is not None:
        _register()
    elif not any(isinstance(finder, _GymnasiumFinder) for finder in sys.meta_path):
        sys.meta_path.insert(0, _GymnasiumFinder())


class _GymnasiumFinder:
    """Finds Gymnasium as the other finders do, and registers when its import is complete.

    Importing Gymnasium takes longer than all other imports here, and programs that train or fly do
    not need it.
    """

    def __init__(self) -> None:
        self._asks_others = False

    def find_spec(
        self, name: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """The method that Python calls on entries of `sys.meta_path`."""
        if name != "gymnasium" or self._asks_others:
            return None
        self._asks_others = True
        try:
            spec = importlib.util.find_spec(name)
        finally:
            self._asks_others = False
        if spec is None or spec.loader is None:
            return spec
        run = spec.loader.exec_module

        def run_and_register(module: ModuleType) -> None:
            run(module)
            _register()

        spec.loader.exec_module = run_and_register  # type: ignore[method-assign]
        return spec


def _register() -> None:
    import gymnasium

    for scenario in shipped_scenarios():
        name = gymnasium_id(scenario)
        if name not in gymnasium.registry:
            gymnasium.register(
                id=name,
                entry_point="skybody.env:SkybodyEnv",
                vector_entry_point="skybody.vector:SkybodyVectorEnv",
                kwargs={"scenario": scenario},
            )
