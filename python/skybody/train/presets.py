"""Presets: hyper-parameters and steps that a scenario is trained with where nobody says otherwise.

Those of `folder/NAME.yaml` are in `folder/training/NAME.yaml`, shipped scenarios' like anybody's:
a key a learner, below it hyper-parameters and `total_steps`. docs/training.md says more.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from skybody._native import CompiledScenario, read_settings, scenario_file
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

TOTAL_STEPS = 1_000_000  # of a run that is told no number


@dataclass(frozen=True)
class Preset:
    """What a learner is told for a scenario."""

    hyper: Hyperparameters
    total_steps: int  # environment steps of a whole run


def told(
    scenario: str,
    algorithm: str,
    compiled: CompiledScenario,
    settings: Sequence[str] = (),
    total_steps: int | None = None,
) -> Preset:
    """What a run is told: the scenario's preset, and in its place what a command line says.

    Args:
        scenario: as of preset(); `compiled` is the same, loaded.
        settings: hyper-parameters, KEY=VALUE. They are not checked yet.
        total_steps: None: the preset's.

    Raises:
        InputError, UsageError: as preset(); and for settings that do not fit.
    """
    found = preset(scenario, algorithm, compiled.dt * compiled.action_repeat)
    steps = found.total_steps if total_steps is None else total_steps
    return Preset(with_settings(found.hyper, settings), steps)


def presets_file(scenario: str) -> Path:
    """Where a scenario's presets would be. `scenario`: a YAML file, or a shipped one's name."""
    file = Path(scenario_file(scenario))
    return file.parent / "training" / f"{file.stem}.yaml"


def preset(scenario: str, algorithm: str, action_seconds: float | None = None) -> Preset:
    """The preset for a scenario and a learner; the learner's defaults where it has none.

    Args:
        scenario: a YAML file, or the name of a shipped one.
        algorithm: a key of ALGORITHMS.
        action_seconds: between two actions [s], which learners of scenarios without a preset heed.

    Raises:
        InputError: the file of presets is no YAML of this form; with places.
        UsageError: it names a learner or a hyper-parameter that there is not, or a wrong value.
    """
    row = algorithm_of(algorithm)
    made = Preset(row.defaults(), TOTAL_STEPS)
    file = presets_file(scenario)
    sections = read_settings(str(file)) if file.is_file() else {}
    for name, (_, place) in sections.items():
        if name not in ALGORITHMS:
            raise UsageError(f"{place}: no learner `{name}`{allowed_words(name, ALGORITHMS)}")
    values, _ = sections.get(algorithm, ({}, ""))
    if not values and action_seconds is not None:
        made = dataclasses.replace(made, hyper=row.fit(made.hyper, action_seconds))
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
