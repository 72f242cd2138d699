"""`render()` of environments draws them as they are, and changes nothing."""

from __future__ import annotations

import pickle
import sys
import types
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
import skybody
from gymnasium.utils.env_checker import check_env
from gymnasium.wrappers import RecordVideo
from numpy.typing import NDArray
from skybody.env import SkybodyEnv

SIZE = (96, 54)
PICTURE = (54, 96, 3)


def made(scenario: str = "racing", **more: Any) -> SkybodyEnv:
    return SkybodyEnv(scenario, render_mode="rgb_array", render_size=SIZE, seed=1, **more)


def action(env: Any, step: int) -> NDArray[np.float32]:
    return np.full(env.action_space.shape, 0.3 * np.sin(step), np.float32)


def frame_of(env: SkybodyEnv) -> NDArray[np.uint8]:
    frame = env.render()
    assert frame is not None
    return frame


# --- pictures -----------------------------------------------------------------------------------


def test_a_picture_shows_the_present_state() -> None:
    frames = []
    for _ in range(2):
        env = made()
        env.reset()
        first = frame_of(env)
        np.testing.assert_array_equal(first, frame_of(env))
        for k in range(20):
            env.step(action(env, k))
        frames += [first, frame_of(env)]
    assert first.shape == PICTURE
    assert first.dtype == np.uint8
    assert first.std() > 5.0  # not of one colour
    np.testing.assert_array_equal(frames[0], frames[2])
    np.testing.assert_array_equal(frames[1], frames[3])
    assert np.mean(frames[0] != frames[1]) > 0.01


@pytest.mark.parametrize("scenario", ["racing", "cooperative_payload_ropes", "landing"])
def test_flights_are_the_same_with_pictures_and_without(scenario: str) -> None:
    drawn, plain = made(scenario), SkybodyEnv(scenario, seed=1)
    np.testing.assert_array_equal(drawn.reset()[0], plain.reset()[0])
    for k in range(15):
        drawn.render()
        one, other = drawn.step(action(drawn, k)), plain.step(action(plain, k))
        np.testing.assert_array_equal(one[0], other[0])
        assert one[1:4] == other[1:4]
    assert drawn.save() == plain.save()


def test_the_world_is_drawn_as_the_episode_and_its_parameters_have_it() -> None:
    env = made()
    env.reset()
    first = frame_of(env)
    for k, place in enumerate(env._pool.state("robots.quad.base.position")[0]):
        env.set_param(f"obstacles.gate_1.position[{k}]", place)
    moved = frame_of(env)
    assert np.mean(first != moved) > 0.01
    env.reset()
    env.reset(seed=1)
    np.testing.assert_array_equal(frame_of(env), first)


def test_a_vector_gives_the_picture_of_each_environment() -> None:
    envs = skybody.make_vec(
        "landing", 3, seed=1, render_mode="rgb_array", render_size=SIZE, num_threads=1
    )
    one = made("landing", env_id=2)
    envs.reset()
    one.reset()
    for k in range(4):
        envs.step(action(envs, k))
        one.step(action(one, k))
        frames = envs.render()
        assert frames is not None
        np.testing.assert_array_equal(frames[2], frame_of(one))
    assert [frame.shape for frame in frames] == [PICTURE] * 3
    assert envs.metadata["render_modes"] == ["rgb_array"]
    with pytest.raises(ValueError, match="render_mode is 'human'; it must be one of None, rgb_arr"):
        skybody.make_vec("landing", 3, render_mode="human")


def test_robots_of_pettingzoo_are_drawn() -> None:
    pytest.importorskip("pettingzoo")
    from skybody.multi_agent import ParallelEnv

    env = ParallelEnv("formation_2", seed=1, render_mode="rgb_array", render_size=SIZE)
    env.reset()
    frame = env.render()
    assert frame is not None
    assert frame.shape == PICTURE
    assert env.metadata["render_fps"] == pytest.approx(
        1.0 / (env.compiled.dt * env.compiled.action_repeat)
    )


def test_a_copy_draws_on() -> None:
    env = made()
    env.reset()
    env.render()
    other = pickle.loads(pickle.dumps(env))
    np.testing.assert_array_equal(frame_of(other), frame_of(env))


# --- Gymnasium ----------------------------------------------------------------------------------


def test_gymnasiums_checker_finds_no_fault_in_an_environment_with_pictures(
    recwarn: pytest.WarningsRecorder,
) -> None:
    check_env(made("landing"))
    said = [str(warning.message) for warning in recwarn]
    assert not [text for text in said if "render" in text and "alternative render" not in text]


def test_record_video_records(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    clips = []

    class ImageSequenceClip:  # as far as the wrapper uses MoviePy, whose Pillow is older than ours
        def __init__(self, frames: list[NDArray[np.uint8]], fps: float) -> None:
            clips.append((frames, fps))

        def write_videofile(self, path: str, logger: object) -> None:
            Path(path).touch()

    names = ("moviepy", "moviepy.video", "moviepy.video.io", "moviepy.video.io.ImageSequenceClip")
    for name in names:
        monkeypatch.setitem(sys.modules, name, types.ModuleType(name))
    monkeypatch.setattr(sys.modules[names[-1]], "ImageSequenceClip", ImageSequenceClip, False)
    inner = gymnasium.make("skybody/Landing-v0", render_mode="rgb_array", render_size=SIZE)
    env = RecordVideo(inner, str(tmp_path))
    env.reset(seed=1)
    for k in range(5):
        env.step(action(env, k))
    env.close()
    frames, fps = clips[0]
    assert [frame.shape for frame in frames] == [PICTURE] * 6
    assert fps == 50.0  # dt 2 ms, action_repeat 10
    assert [path.suffix for path in tmp_path.iterdir()] == [".mp4"]


def test_without_a_mode_nothing_is_drawn(recwarn: pytest.WarningsRecorder) -> None:
    env = SkybodyEnv("landing", seed=1)
    env.reset()
    assert env.render() is None
    assert 'give the environment render_mode="rgb_array"' in str(recwarn[-1].message)


# --- windows ------------------------------------------------------------------------------------


class Tk(types.ModuleType):
    """As far as the window uses Tk."""

    TclError = RuntimeError

    def __init__(self) -> None:
        super().__init__("tkinter")
        self.shown: list[bytes] = []
        self.windows = 0

    def Tk(self) -> Tk:
        self.windows += 1
        return self

    def Label(self, *_: Any, **__: Any) -> types.SimpleNamespace:
        return types.SimpleNamespace(pack=lambda: None, configure=lambda image: None)

    def PhotoImage(self, data: bytes, format: str) -> bytes:
        self.shown.append(data)
        return data

    def title(self, text: str) -> None:
        assert text == "landing"

    def resizable(self, *_: bool) -> None: ...
    def protocol(self, *_: Any) -> None: ...
    def update(self) -> None: ...

    def destroy(self) -> None:
        self.windows -= 1


def test_a_window_shows_the_flight(monkeypatch: pytest.MonkeyPatch) -> None:
    tk = Tk()
    monkeypatch.setitem(sys.modules, "tkinter", tk)
    monkeypatch.setenv("DISPLAY", ":0")
    env = SkybodyEnv("landing", render_mode="human", render_size=SIZE, seed=1)
    assert tk.windows == 0  # before the first picture
    env.reset()
    assert tk.windows == 1
    assert tk.shown[0].startswith(b"P6 96 54 255\n")
    for k in range(10):  # 0.2 s of flight
        env.step(action(env, k))
    assert len(tk.shown) > 1
    assert env.render() is None
    env.close()
    assert tk.windows == 0


def test_without_a_display_one_error_names_the_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.delenv("DISPLAY", raising=False)
    with pytest.raises(skybody.Error, match=r"no display .* use render_mode=\"rgb_array\""):
        SkybodyEnv("landing", render_mode="human")
    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setitem(sys.modules, "tkinter", None)
    with pytest.raises(skybody.Error, match="without Tk: `apt install python3-tk`"):
        SkybodyEnv("landing", render_mode="human")


# --- bad input ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"render_mode": "ansi"}, "render_mode is 'ansi'; it must be one of None, human, rgb_arr"),
        ({"render_camera": "drone"}, "render_camera is 'drone'; it must be one of chase, fixed"),
        ({"render_size": (0, 64)}, r"render_size is \(0, 64\); it must be \(width, height\), each"),
        ({"render_size": (64,)}, r"render_size is \(64,\); it must be \(width, height\)"),
    ],
)
def test_wrong_options_are_refused(options: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        SkybodyEnv("landing", **{"render_mode": "rgb_array", **options})


def test_a_picture_before_the_first_episode_is_refused() -> None:
    with pytest.raises(ValueError, match="has not begun an episode: reset it first"):
        made("landing").render()
