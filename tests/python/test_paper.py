"""`python -m research paper`: its rows, verdicts from data, and runs that are not repeated."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from research.paper import readings, report
from research.paper.command import main
from research.paper.items import HOLDS, MISSED, OPEN, Item, items, verdict
from research.paper.runs import Record, minutes, run_all
from research.registry import measurements

ROOT = Path(__file__).resolve().parents[2]
ITEMS = {item.item: item for item in items()}
TABLES = [f"Table {number}" for number in ("I", "II", "III", "IV", "V")]
MEASUREMENTS = {row.name for row in measurements()}
FIGURES = [f"Figure {number}" for number in range(1, 12)]


def row(*runs: str) -> Item:
    return Item("Table VI", "", "", list(runs), 5.0, "docs/none.md", "films", "", 0.0, "above")


def test_each_table_and_figure_of_the_paper_has_one_row() -> None:
    assert sorted(ITEMS) == sorted([*TABLES, *FIGURES])
    assert len(items()) == len(ITEMS)


@pytest.mark.parametrize("name", ITEMS)
def test_a_row_names_measurements_and_a_reading(name: str) -> None:
    item = ITEMS[name]
    assert {run.split()[0] for run in item.runs} <= MEASUREMENTS
    assert callable(getattr(readings, item.reading))
    assert item.minutes > 0 or not item.runs


@pytest.mark.parametrize("name", ITEMS)
def test_a_row_whose_data_are_there_has_a_figure(name: str) -> None:
    item = ITEMS[name]
    found = verdict(item)
    is_there = (ROOT / item.page).is_file()
    assert (found.figure is not None) == is_there
    assert (found.word == OPEN) == (not is_there)


def test_a_verdict_follows_the_data(tmp_path: Path) -> None:
    item = ITEMS["Table III"]
    assert verdict(item, tmp_path).word == OPEN
    (tmp_path / "data").mkdir()
    file = tmp_path / "data/scalability.json"
    shutil.copy(ROOT / "docs/results/data/scalability.json", file)
    assert verdict(item, tmp_path).word == HOLDS
    content = json.loads(file.read_text())
    for pool in content["pool"]:
        pool["mean"]["rate"] = 1000.0
    file.write_text(json.dumps(content))
    found = verdict(item, tmp_path)
    assert (found.word, found.figure) == (MISSED, 1000.0)
    assert verdict(ITEMS["Figure 7"], tmp_path).figure == 0.0


def test_steps_between_are_those_of_one_process(tmp_path: Path) -> None:
    (tmp_path / "data").mkdir()
    rows = [
        {"stepping": "in process", "intervening": [0, 0], "spread_mm": [0.0, 0.0]},
        {"stepping": "free-running", "intervening": [9, 40], "spread_mm": [0.0, 80.0]},
    ]
    (tmp_path / "data/synchronization.json").write_text(json.dumps({"rows": rows}))
    assert verdict(ITEMS["Figure 4"], tmp_path).word == HOLDS
    assert verdict(ITEMS["Figure 5"], tmp_path).word == HOLDS
    rows[0]["intervening"] = [0, 1]
    (tmp_path / "data/synchronization.json").write_text(json.dumps({"rows": rows}))
    assert verdict(ITEMS["Figure 4"], tmp_path).word == MISSED


def test_the_transfer_is_judged_by_its_worst_engine(tmp_path: Path) -> None:
    (tmp_path / "data").mkdir()
    drawn = {"policy": "drawn", "condition": "hidden", "failed": 0}
    flights = [
        {**drawn, "engine": "mujoco", "mean": [0.05, 0.07]},
        {**drawn, "engine": "bullet", "mean": [0.08, 0.10], "failed": 1},
        {**drawn, "engine": "skybody", "mean": [0.5, 0.5]},
        {**drawn, "engine": "rotorpy", "mean": [0.5, 0.5], "condition": "plain"},
    ]
    (tmp_path / "data/transfer.json").write_text(json.dumps({"flights": flights}))
    assert verdict(ITEMS["Table V"], tmp_path).figure == pytest.approx(9.0)
    assert verdict(ITEMS["Figure 9"], tmp_path).figure == pytest.approx(75.0)


def test_runs_that_ended_are_not_repeated_and_failed_ones_are(tmp_path: Path) -> None:
    record, called = Record(tmp_path / "done.json"), []
    codes = {"one": 0, "two --quick": 1}

    def run(words: str) -> int:
        called.append(words)
        return codes[words]

    wanted = [row("one"), row("one", "two --quick")]
    assert run_all(wanted, False, record, run) == ["two --quick"]
    assert called == ["one", "two --quick"]
    codes["two --quick"] = 0
    assert run_all(wanted, False, record, run) == []
    assert called == ["one", "two --quick", "two --quick"]
    assert run_all(wanted, True, record, run) == []
    assert len(called) == 5


def test_measured_times_replace_estimates(tmp_path: Path) -> None:
    record = Record(tmp_path / "done.json")
    record.add("one", 90.0)
    assert minutes(row("one"), record) == pytest.approx(1.5)
    assert minutes(row("one", "two"), record) == 5.0


def test_the_list_has_all_rows_and_their_count(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--list"]) == 0
    printed = capsys.readouterr().out
    assert [line for line in printed.splitlines() if line.startswith(("Table", "Figure"))] == [
        f"{item.item}: {item.subject}" for item in items()
    ]
    assert "5 tables and 11 figures" in printed


def test_an_unknown_name_is_refused_with_the_known_ones(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--all", "--only", "Table VI"]) == 2
    error = capsys.readouterr().err
    assert error.startswith("paper: the paper has no `Table VI`; it has Figure 1,")
    assert error.count("\n") == 1


def test_the_page_is_current() -> None:
    assert report.is_current(), "python -m research paper --page writes it"
