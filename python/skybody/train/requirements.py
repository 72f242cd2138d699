"""Packages that training needs beside those of a plain `pip install .`, by the extra with them."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterable

from skybody.train.algorithms import algorithm_of
from skybody.train.hyperparameters import UsageError

EXTRAS = {
    "train": ("matplotlib", "tqdm"),  # whatever learns
    "sb3": ("stable_baselines3", "torch"),  # learners that are not in C++
}
COMPUTING = ("torch", "numpy", "stable-baselines3", "gymnasium")


def packages_of(algorithm: str) -> tuple[str, ...]:
    """That a learner's training takes. Raises UsageError where there is no such learner."""
    return EXTRAS["train"] + (() if algorithm_of(algorithm).is_native else EXTRAS["sb3"])


def package_versions(algorithm: str) -> dict[str, str]:
    """Of the packages that a learner computes with; those in C++ need none."""
    if algorithm_of(algorithm).is_native:
        return {}
    from importlib import metadata

    return {name: metadata.version(name) for name in COMPUTING}


def demand_packages(names: Iterable[str]) -> None:
    """Raises UsageError, which names all that are missing and what installs them.

    Asked before anything is begun: matplotlib, say, is first used when training is over.
    """
    if missing := [name for name in names if importlib.util.find_spec(name) is None]:
        raise UsageError(missing_text(missing))


def missing_text(packages: Iterable[str]) -> str:
    """That packages are missing, and what installs them."""
    names = list(packages)
    extras = [extra for extra, brought in EXTRAS.items() if set(names) & set(brought)] or ["train"]
    return (
        f"needs {', '.join(names)}, not installed here: `pip install '.[{','.join(extras)}]'` in "
        "Skybody's source folder"
    )
