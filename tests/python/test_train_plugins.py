"""Run folders name the plugin folders of their training, but do not select them."""

from __future__ import annotations

import gc
from pathlib import Path

import pytest
from skybody.train import evaluate
from skybody.train.__main__ import main
from training import arguments

PLUGINS = Path(__file__).resolve().parents[2] / "build/release/tests/plugins/hostile"

pytestmark = [
    pytest.mark.timeout(120),
    pytest.mark.skipif(not PLUGINS.is_dir(), reason="the tests' plugins are not built"),
]


@pytest.fixture
def mark(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A file that the plugin creates when it is loaded."""
    file = tmp_path / "mark"
    monkeypatch.setenv("SKYBODY_TEST_MARK", str(file))
    return file


def test_recorded_plugin_folders_are_named_and_not_searched(
    tmp_path: Path, mark: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run, given = tmp_path / "run", ["--plugin-path", str(PLUGINS)]
    command = arguments("fast-ppo", run)
    command[command.index("--total-steps") + 1] = "600"
    command[command.index("--eval-episodes") + 1] = "1"
    command += ["--override", "robots.quad.controllers=[{plugin: leaves_a_mark}, {plugin: ctbt}]"]
    assert main([*command, *given]) == 0
    assert mark.exists()
    assert list(run.glob("checkpoints/*/evaluation.json"))  # its process received the plugin path
    longer = ["--resume", "--out", str(run), "--total-steps", "1200"]
    calls = ((main, longer), (evaluate.main, [str(run), "--episodes", "1"]))
    for call, options in calls:
        gc.collect()  # any object that keeps the plugin loaded
        mark.unlink()
        capsys.readouterr()
        assert call(options) == 2
        said = capsys.readouterr().err
        assert said.startswith("warning: ")
        assert f"plugins from `{PLUGINS}`, which is not searched; if you trust this folder" in said
        assert "the scenario cannot be loaded; `skybody check hover_learn --set" in said
        assert not mark.exists()
        gc.collect()
        assert call([*options, *given]) == 0
        assert "warning" not in capsys.readouterr().err
        assert mark.exists()


def test_a_resume_without_the_recorded_folder_keeps_it_on_the_list(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = tmp_path / "run"
    command = arguments("fast-ppo", run)
    command[command.index("--total-steps") + 1] = "600"
    assert main([*command, "--plugin-path", str(PLUGINS)]) == 0
    for steps in ("1200", "1800"):
        capsys.readouterr()
        assert main(["--resume", "--out", str(run), "--total-steps", steps]) == 0
        assert f"`{PLUGINS}`, which is not searched" in capsys.readouterr().err


def test_a_recorded_folder_drives_no_terminal_and_is_no_command(
    capsys: pytest.CaptureFixture[str],
) -> None:
    evaluate.warn_of_plugin_path(Path("run"), ["/tmp/p\x1b[2J; echo pwned"], [])
    said = capsys.readouterr().err
    assert "from `/tmp/p\\x1b[2J; echo pwned`, which" in said
    assert "--plugin-path /" not in said
