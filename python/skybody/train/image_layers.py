"""The layers of a policy that see images, in NumPy (docs/policies.md)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


def activated(sums: NDArray[np.float64], activation: str) -> NDArray[np.float64]:
    """The activation of a policy file: tanh, relu, elu or none."""
    if activation == "tanh":
        return np.tanh(sums)
    if activation == "relu":
        return np.maximum(sums, 0.0)
    if activation == "elu":
        return np.where(sums > 0.0, sums, np.expm1(np.minimum(sums, 0.0)))
    return sums


@dataclass(frozen=True)
class Convolution:
    """activation(weight x + bias) for every window x of an image."""

    weight: NDArray[np.floating[Any]]  # (out, kernel height * kernel width * channels)
    bias: NDArray[np.floating[Any]]  # (out)
    activation: str
    kernel: tuple[int, int, int, str]  # height, width, stride, padding ("valid" or "same")

    def __call__(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Outputs (n, rows, columns, out) of images (n, height, width, channels)."""
        *sizes, stride, padding = self.kernel
        if padding == "same":
            borders = [border(*size, stride) for size in zip(x.shape[1:3], sizes, strict=True)]
            x = np.pad(x, [(0, 0), *borders, (0, 0)])
        windows = np.lib.stride_tricks.sliding_window_view(x, sizes, axis=(1, 2))
        windows = windows[:, ::stride, ::stride].transpose(0, 1, 2, 4, 5, 3)
        rows = windows.reshape(*windows.shape[:3], -1)
        return activated(rows @ self.weight.astype(np.float64).T + self.bias, self.activation)


def border(size: int, kernel: int, stride: int) -> tuple[int, int]:
    """Zeros before and after an image for ceil(size / stride) windows, as in TensorFlow."""
    missing = max(0, (-(-size // stride) - 1) * stride + kernel - size)
    return missing // 2, missing - missing // 2


@dataclass(frozen=True)
class PolicyImage:
    """An image that a policy sees, and the convolutions that make features of it."""

    column: str  # of the observation
    shape: tuple[int, int, int]  # height, width, channels
    low: float  # pixels become (clip(pixel, low, high) - low) / (high - low)
    high: float
    layers: list[Convolution]

    def features(self, pixels: NDArray[Any]) -> NDArray[np.float64]:
        """Features (n, features) of images (n, height, width) or (n, height, width, channels)."""
        low, high = np.float32(self.low), np.float32(self.high)
        values = pixels.reshape(len(pixels), *self.shape).astype(np.float32)
        values = np.where(values < high, values, high)  # so is a value that is no number
        scaled = (np.maximum(values, low) - low) * (np.float32(1.0) / (high - low))
        x: NDArray[np.float64] = scaled.astype(np.float64)
        for layer in self.layers:
            x = layer(x)
        return x.reshape(len(pixels), -1)

    @property
    def size(self) -> int:
        """Number of features."""
        return len(self.layers[-1].bias)


def image_of_values(values: tuple[Any, ...]) -> PolicyImage:
    """The image of an entry `images` of `read_policy_file`."""
    column, shape, low, high, layers = values
    return PolicyImage(column, shape, low, high, [Convolution(*layer) for layer in layers])


def values_of_image(image: PolicyImage) -> tuple[Any, ...]:
    """The inverse of image_of_values()."""
    layers = [
        (_doubles(layer.weight), _doubles(layer.bias), layer.activation, layer.kernel)
        for layer in image.layers
    ]
    return (image.column, image.shape, image.low, image.high, layers)


def _doubles(values: Any) -> NDArray[np.float64]:
    return np.ascontiguousarray(values, np.float64)
