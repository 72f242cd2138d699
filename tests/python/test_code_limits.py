"""The reader behind scripts/code_limits.py counts methods, members and lines of C++."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))
import code_limits


def in_class(declaration: str, count: int) -> str:
    """A class with `count` declarations; `#` is the number of each."""
    lines = "".join(f"  {declaration.replace('#', str(k))}\n" for k in range(count))
    return f"namespace n {{\nclass Box {{\n public:\n{lines}}};\n}}  // namespace n\n"


@pytest.mark.parametrize(
    "declaration", ["int get_#() const;", "int get_#() const { return 1; }", "Box(int a#);"]
)
def test_a_class_above_the_limit_of_methods_is_named_with_their_number(declaration: str) -> None:
    assert code_limits.excesses("box.h", in_class(declaration, 40)) == []
    found = code_limits.excesses("box.h", in_class(declaration, 41))
    assert found == ["box.h:2: Box has 41 methods; at most 40"]


@pytest.mark.parametrize("declaration", ["int a#_ = 0;", "std::map<int, int> a#_{};"])
def test_a_class_above_the_limit_of_members_is_named_with_their_number(declaration: str) -> None:
    assert code_limits.excesses("box.h", in_class(declaration, 25)) == []
    found = code_limits.excesses("box.h", in_class(declaration, 26))
    assert found == ["box.h:2: Box has 26 members; at most 25"]


def test_members_in_one_declaration_count_each() -> None:
    found = code_limits.excesses("box.h", in_class("int a#_ = 0, b#_{1};", 13))
    assert found == ["box.h:2: Box has 26 members; at most 25"]


@pytest.mark.parametrize(
    "declaration",
    ["using T# = int;", "static constexpr int k# = 1;", "RealParameter a#_{{.name = 1}};"],
)
def test_aliases_constants_and_parameters_of_plugins_are_no_members(declaration: str) -> None:
    assert code_limits.excesses("box.h", in_class(declaration, 60)) == []


def test_a_function_above_the_limit_of_lines_is_named_with_their_number() -> None:
    for lines, expected in [(58, []), (59, ["f.cpp:1: f() has 61 lines; at most 60"])]:
        text = "int f(int a) {\n" + "  ++a;\n" * lines + "}\n"
        assert code_limits.excesses("f.cpp", text) == expected
