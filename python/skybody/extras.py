"""Optional packages of some modules: their install commands, and the error for a missing one."""

from __future__ import annotations

import functools
from collections.abc import Iterable
from importlib import metadata

EXTRAS = {  # of the modules that are imported at their first use; empty: a plain installation
    "camera": "",
    "env": "",
    "vector": "",
    "multi_agent": "multi-agent",
    "look": "",
    "python_task": "",
    "sb3": "sb3",
    "sb3_adapter": "sb3",
}


def install_command(extras: Iterable[str]) -> str:
    """The command that installs the packages of some extras, or those of every installation."""
    names = ",".join(filter(None, extras))
    wanted = f"[{names}]" if names else ""
    if _is_installed():
        return f"`pip install 'skybody{wanted}'`"
    return f"`pip install '.{wanted}'` in Skybody's source folder"


@functools.cache
def _is_installed() -> bool:
    """Whether pip knows this package; it does not in a source tree."""
    try:
        metadata.distribution("skybody")
    except metadata.PackageNotFoundError:
        return False
    return True


def missing_package(module: str, error: ModuleNotFoundError) -> ImportError:
    """The error of `skybody.<module>` for a missing package, with the remedy."""
    package = (error.name or "").partition(".")[0]
    extra = EXTRAS[module]
    remedy = install_command([extra]) if extra else f"`pip install {package}`"
    return ImportError(f"skybody.{module} needs the package {package!r}: {remedy}", name=package)
