"""The trajectory controller of docs/plugins.md builds, flies as the page says, and is tuned."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
BUILD = ROOT / "build/release"
PAGE = ROOT / "docs/plugins.md"


def run(*command: str | Path, folder: Path) -> str:
    """Runs a command with the project's plugins; returns its output."""
    environment = {
        **os.environ,
        "PATH": f"{BUILD / 'bin'}:{os.environ['PATH']}",
        "SKYBODY_PLUGIN_PATH": str(folder / "build/plugins"),
        "SKYBODY_PYTHON": sys.executable,
    }
    done = subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    return done.stdout


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The project of the page: that of `skybody new`, with the page's listing and chain."""
    folder = tmp_path_factory.mktemp("own")
    run("skybody", "new", "controller", "my_law", "--dir", folder, folder=folder)
    project = folder / "my_law"
    listings = re.findall(r"^```cpp\n(.*?)^```", PAGE.read_text(encoding="utf-8"), re.M | re.S)
    (law,) = [text for text in listings if "SKYBODY_PLUGIN(skybody::MyLaw" in text]
    (project / "my_law.cpp").write_text(law, encoding="utf-8")
    scenario = project / "scenario.yaml"
    text, count = re.subn(
        r"controllers:\n(?: {6,}.*\n)+",
        "controllers: [{plugin: my_law}, {plugin: ctbt}]\n",
        scenario.read_text(encoding="utf-8"),
    )
    assert count == 1
    scenario.write_text(text, encoding="utf-8")
    options = (f"-DSkybody_DIR={BUILD}", "-DBUILD_TESTING=OFF", "-DCMAKE_CXX_FLAGS=-O1")
    run("cmake", "-B", "build", "-G", "Ninja", *options, folder=project)
    run("cmake", "--build", "build", folder=project)
    return project


def reference_error(output: str) -> float:
    """RMS [cm] of the table of references, whose lines begin with the episode."""
    (error,) = re.findall(r"^ +1  quad\.base_link +(\S+)", output, re.M)
    return float(error)


def test_it_follows_the_figure_of_eight_as_the_page_says(project: Path) -> None:
    flown = run("skybody", "run", "scenario.yaml", "--reference", "figure_eight", folder=project)
    assert "about 2 cm" in PAGE.read_text(encoding="utf-8")
    assert reference_error(flown) == pytest.approx(2.0, abs=0.5)  # the page rounds to 1 cm


def test_it_flies_in_wind_as_geometric_does(project: Path) -> None:
    command = ("skybody", "run", "windy_hover", "--reference", "figure_eight")
    geometric = reference_error(run(*command, "--out", "geometric", folder=project))
    chain = "robots.quad.controllers=[{plugin: my_law}, {plugin: ctbt}]"
    own = reference_error(run(*command, "--set", chain, "--out", "own", folder=project))
    # The same wind moves both: 10.35 and 10.36 cm when this was written; laws differ by less.
    assert own == pytest.approx(geometric, rel=0.1)


def test_its_gains_are_tuned(project: Path) -> None:
    few = ("--candidates", "8", "--draws", "1", "--out", "tuned")
    run("skybody", "tune", "qdrone2", "--chain", "my_law,ctbt", *few, folder=project)
    assert "my_law" in (project / "tuned/gains.yaml").read_text(encoding="utf-8")
