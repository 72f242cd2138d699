"""Properties of a loaded scenario, and the reasons why loading fails."""

from __future__ import annotations

import pickle
from pathlib import Path

import pytest
import skybody
from skybody._native import CompiledScenario


def test_numbers_are_those_of_the_scenario_file(hover: CompiledScenario) -> None:
    assert hover.name == "hover"
    assert Path(hover.file).name == "hover.yaml"
    assert hover.dt == 0.001
    assert hover.action_repeat == 1
    assert hover.horizon == 20000
    assert hover.gravity == (0.0, 0.0, -9.81)
    assert hover.robots == ["quad"]
    assert hover.agents == [0]


def test_observation_channels_fill_the_row_without_gaps(hover: CompiledScenario) -> None:
    first = 0
    for channel in hover.observation_channels:
        assert channel.first == first
        assert channel.low <= channel.high
        first += channel.count
    assert first == hover.observation_size
    assert [c.name for c in hover.observation_channels][:2] == ["position_error", "yaw_error"]
    assert hover.observation_channels[0].unit == "m"


def test_info_channels_fill_the_info_row(hover: CompiledScenario) -> None:
    assert sum(c.count for c in hover.info_channels) == hover.info_size


def test_action_channel_has_the_physical_range_of_the_signal(hover: CompiledScenario) -> None:
    (channel,) = hover.action_channels
    assert (channel.robot, channel.name, channel.first, channel.count) == (0, "rotor_speed", 0, 4)
    assert channel.low == [0.0] * 4
    assert all(high > 0 for high in channel.high)


def test_param_info_has_nominal_value_bounds_and_unit(hover: CompiledScenario) -> None:
    path = "robots.quad.links.base_link.mass"
    assert path in hover.param_paths
    nominal, low, high, unit = hover.param_info(path)
    assert low < nominal < high
    assert unit == "kg"
    with pytest.raises(ValueError, match=r"`robots\.quad\.colour`"):
        hover.param_info("robots.quad.colour")


def test_plugins_in_use_have_versions(hover: CompiledScenario) -> None:
    assert set(hover.plugins) >= {"rotor_speed", "hover"}
    assert all(hover.plugins.values())


def test_versions_name_the_library_and_simbody() -> None:
    versions = skybody.versions()
    assert versions["skybody"] == skybody.__version__
    assert versions["simbody"]


def test_overrides_change_values_and_the_hash(hover: CompiledScenario) -> None:
    other = CompiledScenario("hover", ["stepping.horizon=50"])
    assert other.horizon == 50
    assert other.scenario_hash != hover.scenario_hash
    assert other.scenario_text != hover.scenario_text


def test_the_same_scenario_has_the_same_hash_from_its_path(hover: CompiledScenario) -> None:
    again = CompiledScenario(Path(hover.file))
    assert again.scenario_hash == hover.scenario_hash


def test_every_mistake_of_a_scenario_is_named_with_its_place(tmp_path: Path) -> None:
    file = tmp_path / "bad.yaml"
    file.write_text("name: bad\nstepping: {dt: -1, colour: red}\ntask: {plugin: nothing_like_it}\n")
    with pytest.raises(skybody.InputError) as caught:
        CompiledScenario(file)
    text = str(caught.value)
    assert isinstance(caught.value, ValueError)
    assert f"{file}:2:16: error:" in text  # dt
    assert f"{file}:2:20: error:" in text  # colour
    assert f"{file}:3:16: error:" in text  # the plugin
    assert "nothing_like_it" in text


def test_a_scenario_that_is_not_there_is_an_input_error() -> None:
    with pytest.raises(skybody.InputError, match="no_such_scenario"):
        CompiledScenario("no_such_scenario")


def test_an_empty_name_of_a_scenario_is_an_input_error() -> None:
    with pytest.raises(skybody.InputError, match="no scenario is named"):
        CompiledScenario("")


def test_a_plugin_folder_that_is_missing_is_an_error_that_names_it(tmp_path: Path):
    missing = tmp_path / "missing"
    with pytest.raises(skybody.InputError, match=f"{missing}: error: the plugin path names this"):
        CompiledScenario("hover", plugin_path=[missing])


def test_messages_that_quote_bytes_that_are_no_text_are_text(tmp_path: Path) -> None:
    (tmp_path / "r.urdf").write_bytes(b'<robot name="r"><link name="a\xff\x1b[2J"/></robot>')
    (tmp_path / "q.urdf").write_bytes(b'<robot name="r"><link name="a\xff"/></robot>')
    file = tmp_path / "bad.yaml"
    file.write_text(
        "robots: [{name: r, model: r.urdf}, {name: q, model: q.urdf}]\ntask: {plugin: hover}\n"
    )
    with pytest.raises(skybody.InputError) as caught:
        CompiledScenario(file)
    assert r"the control character `\x1b`, which XML forbids" in str(caught.value)
    assert r"the name of this <link>, `a\xff`, holds" in str(caught.value)


def test_an_override_that_is_nested_too_deep_is_an_input_error() -> None:
    with pytest.raises(skybody.InputError, match="nested more than 64 levels deep"):
        CompiledScenario("hover", ["gravity=" + "[" * 100_000])


def test_an_environment_is_pickled_as_what_it_was_loaded_from() -> None:
    compiled = CompiledScenario("hover", ["stepping.horizon=77"])
    copy = pickle.loads(pickle.dumps(compiled))
    assert copy.horizon == 77
    assert copy.scenario_hash == compiled.scenario_hash


def test_shapes_of_bodies_and_obstacles_are_listed_with_sizes_and_poses() -> None:
    obstacles = (
        "[{name: pole, cylinder: [0.2, 3], position: [4, 1, 1.5]},"
        " {name: door, gate: [1, 2, 0.1], position: [7, 0, 2], rpy: [0, 0, 3.141592653589793]}]"
    )
    compiled = CompiledScenario("hover", [f"obstacles={obstacles}"])
    assert [shape.id for shape in compiled.shapes] == list(range(len(compiled.shapes)))
    box = compiled.shapes[0]
    assert (box.kind, box.robot, box.body, box.obstacle) == ("box", "quad", 0, -1)
    assert box.size == (0.3, 0.35, 0.05)
    assert box.position == (0.0, 0.0, 0.005)

    pole, door = compiled.obstacles
    assert (pole.name, pole.kind, pole.size, pole.robot) == ("pole", "cylinder", (0.2, 3.0), None)
    assert (pole.obstacle, door.obstacle) == (0, 1)
    assert pole.position == (4.0, 1.0, 1.5)
    assert (door.kind, door.size) == ("gate", (1.0, 2.0, 0.1))
    assert door.rotation == pytest.approx((0, 0, 0, 1))
    assert compiled.param_paths[pole.first_param] == "obstacles.pole.present"
    assert repr(pole) == "Shape(pole: cylinder [0.2, 3])"


def test_bodies_have_the_names_of_flight_logs() -> None:
    names = CompiledScenario("cooperative_payload").bodies
    assert names == [f"{r}.base_link" for r in ("alpha", "bravo", "charlie")] + ["load.plate"]


def test_a_star_in_a_path_stands_for_nothing_too() -> None:
    ranges = "{what: ['robots.quad.links.base_link.mass*'], range: [0.5, 0.5], form: scale}"
    overrides = [f"randomization=[{{plugin: draw, parameters: {ranges}}}]"]
    pool = skybody.make_pool(CompiledScenario("hover", overrides), 1)
    pool.reset(seed=1)
    path = "robots.quad.links.base_link.mass"
    assert pool.param(0, path) == 0.5 * pool.compiled.param_info(path)[0]
