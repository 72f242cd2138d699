"""A fixed sequence of inputs, for the self-test of exported C and for comparisons of bits.

Inputs are a centre plus a whole multiple of a power of two, so that a processor that fuses products
and sums computes the same.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from skybody._native import PolicyNetwork

from .c_text import comment, number, table
from .interface import BEFORE_THE_FIRST, Image
from .source import PolicySource

STEPS = 100
_MULTIPLIER, _INCREMENT = 1664525, 1013904223  # of the generator: x' = a x + c, modulo 2^32
_BASIS, _PRIME = 0x811C9DC5, 0x01000193  # of the hash FNV-1a, over words


def centres(source: PolicySource) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Centre and spread of each of the network's inputs."""
    policy = source.policy
    spread = np.exp2(np.round(np.log2(1.0 / policy.scale)))
    return policy.mean.astype(np.float32), spread.astype(np.float32)


def _range_of(image: Image) -> tuple[float, float]:
    """Least value and spread of a float image's pixels."""
    return image.low, float(np.exp2(np.floor(np.log2(image.high - image.low))))


@cache
def _steps(count: int) -> tuple[NDArray[np.uint32], NDArray[np.uint32]]:
    """Factors and terms of the next words: word k is factor[k] word + term[k], modulo 2^32."""
    factors, terms = np.empty(count, np.uint32), np.empty(count, np.uint32)
    factor, term = 1, 0
    for k in range(count):
        factor = factor * _MULTIPLIER & 0xFFFFFFFF
        term = (term * _MULTIPLIER + _INCREMENT) & 0xFFFFFFFF
        factors[k], terms[k] = factor, term
    return factors, terms


@dataclass
class Sequence:
    """The words of the generator."""

    word: int = 1

    def take(self, count: int) -> NDArray[np.uint32]:
        """The next words."""
        factors, terms = _steps(count)
        words = factors * np.uint32(self.word) + terms
        self.word = int(words[-1])
        return words


def inputs_of(words: NDArray[np.uint32], centre: NDArray[np.float32], spread: NDArray[np.float32]
              ) -> NDArray[np.float32]:  # fmt: skip
    """Inputs from words: centre + [-2, 2) spread."""
    unit = (words >> 8).astype(np.float32) * np.float32(2.0**-22) - np.float32(2.0)
    return centre + unit * spread


def pixels_of(words: NDArray[np.uint32], image: Image) -> NDArray[np.generic]:
    """Pixels from words."""
    if image.dtype == "float32":
        low, spread = _range_of(image)
        unit = (words >> 8).astype(np.float32) * np.float32(2.0**-24)
        return np.float32(low) + unit * np.float32(spread)
    return (words >> np.uint32(24 if image.dtype == "uint8" else 16)).astype(image.dtype)


def actions_of(source: PolicySource, steps: int) -> NDArray[np.float32]:
    """Actions (steps, A) of the engine's evaluator for the sequence, of the first robot."""
    interface, agents = source.interface, source.policy.agents
    network = PolicyNetwork(str(source.file), [image.dtype for image in interface.images])
    row = np.zeros((1, source.policy.sizes()["observation_size"]), np.float32)
    places = agents[0].observation if agents else np.arange(row.shape[1])
    entries = agents[0].action if agents else slice(None)
    centre, spread = centres(source)
    past = {s.name: np.full(s.count, BEFORE_THE_FIRST, np.float32) for s in interface.past_actions}
    words, actions = Sequence(), []
    for _ in range(steps):
        for signal in interface.signals:
            own = slice(signal.first, signal.first + signal.count)
            if signal.actions is not None:
                row[0, places[own]] = past[signal.name]
            else:
                row[0, places[own]] = inputs_of(words.take(signal.count), centre[own], spread[own])
        seen = [pixels_of(words.take(int(np.prod(i.shape))), i) for i in interface.images]
        action = network.act(row, [pixels.view(np.uint8)[None] for pixels in seen])[0, entries]
        for signal in interface.past_actions:
            newest = action[list(signal.actions or ())]
            past[signal.name] = np.concatenate([newest, past[signal.name][: -len(newest)]])
        actions.append(action)
    return np.array(actions, np.float32)


def hash_of(actions: NDArray[np.float32]) -> int:
    """The hash of the actions' bits."""
    value = _BASIS
    for word in np.ascontiguousarray(actions).view(np.uint32).ravel().tolist():
        value = ((value ^ word) * _PRIME) & 0xFFFFFFFF
    return value


def self_test_text(source: PolicySource) -> str:
    """The C text of the self-test."""
    name, interface = source.name, source.interface
    fills = [
        line
        for signal in interface.inputs
        for line in _fill(signal.name, signal.first, signal.count)
    ]
    images = [line for image in interface.images for line in _draw(image)]
    storage = "".join(_storage(image) for image in interface.images)
    points = [f"  input.{image.name} = test_{image.name};" for image in interface.images]
    robot = ", 0" if interface.ranges_differ else ""
    centre, spread = centres(source)
    body = "\n".join([*points, f"  {name}_reset(&state{robot});", "  for (; steps > 0; --steps) {",
                      *fills, *images])  # fmt: skip
    return f"""\
#ifdef {name.upper()}_SELF_TEST
{table("test_centre", centre)}
{table("test_spread", spread)}
static uint32_t next_word(uint32_t *word) {{
  *word = *word * {_MULTIPLIER}u + {_INCREMENT}u;
  return *word;
}}

{comment("centre + [-2, 2) spread")}
static float test_value(uint32_t word, float centre, float spread) {{
  return centre + ((float)(word >> 8) * {number(2.0**-22)} - 2.0f) * spread;
}}

uint32_t {name}_self_test(uint32_t steps) {{
{storage}  static {name}_state state;
  static {name}_input input;
  {name}_output output;
  union {{
    float value;
    uint32_t bits;
  }} action;
  uint32_t word = 1u, hash = {_BASIS:#x}u;
  int i;
{body}
    {name}_step(&state, &input, &output);
    for (i = 0; i < {len(interface.outputs)}; ++i) {{
      action.value = state.action[i];
      hash = (hash ^ action.bits) * {_PRIME:#x}u;
    }}
  }}
  return hash;
}}
#endif
"""


def _fill(name: str, first: int, count: int) -> list[str]:
    at = f"{first} + i"
    if count == 1:
        return [f"    input.{name} = test_value(next_word(&word), test_centre[{first}], "
                f"test_spread[{first}]);"]  # fmt: skip
    return [
        f"    for (i = 0; i < {count}; ++i)",
        f"      input.{name}[i] = test_value(next_word(&word), test_centre[{at}], "
        f"test_spread[{at}]);",
    ]


def _count(image: Image) -> int:
    return int(np.prod(image.shape))


def _storage(image: Image) -> str:
    kind = {"float32": "float", "uint8": "uint8_t", "uint16": "uint16_t"}[image.dtype]
    return f"  static {kind} test_{image.name}[{_count(image)}];\n"


def _draw(image: Image) -> list[str]:
    if image.dtype == "float32":
        low, spread = _range_of(image)
        unit = f"(float)(next_word(&word) >> 8) * {number(2.0**-24)}"
        value = f"{number(low)} + {unit} * {number(spread)}"
    else:
        kind, shift = ("uint8_t", 24) if image.dtype == "uint8" else ("uint16_t", 16)
        value = f"({kind})(next_word(&word) >> {shift})"
    return [f"    for (i = 0; i < {_count(image)}; ++i) test_{image.name}[i] = {value};"]
