"""Policies with random weights, of every kind of layer that a policy.h5 may have."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from skybody import CompiledScenario
from skybody.train.image_layers import Convolution, PolicyImage
from skybody.train.policy_file import Layer, Policy, write_policy

Random = np.random.Generator


def uniform(random: Random, *shape: int) -> NDArray[np.float32]:
    """Weights for which sums of products stay near 1."""
    bound = 1.5 / np.sqrt(shape[-1])
    return random.uniform(-bound, bound, shape).astype(np.float32)


def dense(random: Random, inputs: int, outputs: int, activation: str) -> Layer:
    """A dense layer."""
    return Layer(uniform(random, outputs, inputs), uniform(random, outputs), activation)


def recurrent(random: Random, inputs: int, units: int, gates: int = 3) -> Layer:
    """Gated recurrent units; with 4 gates long short-term memory."""
    return Layer(
        uniform(random, gates * units, inputs),
        uniform(random, gates * units),
        "none",
        uniform(random, gates * units, units),
        uniform(random, gates * units),
    )


def convolution(
    random: Random, channels: int, outputs: int, activation: str, kernel: tuple[int, int, int, str]
) -> Convolution:
    """A convolution; `kernel`: height, width, stride, padding."""
    window = kernel[0] * kernel[1] * channels
    return Convolution(
        uniform(random, outputs, window), uniform(random, outputs), activation, kernel
    )


def with_memory(random: Random, inputs: int, outputs: int) -> tuple[list[Layer], str]:
    """A recurrent layer, then others."""
    layers = [recurrent(random, inputs, 64), dense(random, 64, 21, "elu")]
    return [*layers, dense(random, 21, outputs, "none")], "clip"


def squashed(random: Random, inputs: int, outputs: int) -> tuple[list[Layer], str]:
    """Actions by tanh, after two recurrent layers whose sizes are no multiples of 4."""
    layers = [recurrent(random, inputs, 21), recurrent(random, 21, 5)]
    return [*layers, dense(random, 5, outputs, "none")], "tanh"


def rectified(random: Random, inputs: int, outputs: int) -> tuple[list[Layer], str]:
    """Rectified linear units."""
    layers = [dense(random, inputs, 64, "relu"), dense(random, 64, 64, "relu")]
    return [*layers, dense(random, 64, outputs, "tanh")], "clip"


def with_cells(random: Random, inputs: int, outputs: int) -> tuple[list[Layer], str]:
    """Long short-term memory."""
    layers = [recurrent(random, inputs, 37, gates=4), dense(random, 37, 20, "tanh")]
    return [*layers, dense(random, 20, outputs, "none")], "clip"


NETWORKS: dict[str, Callable[[Random, int, int], tuple[list[Layer], str]]] = {
    "with_memory": with_memory,
    "with_cells": with_cells,
    "squashed": squashed,
    "rectified": rectified,
}


def images_of(random: Random, compiled: CompiledScenario) -> list[PolicyImage]:
    """Convolutions with and without zeros around, of each image of a scenario."""
    images = []
    for column in compiled.observation_columns:
        if column.image < 0:
            continue
        height, width, channels = (*column.shape, 1)[:3]
        kernels: Sequence[tuple[int, int, int, str]] = (
            (5, 4, 3, "same"), (3, 3, 2, "valid"), (3, 3, 2, "same"),
        )  # fmt: skip
        layers, shape = [], [height, width, channels]
        for outputs, kernel in zip((6, 17, 8), kernels, strict=True):
            layers.append(convolution(random, shape[2], outputs, "elu", kernel))
            shape = [*_windows(shape, kernel), outputs]
        whole = (shape[0], shape[1], 1, "valid")
        layers.append(convolution(random, shape[2], 13, "relu", whole))
        size = (height, width, channels)
        images.append(PolicyImage(column.name, size, column.low, column.high, layers))
    return images


def _windows(shape: Sequence[int], kernel: tuple[int, int, int, str]) -> list[int]:
    """Rows and columns of a convolution's output."""
    *sizes, stride, padding = kernel
    if padding == "same":
        return [-(-size // stride) for size in shape[:2]]
    return [(size - k) // stride + 1 for size, k in zip(shape, sizes, strict=False)]


def write_draft(path: Path, scenario: str, network: str, *, is_normalized: bool = True) -> Path:
    """Writes a policy of NETWORKS for a scenario, the same bits each time."""
    random = np.random.default_rng(20)
    compiled = CompiledScenario(scenario)
    images = images_of(random, compiled)
    features = sum(image.size for image in images)
    size = compiled.observation_size
    layers, squash = NETWORKS[network](random, size + features, compiled.action_size)
    attributes = {
        "scenario": compiled.name,
        "scenario_hash": f"{compiled.scenario_hash:016x}",
        "algorithm": "none",
        "steps": 0,
    }
    mean = random.normal(0.0, 5.0, size) if is_normalized else np.zeros(size)
    scale = np.exp(random.normal(0.0, 1.0, size)) if is_normalized else np.ones(size)
    clip = 5.0 if is_normalized else np.inf
    policy = Policy(layers, mean, scale, clip, attributes, [], squash, images)
    write_policy(path, policy)
    return path
