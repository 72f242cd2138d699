"""Training on several machines with Ray: `pip install '.[ray]'` in the source folder; docs/ray.md.

`skybody train --ray ADDRESS` trains one policy on many machines, `python -P -m skybody.ray.sweep`
trains many policies, and `skybody.ray.rllib` provides environments for RLlib. Ray itself is
imported only when a cluster is used.
"""
