"""Distributions of draws by randomizers and requests, measured from outside: shape, correlation,
drift.

Every run is keyed, so a test gives the same values each time: a probability of 1e-3 under the
hypothesis cannot cause a failure in a later run.
"""

from __future__ import annotations

import subprocess
from contextlib import closing
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import skybody
from numpy.typing import NDArray
from scipy import stats

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = ROOT / "build/release/bin/skybody"
ENVS, RESETS = 500, 20  # 10^4 draws
LEAST = 1e-3  # significance level
MASS = "robots.quad.links.base_link.mass"
INERTIA = "robots.quad.links.base_link.inertia"
HEIGHT = "robots.quad.start.position[2]"
TURN = "robots.quad.start.turn[2]"
ROTORS = "robots.quad.rotors"
# Draws: the value in the schema's terms, and SciPy's distribution of its ratio to the nominal
# value.
NORMAL = {"distribution": "normal", "mean": 1.0, "deviation": 0.1, "range": [0.85, 1.3]}
DISTRIBUTIONS: dict[str, tuple[dict[str, Any], Any]] = {
    MASS: ({"range": [0.8, 1.3], "form": "scale"}, stats.uniform(0.8, 0.5)),
    f"{ROTORS}[0].tau_up": (
        {"distribution": "log_uniform", "range": [0.2, 5.0], "form": "scale"},
        stats.loguniform(0.2, 5.0),
    ),
    f"{ROTORS}[1].thrust_constant": (
        {**NORMAL, "form": "scale"},
        stats.truncnorm(-1.5, 3.0, loc=1.0, scale=0.1),
    ),
    HEIGHT: ({"range": [0.5, 3.5]}, stats.uniform(0.5, 3.0)),
    TURN: ({"range": [-0.7, 0.7], "form": "shift"}, stats.uniform(-0.7, 1.4)),
    "task.target[0]": ({"range": [-4.0, 4.0]}, stats.uniform(-4.0, 8.0)),
}
FIXED_TARGET = "task.parameters.target=[0, 0, 1, 0]"


def draw(name: str, what: list[str] | str, **parameters: Any) -> str:
    paths = [what] if isinstance(what, str) else what
    words = ", ".join(
        f"{key}: {value if isinstance(value, list) else str(value).lower()}"
        for key, value in parameters.items()
    )
    return f"{{plugin: draw, name: {name}, parameters: {{what: {paths}, {words}}}}}"


def made(randomizers: list[str], envs: int = ENVS, **options: Any) -> Any:
    overrides = [f"randomization=[{', '.join(randomizers)}]", FIXED_TARGET]
    overrides += options.pop("overrides", [])
    return skybody.make_vec("hover", envs, seed=11, infos=False, overrides=overrides, **options)


def values(envs: Any, paths: list[str]) -> NDArray[np.float64]:
    """Drawn values as an array of shape (paths, environments)."""
    return np.stack([np.asarray(envs.state(path)).copy() for path in paths])


def over_resets(envs: Any, paths: list[str], resets: int = RESETS) -> NDArray[np.float64]:
    """Drawn values as an array of shape (paths, draws)."""
    found = []
    for _ in range(resets):
        envs.reset()
        found.append(values(envs, paths))
    return np.concatenate(found, axis=1)


def nominal(envs: Any, path: str, parameters: dict[str, Any]) -> float:
    return envs.compiled.param_info(path)[0] if parameters.get("form") == "scale" else 1.0


def check_distributions(envs: Any, found: NDArray[np.float64]) -> None:
    for row, (path, (parameters, distribution)) in zip(found, DISTRIBUTIONS.items(), strict=True):
        test = stats.kstest(row / nominal(envs, path, parameters), distribution.cdf)
        assert test.pvalue > LEAST, (path, test)
    # Independent: 15 pairs, each within four standard errors.
    correlations = np.corrcoef(found) - np.eye(len(found))
    assert np.abs(correlations).max() < 4.0 / np.sqrt(found.shape[1])


def test_ten_thousand_draws_at_resets_have_their_distributions() -> None:
    randomizers = [
        draw(f"draw{k}", path, **parameters)
        for k, (path, (parameters, _)) in enumerate(DISTRIBUTIONS.items())
    ]
    with closing(made(randomizers)) as envs:
        check_distributions(envs, over_resets(envs, list(DISTRIBUTIONS)))


@pytest.mark.parametrize("when", ["next_step", "next_reset"])
def test_ten_thousand_requested_draws_have_their_distributions(when: Any) -> None:
    with closing(made([])) as envs:
        envs.reset()
        found = []
        for _ in range(RESETS):
            envs.request(
                None, {p: parameters for p, (parameters, _) in DISTRIBUTIONS.items()}, when
            )
            if when == "next_step":
                envs.step(np.zeros(envs.action_space.shape, np.float32))
            else:
                envs.reset()
            found.append(values(envs, list(DISTRIBUTIONS)))
        check_distributions(envs, np.concatenate(found, axis=1))


def test_choices_come_by_their_weights() -> None:
    choice = draw(
        "choice",
        "gravity[2]",
        distribution="choice",
        values=[-9.9, -9.8, -1.6],
        weights=[0.2, 0.5, 0.3],
    )
    with closing(made([choice])) as envs:
        found = over_resets(envs, ["gravity[2]"])[0]
    counts = [np.count_nonzero(found == value) for value in (-9.9, -9.8, -1.6)]
    assert sum(counts) == len(found)
    expected = len(found) * np.array([0.2, 0.5, 0.3])
    assert stats.chisquare(counts, expected).pvalue > LEAST


def test_draws_of_one_name_are_correlated_and_others_are_not() -> None:
    with closing(
        made(
            [
                draw("a", MASS, range=[0.5, 2.0], form="scale", correlated="size"),
                draw(
                    "b",
                    f"{ROTORS}[0].tau_up",
                    distribution="log_uniform",
                    range=[0.5, 2.0],
                    form="scale",
                    correlated="size",
                ),
                draw("c", f"{ROTORS}[1].tau_up", range=[0.5, 2.0], form="scale"),
            ]
        )
    ) as envs:
        found = over_resets(envs, [MASS, f"{ROTORS}[0].tau_up", f"{ROTORS}[1].tau_up"])
    ranks = stats.rankdata(found, axis=1)
    assert stats.spearmanr(ranks[0], ranks[1]).statistic == pytest.approx(1.0, abs=1e-12)
    assert abs(stats.spearmanr(ranks[0], ranks[2]).statistic) < 4.0 / np.sqrt(found.shape[1])


def test_a_shared_draw_is_one_for_all_and_else_all_are_independent() -> None:
    rotors = [f"{ROTORS}[{k}].tau_up" for k in range(4)]
    for shared in (True, False):
        randomizer = draw(
            "tau", f"{ROTORS}[*].tau_up", range=[0.5, 2.0], form="scale", shared=shared
        )
        with closing(made([randomizer])) as envs:
            found = over_resets(envs, rotors)
        if shared:
            assert (found == found[0]).all()
        else:
            correlations = np.corrcoef(found) - np.eye(4)
            assert np.abs(correlations).max() < 4.0 / np.sqrt(found.shape[1])


@pytest.mark.parametrize("way", ["axis by axis", "vehicle_constants"])
def test_drawn_inertias_are_always_physical(way: str) -> None:
    axes = [f"{INERTIA}[{k}]" for k in range(6)]
    randomizer = (
        draw("axes", axes[:3], range=[0.9, 1.1], form="scale")
        if way == "axis by axis"
        else "{plugin: vehicle_constants, parameters: {mass: [0.5, 2], inertia: [0.5, 2]}}"
    )
    with closing(made([randomizer])) as envs:
        found = over_resets(envs, axes)
        redraws = np.asarray(envs.state("redraws"))
    xx, yy, zz, xy, xz, yz = found
    matrices = np.moveaxis(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]), 2, 0)
    moments = np.linalg.eigvalsh(matrices)
    # Round-off of the eigenvalues: 1e-17 kg m^2 compared with 0.03.
    assert (moments[:, 0] + moments[:, 1] >= moments[:, 2] - 1e-15).all()
    assert (moments > 0.0).all()
    assert (redraws.max() > 0) == (way == "axis by axis")


def test_nothing_drifts_over_ten_thousand_resets() -> None:
    path, tau = MASS, f"{ROTORS}[2].tau_down"
    randomizers = [
        draw("mass", path, range=[0.9, 1.1], form="scale"),
        draw("tau", tau, range=[-0.001, 0.001], form="shift", every=3),
    ]
    with closing(made(randomizers, envs=2)) as envs:
        found = over_resets(envs, [path, tau], resets=10_000)
        info = [envs.compiled.param_info(p)[0] for p in (path, tau)]
    first, last = found[0, :4000] / info[0], found[0, -4000:] / info[0]
    assert found[0].min() >= 0.9 * info[0] * (1 - 1e-15) and found[0].max() <= 1.1 * info[0] * (
        1 + 1e-15
    )
    for part in (first, last):
        assert stats.kstest(part, stats.uniform(0.9, 0.2).cdf).pvalue > LEAST
    assert np.abs(found[1] - info[1]).max() <= 0.001 * (1 + 1e-12)
    assert stats.kstest(found[1, ::6] - info[1], stats.uniform(-0.001, 0.002).cdf).pvalue > LEAST


def test_draws_in_time_are_uniform_in_their_window() -> None:
    randomizer = draw("late", MASS, range=[0.5, 0.9], form="scale", when="time", time=[0.01, 0.029])
    envs = 2000
    with closing(made([randomizer], envs=envs)) as vector:
        counts = np.zeros(41, int)
        for _ in range(5):  # 10^4 episodes
            vector.reset()
            before = np.asarray(vector.state(MASS)).copy()
            for step in range(1, 41):
                vector.step(np.zeros(vector.action_space.shape, np.float32))
                now = np.asarray(vector.state(MASS)).copy()
                counts[step] += np.count_nonzero(now != before)
                before = now
    # Drawn before physics step k, visible after it as step k + 1: from 10 ms to 29 ms, 20 equally
    # likely steps.
    assert counts.sum() == 5 * envs
    window = counts[11:31]
    assert window.sum() == 5 * envs
    assert stats.chisquare(window).pvalue > LEAST


def test_what_was_drawn_is_in_the_infos() -> None:
    overrides = [f"infos=[{MASS}, robots.quad.start.position]"]
    with closing(
        skybody.make_vec(
            "hover",
            8,
            seed=1,
            overrides=[
                *overrides,
                f"randomization=[{draw('mass', MASS, range=[0.9, 1.1], form='scale')}]",
            ],
        )
    ) as envs:
        _, infos = envs.reset()
        assert infos[MASS] == pytest.approx(np.asarray(envs.state(MASS)), rel=1e-6)
        assert len(set(infos[MASS].tolist())) == 8
        assert (infos[HEIGHT] == 1.0).all()
        envs.request([2], {MASS: 1.25})
        infos = envs.step(np.zeros(envs.action_space.shape, np.float32))[4]
        assert infos[MASS][2] == 1.25


def test_what_was_drawn_is_in_a_recording_and_is_replayed(tmp_path: Path) -> None:
    file = tmp_path / "run.h5"
    randomizers = [
        draw("mass", MASS, range=[0.9, 1.1], form="scale"),
        draw(
            "late",
            f"{ROTORS}[0].tau_up",
            range=[0.5, 2.0],
            form="scale",
            when="time",
            time=[0, 0.01],
        ),
        draw("height", HEIGHT, range=[1.0, 2.0]),
    ]
    with closing(made(randomizers, envs=4)) as envs:
        envs.record(file, states=True)
        envs.reset()
        envs.request(None, {HEIGHT: {"range": [2.0, 3.0]}}, when="next_reset")
        envs.request(None, {"task.target[1]": {"range": [2.0, 3.0]}})
        for _ in range(20):
            envs.step(np.zeros(envs.action_space.shape, np.float32))
        envs.reset()
        paths = [MASS, f"{ROTORS}[0].tau_up", HEIGHT, "task.target[1]"]
        last = values(envs, paths)
        envs.stop_recording()
    with h5py.File(file) as log:
        names = [name.decode().rstrip("\0") for name in log["state_names"][()]]
        states = log["transitions/state"][()].view(np.float64)
        ids = log["transitions/env_id"][()]
    for path, row in zip(paths, last, strict=True):
        column = states[:, names.index(f"params {path}")]
        assert [column[ids == k][-1] for k in range(4)] == row.tolist()
    done = subprocess.run(
        [str(PROGRAM), "replay", str(file)], capture_output=True, text=True, check=False
    )
    assert done.stdout.startswith("identical"), done.stdout + done.stderr


def test_a_log_tells_draws_in_time_and_starts_that_were_drawn_again(tmp_path: Path) -> None:
    axes = [f"{INERTIA}[{k}]" for k in range(3)]
    randomizers = [
        draw("axes", axes, range=[0.9, 1.1], form="scale"),
        draw("late", MASS, range=[0.9, 1.1], form="scale", when="time", time=[0.01, 0.02]),
    ]
    done = subprocess.run(
        [
            str(PROGRAM),
            "run",
            "hover",
            "--episodes",
            "20",
            "--steps",
            "40",
            "--no-picture",
            "--out",
            str(tmp_path / "log"),
            "--set",
            f"randomization=[{', '.join(randomizers)}]",
        ],
        capture_output=True,
        text=True,
        check=True,
    )
    assert "starts drawn again: " in done.stdout and INERTIA in done.stdout
    with h5py.File(tmp_path / "log/flight.h5") as log:
        texts = [
            [event["text"].decode() for event in episode["events"]]
            for episode in log["episodes"].values()
        ]
    assert any(events[0].startswith("reset, the start drawn again: ") for events in texts)
    for events in texts:
        assert events[1].startswith(f"drawn: {MASS} = ") and len(events) == 3
