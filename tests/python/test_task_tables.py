"""Tables of observations in the READMEs of tasks match the tasks' declarations."""

from __future__ import annotations

from measurements import module


def test_readmes_of_tasks_have_the_tables_that_the_tasks_declare() -> None:
    script = module("task_tables")
    for readme in script.pages():
        text = readme.read_text()
        assert script.page(text) == text, f"{readme}: scripts/update_docs.sh writes it anew"
