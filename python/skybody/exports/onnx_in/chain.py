"""Tensors of a network as parts of policy.h5: inputs, an image, or outputs of layers.

Each value has an affine map, `factor` and `term` for each entry, that is still to be applied. The
next layer takes it into its weights.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from skybody.train.image_layers import Convolution
from skybody.train.policy_file import Layer

Array = NDArray[np.float64]
NO_CLIP = 1e30  # of normalized inputs that the network does not clip
MOST_IDENTITY = 2048  # values of an image that go into a concatenation without a layer


class Unsupported(ValueError):
    """A network that policy.h5 cannot express."""


@dataclass(frozen=True)
class Unmapped:
    """An input that is no observation: a recurrent state, which is zero at first."""

    name: str


@dataclass(frozen=True)
class Inputs:
    """Entries of the observation, or features of images: clip(scale * x + offset) * factor + term.

    `place`: of the observation, or that of a feature of image `image`.
    """

    place: NDArray[np.intp]
    image: NDArray[np.intp]  # -1: an observation
    scale: Array
    offset: Array
    clip: Array  # NO_CLIP: none
    factor: Array
    term: Array

    def __len__(self) -> int:
        return len(self.place)

    def taken(self, index: Sequence[int] | NDArray[np.intp] | slice) -> Inputs:
        """Some of the entries."""
        return Inputs(**{name: values[index] for name, values in vars(self).items()})

    def mapped(self, factor: Array | float, term: Array | float) -> Inputs:
        """factor * x + term."""
        if (self.clip == NO_CLIP).all() and (self.image < 0).all():
            return replace(self, scale=self.scale * factor, offset=self.offset * factor + term)
        return replace(self, factor=self.factor * factor, term=self.term * factor + term)

    def clipped(self, bound: float) -> Inputs:
        """Clipped to -bound ... bound."""
        if (self.clip < NO_CLIP).any() or (self.image >= 0).any():
            raise Unsupported("inputs are clipped twice, or features are clipped")
        return replace(self, clip=np.full(len(self), bound))


def observations(places: Sequence[int]) -> Inputs:
    """Entries of the observation."""
    return _plain(places, -1)


def features(count: int, image: int) -> Inputs:
    """All features of an image."""
    return _plain(range(count), image)


def _plain(places: Sequence[int], image: int) -> Inputs:
    size = len(places)
    ones, zeros = np.ones(size), np.zeros(size)
    return Inputs(
        np.array(places, np.intp),
        np.full(size, image, np.intp),
        ones,
        zeros,
        np.full(size, NO_CLIP),
        ones,
        zeros,
    )


def joined(parts: Sequence[Inputs]) -> Inputs:
    """One after another."""
    names = vars(parts[0])
    return Inputs(**{name: np.concatenate([vars(part)[name] for part in parts]) for name in names})


@dataclass(frozen=True)
class Hidden:
    """Outputs of layers, times `factor` plus `term`; the first layer's weights are for `inputs`."""

    inputs: Inputs
    layers: tuple[Layer, ...]
    factor: Array
    term: Array
    is_bounded: bool = False  # clipped to [-1, 1]: nothing may follow

    def mapped(self, factor: Array | float, term: Array | float) -> Hidden:
        """factor * x + term."""
        return replace(self, factor=self.factor * factor, term=self.term * factor + term)

    def activated(self, activation: str) -> Hidden:
        """With an activation after the last layer, which has none yet."""
        last = self.layers[-1]
        if last.units or last.activation != "none":
            size = len(self.factor)
            last = Layer(np.diag(self.factor), self.term.copy(), activation)
            return of_layers(self.inputs, (*self.layers, last), size)
        weight = last.weight * self.factor[:, None]
        layer = Layer(weight, last.bias * self.factor + self.term, activation)
        return of_layers(self.inputs, (*self.layers[:-1], layer), len(self.factor))


def of_layers(inputs: Inputs, layers: tuple[Layer, ...], size: int) -> Hidden:
    """Outputs of layers, without more."""
    return Hidden(inputs, layers, np.ones(size), np.zeros(size))


def with_layer(value: Inputs | Hidden, layer: Layer) -> Hidden:
    """The value through a layer, whose weights take the value's affine map."""
    if isinstance(value, Hidden) and value.is_bounded:
        raise Unsupported("a clip to [-1, 1] that is not the last step")
    weight = layer.weight * value.factor
    bias = layer.bias + layer.weight @ value.term
    made = replace(layer, weight=weight, bias=bias)
    size = layer.units or len(bias)
    if isinstance(value, Hidden):
        return of_layers(value.inputs, (*value.layers, made), size)
    return of_layers(value, (made,), size)


@dataclass(frozen=True)
class Picture:
    """An image, or convolutions of it: times `factor` plus `term`, for each channel."""

    image: int
    low: float
    high: float
    layers: tuple[Convolution, ...]
    shape: tuple[int, int, int]  # rows, columns, channels
    factor: Array  # (channels)
    term: Array
    pixels: tuple[int, int, int]  # the shape of the image itself
    axes: str = "NHWC"  # as the network has them
    is_flat: bool = False

    def mapped(self, factor: Array | float, term: Array | float) -> Picture:
        """factor * x + term."""
        return replace(self, factor=self.factor * factor, term=self.term * factor + term)

    def clipped(self, low: float, high: float) -> Picture:
        """Clipped to low ... high, before the first layer."""
        if self.layers or len(set(self.factor)) > 1 or len(set(self.term)) > 1:
            raise Unsupported("a clip between convolutions, or with a range for each channel")
        factor, term = float(self.factor[0]), float(self.term[0])
        if factor <= 0.0:
            raise Unsupported("a clip of an image times a negative factor")
        low, high = max(low, term), min(high, factor + term)
        pixel = (self.high - self.low) / factor
        channels = len(self.factor)
        return replace(
            self,
            low=self.low + (low - term) * pixel,
            high=self.low + (high - term) * pixel,
            factor=np.full(channels, high - low),
            term=np.full(channels, low),
        )

    def convolved(self, weight: Array, bias: Array, kernel: tuple[int, int, int, str]) -> Picture:
        """Through a convolution with weight (out, height, width, channels)."""
        if kernel[3] == "same" and not np.allclose(self.term, 0.0, atol=1e-7):
            raise Unsupported("a padded convolution of an image that is shifted before it")
        height, width, stride, padding = kernel
        sums = (weight * self.term).sum(axis=(1, 2, 3))
        rows = (weight * self.factor).reshape(len(weight), -1)
        layer = Convolution(rows, bias + sums, "none", kernel)
        if padding == "same":
            size = (-(-self.shape[0] // stride), -(-self.shape[1] // stride))
        else:
            size = ((self.shape[0] - height) // stride + 1, (self.shape[1] - width) // stride + 1)
        ones, zeros = np.ones(len(weight)), np.zeros(len(weight))
        return replace(
            self,
            layers=(*self.layers, layer),
            shape=(*size, len(weight)),
            factor=ones,
            term=zeros,
        )

    def activated(self, activation: str) -> Picture:
        """With an activation after the last convolution, which has none yet."""
        last = self.layers[-1] if self.layers else None
        if last is None or last.activation != "none":
            raise Unsupported("an activation that follows no convolution or another activation")
        weight = last.weight * self.factor[:, None]
        bias = last.bias * self.factor + self.term
        layer = Convolution(weight, bias, activation, last.kernel)
        ones, zeros = np.ones(len(bias)), np.zeros(len(bias))
        return replace(self, layers=(*self.layers[:-1], layer), factor=ones, term=zeros)

    def through(self, weight: Array, bias: Array) -> Picture:
        """Flat, through a dense layer: a convolution of one window."""
        rows, columns, channels = self.shape
        if self.axes == "NCHW":
            weight = weight.reshape(-1, channels, rows, columns).transpose(0, 2, 3, 1)
        else:
            weight = weight.reshape(-1, rows, columns, channels)
        return self.convolved(weight, bias, (rows, columns, 1, "valid"))

    def features(self) -> tuple[Picture, Inputs]:
        """The picture with one window, and its features."""
        whole = self
        if not self.layers or self.shape[:2] != (1, 1):
            size = int(np.prod(self.shape))
            if size > MOST_IDENTITY:
                raise Unsupported(f"{size} values of an image without a layer after them")
            whole = self.through(np.eye(size), np.zeros(size))
        return whole, features(whole.shape[2], self.image).mapped(whole.factor, whole.term)
