"""The code of docs/task_kit.md is compiled and flown."""

from __future__ import annotations

import re
import textwrap
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs/task_kit.md").read_text()
TEMPLATE = (ROOT / "plugins/template/task/NAME.cpp.in").read_text()
EXAMPLE = (ROOT / "examples/visit_points.cpp").read_text()
WHOLE_TASK = TEMPLATE.replace("@CLASS@", "Stay").replace("@NAME@", "stay")
QUOTED = re.compile(r"<!-- examples/visit_points\.cpp: ([\w, ]+) -->\n```cpp\n(.*?)```", re.DOTALL)


def part(name: str) -> str:
    """The text between `// [name]` and `// [end]` of the example, without indentation."""
    found = re.search(rf"^ *// \[{name}\]\n(.*?)^ *// \[end\]\n", EXAMPLE, re.DOTALL | re.MULTILINE)
    assert found, name
    return textwrap.dedent(found[1])


def test_the_task_in_the_manual_is_the_one_that_new_projects_begin_with() -> None:
    assert f"```cpp\n{WHOLE_TASK}```" in PAGE


def test_the_manual_quotes_the_example_word_for_word() -> None:
    for names, code in QUOTED.findall(PAGE):
        assert code == "\n".join(part(name) for name in names.split(", ")), names


def test_the_manual_has_no_other_code() -> None:
    blocks = re.findall(r"```cpp\n(.*?)```", PAGE, re.DOTALL)
    quoted = [code for _, code in QUOTED.findall(PAGE)]
    assert sorted(blocks) == sorted([WHOLE_TASK, *quoted])
