"""policy.h5: a trained policy as plain numbers, read by `skybody run --policy` and by evaluate.py.

Root attributes describe the training; /normalization, /images and /layers/0, 1, ... hold the
network.
The first 512 bytes are a seal: the hash of all other bytes, checked before HDF5 reads the file.
docs/policies.md has the whole format. The reader and the writer are those of C++.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skybody._native import Error, policy_file_bytes, read_policy_file, shipped_policy_file
from skybody.train import files
from skybody.train.image_layers import PolicyImage, activated, image_of_values, values_of_image


@dataclass(frozen=True)
class Layer:
    """activation(weight x + bias); with state weights, recurrent as PyTorch's GRU or LSTM.

    Rows of a recurrent layer's arrays are those of the gates r, z and n, or i, f, g and o, `out`
    each.
    """

    weight: NDArray[np.floating[Any]]  # (out, in), recurrent: (gates out, in)
    bias: NDArray[np.floating[Any]]  # (out), recurrent: (gates out)
    activation: str  # "tanh", "relu", "elu" or "none"
    state_weight: NDArray[np.floating[Any]] | None = None  # recurrent: (gates out, out)
    state_bias: NDArray[np.floating[Any]] | None = None  # recurrent: (gates out)

    @property
    def units(self) -> int:
        """Outputs of a recurrent layer; 0: a dense layer."""
        return 0 if self.state_weight is None else self.state_weight.shape[1]

    @property
    def gates(self) -> int:
        """Rows of weights for each output: 3 of a GRU, 4 of an LSTM, else 1."""
        return self.weight.shape[0] // self.units if self.units else 1

    @property
    def memory(self) -> int:
        """Number of state values: outputs, and then the cells of an LSTM."""
        return self.units * (2 if self.gates == 4 else 1)

    def __call__(self, x: NDArray[np.float64], state: NDArray[np.float64]) -> NDArray[np.float64]:
        """Outputs (n, out) of inputs (n, in); updates a recurrent layer's state (n, memory)."""
        sums = x @ self.weight.astype(np.float64).T + self.bias
        if self.state_weight is not None and self.state_bias is not None:
            weight = self.state_weight.astype(np.float64)
            from_state = state[:, : self.units] @ weight.T + self.state_bias
            if self.gates == 4:
                return _remember(sums + from_state, state)
            return _gate(sums, from_state, state)
        return activated(sums, self.activation)


def _gate(
    from_input: NDArray[np.float64], from_state: NDArray[np.float64], state: NDArray[np.float64]
) -> NDArray[np.float64]:
    """The next state (Cho et al. 2014), which is also written to `state`."""
    input_r, input_z, input_n = np.split(from_input, 3, axis=1)
    state_r, state_z, state_n = np.split(from_state, 3, axis=1)
    reset, update = _sigmoid(input_r + state_r), _sigmoid(input_z + state_z)
    candidate = np.tanh(input_n + reset * state_n)
    state[:] = (1.0 - update) * candidate + update * state
    return state.copy()


def _remember(sums: NDArray[np.float64], state: NDArray[np.float64]) -> NDArray[np.float64]:
    """The outputs of an LSTM (Gers et al. 1999), which are written to `state` with its cells."""
    enter, keep, new, out = np.split(sums, 4, axis=1)
    cells = state[:, state.shape[1] // 2 :]
    cells[:] = _sigmoid(keep) * cells + _sigmoid(enter) * np.tanh(new)
    output = _sigmoid(out) * np.tanh(cells)
    state[:, : state.shape[1] // 2] = output
    return output


def _sigmoid(x: NDArray[np.float64]) -> NDArray[np.float64]:
    return 0.5 + 0.5 * np.tanh(0.5 * x)


@dataclass(frozen=True)
class Agent:
    """A robot's part of a team's rows."""

    observation: NDArray[np.intp]  # entries of the observation that are the network's inputs
    action: NDArray[np.intp]  # entries of the action that are its outputs


@dataclass(frozen=True)
class Policy:
    """The mean of a Gaussian policy: a network on normalized observations and features of images.

    If robots share it, it is evaluated for each of `agents`. The state of recurrent layers is in
    states(), held by the caller.
    """

    layers: list[Layer]
    mean: NDArray[np.float64]  # (I) of the network's inputs, which are observations
    scale: NDArray[np.float64]  # (I), 1 / deviation
    clip: float  # of normalized observations
    attributes: dict[str, Any] = field(default_factory=dict)
    agents: list[Agent] = field(default_factory=list)
    squash: str = "clip"  # or "tanh": maps outputs to actions in [-1, 1]
    images: list[PolicyImage] = field(default_factory=list)  # their features follow the inputs

    def states(self, n: int) -> NDArray[np.float64]:
        """The recurrent states of n environments at the beginning of an episode."""
        size = sum(layer.memory for layer in self.layers)
        return np.zeros((n, max(1, len(self.agents)), size))

    def __call__(
        self,
        observation: NDArray[np.float32],
        states: NDArray[np.float64] | None = None,
        pixels: Sequence[NDArray[Any]] = (),
    ) -> NDArray[np.float64]:
        """Actions (n, A) in [-1, 1] for observations (n, O); float64 from float32 weights.

        `pixels` are those of `images`, (n, height, width, channels) each.
        `states` of a policy with recurrent layers, from states(n), are updated; without
        them it acts as at the beginning of an episode.
        """
        states = self.states(len(observation)) if states is None else states
        if not self.agents:
            features = [
                image.features(seen) for image, seen in zip(self.images, pixels, strict=True)
            ]
            return self._evaluate(observation, states[:, 0], features)
        size = sum(len(agent.action) for agent in self.agents)
        actions = np.empty((len(observation), size))
        for k, agent in enumerate(self.agents):
            inputs = observation[:, agent.observation]
            actions[:, agent.action] = self._evaluate(inputs, states[:, k])
        return actions

    def _evaluate(
        self,
        inputs: NDArray[np.float32],
        states: NDArray[np.float64],
        features: Sequence[NDArray[np.float64]] = (),
    ) -> NDArray[np.float64]:
        x = np.clip((inputs - self.mean) * self.scale, -self.clip, self.clip)
        x = np.hstack([x.astype(np.float32).astype(np.float64), *features])
        begin = 0
        for layer in self.layers:
            x = layer(x, states[:, begin : begin + layer.memory])
            begin += layer.memory
        return np.tanh(x) if self.squash == "tanh" else np.clip(x, -1.0, 1.0)

    def sizes(self) -> dict[str, int]:
        """Sizes of the scenario's rows."""
        if not self.agents:
            return {
                "observation_size": _inputs(self.layers, self.images),
                "action_size": self.layers[-1].weight.shape[0],
            }
        return {
            "observation_size": int(self.attributes["observation_size"]),
            "action_size": sum(len(agent.action) for agent in self.agents),
        }


def _inputs(layers: list[Layer], images: list[PolicyImage]) -> int:
    """Number of the network's inputs that are no features."""
    return int(layers[0].weight.shape[1]) - sum(image.size for image in images)


def shipped_policy(scenario: str, trained: str = "") -> Path:
    """The file of the policy that is shipped for the scenario of that name.

    Args:
        scenario: the scenario's name.
        trained: the scenario argument of `skybody train`, for the message; empty: its name.

    Raises:
        Error: there is none; the message lists the shipped policies.
    """
    return Path(shipped_policy_file(scenario, trained))


def write_policy(path: Path, policy: Policy) -> None:
    """Writes `policy` with its attributes to `path`, atomically."""
    files.write_file(path, policy_bytes(policy))


def policy_bytes(policy: Policy) -> bytes:
    """The bytes of `policy`'s file. Its attributes contain the training's stamps and seed.

    For a policy without attributes only the sizes are written.
    """
    stamps: dict[str, Any] = {"scenario": "", "scenario_hash": "", "algorithm": "", "steps": 0}
    stamps.update({name: policy.attributes[name] for name in stamps if name in policy.attributes})
    seed = int(policy.attributes.get("seed", 0))
    normalized = np.isfinite(policy.clip)
    values = {
        **stamps,
        **policy.sizes(),
        "action_squash": policy.squash,
        "agents": [(agent.observation.tolist(), agent.action.tolist()) for agent in policy.agents],
        "mean": _doubles(policy.mean if normalized else []),
        "scale": _doubles(policy.scale if normalized else []),
        "clip": float(policy.clip) if normalized else 0.0,
        "images": [values_of_image(image) for image in policy.images],
        "layers": [_layer_values(layer) for layer in policy.layers],
    }
    return policy_file_bytes(values, seed)


def _layer_values(layer: Layer) -> tuple[Any, ...]:
    """A layer in the format of `read_policy_file`."""
    dense = (_doubles(layer.weight), _doubles(layer.bias), layer.activation)
    if layer.state_weight is None:
        return dense
    return (*dense, _doubles(layer.state_weight), _doubles(layer.state_bias))


def _doubles(values: Any) -> NDArray[np.float64]:
    return np.ascontiguousarray(values, np.float64)


def read_policy(path: Path) -> Policy:
    """Reads a policy by the rules of `skybody run --policy`; both use the same reader.

    Raises ValueError, which names the file, for any file that the reader rejects.
    """
    try:
        values = read_policy_file(str(path))
    except Error as error:
        raise ValueError(str(error)) from error
    return policy_of_values(values)


def policy_of_values(values: dict[str, Any]) -> Policy:
    """The policy of the values of `read_policy_file`."""
    layers = [Layer(*layer) for layer in values["layers"]]
    agents = [Agent(*(np.asarray(part, np.intp) for part in agent)) for agent in values["agents"]]
    names = ("scenario", "scenario_hash", "algorithm", "steps", "observation_size")
    attributes = {name: values[name] for name in names}
    images = [image_of_values(image) for image in values["images"]]
    rest = (attributes, agents, values["action_squash"], images)
    if len(values["mean"]) == 0:  # no normalization: inputs go into the network unchanged
        size = _inputs(layers, images)
        return Policy(layers, np.zeros(size), np.ones(size), np.inf, *rest)
    return Policy(layers, values["mean"], values["scale"], values["clip"], *rest)
