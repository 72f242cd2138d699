"""Optional packages of some modules: their install commands, and the error for a missing one."""

from __future__ import annotations

from collections.abc import Iterable

EXTRAS = {  # of the modules that are imported at their first use; empty: a plain installation
    "camera": "",
    "env": "",
    "vector": "",
    "multi_agent": "multi-agent",
    "look": "train",
    "python_task": "",
    "sb3": "sb3",
    "sb3_adapter": "sb3",
}


def install_command(extras: Iterable[str]) -> str:
    """The command in words; from the source folder, since Skybody is in no package registry."""
    names = ",".join(filter(None, extras))
    return f"`pip install '.{f'[{names}]' if names else ''}'` in Skybody's source folder"


def missing_package(module: str, error: ModuleNotFoundError) -> ImportError:
    """The error of `skybody.<module>` for a missing package, with the remedy."""
    package = (error.name or "").partition(".")[0]
    return ImportError(
        f"skybody.{module} needs the package {package!r}: {install_command([EXTRAS[module]])}",
        name=package,
    )
