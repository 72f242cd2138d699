"""Versions of symbols that a library asks of the C++ library, lowered where that is possible.

g++ 12 takes `std::condition_variable::wait` as GLIBCXX_3.4.30, which only systems with its own
libstdc++ have: Debian 12, Ubuntu 22.04 and newer ones. Every libstdc++ also has the function as
GLIBCXX_3.4.11, which does the same. A library that asks for the older one runs on more systems. Its
sources need no change, and the libraries of others, which are there as Debian has compiled them,
can be treated in the same way.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path

WAIT = "_ZNSt18condition_variable4waitERSt11unique_lockISt5mutexE"
NEW, OLD = "GLIBCXX_3.4.30", "GLIBCXX_3.4.11"

SYMBOLS, NEEDS, VERSIONS = 11, 0x6FFFFFFE, 0x6FFFFFFF  # types of sections
HEADER = struct.Struct("<4sBBB9xHHIQQQIHHHHHH")
SECTION = struct.Struct("<IIQQQQIIQQ")
SYMBOL = struct.Struct("<IBBHQQ")
NEED = struct.Struct("<HHIII")  # version, number of versions, file's name, first version, next file
VERSION = struct.Struct("<IHHII")  # hash, flags, index, name, next version


@dataclass(frozen=True)
class Section:
    """A section of a file: its type, place, size and the section that it refers to."""

    kind: int
    offset: int
    size: int
    link: int


def elf_hash(name: str) -> int:
    """The hash by which the loader compares versions."""
    value = 0
    for letter in name.encode():
        value = (value << 4) + letter
        high = value & 0xF0000000
        value = (value ^ (high >> 24)) & ~high
    return value & 0xFFFFFFFF


class Library:
    """A 64-bit ELF file in memory."""

    def __init__(self, data: bytes) -> None:
        self.data = bytearray(data)
        header = HEADER.unpack_from(data)
        first, size, count = header[9], header[14], header[15]
        found = [SECTION.unpack_from(data, first + size * k) for k in range(count)]
        self.sections = [Section(s[1], s[4], s[5], s[6]) for s in found]

    def section(self, kind: int) -> Section | None:
        """The section of a kind, of which a library has at most one."""
        return next((s for s in self.sections if s.kind == kind), None)

    def text(self, offset: int) -> str:
        """A text that ends in a zero."""
        return self.data[offset : self.data.index(0, offset)].decode()

    def asks(self) -> list[tuple[int, int, str]]:
        """Versions asked for: place of the entry, index, name."""
        found: list[tuple[int, int, str]] = []
        needs = self.section(NEEDS)
        if needs is None:
            return found
        texts = self.sections[needs.link].offset
        file = needs.offset
        while True:
            _, count, _, to_version, to_file = NEED.unpack_from(self.data, file)
            entry = file + to_version
            for _ in range(count):
                _, _, index, name, to_next = VERSION.unpack_from(self.data, entry)
                found.append((entry, index, self.text(texts + name)))
                entry += to_next
            if to_file == 0:
                return found
            file += to_file

    def symbols_of(self, index: int) -> set[str]:
        """Names of the symbols that ask for the version with this index."""
        symbols, versions = self.section(SYMBOLS), self.section(VERSIONS)
        assert symbols and versions, "a library that asks for versions has these sections"
        texts = self.sections[symbols.link].offset
        found = set()
        for k in range(versions.size // 2):
            (own,) = struct.unpack_from("<H", self.data, versions.offset + 2 * k)
            if own & 0x7FFF == index:
                name = SYMBOL.unpack_from(self.data, symbols.offset + SYMBOL.size * k)[0]
                found.add(self.text(texts + name))
        return found

    def lower(self) -> bool:
        """Asks for the older wait; returns whether anything has changed.

        Nothing changes if the library asks for no newer wait, or also for other new symbols.
        """
        needs = self.section(NEEDS)
        new = [(entry, index) for entry, index, name in self.asks() if name == NEW]
        old = [entry for entry, _, name in self.asks() if name == OLD]
        if needs is None or not new or not old:
            return False
        ((entry, index),) = new
        if self.symbols_of(index) != {WAIT}:
            return False
        name = VERSION.unpack_from(self.data, old[0])[3]
        _, flags, _, _, to_next = VERSION.unpack_from(self.data, entry)
        VERSION.pack_into(self.data, entry, elf_hash(OLD), flags, index, name, to_next)
        return True


def lower(path: Path) -> bool:
    """Lowers the versions that a file asks for; returns whether the file has changed."""
    data = path.read_bytes()
    if not data.startswith(b"\x7fELF"):
        return False
    library = Library(data)
    if not library.lower():
        return False
    path.write_bytes(library.data)
    return True
