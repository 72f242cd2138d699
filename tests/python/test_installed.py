"""Parts of an installation: the folders for C++, and errors of a module that does not load.

Wheels take minutes: `.ci/run` builds them (`./dev wheel --quick`: scripts/build_wheels.py), and
installs them in an environment of their own (scripts/check_wheels.py).
"""

import subprocess
import sys
from pathlib import Path

import pytest
from skybody.__main__ import main
from skybody.native_problem import native_problem


def test_the_cmake_folder_is_that_of_this_build() -> None:
    command = [sys.executable, "-m", "skybody", "--cmake-dir"]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert (Path(done.stdout.strip()) / "SkybodyConfig.cmake").is_file()


def test_a_library_without_files_for_cpp_says_what_installs_them(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("skybody.__main__.library_folder", lambda: str(tmp_path))
    assert main(["--cmake-dir"]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"error: no files for C++ beside {tmp_path}; install the wheel")


@pytest.mark.parametrize(
    ("error", "remedy"),
    [
        (ModuleNotFoundError("No module named 'skybody._native'"), "install the wheel of this"),
        (ImportError("libc.so.6: version `GLIBC_2.35' not found"), "build it here from source"),
        (
            ImportError("libskybody.so.1: cannot open shared object file"),
            "install the wheels `skybody` and `libskybody` of one version",
        ),
        (ImportError("undefined symbol: _ZN7skybody3fooEv"), "`libskybody` of one version"),
    ],
)
def test_a_native_module_that_does_not_load_is_one_line_with_the_remedy(
    error: ImportError, remedy: str
) -> None:
    said = str(native_problem(error))
    assert said.startswith("skybody: its ") or said.startswith("skybody: this system's")
    assert remedy in said
    assert "\n" not in said
