"""More than one machine, by Ray: `pip install '.[ray]'` in the source folder; see docs/ray.md.

`skybody train --ray ADDRESS` trains one policy on many machines, `python -P -m skybody.ray.sweep`
trains many policies, and `skybody.ray.rllib` serves RLlib. Ray itself is imported when a cluster
is asked for.
"""
