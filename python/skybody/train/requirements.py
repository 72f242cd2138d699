"""Packages that training needs, by the extra that brings them."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterable

from skybody.extras import install_command
from skybody.train.algorithms import algorithm_of
from skybody.train.hyperparameters import UsageError

EXTRAS = {
    "": ("matplotlib", "tqdm"),  # all learners; every installation by pip has them
    "sb3": ("stable_baselines3", "torch"),  # learners that are not in C++
}
COMPUTING = ("torch", "numpy", "stable-baselines3", "gymnasium")


def packages_of(algorithm: str) -> tuple[str, ...]:
    """Packages that a learner's training needs. Raises UsageError if there is no such learner."""
    return EXTRAS[""] + (() if algorithm_of(algorithm).is_native else EXTRAS["sb3"])


def package_versions(algorithm: str) -> dict[str, str]:
    """Versions of the packages that a learner computes with; learners in C++ need none."""
    if algorithm_of(algorithm).is_native:
        return {}
    from importlib import metadata

    return {name: metadata.version(name) for name in COMPUTING}


def demand_packages(names: Iterable[str]) -> None:
    """Raises UsageError, which names all missing packages and the install command.

    It is called before a run begins: matplotlib, for example, is first used after training.
    """
    if missing := [name for name in names if importlib.util.find_spec(name) is None]:
        raise UsageError(missing_text(missing))


def missing_text(packages: Iterable[str]) -> str:
    """Message about missing packages, with the install command."""
    names = list(packages)
    extras = [extra for extra, brought in EXTRAS.items() if set(names) & set(brought)]
    return f"needs {', '.join(names)}, not installed here: {install_command(extras)}"
