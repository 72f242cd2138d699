"""A policy as ONNX and as C: flown by ONNX Runtime, compiled by cc.

`python examples/export_policy.py` writes both into the folder --out (docs/export_policy.md).
"""

import argparse
import subprocess
from pathlib import Path

import numpy as np
import onnxruntime
import skybody
from skybody.exports.__main__ import main as export

SCENARIO, ENVS = "landing", 16
MAIN = f"""#include <stdio.h>
#include "{SCENARIO}.h"
int main(void) {{
  int same = {SCENARIO}_self_test({SCENARIO.upper()}_SELF_TEST_STEPS)
             == {SCENARIO.upper()}_SELF_TEST_HASH;
  puts(same ? "C: the bits of the simulator" : "C: other bits");
  return !same;
}}
"""

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--out", type=Path, default=Path("policy"), help="a new folder")
folder = parser.parse_args().out
for kind, path in (("onnx", folder / "policy.onnx"), ("c", folder / "c")):
    export(["shipped", "--scenario", SCENARIO, "--to", kind, "-o", str(path)])

(folder / "main.c").write_text(MAIN)
sources = [str(folder / "main.c"), str(folder / f"c/{SCENARIO}.c")]
flags = ["-std=c99", "-O2", f"-D{SCENARIO.upper()}_SELF_TEST", f"-I{folder / 'c'}"]
subprocess.run(["cc", *flags, *sources, "-o", str(folder / "main")], check=True)
subprocess.run([str(folder / "main")], check=True)

session = onnxruntime.InferenceSession(folder / "policy.onnx")
envs = skybody.make_vec(SCENARIO, ENVS, seed=1, dict_observations=True)
observations, _ = envs.reset()
ended, succeeded = np.zeros(ENVS, bool), np.zeros(ENVS, bool)
while not ended.all():
    # An input `past_NAME` is the column NAME of earlier actions.
    feed = {i.name: observations[i.name.removeprefix("past_")] for i in session.get_inputs()}
    (actions,) = session.run(["action"], feed)
    observations, _, terminations, truncations, infos = envs.step(actions)
    done = (terminations | truncations) & ~ended
    succeeded |= done & (infos["success"] > 0)
    ended |= done
print(f"ONNX Runtime: {succeeded.sum()} of {ENVS} flights succeed")
