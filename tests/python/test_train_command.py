"""`skybody train` with C++ learners: the same bits after kill -9, one message per mistake."""

from __future__ import annotations

import random
import re
import resource
import shlex
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from skybody.train.checkpoint import checkpoint_folders, read_meta
from skybody.train.run_folder import read_table

pytestmark = pytest.mark.timeout(120)

PROGRAM = Path(__file__).resolve().parents[2] / "build/release/bin/skybody"
LEARNERS = {  # options that make a rollout of 16 environments small
    "fast-ppo": ["rollout_steps=50", "minibatch=200", "hidden=8,8"],
    "gradient": ["rollout_steps=8", "hidden=8,8"],
}
ROLLOUTS = 80

each = pytest.mark.parametrize("algorithm", LEARNERS)


def command(algorithm: str, *more: str) -> list[str]:
    """A run of ROLLOUTS rollouts, with a checkpoint after every second one."""
    rollout = 16 * (50 if algorithm == "fast-ppo" else 8)
    words = ["hover_learn", "--algo", algorithm, "--seed", "3", "--envs", "16"]
    words += ["--total-steps", str(rollout * ROLLOUTS), "--checkpoint-every", str(2 * rollout)]
    words += ["--override", "stepping.horizon=100", "--eval-episodes", "0", "--threads", "1"]
    for setting in LEARNERS[algorithm]:
        words += ["--set", setting]
    return [*words, *more]


def start(words: list[str], folder: Path, **options: Any) -> subprocess.Popen[str]:
    """Starts `skybody train` with these arguments in `folder`."""
    return subprocess.Popen(
        [str(PROGRAM), "train", *words],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={"PATH": "/usr/bin:/bin", "SKYBODY_PYTHON": sys.executable},
        **options,
    )


def train(words: list[str], folder: Path, **options: Any) -> tuple[int, str, str]:
    """Runs it to its end and returns exit status, stdout and stderr."""
    process = start(words, folder, **options)
    out, complaint = process.communicate(timeout=100)
    return process.returncode, out, complaint


def trained(algorithm: str, folder: Path) -> Path:
    """An uninterrupted run."""
    status, _, complaint = train(command(algorithm, "--out", algorithm), folder)
    assert status == 0, complaint
    return folder / algorithm


@pytest.fixture(scope="module")
def whole_run(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """An uninterrupted run, made once."""
    folder = tmp_path_factory.mktemp("whole")

    def run_of(algorithm: str) -> Path:
        run = folder / algorithm
        return run if run.exists() else trained(algorithm, folder)

    return run_of


def final_hash(run: Path) -> str:
    """Hash of the parameters at the end."""
    return str(read_meta(checkpoint_folders(run)[-1])["parameter_hash"])


def wait_for_checkpoints(run: Path, number: int, process: subprocess.Popen[str]) -> None:
    while len(checkpoint_folders(run)) < number:
        assert process.poll() is None, process.communicate()
        time.sleep(0.002)


@each
def test_a_run_killed_at_a_random_moment_ends_with_the_bits_of_one_that_was_not(
    algorithm: str, whole_run: Callable[[str], Path], tmp_path: Path
) -> None:
    whole, killed = whole_run(algorithm), tmp_path / "killed"
    moment = random.Random()
    wanted, pause = moment.randint(1, ROLLOUTS // 8), moment.uniform(0.0, 0.02)
    print(f"killed {pause:.4f} s after checkpoint {wanted}")
    process = start(command(algorithm, "--out", "killed"), tmp_path)
    try:
        wait_for_checkpoints(killed, wanted, process)
        time.sleep(pause)
    finally:
        process.kill()
    process.communicate()
    assert process.returncode == -signal.SIGKILL
    assert len(checkpoint_folders(killed)) < len(checkpoint_folders(whole))

    status, _, complaint = train(["--resume", "--threads", "2", "--out", "killed"], tmp_path)
    assert status == 0, complaint
    assert final_hash(killed) == final_hash(whole)
    steps = [[row["steps"] for row in read_table(run / "progress.csv")] for run in (whole, killed)]
    assert steps[0] == steps[1]
    assert len(steps[0]) >= ROLLOUTS  # `gradient` does not count steps after an episode's end


@each
def test_an_interrupt_writes_a_checkpoint_that_goes_on_with_the_same_bits(
    algorithm: str, whole_run: Callable[[str], Path], tmp_path: Path
) -> None:
    whole, stopped = whole_run(algorithm), tmp_path / "stopped"
    process = start(command(algorithm, "--out", "stopped"), tmp_path)
    wait_for_checkpoints(stopped, 2, process)
    process.send_signal(signal.SIGINT)
    _, complaint = process.communicate()
    assert process.returncode == 130, complaint
    assert "stopping after this rollout, with a checkpoint" in complaint
    assert "Traceback" not in complaint
    newest = read_meta(checkpoint_folders(stopped)[-1])["steps"]
    assert newest == int(read_table(stopped / "progress.csv")[-1]["steps"])
    assert train(["--resume", "--out", "stopped"], tmp_path)[0] == 0
    assert final_hash(stopped) == final_hash(whole)


def test_runs_that_are_told_no_folder_have_one_each_and_say_how_to_fly(tmp_path: Path) -> None:
    (tmp_path / "my plugins").mkdir()
    world = ["--override", "robots.quad.pose.position=[0, 0, 2]", "--plugin-path", "my plugins"]
    short = command("fast-ppo", "--total-steps", "800", *world)
    said = [train(short, tmp_path)[1] for _ in range(2)]
    flights = sorted(folder.name for folder in (tmp_path / "flights").iterdir())
    assert flights == ["hover_learn_fast-ppo", "hover_learn_fast-ppo-2"]
    fly = re.search(r"^fly it +(skybody run .*)$", said[1], re.MULTILINE)
    assert fly is not None, said[1]
    # The command must repeat the overrides and the plugin folders.
    assert "--set 'robots.quad.pose.position=[0, 0, 2]' --plugin-path 'my plugins'" in fly[1]
    words = [*shlex.split(fly[1])[1:], "--no-picture", "--steps", "5"]
    flown = subprocess.run(
        [str(PROGRAM), *words], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert flown.returncode == 0, flown.stderr


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--resume"], "--resume: which run? Name its folder with --out DIR"),
        (["hover_lern"], "did you mean `hover_learn`?"),
        (["hover_learn", "--set", "lerning_rate=1"], "did you mean `learning_rate`?"),
        (["hover_learn", "--set", "total_steps=2e6"], "that is an option, --total-steps 2e6"),
        (["hover_learn", "--set", "discount=2"], "discount = 2: allowed is 0 to 1"),
        (["hover_learn", "--set", "torch_threads=2"], "no hyper-parameter `torch_threads`"),
        (["formation_2", "--algo", "gradient"], "fast-ppo"),
    ],
)
def test_a_mistake_is_one_message_and_leaves_nothing(
    words: list[str], message: str, tmp_path: Path
) -> None:
    status, out, complaint = train(words, tmp_path)
    assert status == 2, complaint
    assert message in complaint
    assert "Traceback" not in complaint
    assert out == ""
    assert list(tmp_path.glob("flights/*")) == []


@each
def test_where_a_file_cannot_be_written_whole_checkpoints_stay_and_the_run_goes_on(
    algorithm: str, whole_run: Callable[[str], Path], tmp_path: Path
) -> None:
    whole = whole_run(algorithm)

    def fill() -> None:
        """Limits the size of files to that of progress.csv after some rollouts."""
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        most = (whole / "progress.csv").stat().st_size // 2
        resource.setrlimit(resource.RLIMIT_FSIZE, (most, resource.RLIM_INFINITY))

    run = ["--out", "full", "--checkpoint-every", "1000000"]
    status, _, complaint = train(command(algorithm, *run), tmp_path, preexec_fn=fill)
    assert status == 2, complaint
    assert "File too large" in complaint
    assert "--resume goes on from the newest checkpoint" in complaint
    assert "Traceback" not in complaint
    assert list((tmp_path / "full" / "checkpoints").glob(".*")) == []
    assert train(["--resume", "--out", "full"], tmp_path)[0] == 0
    assert final_hash(tmp_path / "full") == final_hash(whole)


@pytest.mark.parametrize("name", ["state.npz", "environments.bin", "policy.h5"])
def test_a_damaged_checkpoint_is_refused_by_name_with_the_remedy(
    name: str, whole_run: Callable[[str], Path], tmp_path: Path
) -> None:
    run = shutil.copytree(whole_run("gradient"), tmp_path / "run")
    damaged = checkpoint_folders(run)[-1] / name
    content = bytearray(damaged.read_bytes())
    content[len(content) // 2] ^= 1
    damaged.write_bytes(content)
    more = ["--resume", "--out", "run", "--total-steps", "1e6"]
    status, _, complaint = train(more, tmp_path)
    assert status == 2
    assert f"{name} is damaged" in complaint
    assert "remove this checkpoint's folder" in complaint


@pytest.mark.parametrize("algorithm", [*LEARNERS, "ppo"])
def test_a_learning_rate_beyond_all_reason_is_one_message(algorithm: str, tmp_path: Path) -> None:
    words = ["hover_learn", "--algo", algorithm, "--envs", "16", "--eval-episodes", "0"]
    words += ["--set", "rollout_steps=50", "--set", "hidden=8,8", "--set", "learning_rate=1e30"]
    words += ["--total-steps", "1600"]
    if algorithm != "gradient":
        words += ["--set", "minibatch=200"]
    status, _, complaint = train(words, tmp_path)
    assert status == 2
    assert "learning_rate" in complaint
    assert len(complaint.splitlines()) == 1


def test_a_run_of_ppo_that_diverges_is_one_message(tmp_path: Path) -> None:
    words = ["hover_learn", "--algo", "ppo", "--envs", "16", "--eval-episodes", "0"]
    for setting in ("rollout_steps=20", "minibatch=160", "hidden=8,8", "epochs=100"):
        words += ["--set", setting]
    # The entropy's weight increases the deviation of actions until it overflows a float.
    words += ["--set", "learning_rate=1", "--set", "entropy_weight=100", "--total-steps", "1600"]
    status, _, complaint = train(words, tmp_path)
    assert status == 2
    assert complaint.startswith("error: ppo diverged: the distribution of actions is not finite")
    assert "try a smaller learning_rate" in complaint
    assert len(complaint.splitlines()) == 1
