"""What installs the packages that some modules need, and how it is said where one is missing."""

from __future__ import annotations

# In the source folder: no registry has Skybody.
INSTALLED_BY = {
    "env": ".",
    "vector": ".",
    "multi_agent": ".[multi-agent]",
    "python_task": ".",
    "sb3": ".[sb3]",
    "sb3_adapter": ".[sb3]",
}


def missing_package(module: str, error: ModuleNotFoundError) -> ImportError:
    """The error of `skybody.<module>` for a package that is not installed, with the remedy."""
    package = (error.name or "").partition(".")[0]
    return ImportError(
        f"skybody.{module} needs the package {package!r}: `pip install "
        f"'{INSTALLED_BY[module]}'` in Skybody's source folder",
        name=package,
    )
