"""Presets: default hyper-parameters and number of steps of a scenario's training.

Those of `folder/NAME.yaml` are in `folder/training/NAME.yaml`, for shipped and for other scenarios,
else beside the nearest scenario that it includes: one key per learner, below it hyper-parameters
and `total_steps`. See docs/training.md.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from skybody._native import CompiledScenario, read_preset, read_settings, training_presets
from skybody.arguments import allowed_words
from skybody.train.algorithms import ALGORITHMS, algorithm_of
from skybody.train.hyperparameters import (
    STEPS_KEY,
    Hyperparameters,
    UsageError,
    whole_number,
    with_settings,
    with_value,
)

TOTAL_STEPS = 1_000_000  # default of a run


@dataclass(frozen=True)
class Preset:
    """Settings of a learner for a scenario."""

    hyper: Hyperparameters
    total_steps: int  # environment steps of a whole run


def told(
    scenario: str,
    algorithm: str,
    compiled: CompiledScenario,
    settings: Sequence[str] = (),
    total_steps: int | None = None,
) -> Preset:
    """Settings of a run: the scenario's preset, overridden by the command line.

    Args:
        scenario: as in preset(); `compiled` is the same scenario, loaded.
        settings: hyper-parameters, KEY=VALUE. They are not checked yet.
        total_steps: None: the preset's.

    Raises:
        InputError, UsageError: as in preset(); and for invalid settings.
    """
    found = preset(scenario, algorithm, compiled.dt * compiled.action_repeat)
    steps = found.total_steps if total_steps is None else total_steps
    return Preset(with_settings(found.hyper, settings), steps)


def presets_file(scenario: str) -> Path:
    """Path of a scenario's presets file, its own or that of the nearest scenario it includes.

    Args:
        scenario: a YAML file, or the name of a shipped one.

    Returns:
        The file. If there is none, the place where the scenario's own would be.
    """
    return Path(training_presets(scenario))


def preset(scenario: str, algorithm: str, action_seconds: float | None = None) -> Preset:
    """The preset for a scenario and a learner; the learner's defaults if there is none.

    Args:
        scenario: a YAML file, or the name of a shipped one.
        algorithm: a key of ALGORITHMS.
        action_seconds: between two actions [s]; some learners need it in scenarios without a
            preset.

    Raises:
        InputError, UsageError: the file of presets is not YAML of this form, or names an unknown
            learner or hyper-parameter, or a wrong value; with places.
    """
    row = algorithm_of(algorithm)
    if row.is_native:
        values, steps = read_preset(scenario, algorithm, action_seconds or 0.0)
        return Preset(dataclasses.replace(row.defaults(), **values), steps)
    return _python_preset(scenario, algorithm, row.defaults())


def _python_preset(scenario: str, algorithm: str, defaults: Hyperparameters) -> Preset:
    """The preset of a learner in Python; see preset()."""
    made = Preset(defaults, TOTAL_STEPS)
    file = presets_file(scenario)
    sections = read_settings(str(file)) if file.is_file() else {}
    for name, (_, place) in sections.items():
        if name not in ALGORITHMS:
            raise UsageError(f"{place}: no learner `{name}`{allowed_words(name, ALGORITHMS)}")
    values, _ = sections.get(algorithm, ({}, ""))
    for key, (text, place) in values.items():
        where = f"{place}: {key}"
        if key == STEPS_KEY:
            made = dataclasses.replace(made, total_steps=whole_number(text, where))
        else:
            hyper = with_value(made.hyper, key, text, where, others=[STEPS_KEY])
            made = dataclasses.replace(made, hyper=hyper)
    try:
        made.hyper.check()
    except UsageError as error:
        _, place = values.get(error.key or "", ("", f"{file}"))
        raise UsageError(f"{place}: {algorithm}: {error}", error.key) from None
    return made
