"""Parts of an installation: the folders for C++, and errors of a module that does not load.

Wheels take minutes: `.ci/run` builds them (`./dev wheel --quick`: scripts/build_wheels.py), and
installs them in an environment of their own (scripts/check_wheels.py). Roots of other Debian
releases (scripts/debian_root.sh) take longer: scripts/check_debian.sh makes, installs and removes
Debian packages in one, scripts/time_installation.sh times the way from wheels to a film.
"""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from skybody.__main__ import main
from skybody.native_problem import native_problem, version_problem

ROOT = Path(__file__).resolve().parents[2]


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
        (
            ImportError("libstdc++.so.6: cannot open shared object file"),
            "this system has no libstdc++.so.6: install the package that has it",
        ),
        (ImportError("undefined symbol: _ZN7skybody3fooEv"), "`libskybody` of one version"),
    ],
)
def test_a_native_module_that_does_not_load_is_one_line_with_the_remedy(
    error: ImportError, remedy: str
) -> None:
    said = str(native_problem(error))
    assert said.startswith("skybody: its ") or said.startswith("skybody: this system")
    assert remedy in said
    assert "\n" not in said


def test_ctrl_c_while_the_native_module_loads_is_no_problem_of_the_installation() -> None:
    error = ImportError("Encountered an error while initializing the extension.")
    error.__cause__ = KeyboardInterrupt()
    with pytest.raises(KeyboardInterrupt):
        native_problem(error)


def test_parts_of_one_version_are_no_problem() -> None:
    assert version_problem(package="1.0.0", library="1.0.0", program="1.0.0") is None


@pytest.mark.parametrize(
    ("library", "program", "remedy"),
    [
        ("1.0.1", "1.0.0", "install the wheels `skybody` and `libskybody` of one version"),
        ("1.0.0", "1.0.1", "start the program of this Python's environment"),
    ],
)
def test_parts_of_two_versions_are_one_line_with_the_remedy(
    library: str, program: str, remedy: str
) -> None:
    said = str(version_problem(package="1.0.0", library=library, program=program))
    assert "1.0.0" in said and "1.0.1" in said
    assert remedy in said
    assert "\n" not in said


def test_a_program_of_another_version_is_refused() -> None:
    environment = {**os.environ, "SKYBODY_PROGRAM_VERSION": "0.1.0"}
    command = [sys.executable, "-c", "import skybody"]
    done = subprocess.run(command, capture_output=True, text=True, env=environment)
    assert done.returncode == 2
    assert done.stderr.startswith("error: skybody: the program is 0.1.0, the Python package in")
    assert done.stderr.count("\n") == 1


def test_the_program_has_manual_pages(tmp_path: Path) -> None:
    command = [sys.executable, str(ROOT / "scripts/manual_pages.py"), "--out", str(tmp_path)]
    program = ROOT / "build/release/bin/skybody"
    subprocess.run([*command, "--program", str(program)], check=True)
    pages = {path.name: path.read_text() for path in tmp_path.glob("*.1")}
    assert {"skybody.1", "skybody-run.1", "skybody-check.1"} <= set(pages)
    assert "skybody-train.1" not in pages  # its help needs Python's packages
    assert "\n.SH COMMANDS\n" in pages["skybody.1"] and "\ntrain\n" not in pages["skybody.1"]
    for name, text in pages.items():
        title = name.removesuffix(".1")
        assert text.startswith(f".TH {title.upper()} 1 ")
        assert f"\n.SH NAME\n{title.replace('-', chr(92) + '-')} \\- " in text
    assert "\\-\\-policy" in pages["skybody-run.1"]
