"""Packages of the `train` extra, which a plain `pip install .` does not bring."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterable

from skybody.train.algorithms import ALGORITHMS
from skybody.train.hyperparameters import UsageError

TRAINING = ("matplotlib", "stable_baselines3", "torch", "tqdm")
COMPUTING = ("torch", "numpy", "stable-baselines3", "gymnasium")
REMEDY = "`pip install '.[train]'` in Skybody's source folder"


def package_versions(algorithm: str) -> dict[str, str]:
    """Of the packages that a learner computes with; those in C++ need none."""
    if ALGORITHMS[algorithm].is_native:
        return {}
    from importlib import metadata

    return {name: metadata.version(name) for name in COMPUTING}


def demand_packages(names: Iterable[str]) -> None:
    """Raises UsageError, which names all that are missing and what installs them.

    Asked before anything is begun: matplotlib, say, is first used when training is over.
    """
    missing = [name for name in names if importlib.util.find_spec(name) is None]
    if missing:
        raise UsageError(f"needs {', '.join(missing)}, not installed here: {REMEDY}")
