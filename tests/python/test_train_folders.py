"""Run folders of skybody.train: damaged, of another version, in use; each a clear message."""

from __future__ import annotations

import hashlib
import io
import json
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from skybody._native import CompiledScenario, Ppo
from skybody.train import curve, evaluate
from skybody.train.__main__ import main
from skybody.train.checkpoint import checkpoint_folders, read_checkpoint
from skybody.train.evaluation_file import read_evaluation
from skybody.train.native_learners import FastPpo
from skybody.train.policy_file import Layer, Policy, write_policy
from training import arguments, finished_run

PROGRAM = Path(__file__).resolve().parents[2] / "build/release/bin/skybody"


pytestmark = pytest.mark.timeout(120)


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished run with evaluations."""
    return finished_run(tmp_path_factory.mktemp("train") / "run")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--seed", "4"], "begun with seed 3, not 4"),
        (["--algo", "ppo"], "begun with algorithm fast-ppo, not ppo"),
        (["--set", "epochs=3"], "leave --set and --envs out"),
        (["--total-steps", "1"], "--total-steps 1: "),
    ],
)
def test_a_run_is_resumed_with_its_own_options(
    options: list[str], message: str, run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["--resume", "--out", str(run), *options]) == 2
    assert message in capsys.readouterr().err


def test_there_must_be_a_run_to_resume(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--resume", "--out", str(tmp_path)]) == 2
    assert "no run to go on with" in capsys.readouterr().err


@contextmanager
def damaged(path: Path) -> Iterator[None]:
    """Flips the last bit of a file."""
    whole = path.read_bytes()
    path.write_bytes(whole[:-1] + bytes([whole[-1] ^ 1]))
    try:
        yield
    finally:
        path.write_bytes(whole)


def test_a_damaged_checkpoint_is_named(run: Path) -> None:
    folder = checkpoint_folders(run)[0]
    with (
        damaged(folder / "environments.bin"),
        pytest.raises(ValueError, match=r"environments\.bin is damaged"),
    ):
        read_checkpoint(folder)


def test_a_damaged_policy_is_not_evaluated(run: Path) -> None:
    folder = checkpoint_folders(run)[0]
    with (
        damaged(folder / "policy.h5"),
        pytest.raises(ValueError, match=r"policy\.h5 is damaged"),
    ):
        evaluate.evaluate_checkpoint(folder, episodes=1, seed=1)


def test_a_damaged_configuration_is_named(run: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = run / "config.json"
    whole = path.read_bytes()
    try:
        path.write_bytes(whole[: len(whole) // 2])
        assert main(["--resume", "--out", str(run)]) == 2
    finally:
        path.write_bytes(whole)
    assert "config.json is damaged" in capsys.readouterr().err


@contextmanager
def replaced(path: Path, content: bytes | None) -> Iterator[None]:
    """Replaces a file's bytes, or removes the file (None)."""
    whole = path.read_bytes()
    if content is None:
        path.unlink()
    else:
        path.write_bytes(content)
    try:
        yield
    finally:
        path.write_bytes(whole)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "meta.json is damaged"),
        (b'{"steps": 12', "meta.json is damaged"),
        (b"\xff\xfe", "meta.json is damaged"),
        (b"[]", "meta.json is damaged (no map of stamps)"),
        (
            b'{"steps": 1200}',
            "meta.json is damaged (`parameter_hash` is missing, `algorithm` is",
        ),
    ],
)
@pytest.mark.parametrize("program", ["train", "evaluate"])
def test_damaged_stamps_of_a_checkpoint_are_named_with_the_remedy(
    program: str, content: bytes, message: str, run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with replaced(checkpoint_folders(run)[-1] / "meta.json", content):
        if program == "train":
            assert main(["--resume", "--out", str(run)]) == 2
        else:
            assert evaluate.main([str(run)]) == 2
    said = capsys.readouterr().err
    assert message in said
    assert "remove this checkpoint's folder to go on from the one before" in said


@pytest.mark.parametrize("name", ["state.npz", "environments.bin", "policy.h5"])
def test_a_file_that_a_checkpoint_lacks_is_named(
    name: str, run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = checkpoint_folders(run)[-1] / name
    with replaced(path, None):
        assert main(["--resume", "--out", str(run)]) == 2
    assert f"{path} is missing: remove this checkpoint's folder" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"garbage\nmore of it\n", "line 2 is no row of a table with a column `steps`"),
        (b"steps,faults\n300,0\n600\n", "line 3 is no row"),
        (b"steps,faults\n300,0\n600,many\n", "line 3: `faults` is `many`, not a number"),
        (b"\xff\xfe\n\n", "can't decode"),
    ],
)
def test_a_damaged_table_is_named_with_the_remedy(
    content: bytes, message: str, run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = run / "progress.csv"
    with replaced(path, content):
        assert main(["--resume", "--out", str(run)]) == 2
        resumed = capsys.readouterr().err
        assert curve.main([str(run)]) == 2
        drawn = capsys.readouterr().err
    for said in (resumed, drawn):
        assert f"{path} is damaged" in said
        assert message in said
        assert "remove it, which loses its rows only" in said


def test_a_checkpoint_of_another_version_is_one_message(
    run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = checkpoint_folders(run)[-1]
    state, meta_file = folder / "state.npz", folder / "meta.json"
    with np.load(state) as entries:
        fewer = {name: entries[name] for name in entries.files if name != "return_moments.mean"}
    buffer = io.BytesIO()
    np.savez(buffer, **fewer)
    meta = json.loads(meta_file.read_text())
    meta["versions"]["skybody"] = "0.0.9"
    meta["files"][state.name] = hashlib.sha256(buffer.getvalue()).hexdigest()
    with replaced(state, buffer.getvalue()), replaced(meta_file, json.dumps(meta).encode()):
        assert main(["--resume", "--out", str(run)]) == 2
    said = capsys.readouterr().err
    assert f"{folder} was written by skybody 0.0.9 and does not fit this one" in said
    assert "no `return_moments.mean`" in said
    assert len(said.splitlines()) == 1


def test_a_curve_has_position_errors_where_a_task_has_them(tmp_path: Path) -> None:
    def height(error: str) -> int:
        row = "steps,wall_clock,return_mean,position_error\n"
        (tmp_path / "progress.csv").write_text(f"{row}100,1.0,2.0,{error}\n200,2.0,3.0,{error}\n")
        curve.draw_curve([tmp_path], tmp_path / "curve.png")
        return int.from_bytes((tmp_path / "curve.png").read_bytes()[20:24], "big")  # of the PNG

    assert height("nan") == height("") < height("0.5")


def test_a_curve_of_no_folder_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert curve.main([str(tmp_path / "nothere")]) == 2
    assert capsys.readouterr().err == f"error: {tmp_path}/nothere: there is no such folder\n"


NOT_WHOLE: list[Callable[[dict[str, Any]], object]] = [
    lambda e: [e.pop(name) for name in list(e) if name not in ("steps", "episodes")],
    lambda e: e.update(return_mean="abc"),
    lambda e: e.update(return_mean=float("nan")),
    lambda e: e.update(return_cv=float("inf")),
    lambda e: e.update(length_mean=10**400),
    lambda e: e.update(success_share=True),
    lambda e: e.update(steps=5.0),
    lambda e: e.update(parameter_hash=5),
    lambda e: e.pop("wall_clock"),
    lambda e: e["failed"].pop(),
    lambda e: e["position_errors"].__setitem__(0, "far"),
]


@pytest.mark.parametrize("change", NOT_WHOLE)
def test_an_evaluation_that_is_not_whole_counts_as_missing(
    change: Callable[[dict[str, Any]], object], run: Path
) -> None:
    folder = checkpoint_folders(run)[0]
    path = folder / "evaluation.json"
    found = read_evaluation(folder)
    assert found is not None
    change(found)
    with replaced(path, json.dumps(found).encode()):
        assert read_evaluation(folder) is None
    assert read_evaluation(folder) is not None


@pytest.mark.parametrize("content", [b"", b"{", b"null", b"[]", b"[" * 10**5, b"\xff\xfe"])
def test_an_evaluation_that_is_none_counts_as_missing(content: bytes, run: Path) -> None:
    folder = checkpoint_folders(run)[0]
    with replaced(folder / "evaluation.json", content):
        assert read_evaluation(folder) is None


def test_a_resumed_run_evaluates_anew_what_is_damaged(run: Path) -> None:
    tables = [run / "evaluation.csv", checkpoint_folders(run)[0] / "evaluation.json"]
    whole = [path.read_text() for path in tables]
    tables[1].write_text('{"steps": 5, "episodes": 3}')
    assert main(["--resume", "--out", str(run)]) == 0
    assert [path.read_text() for path in tables] == whole


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda c: c["hyper"].update(discount=0.5), "hyper.discount (0.98 then, 0.5 now)"),
        (lambda c: c["hyper"].update(hidden=[16, 8]), "hyper.hidden ([8, 8] then, [16, 8] now)"),
        (lambda c: c.update(seed=4), "seed (3 then, 4 now)"),
    ],
)
def test_a_run_whose_configuration_was_changed_by_hand_is_not_resumed(
    change: Callable[[dict[str, Any]], None],
    message: str,
    run: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    path = run / "config.json"
    config = json.loads(path.read_text())
    change(config)
    with replaced(path, json.dumps(config).encode()):
        assert main(["--resume", "--out", str(run)]) == 2
    said = capsys.readouterr().err
    newest = checkpoint_folders(run)[-1] / "meta.json"
    assert f"config.json is not what {newest} was trained with: {message}; put the old" in said


@pytest.mark.parametrize(
    ("algorithm", "message"),
    [
        ("ppo", "hyper-parameters of another learner or version: activation, "),
        ("lean-ppo", "the learner `lean-ppo` has gone: `fast-ppo` learns by the same method"),
    ],
)
def test_a_run_of_a_learner_that_does_not_fit_is_not_resumed(
    algorithm: str, message: str, run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = run / "config.json"
    content = path.read_text().replace('"algorithm": "fast-ppo"', f'"algorithm": "{algorithm}"')
    with replaced(path, content.encode()):
        assert main(["--resume", "--out", str(run)]) == 2
    said = capsys.readouterr().err
    assert f"{path} is damaged or of another version ({message}" in said
    assert len(said.splitlines()) == 1


def test_two_processes_do_not_train_in_one_folder(
    run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    holder = """
import sys
from pathlib import Path
from skybody.train import files
with files.folder_lock(Path(sys.argv[1])):
    print("held", flush=True)
    sys.stdin.read()
"""
    process = subprocess.Popen(
        [sys.executable, "-c", holder, str(run)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        assert process.stdout is not None and process.stdout.readline() == "held\n"
        assert main(["--resume", "--out", str(run)]) == 2
        assert "another process trains there" in capsys.readouterr().err
    finally:
        process.communicate("")


def test_a_run_that_goes_on_under_other_versions_says_so(
    run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = run / "config.json"
    whole = path.read_text()
    try:
        path.write_text(whole.replace('"python": "', '"python": "0.'))
        assert main(["--resume", "--out", str(run)]) == 0
        assert "versions differ, and so may bits: python 0." in capsys.readouterr().err
    finally:
        path.write_text(whole)


def test_a_policy_with_a_flipped_bit_does_not_fly(tmp_path: Path) -> None:
    weight = np.random.default_rng(0).standard_normal((4, 22)).astype(np.float32)
    layer = Layer(weight, np.zeros(4, np.float32), "none")
    stamps = {
        "scenario": "hover",
        "scenario_hash": f"{CompiledScenario('hover').scenario_hash:016x}",
    }
    stamps |= {"seed": 1, "algorithm": "ppo", "steps": 1}
    file = tmp_path / "policy.h5"
    write_policy(file, Policy([layer], np.zeros(22), np.ones(22), 10.0, stamps))

    def fly() -> subprocess.CompletedProcess[str]:
        command = [str(PROGRAM), "run", "hover", "--policy", str(file), "--steps", "5"]
        command += ["--no-picture", "--out", str(tmp_path / "flight")]
        return subprocess.run(command, capture_output=True, text=True, check=False)

    assert fly().returncode == 0, fly().stderr
    content = bytearray(file.read_bytes())
    content[content.find(weight.tobytes()) + 5] ^= 4
    file.write_bytes(content)
    done = fly()
    assert done.returncode == 2
    assert str(file) in done.stderr
    assert len(done.stderr.splitlines()) == 1


class Counting:
    """A learner of the engine that counts requests for its complete state."""

    saves = 0

    def __init__(self, *arguments: Any) -> None:
        self._learner = Ppo(*arguments)

    def __getattr__(self, name: str) -> Any:
        Counting.saves += name == "save"
        return getattr(self._learner, name)


def test_a_checkpoint_copies_a_learners_words_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(FastPpo, "_kind", Counting)
    command = arguments("fast-ppo", tmp_path / "run")
    command[command.index("--total-steps") + 1] = "1200"
    assert main(command) == 0
    checkpoints = checkpoint_folders(tmp_path / "run")
    assert Counting.saves == len(checkpoints) + 1  # the summary contains the parameters' hash
