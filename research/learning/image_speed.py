"""Steps/s of learning from images: fast-ppo against Stable-Baselines3 on the same environments.

    python -m research run image_speed [--turns 3] [--quick]

`hover_learn` with a sensor that makes a grey image of 64 x 64 bytes at almost no cost
(tests/plugins/image_sensor.cpp), so that the learners are compared and not a renderer. The network
of both: three convolutions, a dense layer of 128 features, two hidden layers. Each measurement runs
in its own process, in turns; the first iteration does not count; PyTorch has one thread and two,
and the better counts. Writes image_speed.md and its JSON. Run it on an otherwise idle machine. Exit
code 1 if a figure misses its goal.
"""

from __future__ import annotations

import multiprocessing
import statistics
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from skybody import CompiledScenario
from skybody.program import ignoring_interrupts
from skybody.train.__main__ import all_versions
from skybody.train.algorithms import algorithm_of
from skybody.train.hyperparameters import with_settings

from research.common.machine import machine_line, versions_line
from research.common.options import Options, heading
from research.common.pages import head, markdown_table, write_page
from research.common.places import ROOT
from research.common.programs import RunError

PAGE = "image_speed"

SCENARIO = "hover_learn"
PLUGINS = ROOT / "build/release/tests/plugins/images"
OVERRIDES = (
    "sensors=[{plugin: image_sensor, name: eye, parameters: {height: 64, width: 64, period: 20}}]",
    "observe=[eye.grey]",
)
CHANNELS, KERNELS, STRIDES, FEATURES = (16, 32, 32), (8, 4, 3), (4, 2, 1), 128
HIDDEN = (64, 64)
ENVS, THREADS = 64, 2
ROLLOUT, ITERATIONS = 32, 4  # steps of a rollout, and iterations that count
QUICK_ROLLOUT, QUICK_ITERATIONS = 4, 1
PATIENCE = 600.0  # s, for one process
LEAST = 5.0  # goal: our steps/s over those of Stable-Baselines3

# What both learners do with a rollout: name, settings of fast-ppo, arguments of PPO and its policy.
Work = tuple[str, dict[str, Any], dict[str, Any], dict[str, Any]]
WORKS: tuple[Work, ...] = (
    ("defaults of each", {}, {}, {}),
    (
        "the same: 5 passes of two networks, minibatches of 1024",
        {"epochs": 5, "value_epochs": 5, "minibatch": 1024},
        {"n_epochs": 5, "batch_size": 1024},
        {"share_features_extractor": False},
    ),
)


def joined(sizes: tuple[int, ...]) -> str:
    """Sizes as a setting."""
    return ",".join(map(str, sizes))


# --- one learner in its own process -------------------------------------------------------------


def learn_ours(settings: dict[str, Any], rollout: int, iterations: int) -> float:
    """Steps/s of fast-ppo."""
    network = {
        "envs": ENVS,
        "rollout_steps": rollout,
        "hidden": joined(HIDDEN),
        "activation": "relu",
        "cnn_channels": joined(CHANNELS),
        "cnn_kernels": joined(KERNELS),
        "cnn_strides": joined(STRIDES),
        "cnn_features": FEATURES,
    }
    row = algorithm_of("fast-ppo")
    settings = {**network, **settings}
    settings["minibatch"] = min(settings.get("minibatch", 1024), ENVS * rollout)
    words = [f"{name}={value}" for name, value in settings.items()]
    hyper = with_settings(row.defaults(), words)
    compiled = CompiledScenario(SCENARIO, list(OVERRIDES), [str(PLUGINS)])
    learner = row.make(compiled, hyper, 1, THREADS, (1 + iterations) * ENVS * rollout)
    learner.iterate()
    begun = time.perf_counter()
    for _ in range(iterations):
        learner.iterate()
    return iterations * ENVS * rollout / (time.perf_counter() - begun)


def learn_theirs(
    threads: int, arguments: dict[str, Any], policy: dict[str, Any], rollout: int, iterations: int
) -> float:
    """Steps/s of Stable-Baselines3."""
    import torch
    from skybody.sb3 import SkybodyVecEnv
    from stable_baselines3 import PPO
    from stable_baselines3.common.torch_layers import BaseFeaturesExtractor

    class Features(BaseFeaturesExtractor):
        """The features of the image, behind the vectors of the observation."""

        def __init__(self, space: Any) -> None:
            vectors = [key for key, box in space.spaces.items() if len(box.shape) == 1]
            super().__init__(space, FEATURES + sum(space[key].shape[0] for key in vectors))
            self.vectors = vectors
            layers: list[torch.nn.Module] = []
            before = 1
            for channels, kernel, stride in zip(CHANNELS, KERNELS, STRIDES, strict=True):
                layers += [torch.nn.Conv2d(before, channels, kernel, stride), torch.nn.ReLU()]
                before = channels
            layers += [torch.nn.Flatten(), torch.nn.LazyLinear(FEATURES), torch.nn.ReLU()]
            self.image = torch.nn.Sequential(*layers)
            self.image(torch.zeros(1, 1, 64, 64))

        def forward(self, observation: dict[str, torch.Tensor]) -> torch.Tensor:
            rows = [observation[key] for key in self.vectors]
            return torch.cat([*rows, self.image(observation["eye_grey"])], dim=1)

    torch.set_num_threads(threads)
    envs = SkybodyVecEnv(
        SCENARIO, ENVS, seed=1, overrides=OVERRIDES, plugin_path=[PLUGINS], num_threads=THREADS
    )
    kinds = {
        "features_extractor_class": Features,
        "net_arch": list(HIDDEN),
        "activation_fn": torch.nn.ReLU,
        **policy,
    }
    model = PPO(
        "MultiInputPolicy", envs, n_steps=rollout, policy_kwargs=kinds, device="cpu", **arguments
    )
    model.learn(ENVS * rollout)
    begun = time.perf_counter()
    model.learn(iterations * ENVS * rollout, reset_num_timesteps=False)
    seconds = time.perf_counter() - begun
    envs.close()
    return iterations * ENVS * rollout / seconds


def _put(
    results: multiprocessing.Queue[float], function: Callable[..., float], *arguments: Any
) -> None:
    results.put(function(*arguments))


def measure(function: Callable[..., float], *arguments: Any) -> float:
    """The result of a function in a new process."""
    context = multiprocessing.get_context("spawn")
    results: multiprocessing.Queue[float] = context.Queue()
    process = context.Process(target=_put, args=(results, function, *arguments))
    with ignoring_interrupts():
        process.start()
    found = results.get(timeout=PATIENCE)
    process.join()
    return found


# --- the comparison -----------------------------------------------------------------------------


def compare(work: Work, turns: int, rollout: int, iterations: int) -> dict[str, Any]:
    """Medians of both learners for one kind of work, in turns."""
    name, settings, arguments, policy = work
    found: dict[str, list[float]] = {"ours": [], "1": [], "2": [], "blind": []}
    for _ in range(turns):
        found["ours"].append(measure(learn_ours, settings, rollout, iterations))
        for threads in (1, 2):
            rate = measure(learn_theirs, threads, arguments, policy, rollout, iterations)
            found[str(threads)].append(rate)
        blind = {**settings, "value_images": "false"}
        found["blind"].append(measure(learn_ours, blind, rollout, iterations))
    rates = {key: statistics.median(values) for key, values in found.items()}
    theirs = max(rates["1"], rates["2"])
    return {
        "work": name,
        "ours": rates["ours"],
        "ours_blind_value": rates["blind"],
        "theirs": theirs,
        "their_threads": 1 if rates["1"] > rates["2"] else 2,
        "ratio": rates["ours"] / theirs,
    }


def markdown(content: dict[str, Any]) -> str:
    """The page."""
    names = (
        "work per rollout | fast-ppo [steps/s] | the same, value function without images | "
        "Stable-Baselines3 | its threads | fast-ppo / Stable-Baselines3"
    )
    rows = [
        [
            row["work"],
            *(f"{row[key]:,.0f}" for key in ("ours", "ours_blind_value", "theirs")),
            row["their_threads"],
            f"{row['ratio']:.1f}",
        ]
        for row in content["rows"]
    ]
    return f"""\
# Speed of learning from images

    {content["command"]}

on {machine_line(content["machine"])}; medians of {content["turns"]} turns.

{markdown_table([head(names), *rows])}

Goal: {LEAST:.0f} times the steps/s of Stable-Baselines3, with the defaults of each.

`{SCENARIO}` with a grey image of 64 x 64 bytes, which costs almost nothing to make: the learners
are compared, not a renderer. Both have {ENVS} environments, rollouts of {ROLLOUT} steps, relu, and
{THREADS} threads for the environments (fast-ppo also learns on them). Both have the same network:
convolutions with {joined(CHANNELS)} channels, kernels {joined(KERNELS)} and strides
{joined(STRIDES)}, a dense layer of {FEATURES} features, then hidden layers {joined(HIDDEN)} on
features and vectors.
By default fast-ppo passes once over a rollout with the policy and five times with the value
function, in minibatches of 1024; Stable-Baselines3 passes ten times with both, in minibatches of
64, and both share the convolutions.

Versions: {versions_line([content])}.
"""


def main(arguments: list[str] | None = None) -> int:
    """Measures, writes; returns the exit code."""
    options = (
        Options(__doc__, __name__, "one turn of short rollouts, defaults only")
        .add("--turns", type=int, default=3, help="turns of each measurement; default: 3")
        .given(arguments)
    )
    options.turns = 1 if options.quick else options.turns
    if options.turns < 1:
        raise RunError(f"--turns {options.turns}: at least 1")
    if not Path(PLUGINS).is_dir():
        raise RunError("the plugin of images is missing: build the target `test_image_sensor`")
    works = WORKS[:1] if options.quick else WORKS
    sizes = (QUICK_ROLLOUT, QUICK_ITERATIONS) if options.quick else (ROLLOUT, ITERATIONS)
    content: dict[str, Any] = {
        **heading("speed of learning from images", options),
        "versions": all_versions(CompiledScenario(SCENARIO), "ppo"),
        "turns": options.turns,
        "rows": [compare(work, options.turns, *sizes) for work in works],
    }
    write_page(options.out, PAGE, markdown(content), content)
    return 0 if options.quick or content["rows"][0]["ratio"] >= LEAST else 1
