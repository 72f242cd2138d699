"""A library that g++ makes for the newest libstdc++ asks for an older one, and still waits."""

import ctypes
import subprocess
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[2] / "scripts"))
import elf_symbol_versions

WAITS = """
#include <condition_variable>
#include <thread>
extern "C" int wait_for_a_thread() {
  std::mutex mutex;
  std::condition_variable changed;
  int value = 0;
  std::thread other([&] {
    { const std::lock_guard lock(mutex); value = 7; }
    changed.notify_all();
  });
  {
    std::unique_lock lock(mutex);
    while (value == 0) changed.wait(lock);
  }
  other.join();
  return value;
}
"""


def compiled(folder: Path, source: str) -> Path:
    (folder / "waits.cpp").write_text(source)
    made = folder / "libwaits.so"
    words = ["g++", "-O0", "-std=c++17", "-fPIC", "-shared", "-o", str(made)]
    subprocess.run([*words, str(folder / "waits.cpp")], check=True)
    return made


def asked(library: Path) -> set[str]:
    return {name for _, _, name in elf_symbol_versions.Library(library.read_bytes()).asks()}


def test_a_lowered_library_asks_for_the_older_symbol_and_waits(tmp_path: Path) -> None:
    library = compiled(tmp_path, WAITS)
    if elf_symbol_versions.NEW not in asked(library):
        pytest.skip("this compiler's libstdc++ is older")
    assert elf_symbol_versions.lower(library)
    assert elf_symbol_versions.NEW not in asked(library)
    assert not elf_symbol_versions.lower(library)
    assert ctypes.CDLL(str(library)).wait_for_a_thread() == 7


@pytest.mark.parametrize("content", [b"", b"#!/bin/sh\n", b"\x7fEL"])
def test_other_files_stay_as_they_are(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "script"
    path.write_bytes(content)
    assert not elf_symbol_versions.lower(path)
    assert path.read_bytes() == content
