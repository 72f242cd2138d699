"""The policy of a chain of layers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from skybody import CompiledScenario
from skybody._native import ObservationColumn
from skybody.train.image_layers import PolicyImage
from skybody.train.policy_file import Layer, Policy

from .chain import NO_CLIP, Array, Hidden, Inputs, Picture, Unsupported, with_layer


def policy_of(
    chain: Hidden,
    pictures: Mapping[int, Picture],
    columns: Sequence[ObservationColumn],
    compiled: CompiledScenario,
) -> Policy:
    """The policy whose inputs are the whole observation and the features of all images."""
    chain = _finished(chain)
    actions = len(chain.factor)
    if actions != compiled.action_size:
        raise Unsupported(
            f"the policy gives {actions} actions; `{compiled.name}` takes {compiled.action_size}"
        )
    images = [
        PolicyImage(column.name, p.pixels, p.low, p.high, list(p.layers))
        for column, p in ((columns[k], pictures[k]) for k in sorted(pictures))
    ]
    sizes = [0, *np.cumsum([image.size for image in images])]
    size = compiled.observation_size
    first = {k: size + int(sizes[n]) for n, k in enumerate(sorted(pictures))}
    mean, scale, clip = _normalization(chain.inputs, size)
    layer = _arranged(chain, first, size + int(sizes[-1]))
    attributes = {
        "scenario": compiled.name,
        "scenario_hash": f"{compiled.scenario_hash:016x}",
        "algorithm": "onnx",
        "steps": 0,
    }
    layers = [_floats(one) for one in (layer, *chain.layers[1:])]
    return Policy(layers, mean, scale, clip, attributes, [], "clip", images)


def _finished(chain: Hidden) -> Hidden:
    """The chain with a last layer that needs no affine map."""
    if (chain.factor == 1.0).all() and (chain.term == 0.0).all() and not chain.layers[-1].units:
        return chain
    size = len(chain.factor)
    if chain.layers[-1].units or chain.layers[-1].activation != "none":
        return with_layer(replace(chain, is_bounded=False), _identity(size))
    return chain.activated("none")


def _identity(size: int) -> Layer:
    return Layer(np.eye(size), np.zeros(size), "none")


def _normalization(inputs: Inputs, size: int) -> tuple[Array, Array, float]:
    """Mean, scale and clip of the observation's entries."""
    seen = inputs.taken(np.flatnonzero(inputs.image < 0))
    clips = set(seen.clip.tolist())
    if len(clips) > 1:
        raise Unsupported("some inputs are clipped, others not, or to another range")
    if (seen.scale == 0.0).any():
        raise Unsupported("an input times zero")
    mean, scale = np.zeros(size), np.ones(size)
    filled = np.zeros(size, bool)
    for place, s, o in zip(seen.place, seen.scale, seen.offset, strict=True):
        if filled[place] and (scale[place], mean[place]) != (abs(s), -o / s):
            raise Unsupported("an observation that is normalized in two ways")
        mean[place], scale[place], filled[place] = -o / s, abs(s), True
    clip = clips.pop() if clips else NO_CLIP
    plain = clip == NO_CLIP and (mean == 0.0).all() and (scale == 1.0).all()
    return mean, scale, np.inf if plain else clip


def _arranged(chain: Hidden, first: Mapping[int, int], width: int) -> Layer:
    """The first layer with a column for each entry of the observation and each feature."""
    layer, inputs = chain.layers[0], chain.inputs
    weight = np.zeros((layer.weight.shape[0], width))
    signs = np.where(inputs.image < 0, np.sign(inputs.scale), 1.0)
    for k in range(len(inputs)):
        image = int(inputs.image[k])
        place = int(inputs.place[k]) + (first[image] if image >= 0 else 0)
        weight[:, place] += layer.weight[:, k] * signs[k]
    return replace(layer, weight=weight)


def _floats(layer: Layer) -> Layer:
    """The layer with the precision of the file."""
    state = (layer.state_weight, layer.state_bias)
    state_weight, state_bias = (None if v is None else v.astype(np.float32) for v in state)
    weight, bias = layer.weight.astype(np.float32), layer.bias.astype(np.float32)
    return Layer(weight, bias, layer.activation, state_weight, state_bias)
