"""The learner's state in a checkpoint: state.pt or state.npz.

`state.pt` is PyTorch's format, for learners in PyTorch; `state.npz` NumPy's, for learners in C++,
which do not need PyTorch and finish sooner than its import. Both are ZIP archives with uncompressed
entries, so that no file takes more memory than its size.
"""

from __future__ import annotations

import io
import json
import math
import pickle
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from skybody.train.algorithms import NATIVE
from skybody.train.json_file import wrong_kinds

PLAIN = "plain"  # JSON entry of state.npz: everything except the learner's arrays
KINDS: dict[str, Any] = {  # of the trainer's entries beside the learner's state
    "learner": dict[str, Any],
    "average": dict[str, Any],
    "shares": dict[str, float],
    "recent": list[float],
    "faults": int,
}


def state_file(algorithm: str) -> str:
    """Name of the state file of a learner."""
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
    """The inverse of pack_state(). Raises ValueError, without the file's name, for other files."""
    try:
        with zipfile.ZipFile(path) as archive:
            _check_sizes(archive, path.stat().st_size)
            state = _arrays_and_plain(archive) if path.suffix == ".npz" else _tensors(path)
    except (zipfile.BadZipFile, NotImplementedError, EOFError, RuntimeError, KeyError) as error:
        raise ValueError(f"no archive of a learner's state: {error}") from error
    if wrong := wrong_kinds(state, KINDS):
        raise ValueError(", ".join(wrong))
    return state


def _check_sizes(archive: zipfile.ZipFile, room: int) -> None:
    """Raises ValueError for entries that have more bytes than the archive."""
    for entry in archive.infolist():
        if entry.compress_type != zipfile.ZIP_STORED:
            raise ValueError(f"`{entry.filename}` is compressed, which no learner's state is")
        room -= entry.file_size
    if room < 0:
        raise ValueError("its entries have more bytes than the file")


def _arrays_and_plain(archive: zipfile.ZipFile) -> dict[str, Any]:
    arrays = {name.removesuffix(".npy"): _array(archive, name) for name in archive.namelist()}
    if PLAIN not in arrays:
        raise ValueError(f"`{PLAIN}` is missing")
    try:
        plain = json.loads(arrays.pop(PLAIN).tobytes())
    except RecursionError:
        raise ValueError(f"`{PLAIN}` is nested too deeply") from None
    if not isinstance(plain, dict):
        raise ValueError(f"`{PLAIN}` is no map")
    return {**plain, "learner": arrays}


def _array(archive: zipfile.ZipFile, name: str) -> NDArray[Any]:
    """An entry in NumPy's format; checks its size against the header."""
    content = archive.read(name)
    stream = io.BytesIO(content)
    if npy.read_magic(stream) != (1, 0):
        raise ValueError(f"`{name}` is in another version of NumPy's format")
    shape, _, dtype = npy.read_array_header_1_0(stream)
    if dtype.kind not in "iu":
        raise ValueError(f"`{name}` holds {dtype}; a learner's state is whole numbers")
    if math.prod(shape) * dtype.itemsize != len(content) - stream.tell():
        raise ValueError(f"`{name}` has other bytes than its shape {shape} takes")
    return np.frombuffer(content, dtype, offset=stream.tell()).reshape(shape).copy()


def _tensors(path: Path) -> dict[str, Any]:
    import torch

    try:
        state: dict[str, Any] = torch.load(path, weights_only=True)
    except pickle.UnpicklingError:  # its message would advise to trust the file
        raise ValueError("it holds more than tensors and plain values") from None
    if not isinstance(state, dict):
        raise ValueError("no map")
    return state
