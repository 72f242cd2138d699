"""Counts of plain language: the rules of `./dev lint` for comments, docstrings and documents.

    .venv/bin/python scripts/plain_words.py            # lists violations; exit status 1
    .venv/bin/python scripts/plain_words.py --table    # counts per 1,000 words, by folder
    .venv/bin/python scripts/plain_words.py core/env   # only some folders or files

Rules:

* the word "what" occurs at most WHAT_PER_THOUSAND times per 1,000 words of a folder's comments
  and documents;
* lines have at most COLUMNS characters (exempt: tables, links and code in documents, data, lines of
  C++ with a string, and Python, which ruff checks);
* sentences have at most SENTENCE_WORDS words in documents; a colon or semicolon ends one, too.
"""

from __future__ import annotations

import argparse
import io
import re
import subprocess
import sys
import tokenize
from collections import defaultdict
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
WHAT_PER_THOUSAND = 0.5
COLUMNS = 100
SENTENCE_WORDS = 40
CODE = (".h", ".cpp", ".py", ".yaml", ".txt", ".cmake")
# Historical records, and pages that scripts write.
RECORDS = (
    "CHANGELOG.md",
    "docs/golden_log.md",
    "docs/plugin_reference.md",
    "docs/results/",
    "requirements/",
    "tests/golden/",
)
WORD = re.compile(r"[A-Za-z][A-Za-z'-]*")
C_COMMENT = re.compile(r'"(?:\\.|[^"\\\n])*"|//(?P<line>[^\n]*)|/\*(?P<block>.*?)\*/', re.DOTALL)
SENTENCE_END = re.compile(r"(?<=[.!?:;])\s+|\n\s*\n")


@dataclass
class Prose:
    """The prose of one file."""

    words: int = 0
    whats: list[int] = field(default_factory=list)  # their lines
    long_lines: list[int] = field(default_factory=list)
    long_sentences: list[tuple[int, int]] = field(default_factory=list)  # line, words


def tracked(paths: list[str]) -> list[Path]:
    """The files tracked by git below `paths`."""
    found = subprocess.run(
        ["git", "ls-files", *paths], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout.split("\n")
    return [Path(name) for name in found if name and not name.startswith(RECORDS)]


def python_prose(text: str) -> list[tuple[int, str]]:
    """Comments and docstrings with their lines."""
    found = []
    before = tokenize.NEWLINE
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        is_docstring = token.type == tokenize.STRING and before in (
            tokenize.NEWLINE,
            tokenize.INDENT,
        )
        if token.type == tokenize.COMMENT or is_docstring:
            found.append((token.start[0], token.string))
        if token.type not in (tokenize.COMMENT, tokenize.NL):
            before = token.type
    return found


def prose_of(path: Path, text: str) -> list[tuple[int, str]]:
    """Pieces of prose, each with its first line."""
    if path.suffix == ".md":
        return [(1, without_code(text))]
    if path.suffix == ".py":
        return python_prose(text)
    if path.suffix in (".h", ".cpp"):
        return [
            (text.count("\n", 0, match.start()) + 1, match["line"] or match["block"] or "")
            for match in C_COMMENT.finditer(text)
            if match.lastgroup
        ]
    pieces = []
    for number, line in enumerate(text.split("\n"), 1):
        head, mark, comment = line.partition("#")
        if mark and head.count('"') % 2 == 0:
            pieces.append((number, comment))
    return pieces


def without_code(text: str) -> str:
    """A document's prose: code and targets of links are blanked, lines stay."""
    text = re.sub(
        r"^```.*?^```", lambda match: "\n" * match[0].count("\n"), text, flags=re.M | re.S
    )
    text = re.sub(r"^    .*$", "", text, flags=re.M)
    text = re.sub(r"`[^`\n]*`", "code", text)
    return re.sub(r"\]\([^)\n]*\)", "]", text)


def is_exempt(path: Path, line: str) -> bool:
    """Lines that cannot be broken: tables, pictures, links, addresses, data, strings."""
    if "http" in line:
        return True
    if path.suffix == ".md":
        return line.lstrip().startswith(("|", "![", "[", "<")) or line.startswith("    ")
    if path.suffix in (".yaml", ".txt", ".cmake"):
        return not line.lstrip().startswith("#")
    if path.suffix == ".py":  # ruff checks them
        return True
    return '"' in line or path.parts[:2] == ("tests", "fuzz")  # raw strings


def read(path: Path) -> Prose:
    """Counts one file."""
    text = (ROOT / path).read_text(encoding="utf-8", errors="replace")
    prose = Prose()
    for line, piece in prose_of(path, text):
        prose.words += len(WORD.findall(piece))
        prose.whats += [
            line + piece.count("\n", 0, match.start())
            for match in re.finditer(r"\bwhat\b", piece, re.IGNORECASE)
        ]
    in_code = False
    for number, line in enumerate(text.split("\n"), 1):
        in_code ^= path.suffix == ".md" and line.startswith("```")
        if len(line) > COLUMNS and not in_code and not is_exempt(path, line):
            prose.long_lines.append(number)
    if path.suffix == ".md":
        prose.long_sentences = long_sentences(without_code(text))
    return prose


def long_sentences(text: str) -> list[tuple[int, int]]:
    """Line and words of sentences above SENTENCE_WORDS; rows of tables and items end sentences."""
    found = []
    text = re.sub(r"^\s*(?:\||#|[-*] |\d+\. )", "\n\n", text, flags=re.M)
    at = 0
    for sentence in SENTENCE_END.split(text):
        at = text.index(sentence, at) if sentence else at
        words = len(WORD.findall(sentence))
        if words > SENTENCE_WORDS and "|" not in sentence:
            found.append((text.count("\n", 0, at) + 1, words))
    return found


def folder_of(path: Path) -> str:
    """The folder under which a file is counted."""
    parts = path.parts[:-1]
    return "/".join(parts[:2] if parts[:1] in (("core",), ("plugins",), ("learn",)) else parts[:1])


def main(arguments: list[str] | None = None) -> int:
    """Lists the violations of the rules."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--table", action="store_true", help='"what" in 1,000 words, by folder')
    parser.add_argument("paths", nargs="*", default=["."])
    options = parser.parse_args(arguments)
    found = {
        path: read(path)
        for path in tracked(options.paths)
        if path.suffix in (*CODE, ".md") and (ROOT / path).is_file()
    }
    folders: dict[str, list[Path]] = defaultdict(list)
    for path in found:
        folders[folder_of(path)].append(path)
    status = 0
    for folder, paths in sorted(folders.items()):
        words = sum(found[path].words for path in paths)
        whats = sum(len(found[path].whats) for path in paths)
        rate = 1000 * whats / max(words, 1)
        if options.table:
            print(f"{folder or '(top)':32} {words:7} words  {rate:5.2f} what in 1,000")
            continue
        if rate > WHAT_PER_THOUSAND:
            status = 1
            print(
                f'{folder or "(top)"}: "what" {rate:.2f} times in 1,000 words, allowed '
                f"{WHAT_PER_THOUSAND}"
            )
            for path in paths:
                for line in found[path].whats:
                    print(f"  {path}:{line}")
    if options.table:
        return 0
    for path, prose in found.items():
        for line in prose.long_lines:
            status = 1
            print(f"{path}:{line}: above {COLUMNS} columns")
        for line, words in prose.long_sentences:
            status = 1
            print(f"{path}:{line}: a sentence of {words} words, allowed {SENTENCE_WORDS}")
    return status


if __name__ == "__main__":
    sys.exit(main())
