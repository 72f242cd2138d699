"""Exposure and shot noise of cameras: gain of brightness, variance that grows with brightness."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import skybody
from numpy.typing import NDArray

CLEAN = {"width": 96, "height": 96, "position": [0.2, 0, 0.1]}
ROUNDING = np.sqrt(1 / 12) / 255  # standard deviation of whole bytes, as a share


def colors(num_envs: int = 2, draws: str = "[]", **parameters: Any) -> NDArray[np.float64]:
    words = ", ".join(f"{key}: {value}" for key, value in {**CLEAN, **parameters}.items())
    camera = f"{{plugin: camera, name: eye, parameters: {{outputs: [rgb], {words}}}}}"
    overrides = [f"sensors=[{camera}]", "observe=[eye.rgb]", f"randomization={draws}"]
    envs = skybody.make_vec("hover", num_envs, seed=3, overrides=overrides)
    return envs.reset()[0]["eye_rgb"].astype(float)


@pytest.mark.parametrize("gain", [0.0, 0.5, 1.7, 20.0])
def test_exposure_multiplies_all_colours(gain: float) -> None:
    # Bytes are rounded after the gain: of half a byte before it.
    expected = np.clip(gain * colors(), 0, 255)
    assert np.max(np.abs(colors(exposure=gain) - expected)) <= 0.5 * gain + 0.5


def test_exposure_of_one_changes_nothing() -> None:
    np.testing.assert_array_equal(colors(exposure=1.0), colors())


def test_exposure_can_be_drawn_per_episode() -> None:
    draws = "[{plugin: draw, parameters: {what: [sensors.eye.exposure], range: [0.2, 1.0]}}]"
    seen = colors(8, draws, exposure=1.0).mean(axis=(1, 2, 3))
    assert np.ptp(seen / colors(8).mean(axis=(1, 2, 3))) > 0.3


@pytest.mark.parametrize(("base", "shot"), [(0.0, 0.05), (0.02, 0.04)])
def test_the_variance_of_shot_noise_is_linear_in_brightness(base: float, shot: float) -> None:
    clean, noisy = colors(32), colors(32, rgb_noise=base, shot_noise=shot)
    groups = 0
    for byte in np.unique(clean[(clean > 40) & (clean < 200)]):  # nothing is cut there
        errors = (noisy - clean)[clean == byte] / 255
        if errors.size < 20_000:
            continue
        expected = np.sqrt(base**2 + shot**2 * byte / 255 + ROUNDING**2)
        assert np.std(errors) == pytest.approx(expected, rel=0.03)
        assert np.mean(errors) == pytest.approx(0.0, abs=1e-3)
        groups += 1
    assert groups >= 4


@pytest.mark.parametrize("name", ["exposure", "shot_noise"])
def test_wrong_values_are_named(name: str) -> None:
    with pytest.raises(skybody.InputError, match=rf"`{name}` is -1; allowed: a number from 0"):
        colors(**{name: -1})
