"""Pages of reference: modules of the Python package and headers for C++ programs."""

from __future__ import annotations

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))

from markdown_text import for_python_markdown  # noqa: E402
from plugin_reference import Page, Part  # noqa: E402

PYTHON = {
    "Environments": ("vector", "pool", "env", "options", "requests", "display"),
    "Several robots": ("multi_agent", "agents"),
    "Simulation": ("simulation", "python_task"),
    "Learning": ("sb3", "sb3_adapter", "train.policy_file"),
    "Flights": ("look.flight", "look.film"),
}
CPP = {
    "Simulation": (
        ("Scenarios", "core/assemble/compile_scenario.h"),
        ("A compiled scenario", "core/env/compiled_scenario.h"),
        ("One environment", "core/simulation/simulation.h"),
        ("Many environments", "core/simulation/simulation_pool.h"),
        ("Many environments for a learner", "core/batch/pool.h"),
        ("Options of a pool", "core/batch/pool_options.h"),
        ("Rows of transitions", "core/batch/batch.h"),
    ),
    "Learning": (
        ("Learners", "learn/learner.h"),
        ("Making a learner", "learn/make_learner.h"),
        ("PPO", "learn/ppo/ppo.h"),
        ("Gradient descent through the dynamics", "learn/gradient/gradient.h"),
        ("Networks", "learn/network/network.h"),
        ("Networks of policies", "learn/network/policy_network.h"),
        ("Adam", "learn/network/adam.h"),
        ("Rollouts", "learn/rollout/rollout.h"),
        ("Environments of rollouts", "learn/rollout/rollout_environments.h"),
        ("Advantages", "learn/rollout/advantage_estimator.h"),
        ("Normalization", "learn/common/normalizer.h"),
        ("Action distribution", "learn/common/gaussian.h"),
        ("Policy files", "core/io/files/policy_writer.h"),
    ),
}


class HeaderPage(Page):
    """Declarations of whole headers below a title."""

    def __init__(self, title: str, include: str) -> None:
        super().__init__()
        self.parts = [f"# C++: {title.lower()}", f"`#include <skybody/{include}>`."]


def write_references(folder: Path) -> None:
    """Writes reference/python and reference/cpp below the folder."""
    for name, modules in PYTHON.items():
        present = [
            m for m in modules if (ROOT / f"python/skybody/{m.replace('.', '/')}.py").exists()
        ]
        lines = [f"# Python: {name.lower()}", *(f"::: skybody.{module}" for module in present)]
        put(folder / f"reference/python/{file_name(name)}", "\n\n".join(lines) + "\n")
    for name, headers in CPP.items():
        page = HeaderPage(name, "learn.h" if name == "Learning" else "skybody.h")
        for title, header in headers:
            page.add_part(Part(title, header, intro=True, constructors=True))
        put(folder / f"reference/cpp/{file_name(name)}", for_python_markdown(page.text()))


def file_name(title: str) -> str:
    """The file of a page by its title."""
    return title.lower().replace(" ", "_") + ".md"


def put(path: Path, text: str) -> None:
    """Writes a page, with the folders above it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
