"""The header of an exported policy: inputs, outputs and state by name."""

from __future__ import annotations

from .c_text import comment, number
from .interface import Image, Interface, Output, Signal
from .network import Network
from .source import PolicySource

PIXELS = {"float32": "float", "uint8": "uint8_t", "uint16": "uint16_t"}
FRAMES = "Frames: W world, z up; B body, x forward, y left, z up. Quaternions w x y z. SI units."


def header(source: PolicySource, network: Network, self_test: tuple[int, int]) -> str:
    """The text of NAME.h; `self_test`: its number of steps and the hash that it gives."""
    name, interface = source.name, source.interface
    upper = name.upper()
    steps, value = self_test
    return f"""\
{comment(about(source))}
#ifndef {upper}_H
#define {upper}_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {{
#endif

#define {upper}_PERIOD {interface.period!r}f /* s between calls of {name}_step() */
#define {upper}_ACTIONS {len(interface.outputs)}
{_ranges(name, interface)}{_robots(name, interface)}
{comment(f"Inputs. {FRAMES}")}
typedef struct {{
{_inputs(interface)}
}} {name}_input;

{comment("Outputs: the command in physical units.")}
typedef struct {{
{chr(10).join(_output(output, interface) for output in interface.outputs)}
}} {name}_output;

{
        comment(
            "The state of an episode, and work space. All memory that the policy needs beside the "
            "stack."
        )
    }
typedef struct {{
{_state(interface, network)}
}} {name}_state;

{_functions(name, interface)}
{
        comment(
            f"With {upper}_SELF_TEST defined: evaluates a fixed sequence of inputs and returns a "
            "hash of the actions' bits. The simulator's evaluator gives the hash below for that "
            "number of steps."
        )
    }
#ifdef {upper}_SELF_TEST
#define {upper}_SELF_TEST_STEPS {steps}u
#define {upper}_SELF_TEST_HASH 0x{value:08x}u
uint32_t {name}_self_test(uint32_t steps);
#endif

#ifdef __cplusplus
}}
#endif

#endif
"""


def about(source: PolicySource) -> str:
    """One paragraph about the policy."""
    attributes = source.policy.attributes
    shared = source.interface.robots
    team = f" One evaluation is that of one robot of {', '.join(shared)}." if shared else ""
    return (
        f"{source.name}: the policy of the scenario `{attributes['scenario']}` (hash "
        f"{attributes['scenario_hash'] or 'unknown'}), trained by {attributes['algorithm']} for "
        f"{attributes['steps']:,} steps, written by `skybody export --to c`.{team} "
        f"{source.name}.md describes it."
    )


def _ranges(name: str, interface: Interface) -> str:
    """Constants with the range of each output; none if robots have different ones."""
    if interface.ranges_differ:
        return ""
    lines = []
    for output in interface.outputs:
        for word, values in (("LOW", output.low), ("HIGH", output.high)):
            macro = f"{name}_{output.name}_{word}".upper()
            lines.append(f"#define {macro} ({number(values[0])})\n")
    return "".join(lines)


def _robots(name: str, interface: Interface) -> str:
    if not interface.ranges_differ:
        return ""
    words = ", ".join(f"{name.upper()}_{robot.upper()}" for robot in interface.robots)
    return f"\n{comment('Robots, whose ranges of commands differ.')}\nenum {{ {words} }};\n"


def _inputs(interface: Interface) -> str:
    lines = [_input(signal) for signal in interface.inputs]
    return "\n".join([*lines, *(_image(image) for image in interface.images)]) or "  char unused;"


def _input(signal: Signal) -> str:
    size = f"[{signal.count}]" if signal.count > 1 else ""
    return f"{comment(described(signal.unit, signal.meaning), '  ')}\n  float {signal.name}{size};"


def _image(image: Image) -> str:
    height, width, channels = image.shape
    text = described(
        image.unit,
        f"image `{image.column}`: {height} rows of {width} pixels of {channels} values, row by "
        f"row; {image.low:g} ... {image.high:g}",
    )
    return f"{comment(text, '  ')}\n  const {PIXELS[image.dtype]} *{image.name};"


def _output(output: Output, interface: Interface) -> str:
    robots = interface.robots if len(output.low) > 1 else [""]
    ranges = "; ".join(
        f"{robot + ': ' if robot else ''}{low:g} ... {high:g}"
        for robot, low, high in zip(robots, output.low, output.high, strict=False)
    )
    text = described(output.unit, f"{output.meaning}; {ranges}")
    return f"{comment(text, '  ')}\n  float {output.name};"


def described(unit: str, meaning: str) -> str:
    """`[unit] meaning`."""
    return " ".join(filter(None, [f"[{unit}]" if unit else "", meaning]))


def _state(interface: Interface, network: Network) -> str:
    lines = [
        comment("The last actions, in [-1, 1].", "  "),
        f"  float action[{len(interface.outputs)}];",
    ]
    if interface.ranges_differ:
        lines.append("  int robot;")
    for signal in interface.past_actions:
        lines += [comment(f"Input of the network: {signal.meaning}.", "  ")]
        lines += [f"  float past_{signal.name}[{signal.count}];"]
    if network.memory:
        lines += [comment("Recurrent states.", "  "), f"  float memory[{network.memory}];"]
        lines += [f"  float sums[{network.sums}];"]
    features = sum(s.count for s in interface.signals) + network.features
    lines += [f"  float inputs[{features}];", f"  float values[2][{network.width}];"]
    return "\n".join(lines)


def _functions(name: str, interface: Interface) -> str:
    robot = ", int robot" if interface.ranges_differ else ""
    begins = (
        "Begins an episode: call it before the first step, and whenever control is handed over."
    )
    step = (
        "Evaluates the policy once. Returns 1; or 0 if an input is infinite or not a number: the "
        "state and the output are then unchanged, and a safe command is needed."
    )
    return f"""\
{comment(begins)}
void {name}_reset({name}_state *state{robot});

{comment(step)}
int {name}_step({name}_state *state, const {name}_input *input, {name}_output *output);
"""
