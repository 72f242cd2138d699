"""The page about an exported policy: its inputs and outputs in tables."""

from __future__ import annotations

from collections.abc import Iterable

from .c_header import FRAMES
from .interface import BEFORE_THE_FIRST, Interface
from .source import PolicySource


def page(source: PolicySource) -> str:
    """The text of NAME.md."""
    attributes, interface = source.policy.attributes, source.interface
    parts = [
        f"# {source.name}: a policy of `{attributes['scenario']}`",
        f"Trained by {attributes['algorithm']} for {attributes['steps']:,} steps; scenario hash "
        f"{attributes['scenario_hash'] or 'unknown'}. Exported by `skybody export`.",
        f"Evaluate it every {interface.period:g} s ({1.0 / interface.period:g} Hz). It gives the "
        "mean of the action distribution. Normalization is inside.",
        FRAMES,
        "## Inputs",
        _table(("input", "values", "unit", "range", "meaning"), _input_rows(interface)),
        _past(interface),
        "## Outputs",
        _table(("output", "unit", "action -1", "action +1", "meaning"), _output_rows(interface)),
        "The network gives actions in [-1, 1]. A command is low + (action + 1) / 2 (high - low).",
        _team(interface),
    ]
    return "\n\n".join(part for part in parts if part) + "\n"


def _input_rows(interface: Interface) -> Iterable[tuple[str, ...]]:
    for signal in interface.inputs:
        span = f"{signal.low:g} ... {signal.high:g}"
        yield f"`{signal.name}`", str(signal.count), signal.unit, span, signal.meaning
    for image in interface.images:
        height, width, channels = image.shape
        shape = f"{height} x {width} x {channels} {image.dtype}"
        meaning = image.meaning or f"image `{image.column}`, row by row"
        yield f"`{image.name}`", shape, image.unit, f"{image.low:g} ... {image.high:g}", meaning


def _past(interface: Interface) -> str:
    if not interface.past_actions:
        return ""
    names = ", ".join(f"`{signal.name}` ({signal.count})" for signal in interface.past_actions)
    return (
        f"Past actions are also inputs of the network: {names}. They are the actions in [-1, 1] of "
        f"the steps before, the newest first; {BEFORE_THE_FIRST:g} before the first. C keeps them "
        "in its state; ONNX has them as an input and an output."
    )


def _output_rows(interface: Interface) -> Iterable[tuple[str, ...]]:
    for output in interface.outputs:
        low, high = (" / ".join(f"{v:g}" for v in values) for values in (output.low, output.high))
        yield f"`{output.name}`", output.unit, low, high, output.meaning


def _team(interface: Interface) -> str:
    """Table of the columns that are each robot's inputs."""
    if not interface.robots:
        return ""
    rows = [
        (f"`{signal.name}`", *(f"`{columns[k]}`" for columns in interface.columns))
        for k, signal in enumerate(interface.signals)
    ]
    order = " Ranges are in the order of the robots." if interface.ranges_differ else ""
    return (
        f"## Robots\n\nEach robot has its own state and is evaluated by itself.{order} Its inputs "
        "are these columns of the scenario's observation:\n\n"
        + _table(("input", *interface.robots), rows)
    )


def _table(head: Iterable[str], rows: Iterable[tuple[str, ...]]) -> str:
    head = tuple(head)
    lines = [head, ("---",) * len(head), *rows]
    return "\n".join(f"| {' | '.join(cell.replace('|', '/') for cell in row)} |" for row in lines)
