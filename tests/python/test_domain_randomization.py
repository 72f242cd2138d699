"""The domain randomization experiment: compared variants and their evaluation."""

from __future__ import annotations

from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
import yaml
from measurements import module
from scipy import stats
from skybody import CompiledScenario
from skybody.train.presets import presets_file

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def experiment() -> ModuleType:
    return module("domain_randomization")


def test_the_interval_is_welchs(experiment: ModuleType) -> None:
    random = np.random.default_rng(2)
    a, b = random.normal(440.0, 90.0, 5), random.normal(640.0, 150.0, 7)
    gain, half = experiment.difference(list(a), list(b))
    interval = stats.ttest_ind(b, a, equal_var=False).confidence_interval(0.95)
    np.testing.assert_allclose([gain - half, gain + half], [interval.low, interval.high])


def test_the_answer_tells_gains_losses_and_what_is_open(experiment: ModuleType) -> None:
    gains = {0.1: (23.0, 156.0), 0.3: (200.0, 117.0), 0.5: (-80.0, 40.0)}
    rows = [{"spread": 0.0, "drawn": []}]
    rows += [{"spread": k, "drawn": [1], "difference": d, "half": h} for k, (d, h) in gains.items()]
    assert experiment.answer(rows) == (
        "Who was trained on drawn vehicles gets more at +-30 %; who was trained on one vehicle "
        "gets more at +-50 %; no difference can be told at +-10 %."
    )


def test_a_spread_is_that_of_mass_inertia_and_lags(experiment: ModuleType) -> None:
    overrides = list(experiment.drawn_by(0.3, every=1))
    text = CompiledScenario(experiment.DRAWN, overrides).scenario_text
    draws = [d["parameters"] for d in yaml.safe_load(text)["randomization"][:3]]
    for parameters in draws:
        assert list(map(float, parameters["range"])) == [0.7, 1.3]
        assert int(parameters["every"]) == 1
    assert sum(len(parameters["what"]) for parameters in draws) == 1 + 3 + 2


def test_both_kinds_are_trained_alike() -> None:
    files = [presets_file(name) for name in ("pendulum_learn", "pendulum_learn_randomized")]
    assert len({str(yaml.safe_load(file.read_text())) for file in files}) == 1
