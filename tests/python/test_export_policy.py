"""`skybody export --to c`: C sources that compute the bits of `skybody run --policy`."""

from __future__ import annotations

import dataclasses
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from skybody import Simulation
from skybody._native import PolicyNetwork, shipped_policies
from skybody.exports.__main__ import main
from skybody.exports.policy.c_evaluator import CEvaluator, compile_library
from skybody.exports.policy.c_files import write_sources
from skybody.exports.policy.lockstep import inputs_by_name
from skybody.exports.policy.self_test import actions_of, hash_of
from skybody.exports.policy.source import PolicySource, Wanted, open_wanted
from skybody.train.policy_file import read_policy, shipped_policy, write_policy

from research.deploy.network_drafts import NETWORKS, write_draft

STEPS = 1000
IMAGE_STEPS = 30  # an evaluation with images takes 0.2 ms in C, but its inputs more in Python
COMPILERS = [name for name in ("gcc", "clang") if shutil.which(name)]


def opened(source: Path | str, scenario: str | None = None, name: str = "flyer") -> PolicySource:
    return open_wanted(Wanted(str(source), scenario, name))


def expected_hash(source: PolicySource, steps: int) -> int:
    """The hash of the engine's actions. They differ from step to step."""
    actions = actions_of(source, steps)
    assert len(np.unique(actions, axis=0)) > steps // 2
    return hash_of(actions)


def assert_equal_bits(source: PolicySource, folder: Path) -> None:
    write_sources(source, folder)
    steps = IMAGE_STEPS if source.interface.images else STEPS
    assert CEvaluator(source, folder).self_test(steps) == expected_hash(source, steps)


@pytest.mark.parametrize("scenario", shipped_policies())
def test_c_of_a_shipped_policy_gives_the_engines_bits(scenario: str, tmp_path: Path) -> None:
    assert_equal_bits(opened("shipped", scenario), tmp_path)


@pytest.mark.parametrize("is_normalized", [True, False])
@pytest.mark.parametrize("network", NETWORKS)
def test_c_of_each_kind_of_layer_gives_the_engines_bits(
    network: str, is_normalized: bool, tmp_path: Path
) -> None:
    file = tmp_path / "policy.h5"
    write_draft(file, "hover_camera", network, is_normalized=is_normalized)
    assert_equal_bits(opened(file), tmp_path / "c")


@pytest.mark.parametrize("network", NETWORKS)
def test_python_evaluates_each_kind_of_layer_as_the_engine(network: str, tmp_path: Path) -> None:
    file = write_draft(tmp_path / "policy.h5", "hover_learn", network)
    policy, engine = read_policy(file), PolicyNetwork(str(file))
    random, states = np.random.default_rng(5), policy.states(1)
    for _ in range(20):
        row = (random.normal(size=(1, len(policy.mean))) / policy.scale).astype(np.float32)
        # The engine computes in float: sums of up to 64 products of values near 1.
        assert np.abs(policy(row, states) - engine.act(row)).max() < 2e-6


@pytest.mark.parametrize("compiler", COMPILERS)
@pytest.mark.parametrize("flag", ["-O0", "-O3", "-Os", "-march=native"])
def test_bits_depend_neither_on_the_compiler_nor_on_optimisation(
    compiler: str, flag: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    source = opened(write_draft(tmp_path / "policy.h5", "hover_learn", "with_memory"))
    write_sources(source, tmp_path / "c")
    monkeypatch.setenv("CC", compiler)
    monkeypatch.setattr("skybody.exports.policy.c_evaluator.FLAGS", ("-std=gnu99", flag))
    evaluator = CEvaluator(source, tmp_path / "c")
    assert evaluator.self_test(STEPS) == expected_hash(source, STEPS)


def test_fast_math_is_refused_by_the_sources(tmp_path: Path) -> None:
    source = opened("shipped", "racing")
    write_sources(source, tmp_path)
    with pytest.raises(ValueError, match="compile without -ffast-math"):
        compile_library(source, tmp_path, tmp_path / "policy.so", "-ffast-math")


def test_sources_contain_no_call_of_libm_and_no_allocation(tmp_path: Path) -> None:
    source = opened(write_draft(tmp_path / "policy.h5", "hover_camera", "squashed"))
    write_sources(source, tmp_path)
    command = ["cc", "-c", "-O2", "-ffreestanding", "-fno-stack-protector", "flyer.c"]
    subprocess.run(command, cwd=tmp_path, check=True)
    done = subprocess.run(
        ["nm", "-u", "flyer.o"], cwd=tmp_path, check=True, capture_output=True, text=True
    )
    assert not set(done.stdout.split()) - {"U", "memcpy", "memset", "_GLOBAL_OFFSET_TABLE_"}


def test_check_flies_both_and_says_that_they_are_equal(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = write_draft(tmp_path / "policy.h5", "hover_learn", "with_memory")
    arguments = [str(file), "--to", "c", "--check", "2", "-o", str(tmp_path / "c")]
    assert main(arguments) == 0
    assert "2 episodes" in (out := capsys.readouterr().out)
    assert "every action equal in all bits" in out
    assert sorted(path.name for path in (tmp_path / "c").iterdir()) == [
        "hover_learn.c",
        "hover_learn.h",
        "hover_learn.md",
    ]


@pytest.mark.parametrize("scenario", ["racing_duel", "obstacles_vision"])
def test_shared_policies_and_images_fly_in_lockstep(
    scenario: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = str(tmp_path / "c")
    assert main(["shipped", "--scenario", scenario, "--to", "c", "--check", "1", "-o", out]) == 0
    assert "1 episodes" in capsys.readouterr().out


def test_an_export_that_differs_is_not_written_and_not_called_equal(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    from skybody.exports.policy import c_source

    layers = c_source.network_layers_source()
    wrong = layers.replace("0.1337972327137798f", "0.1337972f")
    assert wrong != layers
    monkeypatch.setattr(c_source, "network_layers_source", lambda: wrong)
    arguments = ["shipped", "--scenario", "racing", "--to", "c", "--check", "1"]
    assert main([*arguments, "-o", str(tmp_path / "c")]) == 1
    captured = capsys.readouterr()
    assert "not equal, nothing written" in captured.err
    assert "every action" not in captured.out
    assert not list(tmp_path.iterdir())


def test_commands_are_in_physical_units(tmp_path: Path) -> None:
    source = opened("shipped", "racing")
    write_sources(source, tmp_path)
    evaluator = CEvaluator(source, tmp_path)
    simulation = Simulation("racing")
    simulation.reset()
    for _ in range(20):
        values = inputs_by_name(source.interface, simulation.observation)
        simulation.step(evaluator.act(values))
        # Floats: a rounding of 6e-8 of values up to 40, twice.
        assert evaluator.command == pytest.approx(simulation.commands, abs=5e-6)


def test_robots_with_ranges_of_their_own_get_their_own_commands(tmp_path: Path) -> None:
    source = opened("shipped", "chase_agents")
    assert source.interface.robots == ["hawk", "kite", "owl", "evader"]
    write_sources(source, tmp_path)
    inputs = np.full(source.policy.mean.shape, 0.5, np.float32)
    values = inputs_by_name(source.interface, inputs)
    speeds = []
    for robot in (0, 3):
        evaluator = CEvaluator(source, tmp_path, robot)
        action = evaluator.act(values)
        output = source.interface.outputs[0]
        low, high = output.low[robot], output.high[robot]
        assert evaluator.command[0] == pytest.approx(low + (action[0] + 1.0) / 2.0 * (high - low))
        speeds.append(evaluator.command[0])
    assert speeds[0] != speeds[1]


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_an_input_that_is_no_number_changes_nothing(bad: float, tmp_path: Path) -> None:
    source = opened(write_draft(tmp_path / "policy.h5", "hover_learn", "with_memory"))
    write_sources(source, tmp_path)
    one, other = CEvaluator(source, tmp_path), CEvaluator(source, tmp_path)
    inputs = np.full(source.policy.mean.shape, 0.5, np.float32)
    values = inputs_by_name(source.interface, inputs)
    assert (one.act(values) == other.act(values)).all()
    command = one.command
    assert np.isnan(one.act(values | {"velocity": np.array([0.0, bad, 0.0])})).all()
    assert (one.command == command).all()
    assert (one.act(values) == other.act(values)).all()


def test_the_page_names_inputs_outputs_units_and_frames(tmp_path: Path) -> None:
    write_sources(opened("shipped", "racing"), tmp_path)
    page = (tmp_path / "flyer.md").read_text()
    assert "| `velocity` | 3 | m/s | -inf ... inf | velocity of the base's frame, B |" in page
    assert "| `thrust` | N | 0 | 39.4138 | collective thrust along z of B |" in page
    assert "every 0.02 s (50 Hz)" in page


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["shipped"], "shipped: give --scenario NAME"),
        (["nowhere"], "nowhere: neither a file nor a folder"),
        (["shipped", "--scenario", "hover"], "no policy is shipped for `hover`"),
        (["shipped", "--scenario", "racing", "--name", "a b"], "--name: `a b` is no C identifier"),
        (["shipped", "--scenario", "racing", "--every", "2"], "--every is not for --to c"),
    ],
)
def test_bad_arguments_are_one_message(
    arguments: list[str], message: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert main([*arguments, "--to", "c", "-o", str(tmp_path / "c")]) == 2
    assert message in (error := capsys.readouterr().err)
    assert error.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_a_policy_of_another_hash_needs_the_scenario_by_name(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    policy = read_policy(shipped_policy("racing"))
    attributes = {**policy.attributes, "scenario_hash": "0" * 16}
    file = tmp_path / "policy.h5"
    write_policy(file, dataclasses.replace(policy, attributes=attributes))
    out = ["--to", "c", "-o", str(tmp_path / "c")]
    assert main([str(file), *out]) == 2
    assert "give --scenario racing" in capsys.readouterr().err
    assert main([str(file), "--scenario", "hover", *out]) == 2
    assert "has 25 observations and 4 actions; `hover` has" in capsys.readouterr().err
    assert main([str(file), "--scenario", "racing", *out]) == 0
