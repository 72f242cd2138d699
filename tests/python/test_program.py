"""Ends of programs: exit status, and one line after Ctrl-C."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import textwrap
import time
from collections.abc import Callable
from pathlib import Path

import h5py
import pytest
from conftest import Finished

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build/release/bin/skybody"
MAIN = 'if __name__ == "__main__":\n'


def interrupted(script: str) -> Finished:
    """A script that receives Ctrl-C, with all its child processes, after its first line."""
    with subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(script)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as process:
        assert process.stdout is not None
        first = process.stdout.readline()
        os.killpg(process.pid, signal.SIGINT)
        output, errors = process.communicate(timeout=30)
    return Finished(process.args, process.returncode, first + output, errors)


@pytest.mark.parametrize(("status", "code"), [("0", 0), ("3", 3), ("None", 0)])
def test_a_program_exits_with_its_status(
    status: str, code: int, python: Callable[[str], Finished]
) -> None:
    done = python(f"from skybody.program import run_program\nrun_program(lambda: {status})")
    assert (done.returncode, done.stderr) == (code, "")


def test_ctrl_c_is_one_line() -> None:
    done = interrupted("""
        import time
        from skybody.program import run_program

        def main():
            print("began", flush=True)
            time.sleep(30)

        run_program(main)
    """)
    assert (done.returncode, done.stderr) == (130, "interrupted\n")


def test_ctrl_c_ends_processes_that_take_no_notice_of_it() -> None:
    done = interrupted("""
        import multiprocessing, time
        from skybody.program import ignoring_interrupts, run_program

        def main():
            child = multiprocessing.get_context("fork").Process(target=time.sleep, args=(30,))
            with ignoring_interrupts():
                child.start()
            print(child.pid, flush=True)
            time.sleep(30)

        run_program(main)
    """)
    assert (done.returncode, done.stderr) == (130, "interrupted\n")
    assert not Path(f"/proc/{done.stdout.strip()}").exists()


def test_ctrl_c_interrupts_again_behind_deaf_to_interrupts(
    python: Callable[[str], Finished],
) -> None:
    done = python(f"""
        import signal
        from skybody.program import ignoring_interrupts
        signal.signal(signal.SIGINT, signal.default_int_handler)
        with ignoring_interrupts():
            signal.raise_signal({signal.SIGINT:d})
        try:
            signal.raise_signal({signal.SIGINT:d})
        except KeyboardInterrupt:
            print("heard")
    """)
    assert done.stdout == "heard\n"


@pytest.mark.parametrize("delay", [0.0, 0.05, 0.1, 0.15, 0.2])  # s; the flight takes about 0.15 s
def test_a_log_is_whole_at_whatever_moment_ctrl_c_comes(delay: float, tmp_path: Path) -> None:
    words = ["run", "hover", "--steps", "20000", "--no-picture", "--out", str(tmp_path / "log")]
    with subprocess.Popen([PROGRAM, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as fly:
        while not list(tmp_path.glob("log/.*")) and fly.poll() is None:
            time.sleep(0.001)
        time.sleep(delay)
        fly.send_signal(signal.SIGINT)
        fly.communicate(timeout=30)
    # 130: before the log was whole; else it came after that, maybe while the table was printed.
    assert fly.returncode in (130, 0, -signal.SIGINT)
    assert [path.name for path in (tmp_path / "log").iterdir()] == ["flight.h5"]
    with h5py.File(tmp_path / "log/flight.h5") as log:  # h5py refuses a file that was not closed
        assert len(log.attrs) > 0


def test_every_program_ends_by_run_program() -> None:
    found = [p for folder in ("examples",) for p in ROOT.glob(f"{folder}/**/*")]
    found += [ROOT / "research/peers/ours.py"]
    programs = {p: p.read_text() for p in found if p.suffix == ".py"}
    programs = {path: text for path, text in programs.items() if MAIN in text}
    assert len(programs) > 3
    assert not [path for path, text in programs.items() if "run_program(" not in text]


IMPORTED = {  # by main(), among the first packages
    "train": "matplotlib",
    "train.curve": "matplotlib",
}


@pytest.mark.parametrize("module", IMPORTED)
def test_ctrl_c_while_a_package_is_imported_is_one_line(
    module: str, python: Callable[[str], Finished], tmp_path: Path
) -> None:
    out = tmp_path / "run"
    arguments = ["hover_learn", "--out", str(out)] if module == "train" else [str(out)]
    done = python(f"""
        import runpy, sys

        class Interrupts:
            def find_spec(self, name, path=None, target=None):
                if name == {IMPORTED[module]!r}:
                    raise KeyboardInterrupt

        sys.meta_path.insert(0, Interrupts())
        sys.argv = ["program", *{arguments}]
        runpy.run_module("skybody.{module}", run_name="__main__", alter_sys=True)
    """)
    assert (done.returncode, done.stderr) == (130, "interrupted\n")
    assert not out.exists()
