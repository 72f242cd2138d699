"""Policies outside of the simulator."""
