"""Steps 128 hovering quadrotors at once: `python examples/quickstart.py`."""

import time

import numpy as np
import skybody

envs = skybody.make_vec("hover", num_envs=128, seed=1)
observations, infos = envs.reset()
actions, total, start = np.full((128, 4), 0.21, np.float32), 0.0, time.perf_counter()
for _ in range(10_000):
    observations, rewards, terminations, truncations, infos = envs.step(actions)
    total += rewards.sum()
rate = 128 * 10_000 / (time.perf_counter() - start)
print(f"{rate:,.0f} steps/s, mean reward {total / 1_280_000:.3f}")
