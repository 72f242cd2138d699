"""Programs in examples/ run as their first lines describe; the README's steps run unchanged."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent


def output(*command: str) -> str:
    done = subprocess.run(
        [sys.executable, *command], capture_output=True, text=True, timeout=100, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def rows(after: str) -> list[str]:
    """Files of a table of examples/README.md: the first one after a text."""
    page = (ROOT / "examples/README.md").read_text().partition(after)[2].partition("\n\n|")[2]
    return re.findall(r"\]\(([\w.]+\.(?:py|cpp|yaml))\)", page.partition("\n\n")[0])


def test_the_table_has_all_examples_and_they_are_short():
    short, longer = rows("# Examples"), rows("Longer ones")
    files = [path.name for path in (ROOT / "examples").iterdir()]
    files = [name for name in files if name.endswith((".py", ".cpp", ".yaml"))]
    assert sorted(short + longer) == sorted(files)
    lines = {name: (ROOT / "examples" / name).read_text().count("\n") for name in short}
    assert {name: count for name, count in lines.items() if count > 60} == {}


def test_the_quickstart_prints_its_rate():
    assert re.fullmatch(
        r"[\d,]+ steps/s, mean reward [\d.]+\n", output(str(ROOT / "examples/quickstart.py"))
    )


def test_the_readmes_first_python_block_runs():
    section = (ROOT / "README.md").read_text().partition("## Train from Python")[2]
    block = section.partition("```python\n")[2].partition("```")[0]
    assert "make_vec" in block
    output("-c", block)


def test_the_image_example_trains_stable_baselines():
    assert re.fullmatch(
        r"\d+ episodes, mean return -?[\d.]+\n",
        output(str(ROOT / "examples/sb3_images.py"), "--steps", "2048"),
    )


def test_the_imu_example_learns_from_a_box_and_a_dict():
    line = r": 2048 steps, mean return -?[\d.]+ before, -?[\d.]+ after\n"
    assert re.fullmatch(
        f"Box{line}Dict{line}",
        output(str(ROOT / "examples/imu_observation.py"), "--steps", "2048"),
    )
