"""A policy as ONNX, with a page beside it."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np
import onnx
from onnx import helper

from skybody.whole_output import whole_output

from .c_header import FRAMES
from .lockstep import check
from .onnx_evaluator import OnnxEvaluator
from .onnx_graph import graph_of
from .page import page
from .source import PolicySource

OPSET = 17
IR_VERSION = 8  # of that opset's time: read by older programs, too
LARGEST = 1e-6  # allowed difference from the engine's actions, which are in [-1, 1]


def write(source: PolicySource, path: Path, options: argparse.Namespace) -> None:
    """Writes the file and NAME.md beside the place where it will be; with --check flies first."""
    write_model(source, path)
    if options.check:
        make = lambda robot: OnnxEvaluator(source, path, robot)  # noqa: E731
        print(check(source, make, options.check, LARGEST))
    out = options.out or path.parent.parent / path.name
    with whole_output(out.with_suffix(".md")) as beside:
        beside.write_text(page(source))


def write_model(source: PolicySource, path: Path) -> None:
    """Writes the model."""
    model = helper.make_model(
        graph_of(source.policy, source.interface, source.name),
        opset_imports=[helper.make_opsetid("", OPSET)],
        producer_name="skybody",
        ir_version=IR_VERSION,
        doc_string=page(source),
    )
    helper.set_model_props(model, properties(source))
    onnx.checker.check_model(model, full_check=True)
    onnx.save(model, path)


def properties(source: PolicySource) -> dict[str, str]:
    """The model's metadata: texts, lists as JSON."""
    attributes, interface = source.policy.attributes, source.interface
    inputs = [
        {
            "name": signal.name if signal.actions is None else f"past_{signal.name}",
            "column": signal.column,
            "unit": signal.unit,
            "meaning": signal.meaning,
            "values": signal.count,
        }
        for signal in interface.signals
    ]
    images = [
        {
            "name": image.name,
            "column": image.column,
            "unit": image.unit,
            "shape": image.shape,
            "low": image.low,
            "high": image.high,
        }
        for image in interface.images
    ]
    outputs = [
        {
            "name": output.name,
            "unit": output.unit,
            "meaning": output.meaning,
            "low": np.asarray(output.low).tolist(),
            "high": np.asarray(output.high).tolist(),
        }
        for output in interface.outputs
    ]
    return {
        "format": "skybody-policy",
        "scenario": str(attributes["scenario"]),
        "scenario_hash": str(attributes["scenario_hash"]),
        "period": repr(interface.period),
        "frames": FRAMES,
        "inputs": json.dumps(inputs),
        "images": json.dumps(images),
        "outputs": json.dumps(outputs),
        "robots": json.dumps(interface.robots),
    }
