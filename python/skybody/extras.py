"""Optional packages of some modules: their install commands, and the error for a missing one."""

from __future__ import annotations

# Install from the source folder: Skybody is in no package registry.
INSTALLED_BY = {
    "env": ".",
    "vector": ".",
    "multi_agent": ".[multi-agent]",
    "python_task": ".",
    "sb3": ".[sb3]",
    "sb3_adapter": ".[sb3]",
}


def missing_package(module: str, error: ModuleNotFoundError) -> ImportError:
    """The error of `skybody.<module>` for a missing package, with the remedy."""
    package = (error.name or "").partition(".")[0]
    return ImportError(
        f"skybody.{module} needs the package {package!r}: `pip install "
        f"'{INSTALLED_BY[module]}'` in Skybody's source folder",
        name=package,
    )
