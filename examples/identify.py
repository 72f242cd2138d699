"""A vehicle's constants from its flights, with intervals: docs/identify.md.

`python examples/identify.py` flies a Crazyflie whose inertias, lags and drag are off by 20 to 60 %,
with the noise of an IMU, and finds them again from the logs of two flights.
"""

import argparse
import json
import shutil
import subprocess
import sys
from pathlib import Path

import h5py
from skybody.identify.__main__ import main as identify

SCENARIO = """\
name: unknown
stepping: {{dt: 0.001, action_repeat: 2, horizon: 6000}}
robots:
  - name: quad
    model: models/crazyflie/crazyflie.urdf
    pose: {{position: [0, 0, 2]}}
    rotor_speed: hover
    controllers: [{{plugin: reference, parameters: {{kind: lissajous, centre: [0, 0, 2],
      amplitude: {size}, cycles: {cycles}, period: 4, ramp: 1, check: false}}}},
      {{plugin: geometric}}, {{plugin: ctbt}}]
randomization:
  - {{plugin: vehicle_constants, parameters: {{inertia: [1.3, 1.3], tau_up: [1.6, 1.6],
     tau_down: [1.4, 1.4], drag: [0.8, 0.8]}}}}
sensors: [{{plugin: imu, parameters: {{preset: bmi088}}}}]
task: {{plugin: watch, parameters: {{link: base_link}}}}
"""
FLIGHTS = (("[0.06, 0.03, 0.03]", "[4, 6, 5]"), ("[0.3, 0.03, 0.05]", "[2, 7, 4]"))
PATHS = {  # names of the report, and of the log's parameters
    "inertia.x": "links.base_link.inertia[0]", "inertia.y": "links.base_link.inertia[1]",
    "tau_up": "rotors[0].tau_up", "tau_down": "rotors[0].tau_down",
    "drag.rotor": "rotors[0].drag_constant",
}  # fmt: skip

parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
parser.add_argument("--out", type=Path, default=Path("flights/identify"), help="a folder")
folder = parser.parse_args().out
folder.mkdir(parents=True, exist_ok=True)
program = shutil.which("skybody", path=str(Path(sys.executable).parent)) or "skybody"
logs = [folder / f"flight_{k}" for k in range(len(FLIGHTS))]
for log, (size, cycles) in zip(logs, FLIGHTS, strict=True):
    file = log.with_suffix(".yaml")
    file.write_text(SCENARIO.format(size=size, cycles=cycles))
    subprocess.run([program, "run", str(file), "--no-picture", "--out", str(log)], check=True)
options = ["--model", "crazyflie", "--windows", "100", "--out", str(folder / "vehicle")]
if identify([*map(str, logs), *options]) != 0:
    sys.exit(2)
report = json.loads((folder / "vehicle/report.json").read_text())["parameters"]
with h5py.File(logs[0] / "flight.h5") as log:
    names = [path.decode().removeprefix("robots.quad.") for path in log["params/paths"]]
    true = dict(zip(names, log["episodes/0001/params"], strict=True))
for name, path in PATHS.items():
    low, high = report[name]["interval"]
    print(f"{name:10} true {true[path]:.3e}, 95 % interval {low:.3e} to {high:.3e}")
