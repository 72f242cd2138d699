"""Conversion of policies of format 1, which have no checksum over all content, to format 2."""

from __future__ import annotations

import json
from pathlib import Path

import h5py
import numpy as np
import pytest
from skybody.train import files
from skybody.train.convert_policy import main
from skybody.train.policy_file import read_policy


def write_old(path: Path) -> Path:
    """A policy in the format of earlier Skybody versions."""
    with h5py.File(path, "w") as file:
        file.attrs.update(
            {
                "format": "skybody-policy",
                "version": 1,
                "action_squash": "clip",
                "scenario": "hover",
                "scenario_hash": "0123456789abcdef",
                "algorithm": "ppo",
                "seed": 4,
                "steps": 1200,
                "observation_size": 3,
                "action_size": 2,
            }
        )
        file["normalization/mean"] = np.array([1.0, 2.0, 3.0])
        file["normalization/scale"] = np.array([0.5, 0.25, 2.0])
        file["normalization"].attrs["clip"] = 10.0
        file["layers/0/weight"] = np.arange(6, dtype=np.float32).reshape(2, 3)
        file["layers/0/bias"] = np.array([0.5, -0.5], np.float32)
        file["layers/0"].attrs["activation"] = "tanh"
    return path


def test_a_converted_policy_has_the_same_numbers(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write_old(tmp_path / "policy.h5")
    with pytest.raises(ValueError, match=r"-P -m skybody\.train\.convert_policy .*policy\.h5"):
        read_policy(path)
    assert main([str(path)]) == 0
    assert capsys.readouterr().out == f"{path}: converted to format 2\n"
    policy = read_policy(path)
    np.testing.assert_array_equal(policy.mean, [1.0, 2.0, 3.0])
    np.testing.assert_array_equal(policy.scale, [0.5, 0.25, 2.0])
    np.testing.assert_array_equal(policy.layers[0].weight, [[0.0, 1.0, 2.0], [3.0, 4.0, 5.0]])
    np.testing.assert_array_equal(policy.layers[0].bias, [0.5, -0.5])
    assert (policy.clip, policy.layers[0].activation) == (10.0, "tanh")
    assert policy.attributes["scenario"] == "hover"
    assert policy.attributes["steps"] == 1200
    assert [file.name for file in tmp_path.iterdir()] == ["policy.h5"]
    content = path.read_bytes()
    assert main([str(path)]) == 0
    assert capsys.readouterr().out == f"{path}: has format 2 already\n"
    assert path.read_bytes() == content


def test_the_checkpoint_of_a_converted_policy_knows_its_new_hash(tmp_path: Path) -> None:
    path = write_old(tmp_path / "policy.h5")
    meta = tmp_path / "meta.json"
    meta.write_text(json.dumps({"steps": 1200, "files": {"policy.h5": files.file_hash(path)}}))
    assert main([str(path)]) == 0
    stamps = json.loads(meta.read_text())
    assert stamps == {"steps": 1200, "files": {"policy.h5": files.file_hash(path)}}


def test_a_swapped_policy_of_format_2_does_not_get_its_hash_into_the_checkpoint(
    tmp_path: Path,
) -> None:
    path = write_old(tmp_path / "policy.h5")
    assert main([str(path)]) == 0
    meta = tmp_path / "meta.json"
    meta.write_text(json.dumps({"files": {"policy.h5": "0" * 64}}))
    before = meta.read_bytes()
    assert main([str(path)]) == 0
    assert meta.read_bytes() == before


def test_files_behind_a_bad_one_are_converted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    good = write_old(tmp_path / "good.h5")
    assert main([str(tmp_path / "absent.h5"), str(good)]) == 2
    said = capsys.readouterr()
    assert said.out == f"{good}: converted to format 2\n"
    assert said.err.count("\n") == 1
    read_policy(good)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"text", "not a policy file: it does not begin with `skybody-policy 2`"),
        (b"skybody-policy 2\nbytes 3\n", "damaged, cut short or changed"),
        (b"\x89HDF\r\n\x1a\nand no more", "policy.h5: "),
        (None, "there is no such file"),
    ],
)
def test_what_is_no_policy_is_left_alone(
    content: bytes | None, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "policy.h5"
    if content is not None:
        path.write_bytes(content)
    assert main([str(path)]) == 2
    said = capsys.readouterr().err
    assert message in said
    assert said.startswith(f"convert_policy: {path}: ")
    assert len(said.splitlines()) == 1
    assert content is None or path.read_bytes() == content


def test_a_policy_that_is_not_what_its_checkpoint_wrote_is_not_converted(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write_old(tmp_path / "policy.h5")
    (tmp_path / "meta.json").write_text(json.dumps({"files": {"policy.h5": "0" * 64}}))
    content = path.read_bytes()
    assert main([str(path)]) == 2
    assert "is damaged: its SHA-256 is not that of meta.json beside it" in capsys.readouterr().err
    assert path.read_bytes() == content
