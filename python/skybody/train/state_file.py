"""What a checkpoint holds beside environments and policy, in a file that fits the learner.

`state.pt` is PyTorch's, for learners in PyTorch; `state.npz` NumPy's, for those in C++, which need
no PyTorch and are done before it would be loaded.
"""

from __future__ import annotations

import io
import json
from pathlib import Path
from typing import Any

import numpy as np

from skybody.train.algorithms import NATIVE

PLAIN = "plain"  # the entry of state.npz that is JSON: everything but the learner's arrays


def state_file(algorithm: str) -> str:
    """Its name for a learner."""
    return "state.npz" if algorithm in NATIVE else "state.pt"


def pack_state(algorithm: str, state: dict[str, Any]) -> bytes:
    """The bytes of the file."""
    buffer = io.BytesIO()
    if algorithm in NATIVE:
        plain = {name: value for name, value in state.items() if name != "learner"}
        text = np.frombuffer(json.dumps(plain).encode(), np.uint8)
        entries: dict[str, Any] = {PLAIN: text, **state["learner"]}
        np.savez(buffer, **entries)
    else:
        import torch

        torch.save(state, buffer)
    return buffer.getvalue()


def unpack_state(path: Path) -> dict[str, Any]:
    """What pack_state() was given."""
    if path.suffix == ".npz":
        with np.load(path, allow_pickle=False) as entries:
            arrays = {name: entries[name] for name in entries.files}
        plain: dict[str, Any] = json.loads(arrays.pop(PLAIN).tobytes())
        return {**plain, "learner": arrays}
    import torch

    state: dict[str, Any] = torch.load(path, weights_only=True)
    return state
