"""The source of an exported policy."""

from __future__ import annotations

from skybody._native import network_layers_source

from .c_header import PIXELS, about
from .c_text import comment, number, table
from .interface import BEFORE_THE_FIRST, Interface
from .network import Network
from .self_test import self_test_text
from .source import PolicySource


def source_text(source: PolicySource, network: Network) -> str:
    """The text of NAME.c."""
    name, interface = source.name, source.interface
    parts = [
        comment(about(source)),
        f'#include "{name}.h"\n',
        network_layers_source(),
        "/* --- weights --- */\n",
        *network.tables,
        _ranges(interface),
        _reset(name, interface, network),
        _gather(name, interface),
        _is_finite(name, interface),
        _remember(name, interface),
        _step(name, source, network),
        self_test_text(source),
    ]
    return "\n".join(part for part in parts if part)


def _ranges(interface: Interface) -> str:
    robots = len(interface.outputs[0].low)
    low = [[output.low[r] for output in interface.outputs] for r in range(robots)]
    high = [[output.high[r] for output in interface.outputs] for r in range(robots)]
    return table("action_low", low) + "\n" + table("action_high", high)


def _reset(name: str, interface: Interface, network: Network) -> str:
    robot = interface.ranges_differ
    lines = ["int i;", f"for (i = 0; i < {len(interface.outputs)}; ++i) state->action[i] = 0.0f;"]
    for signal in interface.past_actions:
        place = f"state->past_{signal.name}[i]"
        lines.append(f"for (i = 0; i < {signal.count}; ++i) {place} = {number(BEFORE_THE_FIRST)};")
    if network.memory:
        lines.append(f"for (i = 0; i < {network.memory}; ++i) state->memory[i] = 0.0f;")
    if robot:
        lines.append("state->robot = robot;")
    head = f"void {name}_reset({name}_state *state{', int robot' if robot else ''})"
    return _function(head, lines)


def _gather(name: str, interface: Interface) -> str:
    """The function that writes the network's inputs in order."""
    lines = ["int i;"]
    for signal in interface.signals:
        if signal.actions is None and signal.count == 1:
            lines.append(f"to[{signal.first}] = input->{signal.name};")
            continue
        place = "input->" if signal.actions is None else "state->past_"
        lines.append(
            f"for (i = 0; i < {signal.count}; ++i) to[{signal.first} + i] = "
            f"{place}{signal.name}[i];"
        )
    lines += ["(void)i;", "(void)state;", "(void)input;"]
    head = (
        f"static void gather(const {name}_state *state, const {name}_input *input,\n"
        "                   float *to)"
    )
    return _function(head, lines)


def _is_finite(name: str, interface: Interface) -> str:
    size = sum(signal.count for signal in interface.signals)
    return _function(
        "static int are_finite(const float *values)",
        ["int i;", f"for (i = 0; i < {size}; ++i)", "  if (!layer_is_finite(values[i])) return 0;",
         "return 1;"],
    )  # fmt: skip


def _remember(name: str, interface: Interface) -> str:
    """The function that adds the actions to the past ones, the newest first."""
    if not interface.past_actions:
        return ""
    lines = ["int i;"]
    for signal in interface.past_actions:
        assert signal.actions is not None
        place, size = f"state->past_{signal.name}", len(signal.actions)
        if signal.count > size:
            lines.append(
                f"for (i = {signal.count - 1}; i >= {size}; --i) {place}[i] = {place}[i - {size}];"
            )
        first = f"{signal.actions.start} + " if signal.actions.start else ""
        lines.append(f"for (i = 0; i < {size}; ++i) {place}[i] = state->action[{first}i];")
    return _function(f"static void remember({name}_state *state)", lines)


def _step(name: str, source: PolicySource, network: Network) -> str:
    interface, actions = source.interface, len(source.interface.outputs)
    lines = [
        "float *const inputs = state->inputs;",
        f"float(*const values)[{network.width}] = state->values;",
        "const float *result;",
        "int i;",
        "gather(state, input, inputs);",
        "if (!are_finite(inputs)) return 0;",
    ]
    for image, calls in zip(interface.images, network.image_calls, strict=True):
        count = image.shape[0] * image.shape[1] * image.shape[2]
        pixel = (
            f"(float)input->{image.name}[i]"
            if PIXELS[image.dtype] != "float"
            else (f"input->{image.name}[i]")
        )
        lines.append(f"for (i = 0; i < {count}; ++i)")
        lines.append(
            f"  values[0][i] = layer_pixel({pixel}, {number(image.low)}, {number(image.high)});"
        )
        lines += calls
    lines += [*network.calls, f"result = {network.result};"]
    value = "layer_tanh(result[i])" if source.policy.squash == "tanh" else "result[i]"
    lines.append(f"for (i = 0; i < {actions}; ++i)")
    lines.append(f"  state->action[i] = layer_clip({value}, -1.0f, 1.0f);")
    for k, output in enumerate(interface.outputs):
        at = f"{k} + {actions} * state->robot" if interface.ranges_differ else str(k)
        lines.append(
            f"output->{output.name} = layer_scale(state->action[{k}], action_low[{at}], "
            f"action_high[{at}]);"
        )
    lines += ["remember(state);"] if interface.past_actions else []
    lines += ["(void)values;", "return 1;"]
    head = f"int {name}_step({name}_state *state, const {name}_input *input, {name}_output *output)"
    return _function(head, lines)


def _function(head: str, lines: list[str]) -> str:
    return "\n".join([f"{head} {{", *(f"  {line}" for line in lines), "}"]) + "\n"
