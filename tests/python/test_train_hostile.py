"""Untrusted run folders: one message, exit code 2, and never more memory than the file's size."""

from __future__ import annotations

import hashlib
import io
import json
import os
import resource
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from skybody.train import evaluate, files
from skybody.train.__main__ import main
from skybody.train.checkpoint import checkpoint_folders
from training import arguments, finished_run

pytestmark = pytest.mark.timeout(120)

REMEDY = "remove this checkpoint's folder to go on from the one before"


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return finished_run(tmp_path_factory.mktemp("train") / "run")


@pytest.fixture
def run(whole: Path, tmp_path: Path) -> Path:
    return shutil.copytree(whole, tmp_path / "run")


def put_state(run: Path, content: bytes) -> Path:
    """Replaces the newest checkpoint's state, with its hash."""
    folder = checkpoint_folders(run)[-1]
    state, meta = folder / "state.npz", json.loads((folder / "meta.json").read_text())
    state.write_bytes(content)
    meta["files"][state.name] = hashlib.sha256(content).hexdigest()
    (folder / "meta.json").write_text(json.dumps(meta))
    return state


def entries_of(run: Path) -> dict[str, Any]:
    with np.load(checkpoint_folders(run)[-1] / "state.npz") as entries:
        return {name: entries[name] for name in entries.files}


def archive(entries: dict[str, Any], **more: bytes) -> bytes:
    """Entries as written by np.savez(), and raw entries."""
    buffer = io.BytesIO()
    np.savez(buffer, **entries)
    with zipfile.ZipFile(buffer, "a") as file:
        for name, content in more.items():
            file.writestr(f"{name}.npy", content)
    return buffer.getvalue()


def compressed(entries: dict[str, Any]) -> bytes:
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **entries)
    return buffer.getvalue()


def without(entries: dict[str, Any], name: str) -> dict[str, Any]:
    return {key: value for key, value in entries.items() if key != name}


def plain(value: Any) -> dict[str, Any]:
    return {"plain": np.frombuffer(json.dumps(value).encode(), np.uint8)}


def changed(entries: dict[str, Any], **values: Any) -> dict[str, Any]:
    """Replaces some plain values."""
    return {**entries, **plain({**json.loads(entries["plain"].tobytes()), **values})}


def header(shape: tuple[int, ...]) -> bytes:
    """A header of NumPy's format, without the values."""
    buffer = io.BytesIO()
    described = {"descr": "<i8", "fortran_order": False, "shape": shape}
    np.lib.format.write_array_header_1_0(buffer, described)
    return buffer.getvalue()


STATES: list[tuple[Callable[[dict[str, Any]], bytes], str]] = [
    (lambda e: compressed(e), "is compressed, which no learner's state is"),
    (lambda e: archive(without(e, "plain")), "`plain` is missing"),
    (lambda e: archive({**e, **plain([])}), "`plain` is no map"),
    (lambda e: archive({**e, "plain": np.frombuffer(b"[" * 10**5, np.uint8)}), "too deeply"),
    (lambda e: archive(changed(e, recent="abc")), "`recent` is not a list of numbers"),
    (lambda e: archive(changed(e, faults="3")), "`faults` is not a whole number"),
    (lambda e: archive(changed(e, shares=[])), "`shares` is not a map of numbers"),
    (lambda e: archive({**e, "policy": np.array(["a", None])}), "holds object; a learner's state"),
    (lambda e: archive({**e, "policy": np.array(["text"])}), "holds <U4; a learner's state"),
    (lambda e: archive(without(e, "policy"), policy=header((10**12,))), "has other bytes than"),
    (lambda e: archive(without(e, "policy"), policy=header((-1,))), "has other bytes than"),
    (lambda e: archive(without(e, "policy"), policy=b"no array"), "damaged ("),
    (lambda e: archive(e)[:-30], "no archive of a learner's state"),
    (lambda e: b"", "no archive of a learner's state"),
]


@pytest.mark.parametrize(("make", "message"), STATES)
def test_a_state_that_no_learner_wrote_is_one_message_with_the_remedy(
    make: Callable[[dict[str, Any]], bytes],
    message: str,
    run: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    state = put_state(run, make(entries_of(run)))
    assert main(["--resume", "--out", str(run)]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"error: {state} is damaged (")
    assert message in said
    assert said.endswith(f": {REMEDY}\n")
    assert len(said.splitlines()) == 1
    assert "allow_pickle" not in said


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"shares": {"environment": 1.0}}, "`shares` are of other parts"),
        ({"average": {}}, "'values'"),
        ({"average": {"count": 1, "values": ["x"]}}, "'str' object has no attribute 'numpy'"),
    ],
)
def test_plain_values_of_another_kind_are_one_message(
    change: dict[str, Any], message: str, run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    put_state(run, archive(changed(entries_of(run), **change)))
    assert main(["--resume", "--out", str(run)]) == 2
    said = capsys.readouterr().err
    assert "does not fit this one" in said
    assert message in said
    assert len(said.splitlines()) == 1


def test_a_state_that_unpacks_to_gigabytes_is_not_unpacked(run: Path) -> None:
    """Zeros of 1 GB in 5 MB; the process may have 1 GB."""
    buffer = io.BytesIO()
    with (
        zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as file,
        file.open("policy.npy", "w", force_zip64=True) as entry,
    ):
        entry.write(header((1 << 27,)))
        for _ in range(1 << 10):
            entry.write(bytes(1 << 20))
    put_state(run, buffer.getvalue())
    limit = 1 << 30
    done = subprocess.run(
        [sys.executable, "-P", "-m", "skybody.train", "--resume", "--out", str(run)],
        capture_output=True,
        text=True,
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_DATA, (limit, limit)),
        check=False,
    )
    assert done.returncode == 2
    assert "`policy.npy` is compressed, which no learner's state is" in done.stderr


def test_a_file_larger_than_any_of_ours_is_not_read(
    run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("environments.bin", "meta.json"):
        path = checkpoint_folders(run)[-1] / name
        os.truncate(path, files.MOST_BYTES + 1)  # sparse
        assert main(["--resume", "--out", str(run)]) == 2
        said = capsys.readouterr().err
        assert f"has {files.MOST_BYTES + 1} bytes; at most {files.MOST_BYTES} are read" in said
        assert str(path) in said
        assert len(said.splitlines()) == 1


@pytest.mark.parametrize("name", ["config.json", "checkpoints/step_000000001200/meta.json"])
def test_a_pipe_in_a_files_place_is_not_waited_for(
    name: str, run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (run / name).unlink()
    os.mkfifo(run / name)
    assert main(["--resume", "--out", str(run)]) == 2
    said = capsys.readouterr().err
    assert f"{run / name} is damaged" in said
    assert "is no regular file" in said


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"total_steps": "many"}, "`total_steps` is not a whole number"),
        ({"total_steps": True}, "`total_steps` is not a whole number"),
        ({"threads": 1.5}, "`threads` is not a whole number"),
        ({"overrides": "a=b"}, "`overrides` is not a list of texts"),
        ({"plugin_path": [3]}, "`plugin_path` is not a list of texts"),
        ({"versions": {"numpy": 2}}, "`versions` is not a map of texts"),
        ({"hyper": []}, "`hyper` is not a map"),
        ({"scenario": None}, "`scenario` is not a text"),
        ({"algorithm": 7}, "`algorithm` is not a text"),
        ({"more": 1}, "unexpected keyword argument 'more'"),
    ],
)
def test_a_configuration_with_values_of_another_kind_is_one_message(
    change: dict[str, Any], message: str, run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = run / "config.json"
    path.write_text(json.dumps({**json.loads(path.read_text()), **change}))
    assert main(["--resume", "--out", str(run)]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"error: {path} is damaged or of another version (")
    assert message in said
    assert len(said.splitlines()) == 1


@pytest.mark.parametrize(
    ("key", "value"), [("envs", "6"), ("epochs", 2.5), ("hidden", [8, "8"]), ("hidden", 8)]
)
def test_a_hyper_parameter_of_another_kind_is_named(
    key: str, value: Any, run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = run / "config.json"
    config = json.loads(path.read_text())
    config["hyper"][key] = value
    path.write_text(json.dumps(config))
    assert main(["--resume", "--out", str(run)]) == 2
    assert f"`hyper.{key}` is no such value" in capsys.readouterr().err


@pytest.mark.parametrize("content", [b"[" * 10**5, b"[]", b'"text"', b"\xff"])
def test_a_configuration_that_is_no_map_is_one_message(
    content: bytes, run: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (run / "config.json").write_bytes(content)
    assert main(["--resume", "--out", str(run)]) == 2
    said = capsys.readouterr().err
    assert "config.json is damaged or of another version" in said
    assert len(said.splitlines()) == 1


@pytest.mark.parametrize("record", ["config.json", "checkpoints/step_000000001200/meta.json"])
@pytest.mark.parametrize("key", ["scenario", "overrides"])
def test_a_file_that_a_run_names_as_its_scenario_is_not_quoted(
    record: str, key: str, run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    secret = tmp_path / "secret.yaml"
    secret.write_text("password: swordfish\n")
    value = str(secret) if key == "scenario" else [f"robots.quad.model={secret}"]
    path = run / record
    path.write_text(json.dumps({**json.loads(path.read_text()), key: value}))
    if record == "config.json":
        assert main(["--resume", "--out", str(run)]) == 2
    else:
        assert evaluate.main([str(run)]) == 2
    said = capsys.readouterr().err
    assert f"{path}: the scenario cannot be loaded; `skybody check " in said
    assert "swordfish" not in said and "password" not in said
    assert len(said.splitlines()) == 1


def test_a_run_killed_before_it_had_a_configuration_is_begun_anew(tmp_path: Path) -> None:
    run, words = tmp_path / "run", arguments("fast-ppo", tmp_path / "run")
    words[words.index("--total-steps") + 1] = "600"
    killed = f"""
import os
from skybody.train import __main__, run_folder
run_folder.Config.write = lambda *_: os._exit(9)
__main__.main({words!r})
"""
    done = subprocess.run([sys.executable, "-c", killed], check=False)
    assert done.returncode == 9
    left = {path.name for path in run.iterdir()}
    assert {".lock", "checkpoints", "progress.csv"} <= left and "config.json" not in left
    assert main(words) == 0
    assert len(checkpoint_folders(run)) == 1


@pytest.mark.parametrize("name", ["notes.txt", "checkpoints/step_000000000600", "curve.png"])
def test_a_folder_with_anything_else_is_no_new_one(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / name).mkdir(parents=True)
    (tmp_path / ".lock").touch()
    assert main(arguments("fast-ppo", tmp_path)) == 2
    assert "exists and is not empty: take another, or --resume" in capsys.readouterr().err


def test_a_partial_file_has_a_name_that_nobody_foresees_and_follows_no_link(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    victim = tmp_path / "victim"
    victim.write_text("kept")
    monkeypatch.setattr("secrets.token_hex", lambda _: "foreseen")
    link = tmp_path / ".config.json.foreseen"
    link.symlink_to(victim)
    with pytest.raises(FileExistsError):
        files.write_file(tmp_path / "config.json", b"new")
    assert victim.read_text() == "kept"
    monkeypatch.undo()
    files.write_file(tmp_path / "config.json", b"new")
    assert (tmp_path / "config.json").read_bytes() == b"new"


def test_a_lock_that_is_a_link_is_not_followed(tmp_path: Path) -> None:
    (tmp_path / files.LOCK).symlink_to(tmp_path / "elsewhere")
    with pytest.raises(OSError, match="symbolic links"), files.folder_lock(tmp_path):
        pass
    assert not (tmp_path / "elsewhere").exists()
