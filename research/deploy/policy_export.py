"""Exported policies: size, equality of bits on four processors, error of ONNX, time of a call.

    python -m research run policy_export [--only NAMES] [--quick] [--out DIR]

Each policy is exported to C and to ONNX. The C sources evaluate a fixed sequence of inputs here
and, under QEMU, on aarch64, Cortex-M4 and Cortex-M7; the hash of their actions' bits is compared
with that of the engine's evaluator. ONNX Runtime's actions for normal observations are compared
with the engine's, and a call is timed on one thread, as is one of a model that does nothing.
"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
import onnx
from onnx import TensorProto, helper
from skybody._native import PolicyNetwork, shipped_policies
from skybody.exports.policy.c_files import write_sources
from skybody.exports.policy.network import network_of
from skybody.exports.policy.onnx_evaluator import session_of
from skybody.exports.policy.onnx_file import IR_VERSION, OPSET, write_model
from skybody.exports.policy.self_test import actions_of, hash_of
from skybody.exports.policy.source import PolicySource, Wanted, open_wanted

from research.common.machine import facts, machine_line
from research.common.options import Options
from research.common.pages import head, markdown_table, write_page
from research.deploy.network_drafts import write_draft
from research.deploy.targets import TARGETS, nanoseconds, run_self_test, size_of

PAGE = "policy_export"
# Kinds that no shipped policy has.
DRAFTS = {"GRU": "with_memory", "LSTM": "with_cells", "GRU, squashed": "squashed"}
DRAFTS_SCENARIO = "hover_learn"
BITS = ("gcc", "clang", "aarch64", "cortex-m4", "cortex-m7")
STEPS, IMAGE_STEPS = 10_000, 200
ROWS, IMAGE_ROWS, BLOCK = 100_000, 1_000, 500
ROUNDS, CALLS = 1_000, 400
SMALL = 20_000  # products


def sources(names: list[str], folder: Path) -> dict[str, PolicySource]:
    """The policies by the names of rows."""
    found = {}
    for name in names:
        wanted = Wanted("shipped", name)
        if name in DRAFTS:
            file = write_draft(folder / f"{DRAFTS[name]}.h5", DRAFTS_SCENARIO, DRAFTS[name])
            wanted = Wanted(str(file), name=DRAFTS[name])
        found[name] = open_wanted(wanted)
    return found


def layers_of(source: PolicySource) -> str:
    """Sizes of the layers, such as `25-64-64-4`."""
    layers = source.policy.layers
    sizes = [layers[0].weight.shape[1]]
    sizes += [layer.units or layer.weight.shape[0] for layer in layers]
    text = "-".join(map(str, sizes))
    for image in source.policy.images:
        text += f", image {image.shape[0]} x {image.shape[1]}"
    return text


def measure(source: PolicySource, folder: Path, quick: bool) -> dict[str, Any]:
    """The figures of a row."""
    write_sources(source, folder)
    write_model(source, folder / "policy.onnx")
    has_images = bool(source.interface.images)
    steps = 20 if quick else IMAGE_STEPS if has_images else STEPS
    expected = hash_of(actions_of(source, steps))
    tests = {
        name: run_self_test(TARGETS[name], source, folder, steps)
        for name in BITS
        if not TARGETS[name].missing
    }
    m4 = "cortex-m4" if "cortex-m4" in tests else "gcc"
    size = size_of(TARGETS[m4], source, folder)
    rounds, calls = (2, 10) if quick else (ROUNDS, max(10, CALLS // (50 if has_images else 1)))
    return {
        "layers": layers_of(source),
        "products": network_of(source.policy).operations,
        "flash": size.flash,
        "ram": size.ram,
        "steps": steps,
        "equal": {name: test.hash == expected for name, test in tests.items()},
        "instructions": {
            name: test.instructions for name, test in tests.items() if TARGETS[name].is_bare
        },
        "onnx_error": onnx_error(source, folder, 20 if quick else 0),
        "c_ns": nanoseconds(source, folder, rounds, calls),
        "onnx_ns": onnx_nanoseconds(source, folder / "policy.onnx", rounds, calls),
    }


def feed_of(source: PolicySource, rows: int, random: np.random.Generator) -> dict[str, Any]:
    """Inputs of the model: normal after normalization; states as at the beginning."""
    policy, interface = source.policy, source.interface
    normal = random.normal(size=(rows, len(policy.mean)))
    inputs = (normal / policy.scale + policy.mean).astype(np.float32)
    feed: dict[str, Any] = {
        (s.name if s.actions is None else f"past_{s.name}"): inputs[:, s.first : s.first + s.count]
        for s in interface.signals
    }
    for image in interface.images:
        pixels = random.uniform(image.low, image.high, (rows, *image.shape))
        feed[image.name] = pixels.astype(image.dtype)
    if interface.ranges_differ:
        feed["robot"] = np.zeros(rows, np.int64)
    if size := sum(layer.memory for layer in policy.layers):
        feed["memory"] = np.zeros((rows, size), np.float32)
    return feed


def onnx_error(source: PolicySource, folder: Path, few: int) -> float:
    """Largest difference between ONNX Runtime's actions and the engine's; `few`: rows, 0: all."""
    rows = few or (IMAGE_ROWS if source.interface.images else ROWS)
    session = session_of(folder / "policy.onnx")
    random = np.random.default_rng(3)
    network = PolicyNetwork(str(source.file), [i.dtype for i in source.interface.images])
    agents = source.policy.agents
    largest = 0.0
    for begin in range(0, rows, BLOCK):
        count = min(BLOCK, rows - begin)
        feed = feed_of(source, count, random)
        row = np.zeros((count, source.policy.sizes()["observation_size"]), np.float32)
        inputs = [
            feed[s.name if s.actions is None else f"past_{s.name}"]
            for s in source.interface.signals
        ]
        row[:, agents[0].observation if agents else slice(None)] = np.hstack(inputs)
        images = [feed[image.name] for image in source.interface.images]
        seen = [np.ascontiguousarray(p.reshape(count, -1)).view(np.uint8) for p in images]
        expected = engine_actions(network, row, seen, bool(feed.get("memory") is not None))
        given = session.run(["action"], feed)[0]
        chosen = expected[:, agents[0].action if agents else slice(None)]
        largest = max(largest, float(np.abs(chosen - given).max()))
    return largest


def engine_actions(network: PolicyNetwork, row: Any, images: list[Any], has_memory: bool) -> Any:
    """Actions of rows, each as at the beginning of an episode."""
    if not has_memory:
        return network.act(row, images)
    actions = []
    for k in range(len(row)):
        network.reset()
        actions.append(network.act(row[k : k + 1], [pixels[k : k + 1] for pixels in images]))
    return np.vstack(actions)


def onnx_nanoseconds(source: PolicySource, path: Path, rounds: int, calls: int) -> float:
    """Least time of a call of ONNX Runtime with bound inputs and outputs [ns]."""
    return session_nanoseconds(path, feed_of(source, 1, np.random.default_rng(3)), rounds, calls)


def session_nanoseconds(path: Path, feed: dict[str, Any], rounds: int, calls: int) -> float:
    """Least time of a call of a model, from Python, without copies of inputs [ns]."""
    session = session_of(path)
    binding = session.io_binding()
    for name, values in feed.items():
        binding.bind_cpu_input(name, np.ascontiguousarray(values))
    for output in session.get_outputs():
        binding.bind_output(output.name)
    least = np.inf
    for _ in range(rounds):
        start = time.perf_counter_ns()
        for _ in range(calls):
            session.run_with_iobinding(binding)
        least = min(least, (time.perf_counter_ns() - start) / calls)
    return float(least)


def empty_nanoseconds(folder: Path, quick: bool) -> float:
    """Time of a call of a model that copies four numbers [ns]."""
    x, y = (helper.make_tensor_value_info(n, TensorProto.FLOAT, ["batch", 4]) for n in "xy")
    graph = helper.make_graph([helper.make_node("Identity", ["x"], ["y"])], "empty", [x], [y])
    opset = helper.make_opsetid("", OPSET)
    path = folder / "empty.onnx"
    onnx.save(helper.make_model(graph, opset_imports=[opset], ir_version=IR_VERSION), path)
    rounds, calls = (2, 10) if quick else (ROUNDS, CALLS)
    return session_nanoseconds(path, {"x": np.zeros((1, 4), np.float32)}, rounds, calls)


def page(found: dict[str, Any]) -> str:
    """The page."""
    rows = found["rows"]
    small = [row for row in rows.values() if row["products"] < SMALL]
    faster = [row["onnx_ns"] / row["c_ns"] for row in small]
    alone = [(row["onnx_ns"] - found["empty_ns"]) / row["c_ns"] for row in small]
    equal = sum(all(row["equal"].values()) for row in rows.values())
    worst = max(row["onnx_error"] for row in rows.values())
    return f"""\
# Exported policies

Made by `python -m research run policy_export` on {machine_line(found["facts"])}.

- C: {equal} of {len(rows)} policies give the engine's bits on each of {", ".join(BITS)}.
- ONNX: the largest difference of an action in [-1, 1] is {worst:.1e}.
- Time: of networks with less than {SMALL:,} products, such as 25-64-64-4, a call in C takes
  {min(faster):.1f} to {max(faster):.1f} times less than one of ONNX Runtime. A call of a model that
  does nothing takes {found["empty_ns"] / 1e3:.2f} us; without that it is {min(alone):.1f} to
  {max(alone):.1f} times.

{markdown_table(table(rows), text=(0, 1, 5))}

- layers: inputs (with features of images), then outputs of each layer; GRU: units.
- products: multiplications of a call.
- flash, RAM: code and constants, and the state, compiled for Cortex-M4 with -O2 [KiB].
- bits: processors on which all actions of the self-test have the engine's bits: {STEPS:,} steps,
  with images {IMAGE_STEPS}; x86 by gcc and by clang, aarch64 and Cortex-M under QEMU.
- M4, M7: instructions of a call, counted by QEMU (`-icount`, SysTick). They are not cycles: a
  Cortex-M4F takes more than one cycle for divisions and loads from slow flash.
- ONNX error: largest difference of an action over {ROWS:,} normal observations, with images
  {IMAGE_ROWS:,}.
- C, ONNX: least time of a call over {ROUNDS:,} rounds [us], here, on one thread. ONNX Runtime is
  called from Python with bound inputs and outputs.
- `GRU`, `LSTM`, `GRU, squashed`: random weights for `{DRAFTS_SCENARIO}`; no shipped policy has
  such layers.
"""


def table(rows: dict[str, dict[str, Any]]) -> list[list[str]]:
    """The rows of the table."""
    names = "policy | layers | products | flash | RAM | bits | M4 | M7 | ONNX error | C | ONNX"
    cells = [head(names)]
    for name, row in rows.items():
        same = [name for name, is_equal in row["equal"].items() if is_equal]
        counts = [f"{row['instructions'].get(core, np.nan):,.0f}" for core in BITS[-2:]]
        cells.append(
            [
                name,
                row["layers"],
                f"{row['products']:,}",
                f"{row['flash'] / 1024:.1f}",
                f"{row['ram'] / 1024:.1f}",
                "all" if len(same) == len(BITS) else ", ".join(same),
                *counts,
                f"{row['onnx_error']:.1e}",
                f"{row['c_ns'] / 1e3:.2f}",
                f"{row['onnx_ns'] / 1e3:.2f}",
            ]
        )
    return cells


def main() -> int:
    names = [*shipped_policies(), *DRAFTS]
    options = (
        Options(__doc__, __name__, "two policies, a few steps")
        .add("--only", nargs="+", choices=names, help="policies; default: all")
        .given()
    )
    chosen = options.only or (["racing", "GRU, squashed"] if options.quick else names)
    found: dict[str, Any] = {"facts": facts(), "rows": {}}
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        for k, (name, source) in enumerate(sources(chosen, folder).items()):
            found["rows"][name] = measure(source, folder / str(k), options.quick)
            print(f"{name}: {found['rows'][name]}", flush=True)
        found["empty_ns"] = empty_nanoseconds(folder, options.quick)
    write_page(options.out, PAGE, page(found), found)
    return 0
