"""docs/plugin_reference.md is up to date, complete, and correctly generated from the headers."""

from __future__ import annotations

import importlib
import re
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).resolve().parents[2]
API = ROOT / "plugins/api"


@pytest.fixture
def load(monkeypatch: pytest.MonkeyPatch):
    """Imports a module of scripts/."""
    monkeypatch.syspath_prepend(str(ROOT / "scripts"))
    return importlib.import_module


@pytest.fixture
def reader(load) -> ModuleType:
    return load("cpp_declarations")


def declarations(reader: ModuleType, text: str) -> dict[str, object]:
    return {d.name: d for d in reader.Reader(text).declarations()}


def test_the_page_is_current(load) -> None:
    reference = load("plugin_reference")
    page = reference.write_page()
    assert page.text() == reference.PAGE.read_text(), "scripts/update_docs.sh writes it anew"


def test_every_declaration_of_the_api_has_a_comment(load) -> None:
    assert load("plugin_reference").write_page().bare == []


def test_every_method_that_plugins_may_have_is_under_a_kind(load) -> None:
    page = load("plugin_reference").write_page().text()
    kinds = page.split("\n## Kinds")[1].split("\n## ")[0]
    lines = (API / "methods.h").read_text().splitlines()
    methods = [
        m[1] for line in lines if (m := re.match(r"SKYBODY_PLUGIN_METHOD\(\w+, (\w+),", line))
    ]
    assert len(methods) >= 8
    assert [m for m in methods if f"void {m}(const EnvView<" not in kinds] == []


def test_every_request_of_setup_is_on_the_page(load) -> None:
    page = load("plugin_reference").write_page().text()
    setup = (API / "setup.h").read_text().split("class Setup")[1]
    names = set(re.findall(r"^  [\w:<>&* ]+? ?\b(\w+)\(.*(?:const;|const \{)", setup, re.MULTILINE))
    assert {"input", "need_contacts", "writes"} <= names
    assert [
        n for n in sorted(names - {"raw"}) if not re.search(rf"^- `.*\b{n}\(", page, re.M)
    ] == []


def test_tables_have_a_row_for_each_of_the_lists(load) -> None:
    reference = load("plugin_reference")
    page = reference.write_page().text()
    for header, prefix, place in (
        (ROOT / "core/plugin_abi/signals.h", "SKYBODY_SIGNALS", "Signal::k"),
        (ROOT / "core/base/held_inputs.h", "SKYBODY_HELD_INPUTS", "HeldInput::k"),
    ):
        rows = re.findall(r"^  X\(", header.read_text(), re.MULTILINE)
        assert prefix in header.read_text()
        assert len(re.findall(rf"^\| `{place}", page, re.MULTILINE)) == len(rows)
    places = re.findall(r"X\((SKYBODY_\w+)", (ROOT / "core/base/constants.h").read_text())
    assert re.findall(r"^\| `(SKYBODY_\w+)`", page, re.MULTILINE) == places


def test_a_comment_above_and_one_behind_are_read(reader: ModuleType) -> None:
    text = "/// Above.\nint f(int x) { return x; }\nstruct S {\n  double m;  ///< mass [kg]\n};\n"
    found = declarations(reader, text)
    assert (found["f"].signature, found["f"].doc) == ("int f(int x)", "Above.")
    assert [(m.name, m.doc) for m in found["S"].members] == [("m", "mass [kg]")]


def test_private_parts_bodies_and_detail_are_left_out(reader: ModuleType) -> None:
    text = (
        'class C {\n  int hidden_;\n public:\n  /// "}" counts not.\n'
        '  const char* f() const { return "}"; }\n private:\n  void g();\n};\n'
        "namespace detail {\nvoid h();\n}\n"
    )
    found = declarations(reader, text)
    assert list(found) == ["C"]
    assert [m.signature for m in found["C"].members] == ["const char* f() const"]


def test_values_in_braces_and_constructors_end_where_they_should(reader: ModuleType) -> None:
    text = (
        "struct S {\n  int n = int{1} << 5;\n  S(int x, int y = 2) : n(x), m{y} {}\n"
        "  S& operator+=(const S& b) { n += b.n; return *this; }\n  int m = 0;\n};\n"
    )
    members = declarations(reader, text)["S"].members
    assert [m.signature for m in members] == [
        "int n = int{1} << 5",
        "S(int x, int y = 2)",
        "S& operator+=(const S& b)",
        "int m = 0",
    ]


def test_comments_of_plain_c_are_read(reader: ModuleType) -> None:
    text = (
        "/* A thing,\n * in two lines. */\ntypedef struct T {\n"
        "  double a; /* one */\n  double b; /* two,\n               more */\n} T;\n"
        "enum E {\n  FIRST = 0, /* [m] */\n  LAST = 1   /* [s] */\n};\n"
    )
    found = declarations(reader, text)
    assert found["T"].doc == "A thing,\nin two lines."
    assert [m.doc for m in found["T"].members] == ["one", "two, more"]
    assert [(m.name, m.doc) for m in found["E"].members] == [("FIRST", "[m]"), ("LAST", "[s]")]
