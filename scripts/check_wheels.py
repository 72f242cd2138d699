"""Checks wheels as a user has them: in an environment of their own, in an empty folder.

    ./dev wheel                    # builds wheels, then this check: install, import, fly, compare
    ./dev wheel --beside           # also beside torch, mujoco, h5py, pin and opencv

The check installs the wheels that fit this Python, flies `hover` and compares the hash with
tests/golden. With --beside it imports Skybody before and after each of some packages that bring
their own Eigen, BLAS, OpenMP, HDF5 or Boost, calls a function of theirs, and flies on both engines:
20 processes, which must all give the hash of Skybody alone. Their installation takes gigabytes.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PINNED = ROOT / "tests/golden/hover.json"
DYNAMICS = ("tree", "simbody")
FLIGHT = """
import numpy, skybody
s = skybody.Simulation("payload", seed=7, overrides=["stepping.dynamics={dynamics}"])
s.reset()
for _ in range(200):
    s.step(numpy.full(s.compiled.action_size, 0.2, numpy.float32))
print(f"{{s.hash():016x}}")
"""


@dataclass(frozen=True)
class Other:
    """A package of others: how pip calls it, its module, and a call into its libraries."""

    package: str
    module: str
    call: str


OTHERS = (
    Other("torch", "torch", "torch.linalg.solve(torch.eye(8), torch.ones(8, 1))"),
    Other("mujoco", "mujoco", "mujoco.MjModel.from_xml_string('<mujoco/>')"),
    Other("h5py", "h5py", "h5py.File('x', 'w', driver='core', backing_store=False)['a'] = 1.0"),
    Other("pin", "pinocchio", "pinocchio.buildSampleModelManipulator().createData()"),
    Other("opencv-python-headless", "cv2", "cv2.invert(__import__('numpy').eye(8))"),
)


class Environment:
    """A virtual environment with the wheels, and an empty folder to run in."""

    def __init__(self, folder: Path) -> None:
        self.bin = folder / "venv/bin"
        self.work = folder / "empty"
        self.work.mkdir()
        self.run(sys.executable, "-m", "venv", folder / "venv")

    def run(self, *command: str | Path) -> str:
        """Output of a command. Exits with its message where it fails."""
        words = [str(word) for word in command]
        done = subprocess.run(words, capture_output=True, text=True, cwd=self.work)
        if done.returncode != 0:
            sys.exit(f"error: {' '.join(words)}: {done.returncode}\n{done.stdout}{done.stderr}")
        return done.stdout

    def install(self, *packages: str | Path) -> None:
        """Installs by pip."""
        options = ("--quiet", "--disable-pip-version-check")
        self.run(self.bin / "python", "-m", "pip", "install", *options, *packages)

    def python(self, program: str) -> str:
        """Output of a program, without the line's end."""
        return self.run(self.bin / "python", "-c", program).strip()


def fitting(folder: Path) -> list[Path]:
    """The wheels of a folder for this Python: the library, and one package."""
    own = f"cp{sys.version_info.major}{sys.version_info.minor}-"
    packages = [*folder.glob(f"skybody-*-{own}*.whl"), *folder.glob("skybody-*-abi3-*.whl")]
    libraries = [*folder.glob("libskybody-*.whl")]
    if len(libraries) != 1 or not packages:
        sys.exit(f"error: {folder} has no wheels for Python {sys.version.split()[0]}: ./dev wheel")
    return [libraries[0], packages[0]]


def check_alone(there: Environment) -> None:
    """Flies `hover` by the program and compares; imports; asks for the CMake folder."""
    flight = json.loads(PINNED.read_text())
    words = flight["flight"].replace(" --motion", "").split()[1:]
    found = there.run(there.bin / "skybody", *words).strip()
    pinned = flight["hashes"]["as shipped"]["words"]
    if found != pinned:
        sys.exit(f"error: hover gives {found} from the wheel, and {pinned} is pinned")
    folder = there.run(there.bin / "python", "-m", "skybody", "--cmake-dir").strip()
    if not (Path(folder) / "SkybodyConfig.cmake").is_file():
        sys.exit(f"error: no SkybodyConfig.cmake in {folder}")
    print(f"hover {found}, as pinned")


def check_beside(there: Environment) -> None:
    """Imports Skybody before and after each other package, and flies on both engines."""
    there.install("-r", ROOT / "requirements/torch.txt")  # PyTorch's version for the processor
    there.install(*(other.package for other in OTHERS if other.package != "torch"))
    for dynamics in DYNAMICS:
        flight = FLIGHT.format(dynamics=dynamics)
        alone = there.python(flight)
        print(f"{dynamics:8} alone              {alone}")
        for other in OTHERS:
            call = f"import {other.module}\n{other.call}"
            orders = {
                f"after {other.package}": f"import {other.module}\nimport skybody\n{call}{flight}",
                f"before {other.package}": f"import skybody\n{call}{flight}",
            }
            for order, program in orders.items():
                found = there.python(program)
                print(f"{dynamics:8} {order:18.18} {found}", flush=True)
                if found != alone:
                    sys.exit(f"error: {dynamics}, {order}: {found}, and {alone} alone")


def main() -> int:
    """Runs the checks; returns the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("wheels", type=Path, nargs="?", default=ROOT / "build/wheels")
    parser.add_argument("--beside", action="store_true", help="also beside other packages")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        there = Environment(Path(scratch))
        there.install(*fitting(options.wheels.resolve()))
        check_alone(there)
        if options.beside:
            check_beside(there)
    return 0


if __name__ == "__main__":
    sys.exit(main())
