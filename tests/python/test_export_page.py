"""docs/export_policy.md: its programs and commands work as printed."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs/export_policy.md").read_text()
PROGRAM = ROOT / "build/release/bin"
SHORT = ("--total-steps", "4096", "--envs", "32", "--set", "hidden=16,16", "--override")
SHORT = (*SHORT, "stepping.horizon=50")  # of the training, in place of a minute


def files() -> dict[str, str]:
    """The page's programs by their file names."""
    return dict(re.findall(r"<!-- file: (\S+) -->\n```\w+\n(.*?)```", PAGE, re.DOTALL))


def commands(after: str) -> list[list[str]]:
    """The commands of the first block after a text."""
    block = re.search(r"\n((?:    .+\n)+)", PAGE[PAGE.index(after) :])
    assert block is not None
    return [shlex.split(line) for line in block[1].splitlines()]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A working folder in which the first commands of the page have run, and its programs are."""
    place = tmp_path_factory.mktemp("page")
    for words in commands("# Policies"):
        assert words[0] == "skybody"
        if words[1] == "train":
            words += SHORT
        run(place, [str(PROGRAM / "skybody"), *words[1:]])
    for name, text in files().items():
        (place / name).write_text(text)
    return place


def run(folder: Path, words: list[str]) -> str:
    environment = {**os.environ, "PYTHONPATH": str(ROOT / "python")}
    done = subprocess.run(
        words, cwd=folder, capture_output=True, text=True, check=False, env=environment, timeout=100
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_c_program_compiles_and_commands_rotors(folder: Path) -> None:
    compile_, start = commands("<!-- commands -->")
    run(folder, [*compile_, "-Wall", "-Wextra", "-Werror"])
    lines = run(folder, start).splitlines()
    assert [line.split()[0] for line in lines] == ["rotors"] * 3
    assert all(0.0 <= float(word) <= 2300.0 for line in lines for word in line.split()[1:5])


def test_the_python_program_flies_the_model(folder: Path) -> None:
    assert run(folder, [sys.executable, "fly.py"]).startswith("error ")


def test_every_option_of_policies_is_on_the_page() -> None:
    from skybody.exports.formats import NETWORK

    for option in NETWORK:
        assert f"`--{option.replace('_', '-')} " in PAGE
