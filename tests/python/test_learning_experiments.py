"""The scripts behind the pages on learning: counts, extrapolation, accepted and refused files."""

from __future__ import annotations

import dataclasses
import importlib
import json
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from measurements import module

ROOT = Path(__file__).resolve().parents[2]

torch = pytest.importorskip("torch")
control_abstractions = module("control_abstractions")
learner_profile = module("learner_profile")
learning_speed = module("learning_speed")
paper_protocol = module("paper_protocol")
recurrent_policy = module("recurrent_policy")
options = module("options")
pages = module("pages")
page_data = module("page_data")
rl_tools = module("rl_tools")
gradient_choices = module("gradient_choices")
training_runs = module("training_runs")
algorithms = importlib.import_module("skybody.train.algorithms")
ALGORITHMS, algorithm_of = algorithms.ALGORITHMS, algorithms.algorithm_of


@pytest.mark.parametrize("sizes", [(22, 64, 64, 4), (700, 512, 512, 4), (5, 3)])
def test_operations_of_a_network_are_those_that_pytorch_counts(sizes: tuple[int, ...]) -> None:
    from torch.utils.flop_counter import FlopCounterMode

    layers = [torch.nn.Linear(a, b, bias=False) for a, b in pairwise(sizes)]
    counter = FlopCounterMode(display=False)
    with counter:
        torch.nn.Sequential(*layers)(torch.zeros(8, sizes[0])).sum().backward()
    assert counter.get_total_flops() == 8 * learner_profile.operations(sizes)


def test_rates_are_read_by_network_and_row(tmp_path: Path) -> None:
    program = tmp_path / "bench_learn"
    program.write_text(
        "#!/bin/sh\n"
        "echo '22-64-64-4, 1024 rows   forward   with backward'\n"
        "echo '  ours, v4         64.6 ns   178.4 GFLOP/s     163.6 ns   194.0 GFLOP/s'\n"
        "echo '  Eigen, products alone  67.0 ns   171.9 GFLOP/s 193.4 ns   164.1 GFLOP/s'\n"
        "echo '22-GRU 64-64-4, 32 sequences of 32 steps (v4): forward 217.2 ns'\n"
    )
    program.chmod(0o755)
    assert learner_profile.bare_products(program) == {
        "22-64-64-4": {"ours, v4": 194.0, "Eigen, products alone": 164.1}
    }


def test_a_program_that_fails_is_an_error_with_its_name(tmp_path: Path) -> None:
    program = tmp_path / "bench_learn"
    program.write_text("#!/bin/sh\necho broken >&2\nexit 3\n")
    program.chmod(0o755)
    with pytest.raises(
        learner_profile.RunError, match=r"bench_learn failed \(exit code 3\)\nbroken"
    ):
        learner_profile.bare_products(program)


def test_hyper_parameters_of_a_page_are_those_of_preset_and_command_line_alone() -> None:
    defaults = algorithm_of("fast-ppo").defaults()
    hyper = dataclasses.asdict(
        dataclasses.replace(defaults, bounded_mean=True, hidden=(128, 64), discount=0.98)
    )
    config = json.loads(json.dumps({"algorithm": "fast-ppo", "hyper": hyper}))
    assert sorted(training_runs.changed_hyper(config)) == [
        "bounded_mean=true",
        "discount=0.98",
        "hidden=128,64",
    ]


def test_figures_of_gradient_are_those_of_its_last_look() -> None:
    look = (
        "update {} steps {}  {} s of process  cost 0.5 gradient_norm 1e-05 error 0.20 m faults 0 "
        "| median {} m p90 0.0500 m failures {} of 100 return -7.5\n"
    )
    output = "ready after 0.250 s\n" + look.format("  20", " 1000", "1.000", "0.5000", 9)
    output += look.format("  40", "2000", "2.250", "0.0125", 3) + "hash 00ff\n"
    assert gradient_choices.read_figures(output) == {
        "steps": 2000,
        "seconds": 2.0,
        "median": 0.0125,
        "worst_tenth": 0.05,
        "failures": 3,
        "episodes": 100,
        "mean_return": -7.5,
    }
    with pytest.raises(gradient_choices.RunError, match="printed no figures"):
        gradient_choices.read_figures("ready after 0.250 s\n")


def test_a_folder_without_rl_tools_is_refused_with_the_remedy(tmp_path: Path) -> None:
    with pytest.raises(rl_tools.RunError, match=r"git clone https://github\.com/rl-tools"):
        rl_tools.check(tmp_path)


def test_a_limit_is_reached_by_the_first_checkpoint_that_neither_errs_nor_fails() -> None:
    points = [
        {"seconds": 1.0, "median_error": 0.05, "success_share": 0.9},
        {"seconds": 2.0, "median_error": 0.2, "success_share": 1.0},
        {"seconds": 3.0, "median_error": 0.05, "success_share": 0.98},
    ]
    assert learning_speed.reached(points, 0.1) == 3.0
    assert learning_speed.reached(points, 0.01) is None


def test_one_seed_that_does_not_arrive_leaves_the_learner_without_a_time() -> None:
    assert learning_speed.slowest([1.0, 3.0]) == 3.0
    assert learning_speed.slowest([1.0, None]) is None


def test_a_cut_run_is_extrapolated_at_the_slowest_rate_between_its_checkpoints(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    # Two runs; the first checkpoint includes start-up time, which the rate must exclude.
    metas: dict[str, dict[str, Any]] = {
        "a1": {"steps": 1_000_000, "wall_clock": 110.0, "parameter_hash": "x"},
        "a2": {"steps": 2_000_000, "wall_clock": 210.0, "parameter_hash": "x"},
        "b1": {"steps": 1_000_000, "wall_clock": 210.0, "parameter_hash": "y"},
        "b2": {"steps": 2_000_000, "wall_clock": 410.0, "parameter_hash": "y"},
    }
    folders = lambda run: [run / f"{run.name}1", run / f"{run.name}2"]  # noqa: E731
    monkeypatch.setattr(paper_protocol, "checkpoint_folders", folders)
    monkeypatch.setattr(paper_protocol, "read_meta", lambda folder: metas[folder.name])
    runs = paper_protocol.make_runs("hover", "fast-ppo", tmp_path, 2_000_000)[:2]
    for run, name in zip(runs, "ab", strict=True):
        object.__setattr__(run, "folder", tmp_path / name)
    found = paper_protocol.figures(runs)
    assert found["seconds"] == 410.0
    assert found["steps_per_second"] == pytest.approx(4_000_000 / 410.0, rel=1e-12)
    assert found["minutes_for_all"] == pytest.approx((410.0 + 3.0 * 200.0) / 60.0, rel=1e-12)
    assert found["extrapolated"]


def test_a_whole_run_is_not_extrapolated(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    meta = {"steps": 5_000_000, "wall_clock": 60.0, "parameter_hash": "x"}
    monkeypatch.setattr(paper_protocol, "checkpoint_folders", lambda _: [tmp_path])
    monkeypatch.setattr(paper_protocol, "read_meta", lambda _: meta)
    found = paper_protocol.figures(paper_protocol.make_runs("hover", "ppo", tmp_path, 5_000_000))
    assert not found["extrapolated"]
    assert found["minutes_for_all"] == 1.0


def test_no_preset_is_part_of_the_papers_study(tmp_path: Path) -> None:
    for algorithm in ("ppo", "fast-ppo"):
        (run, *_) = paper_protocol.make_runs("racing", algorithm, tmp_path, 5_000_000)
        told = {setting.split("=")[0] for setting in run.settings}
        assert told == set(vars(ALGORITHMS[algorithm].defaults()))


def test_rows_of_earlier_runs_keep_their_machine() -> None:
    row = {"task": "hover", "learner": "ppo", "machine": {"processor": "old"}}
    earlier = [row, {**row, "learner": "fast-ppo"}]
    new = {**row, "machine": {"processor": "new"}}
    found = paper_protocol.merged(earlier, [new])
    assert [(r["learner"], r["machine"]["processor"]) for r in found] == [
        ("fast-ppo", "old"),
        ("ppo", "new"),
    ]


def protocol_row(task: str, flown: dict[str, Any] | None = None) -> dict[str, Any]:
    """A row of the paper's protocol with a curve of two points."""
    course = {"steps": [1e6, 2e6], "return": [None, 9.0], "error": [3.0, 1.0]}
    row = {"task": task, "learner": "fast-ppo", "seed": 1, "transitions": 2_000_000}
    return {**row, "curve": course, "command": "c"} | ({} if flown is None else {"flown": flown})


def test_a_protocol_curve_is_of_whole_blocks_and_tells_what_is_unknown(tmp_path: Path) -> None:
    lines = ["steps,recent_return_mean,position_error", "10,nan,4", "20,1,2", "30,3,2"]
    (tmp_path / "progress.csv").write_text("\n".join(lines) + "\n")
    (run, *_) = paper_protocol.make_runs("hover", "fast-ppo", tmp_path, 5_000_000, [1])
    object.__setattr__(run, "folder", tmp_path)
    found = paper_protocol.curve(run)
    assert found == {"steps": [10, 20, 30], "return": [None, 1, 3], "error": [4, 2, 2]}


def test_the_protocols_page_tells_what_held_out_flights_did(tmp_path: Path) -> None:
    flown = {"episodes": 100, "succeeded": 7, "failed": 2, "median_error": 0.5}
    rows = [protocol_row("payload_paper", flown), protocol_row("hover")]
    text = paper_protocol.learned_section(rows)
    assert (
        "| `payload_paper` | fast-ppo | 1 | 2,000,000 | -, 9 | 3, 1 | 7 of 100 | 2 | 0.500" in text
    )
    assert "| `hover` | fast-ppo | 1 | 2,000,000 | -, 9 | 3, 1 | - | - | - |" in text
    paper_protocol.draw(rows, tmp_path / "picture.png")
    assert (tmp_path / "picture.png").read_bytes().startswith(b"\x89PNG")


def test_a_protocol_without_curves_has_no_section_on_learning() -> None:
    assert paper_protocol.learned_section([]) == ""


# --- forms of control -----------------------------------------------------------------------------


def arrivals(form: str, steps: list[float | None]) -> list[dict[str, Any]]:
    """Records of `payload`, one for each seed."""
    base = {"task": "payload", "form": form, "total_steps": 100.0}
    return [{**base, "steps": {"1": one}} for one in steps]


def test_who_does_not_get_below_the_threshold_counts_with_all_steps() -> None:
    records = [*arrivals("end-to-end", [20.0, None]), *arrivals("modular", [10.0, 30.0])]
    found = control_abstractions.compare(records, "payload", 1.0)
    assert found["forms"]["end-to-end"]["mean"] == 60.0
    assert found["forms"]["end-to-end"]["arrived"] == 1
    assert found["ratio"] == 3.0
    assert "too few" in control_abstractions.verdict(found)


def test_four_seeds_that_mingle_tell_no_difference_whatever_the_bootstrap_says() -> None:
    records = [
        *arrivals("end-to-end", [10.0, 12.0, 13.0, 20.0]),
        *arrivals("modular", [18.0, 19.0, 20.0, 22.0]),
    ]
    found = control_abstractions.compare(records, "payload", 1.0)
    assert found["ratio_interval"][1] < 1.0
    assert "no difference can be told" in control_abstractions.verdict(found)


@pytest.mark.parametrize(
    ("end_to_end", "said"),
    [
        ([50.0, 51.0, 52.0, 53.0, 54.0], "modular control learns sooner"),
        ([5.0, 5.1, 5.2, 5.3, 5.4], "end-to-end control learns sooner"),
        ([9.0, 10.0, 20.0, 30.0, 31.0], "no difference can be told"),
    ],
)
def test_a_form_learns_sooner_where_the_whole_interval_says_so(
    end_to_end: list[float | None], said: str
) -> None:
    modular = arrivals("modular", [18.0, 19.0, 20.0, 21.0, 22.0])
    records = [*arrivals("end-to-end", end_to_end), *modular]
    assert said in control_abstractions.verdict(
        control_abstractions.compare(records, "payload", 1.0)
    )


@pytest.mark.parametrize("task", list(control_abstractions.TASKS))
def test_both_forms_are_trained_alike(task: str) -> None:
    control_abstractions.require_like_presets(task)


# --- memory ---------------------------------------------------------------------------------------


def seeds(near: list[int], medians: list[float]) -> list[dict[str, Any]]:
    """Rows of one kind of policy, 100 flights each."""
    pairs = zip(near, medians, strict=True)
    return [{"near": n, "episodes": 100, "median_error": error} for n, error in pairs]


@pytest.mark.parametrize(
    ("remembers", "forgets", "said"),
    [
        ([95, 96], [79, 85], "More arrive"),
        ([79, 85], [95, 96], "Fewer arrive"),
        ([95, 97], [94, 96], "Of how many arrive no difference can be told"),
        ([97, 96], [95, 94], "Of how many arrive no difference can be told"),
    ],
)
def test_more_arrive_where_all_seeds_say_so_by_two_standard_errors(
    remembers: list[int], forgets: list[int], said: str
) -> None:
    assert said in recurrent_policy.arriving(
        seeds(remembers, [0.1, 0.1]), seeds(forgets, [0.1] * 2)
    )


@pytest.mark.parametrize(
    ("remembers", "forgets", "said"),
    [
        ([0.01, 0.02], [0.03, 0.04], "nearer with it"),
        ([0.03, 0.04], [0.01, 0.02], "farther off with it"),
        ([0.01, 0.03], [0.02, 0.04], "no difference can be told"),
    ],
)
def test_the_median_vehicle_is_nearer_where_all_seeds_say_so(
    remembers: list[float], forgets: list[float], said: str
) -> None:
    assert said in recurrent_policy.erring(seeds([9, 9], remembers), seeds([9, 9], forgets))


@pytest.mark.parametrize(
    ("remembers", "forgets", "said"),
    [
        ([0.01, 0.02], [0.03, 0.04], "memory helps in 1 of 1 comparisons and does harm in 0"),
        ([0.03, 0.04], [0.01, 0.02], "memory helps in 0 of 1 comparisons and does harm in 1"),
        ([0.01, 0.03], [0.02, 0.04], "No effect of memory can be told with 2 seeds"),
    ],
)
def test_the_page_begins_with_how_often_memory_helps(
    remembers: list[float], forgets: list[float], said: str
) -> None:
    rows = [
        {**row, "task": "hover", "policy": f"{name}, sees no actions", "seed": seed}
        for name, medians in (("memory", remembers), ("no memory", forgets))
        for seed, row in enumerate(seeds([9, 9], medians))
    ]
    assert said in recurrent_policy.answer(rows, [("hover", False)])


# --- pages ----------------------------------------------------------------------------------------


def test_a_page_is_written_beside_the_data_that_it_was_made_of(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    given = options.Options("", "trial").given(["--quick", "--out", str(tmp_path)])
    content = options.heading("a trial", given)
    assert (content["experiment"], content["command"]) == (
        "a trial",
        f"python -m research run trial --quick --out {tmp_path}",
    )
    pages.write_page(tmp_path, "trial", "# A trial\n\nText.\n", content)
    assert json.loads((tmp_path / "data/trial.json").read_text()) == content
    page = (tmp_path / "trial.md").read_text()
    assert page_data.stamp_of(page)["date"]
    assert page_data.body(page) == "# A trial\n\nText.\n"
    assert "Text.\n\nwritten: " in capsys.readouterr().out


@pytest.mark.parametrize("script", [control_abstractions, recurrent_policy])
def test_the_page_is_what_the_figures_make_of_it(script: Any) -> None:
    name = Path(script.__file__).stem
    content = json.loads((ROOT / f"docs/results/data/{name}.json").read_text())
    text = (ROOT / f"docs/results/{name}.md").read_text()
    assert script.markdown(content) == page_data.body(text)
