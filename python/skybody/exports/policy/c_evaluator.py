"""Exported C, compiled by this machine's compiler and called from Python."""

from __future__ import annotations

import ctypes
import os
import shutil
import subprocess
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skybody import InputError

from .interface import Interface
from .source import PolicySource

FLAGS = ("-std=c99", "-O2", "-Wall", "-Wextra", "-Werror")


def compiler() -> str:
    """This machine's C compiler. Raises InputError if there is none."""
    chosen = os.environ.get("CC", "cc")
    found = shutil.which(chosen)
    if found is None:
        raise InputError(f"no C compiler `{chosen}`: install gcc or clang, or set CC")
    return found


def compile_library(source: PolicySource, folder: Path, out: Path, *flags: str) -> None:
    """Compiles the sources in `folder` into a shared library with the self-test.

    The library also has `state_size`, the bytes of a state.

    Raises:
        InputError: the compiler is missing, or refuses them.
    """
    unit = out.with_name("with-size.c")  # no identifier, so never the name of the policy
    size = f"const unsigned long state_size = sizeof({source.name}_state);"
    unit.write_text(f'#include "{source.name}.c"\n{size}\n')
    command = [compiler(), *FLAGS, *flags, f"-D{source.name.upper()}_SELF_TEST", "-fPIC", "-shared"]
    command += [f"-I{folder}", str(unit), "-o", str(out)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise InputError(f"{' '.join(command)}: {done.stderr.strip() or 'failed'}")


class CEvaluator:
    """One robot's policy."""

    def __init__(self, source: PolicySource, folder: Path, robot: int = 0) -> None:
        """Compiles NAME.c of `folder` and begins an episode."""
        with tempfile.TemporaryDirectory() as temporary:
            library = Path(temporary) / "policy.so"
            compile_library(source, folder, library)
            self._library = ctypes.CDLL(str(library))
        self._interface, self._robot = source.interface, robot
        self._step = self._function(f"{source.name}_step", ctypes.c_int)
        self._reset = self._function(f"{source.name}_reset", None)
        self._test = self._function(f"{source.name}_self_test", ctypes.c_uint32)
        size = ctypes.c_ulong.in_dll(self._library, "state_size").value
        self._state = ctypes.create_string_buffer(size)
        self._inputs = _input_type(self._interface)()
        self._command = np.empty(len(self._interface.outputs), np.float32)
        self.reset()

    def _function(self, name: str, result: Any) -> Any:
        function = getattr(self._library, name)
        function.restype = result
        return function

    def reset(self) -> None:
        """Begins an episode."""
        robot = (self._robot,) if self._interface.ranges_differ else ()
        self._reset(self._state, *map(ctypes.c_int, robot))

    def act(self, values: Mapping[str, NDArray[Any]]) -> NDArray[np.float32]:
        """Actions (A,) in [-1, 1] of inputs by name; also sets `command`."""
        kept = []
        for signal in self._interface.inputs:
            setattr(self._inputs, signal.name, _member(values[signal.name]))
        for image in self._interface.images:
            pixels = np.ascontiguousarray(values[image.name], image.dtype)
            kept.append(pixels)
            setattr(self._inputs, image.name, pixels.ctypes.data)
        place = self._command.ctypes.data_as(ctypes.c_void_p)
        if self._step(self._state, ctypes.byref(self._inputs), place) != 1:
            return np.full(len(self._command), np.nan, np.float32)
        return np.frombuffer(self._state.raw, np.float32, len(self._command))

    @property
    def command(self) -> NDArray[np.float32]:
        """The last command (A,), in physical units."""
        return self._command.copy()

    def self_test(self, steps: int) -> int:
        """The hash of the self-test."""
        return int(self._test(ctypes.c_uint32(steps)))


def _member(values: NDArray[Any]) -> Any:
    floats = np.asarray(values, np.float32).ravel()
    return float(floats[0]) if len(floats) == 1 else (ctypes.c_float * len(floats))(*floats)


def _input_type(interface: Interface) -> type[ctypes.Structure]:
    fields: list[tuple[str, Any]] = [
        (s.name, ctypes.c_float if s.count == 1 else ctypes.c_float * s.count)
        for s in interface.inputs
    ]
    fields += [(image.name, ctypes.c_void_p) for image in interface.images]
    return type("Input", (ctypes.Structure,), {"_fields_": fields})
