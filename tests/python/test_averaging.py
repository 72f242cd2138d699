"""The mean of a policy over its updates."""

from __future__ import annotations

import numpy as np
from skybody.train.averaging import PolicyAverage
from skybody.train.policy_file import Layer, Policy


def policy(value: float) -> Policy:
    layer = Layer(np.full((2, 3), value, np.float32), np.full(2, -value, np.float32), "none")
    return Policy([layer], np.zeros(3), np.ones(3), 10.0)


def weight(average: PolicyAverage) -> float:
    layer = average.of(policy(0.0)).layers[0]
    assert (layer.weight == layer.weight[0, 0]).all() and (layer.bias == -layer.weight[0, 0]).all()
    return float(layer.weight[0, 0])


def test_at_first_it_is_the_mean_of_all_and_later_reaches_back_the_window() -> None:
    average = PolicyAverage(window=40)
    for value in (1.0, 2.0, 6.0):
        average.add(policy(value), steps=10)
    assert weight(average) == 3.0
    average.add(policy(7.0), steps=10)  # 1 / 4 = 10 / 40: the share is constant from here on
    average.add(policy(8.0), steps=10)
    assert weight(average) == 5.0


def test_without_a_window_the_policy_is_itself() -> None:
    average = PolicyAverage(window=0)
    average.add(policy(1.0), steps=10)
    given = policy(4.0)
    assert average.of(given) is given


def test_restored_it_goes_on_as_if_it_had_not_stopped() -> None:
    first, second = PolicyAverage(window=40), PolicyAverage(window=40)
    first.add(policy(1.0), steps=10)
    second.restore(first.state(), policy(0.0))
    for average in (first, second):
        average.add(policy(2.0), steps=10)
    assert weight(first) == weight(second) == 1.5
