"""Programs that measurements run, and their output."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from research.common.places import PROGRAM


class RunError(RuntimeError):
    """A run that failed, or that differs from the requested one; the text is the whole message."""


def output_of(command: Sequence[str | Path], seconds: float | None = None, **more: Any) -> str:
    """Output of a program to stdout.

    Args:
        seconds: its longest time; None: any.
        more: options of subprocess.run().

    Raises:
        RunError: it failed; with its command, exit code and stderr.
    """
    words = list(map(str, command))
    try:
        done = subprocess.run(
            words, capture_output=True, text=True, check=False, timeout=seconds, **more
        )
    except subprocess.TimeoutExpired:
        raise RunError(f"{' '.join(words)} has not ended after {seconds:.0f} s") from None
    except OSError as error:
        raise RunError(f"{words[0]}: {error.strerror}; ./dev build makes it") from None
    if done.returncode != 0:
        raise RunError(f"{' '.join(words)} failed (exit code {done.returncode})\n{done.stderr}")
    return str(done.stdout)


def settings_of(overrides: Sequence[str]) -> list[str]:
    """Overrides of a scenario as options of `skybody`."""
    return [word for override in overrides for word in ("--set", override)]


def run_skybody(*words: str | Path, overrides: Sequence[str] = (), program: Path = PROGRAM) -> str:
    """Output of `skybody`. Raises RunError."""
    return output_of([program, *words, *settings_of(overrides)])


def run_bench(
    scenario: str,
    seconds: float,
    *words: str,
    threads: int = 1,
    envs: int = 256,
    overrides: Sequence[str] = (),
    program: Path = PROGRAM,
) -> dict[str, Any]:
    """The figures of `skybody bench`; `words` are further options."""
    options = ["--threads", str(threads), "--envs", str(envs), "--seconds", str(seconds), *words]
    text = run_skybody("bench", scenario, "--json", *options, overrides=overrides, program=program)
    return dict(json.loads(text))
