"""Processors that run an exported policy: this one, aarch64, Cortex-M4 and M7, by emulators."""

from __future__ import annotations

import os
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from skybody.exports.policy.c_header import PIXELS
from skybody.exports.policy.source import PolicySource

HERE = Path(__file__).resolve().parent
BOARD = HERE / "cortex_m"
CALLS = 10  # of self_test.c
INSTRUCTIONS_PER_TICK = 40  # of board.h
TIMEOUT = 600.0  # s
CORTEX = ("-mthumb", "-mfloat-abi=hard", "-ffreestanding", "-nostdlib", "-DBARE")
LINKED = ("-T", str(BOARD / "memory.ld"), str(BOARD / "board.c"), "-I", str(BOARD), "-lgcc")
EMULATOR = ("qemu-system-arm", "-nographic", "-semihosting", "-icount", "shift=0")


@dataclass(frozen=True)
class Target:
    """A processor, with the compiler for it and the emulator that runs it."""

    name: str
    compiler: str
    flags: tuple[str, ...] = ()
    linked: tuple[str, ...] = ()
    emulator: tuple[str, ...] = ()  # empty: runs here
    packages: str = ""  # of Debian
    is_bare: bool = False

    @property
    def missing(self) -> str:
        """The missing program and its packages; empty: all are installed."""
        for program in (self.compiler, *self.emulator[:1]):
            if shutil.which(program) is None:
                return f"no {program}: apt-get install {self.packages}"
        return ""


TARGETS = {
    target.name: target
    for target in (
        Target("gcc", "gcc", packages="gcc"),
        Target("clang", "clang", packages="clang"),
        Target(
            "aarch64", "aarch64-linux-gnu-gcc", (), ("-static",), ("qemu-aarch64",),
            "gcc-aarch64-linux-gnu qemu-user",
        ),
        Target(
            "cortex-m4", "arm-none-eabi-gcc",
            ("-mcpu=cortex-m4", "-mfpu=fpv4-sp-d16", *CORTEX), LINKED,
            (*EMULATOR, "-machine", "mps2-an386", "-kernel"),
            "gcc-arm-none-eabi qemu-system-arm", is_bare=True,
        ),
        Target(
            "cortex-m7", "arm-none-eabi-gcc",
            ("-mcpu=cortex-m7", "-mfpu=fpv5-sp-d16", *CORTEX), LINKED,
            (*EMULATOR, "-machine", "mps2-an500", "-kernel"),
            "gcc-arm-none-eabi qemu-system-arm", is_bare=True,
        ),
    )
}  # fmt: skip


@dataclass(frozen=True)
class SelfTest:
    """The result of a self-test."""

    hash: int
    instructions: float  # of a call; nan where they are not counted


@dataclass(frozen=True)
class Size:
    """Memory of a policy [bytes]."""

    flash: int  # code and constants
    ram: int  # a state; the stack comes in addition


def write_unit(source: PolicySource, folder: Path, program: str) -> Path:
    """Writes a program beside the sources in `folder`; `program`: a C file of this folder."""
    name, images = source.name, source.interface.images
    lines = [f'#include "{name}.c"', f"{name}_state state;", f"{name}_input input;"]
    lines += [
        f"{PIXELS[image.dtype]} pixels_{image.name}[{int(np.prod(image.shape))}];"
        for image in images
    ]
    points = " ".join(f"input.{image.name} = pixels_{image.name};" for image in images)
    robot = ", 0" if source.interface.ranges_differ else ""
    lines += [
        f"void begin(void) {{ {points} {name}_reset(&state{robot}); }}",
        f'#include "{program}"',
    ]
    unit = folder / f"unit-{program}"
    unit.write_text("\n".join(lines) + "\n")
    return unit


def run_self_test(target: Target, source: PolicySource, folder: Path, steps: int) -> SelfTest:
    """Compiles the sources in `folder`, runs the self-test and returns its hash.

    Raises:
        subprocess.SubprocessError: a tool failed.
    """
    program = folder / f"{target.name}.elf"
    command = [target.compiler, "-std=c99", "-O2", "-Wall", "-Wextra", "-Werror", *target.flags]
    command += [f"-DPOLICY={source.name}", f"-DSTEPS={steps}u", f"-I{folder}", f"-I{HERE}"]
    command += [
        f"-D{source.name.upper()}_SELF_TEST",
        str(write_unit(source, folder, "self_test.c")),
    ]
    _run([*command, *target.linked, "-o", str(program)])
    words = _run([*target.emulator, str(program)]).split()
    instructions = np.nan
    if target.is_bare:
        instructions = int(words[1], 16) * INSTRUCTIONS_PER_TICK / CALLS
    return SelfTest(int(words[0], 16), float(instructions))


def nanoseconds(source: PolicySource, folder: Path, rounds: int, calls: int) -> float:
    """Least time of a call on this machine [ns]."""
    program = folder / "timing"
    unit = write_unit(source, folder, "timing.c")
    command = ["gcc", "-std=gnu99", "-O2", f"-I{folder}", f"-I{HERE}", str(unit)]
    command += [f"-DPOLICY={source.name}", f"-DROUNDS={rounds}", f"-DCALLS={calls}"]
    _run([*command, "-o", str(program)])
    return float(_run([str(program)]))


def size_of(target: Target, source: PolicySource, folder: Path) -> Size:
    """Flash and RAM by the compiler's `size`, without the self-test."""
    unit, made = folder / "unit-size.c", folder / f"{target.name}.o"
    unit.write_text(f'#include "{source.name}.c"\n{source.name}_state state;\n')
    flags = [flag for flag in target.flags if flag != "-nostdlib"]
    command = [target.compiler, "-std=c99", "-O2", *flags, f"-I{folder}", "-c", str(unit)]
    _run([*command, "-o", str(made)])
    tool = target.compiler.replace("gcc", "size") if "-" in target.compiler else "size"
    text, data, bss = (int(word) for word in _run([tool, str(made)]).splitlines()[1].split()[:3])
    return Size(text + data, bss)


def _run(command: list[str]) -> str:
    done = subprocess.run(
        command,
        capture_output=True,
        text=True,
        timeout=TIMEOUT,
        check=False,
        env={**os.environ, "LC_ALL": "C"},
        stdin=subprocess.DEVNULL,
    )
    if done.returncode != 0:
        raise subprocess.SubprocessError(f"{' '.join(command)}: {done.stderr or done.stdout}")
    return done.stdout + done.stderr
