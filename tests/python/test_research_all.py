"""`python -m research all`: its plan, skipped rows, and runs that go on where they stopped."""

from __future__ import annotations

import argparse
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest
from measurements import ENVIRONMENT

from research import registry
from research.common import page_data
from research.everything import command
from research.everything import rows as plan
from research.everything.record import Record
from research.everything.rows import Given, Row, missing, sources_are_of

ROOT = Path(__file__).resolve().parents[2]
ROWS = {row.name: row for row in plan.rows()}
# The method of `./dev bench`, written by hand; its tables are rows of their own.
NO_ROW = {"benchmarks"}


def options(folder: Path, *words: str) -> argparse.Namespace:
    return command.parse([*words, "--logs", str(folder)])


def test_every_measurement_with_a_page_has_one_row() -> None:
    known = [row for row in (*registry.measurements(), *registry.OTHERS) if row.page]
    assert {row.name for row in known} - set(ROWS) == NO_ROW
    assert len(ROWS) == len(plan.rows())
    pages = {row.page for row in ROWS.values()} | NO_ROW
    assert {path.stem for path in page_data.pages()} <= pages


@pytest.mark.parametrize("name", ROWS)
def test_a_row_has_a_time_and_a_command(name: str) -> None:
    row = ROWS[name]
    assert row.minutes > 0.0
    assert row.page
    here = Path("/")
    for out in (None, here):
        words = row.words(Given(here, here), out)
        assert "{" not in " ".join(words)
        assert words[0] == "./dev" or Path(words[0]).is_absolute()


def test_a_row_without_its_need_tells_the_remedy() -> None:
    given = Given()
    assert missing(Row("a", 1.0), given) is None
    assert missing(Row("a", 1.0, needs=["package yaml"]), given) is None
    found = missing(Row("a", 1.0, needs=["package no_such_package"]), given)
    assert found == "needs package no_such_package: pip install it, or ./dev build"
    assert missing(Row("a", 1.0, needs=["firmware"]), given) == (
        "needs firmware: scripts/build_betaflight.sh FOLDER makes it"
    )
    assert missing(Row("a", 1.0, needs=["firmware"]), Given(firmware=Path("x"))) is None
    assert "./dev no_such installs it" in (
        missing(Row("a", 1.0, needs=["python no_such"]), given) or ""
    )


def test_the_list_has_times_their_sum_and_reasons(tmp_path: Path) -> None:
    found = command.steps_of(
        options(tmp_path, "--only", "memory", "betaflight_hold"), Record(tmp_path / "no")
    )
    lines = command.listed(found).splitlines()
    assert "15 min" in lines[1] and "skipped: needs firmware" in lines[1]
    assert "10 min" in lines[2] and "(by hand)" in lines[2]
    assert lines[-1] == "1 of 2 rows run: about 10 min"


def test_a_run_goes_on_where_it_stopped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(page_data, "commit", lambda: "1234abcd")
    monkeypatch.setattr(
        "research.everything.record.sources_are_of", lambda name: name == "1234abcd"
    )
    names = ("memory", "hyperparameters", "scenario_index")
    chosen = options(tmp_path, "--resume", "--only", *names)
    record = Record(tmp_path / "state.json")
    called = []

    def run(words: Sequence[str], log: Path) -> int:
        called.append(log.stem)
        return int(log.stem == "hyperparameters")

    failed = command.run_steps(command.steps_of(chosen, record), chosen, record, run)
    assert failed == ["hyperparameters"]
    assert sorted(called) == sorted(names)
    assert set(record.read()) == {"memory", "scenario_index"}
    called.clear()
    steps = command.steps_of(chosen, record)
    assert [step.row.name for step in steps if not step.skipped] == ["hyperparameters"]
    command.run_steps(steps, chosen, record, run)
    assert called == ["hyperparameters"]
    later = options(tmp_path, "--only", *names)
    assert not any(step.skipped for step in command.steps_of(later, record))
    capsys.readouterr()


def test_no_row_starts_that_would_end_after_the_hours(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    chosen = options(tmp_path, "--hours", "0.2", "--only", "learning", "memory")
    record = Record(tmp_path / "state.json")
    called: list[str] = []

    def run(words: Sequence[str], log: Path) -> int:
        called.append(log.stem)
        return 0

    steps = [command.Step(row, row.minutes) for row in (ROWS["learning"], ROWS["memory"])]
    assert command.run_steps(steps, chosen, record, run) == []
    assert called == ["memory"]
    assert "learning: left out, takes about 5.5 h" in capsys.readouterr().out


def test_documents_and_tests_are_no_sources(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def git(*words: str) -> str:
        name = ("-c", "user.name=a", "-c", "user.email=a@b")
        done = subprocess.run(
            ["git", *name, *words], cwd=tmp_path, capture_output=True, text=True, check=True
        )
        return done.stdout.strip()

    for name in ("docs/page.md", "tests/test_a.py", "a.py"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("1\n")
    git("init")
    git("add", ".")
    git("commit", "-m", "all")
    commit = git("rev-parse", "HEAD")
    monkeypatch.setattr(plan, "ROOT", tmp_path)
    assert sources_are_of(commit)
    for bad in ("", "no_such_commit", f"{commit}-dirty"):
        assert not sources_are_of(bad)
    (tmp_path / "docs/page.md").write_text("2\n")
    (tmp_path / "tests/test_a.py").write_text("2\n")
    assert sources_are_of(commit)
    (tmp_path / "a.py").write_text("2\n")
    assert not sources_are_of(commit)


def test_a_trial_runs_resumes_and_refuses(tmp_path: Path) -> None:
    words = [sys.executable, "-P", "-m", "research", "all", "--logs", str(tmp_path)]

    def called(*more: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [*words, *more], env=ENVIRONMENT, capture_output=True, text=True, check=False
        )

    done = called("--quick", "--only", "control_page", "learned_tables")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "skipped: has no trial" in done.stdout
    assert "[1/1] control_page: about 1 min" in done.stdout
    assert (tmp_path / "state.json").is_file()
    refused = called("--only", "no_such")
    assert refused.returncode == 2
    assert "--only no_such: no such row; --list prints all of them" in refused.stderr
    assert called("--list").stdout.count("\n") == len(ROWS) + 2
