"""Makes the files of this folder: run by 0.2.0, in a checkout of its commit d12b77bb.

README.md tells how. Uses `skybody` and the package of that checkout, which must be first on PATH
and PYTHONPATH, and CHECKOUT, its folder, for the headers of the plugin.
"""

import gzip
import hashlib
import json
import os
import shutil
import subprocess
from pathlib import Path

import h5py
import numpy as np
from skybody.train.policy_file import read_policy

HERE = Path(__file__).resolve().parent
TRAINING = (
    "train mission.yaml --algo fast-ppo --seed 3 --out run --total-steps 1200 "
    "--checkpoint-every 600 --eval-episodes 3 --threads 1 --envs 6 --set rollout_steps=50 "
    "--set minibatch=100 --set epochs=2 --set hidden=8,8"
)


def skybody(words: str) -> str:
    """Output of a command."""
    done = subprocess.run(
        ["skybody", *words.split()], cwd=HERE, capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        raise SystemExit(f"skybody {words}: {done.stderr}")
    return done.stdout


def digests(log: Path) -> dict[str, list[object]]:
    """By dataset: its shape, and SHA-256 of its bytes."""
    found = {}
    with h5py.File(log) as file:

        def visit(name: str, item: object) -> None:
            if isinstance(item, h5py.Dataset) and item.dtype.kind in "fiu":
                found[name] = [list(item.shape), hashlib.sha256(item[()].tobytes()).hexdigest()]

        file.visititems(visit)
    return found


def build_plugin(checkout: Path) -> None:
    """The effect of `skybody new effect pull`, as a library for any x86-64."""
    source = (checkout / "plugins/template/effect/NAME.cpp.in").read_text()
    file = HERE / "pull.cpp"
    file.write_text(source.replace("@CLASS@", "Pull").replace("@NAME@", "pull"))
    (HERE / "plugins").mkdir()
    words = "g++ -std=c++20 -Os -fPIC -shared -s -fvisibility=hidden -fvisibility-inlines-hidden"
    flags = [*words.split(), "-ffp-contract=off", f"-I{checkout}", f"-I{checkout}/include"]
    library = HERE / "plugins/pull.so"
    subprocess.run([*flags, str(file), "-o", str(library)], check=True)
    library.chmod(0o644)
    file.unlink()


def main() -> None:
    """Makes all files."""
    for name in ("run", "log", "plugins"):
        shutil.rmtree(HERE / name, ignore_errors=True)
    skybody(TRAINING)
    (HERE / "run/curve.png").unlink()
    first, newest = sorted((HERE / "run/checkpoints").iterdir())
    shutil.rmtree(first)
    shutil.copy(newest / "policy.h5", HERE / "policy.h5")
    skybody("run mission.yaml --policy policy.h5 --steps 40 --no-picture --out log")
    skybody("hash mission.yaml --envs 2 --steps 20 --seed 7 --record recording.h5")
    recording = HERE / "recording.h5"
    (HERE / "recording.h5.gz").write_bytes(gzip.compress(recording.read_bytes(), 9, mtime=0))
    recording.unlink()
    build_plugin(Path(os.environ["CHECKOUT"]))
    policy = read_policy(HERE / "policy.h5")
    with h5py.File(HERE / "log/flight.h5") as file:
        rows = file["episodes/0001/observation"][:]
        paths = [text.decode() for text in file["params/paths"][:]]
        values = file["episodes/0001/params"][:]
        scenario_hash = str(file.attrs["scenario_hash"])
        written = str(file["versions"].attrs.get("skybody", ""))
    facts = {
        "skybody": written,
        "scenario_hash": scenario_hash,
        "observations": rows[:20].astype(float).tolist(),
        "actions": np.asarray(policy(rows[:20].astype(np.float64))).tolist(),
        "log": digests(HERE / "log/flight.h5"),
        "params": dict(zip(paths, values.astype(float).tolist(), strict=True)),
        "hash": skybody("hash mission.yaml --envs 2 --steps 20 --seed 7").split(),
    }
    (HERE / "facts.json").write_text(json.dumps(facts, indent=1) + "\n")


if __name__ == "__main__":
    main()
