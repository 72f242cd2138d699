"""Packages that ./dev installs: each checked by version and hash before any of its code runs."""

import hashlib
import re
import shutil
import subprocess
import sys
import tarfile
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[2] / "requirements"
LOCKS = sorted(path for path in FOLDER.glob("*.txt") if path.name != "torch.txt")
ENTRY = re.compile(
    r"^([a-z0-9.-]+)==[^\s;]+( ; [^\\]+)?(( \\\n)    --hash=sha256:[0-9a-f]{64})+$", re.M
)


def names_in(text: str) -> set[str]:
    return {name.lower().replace("_", "-") for name in re.findall(r"^([\w.-]+)", text, re.M)}


@pytest.mark.parametrize("lock", LOCKS, ids=lambda path: path.name)
def test_locks_are_hashes_of_all_that_is_named_and_nothing_else(lock: Path) -> None:
    text = lock.read_text()
    rest = re.sub(r"^#.*\n", "", ENTRY.sub("", text), flags=re.M)
    assert rest.split() == []
    named = names_in(lock.with_suffix(".in").read_text())
    assert named <= {entry[1] for entry in ENTRY.finditer(text)}


def versions_in(folder: Path) -> set[tuple[str, str]]:
    pins = re.compile(r"^([a-z0-9.-]+==[^\s;]+)", re.M)
    locks = folder.glob("*.txt")
    return {(lock.name, pin) for lock in locks for pin in pins.findall(lock.read_text())}


def test_the_script_that_writes_the_locks_keeps_the_versions_that_are_locked(
    tmp_path: Path,
) -> None:
    script = tmp_path / "scripts/lock_requirements.sh"
    script.parent.mkdir()
    shutil.copy(FOLDER.parent / "scripts/lock_requirements.sh", script)
    copy = Path(shutil.copytree(FOLDER, tmp_path / "requirements"))
    subprocess.run(["bash", str(script)], check=True, capture_output=True, timeout=300)
    assert versions_in(copy) == versions_in(FOLDER)


def make_source_package(folder: Path, marker: Path) -> Path:
    """A source distribution whose build code leaves a file behind."""
    root = folder / "marked-1.0"
    root.mkdir()
    (root / "PKG-INFO").write_text("Metadata-Version: 2.1\nName: marked\nVersion: 1.0\n")
    (root / "setup.py").write_text(
        f"from pathlib import Path\nPath({str(marker)!r}).touch()\n"
        "from setuptools import setup\nsetup(name='marked', version='1.0')\n"
    )
    archive = folder / "marked-1.0.tar.gz"
    with tarfile.open(archive, "w:gz") as file:
        file.add(root, root.name)
    return archive


@pytest.mark.parametrize("right", [False, True])
def test_a_source_with_another_hash_runs_no_build_code(tmp_path: Path, right: bool) -> None:
    """Fetched as ./dev fetches DAQP; with the right hash the build code runs, so the test can
    detect it.
    """
    marker = tmp_path / "ran"
    archive = make_source_package(tmp_path, marker)
    found = hashlib.sha256(archive.read_bytes() if right else b"another").hexdigest()
    wanted = tmp_path / "wanted.txt"
    wanted.write_text(f"marked==1.0 --hash=sha256:{found}\n")
    command = [sys.executable, "-m", "pip", "download", "--no-index", "--find-links", str(tmp_path)]
    command += ["--require-hashes", "--no-deps", "--no-binary", "marked", "--no-build-isolation"]
    command += ["--dest", str(tmp_path / "out"), "-r", str(wanted)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode == 0) == right, done.stderr
    assert marker.exists() == right
    assert right or "DO NOT MATCH THE HASHES" in done.stderr  # the words that ./dev searches for
