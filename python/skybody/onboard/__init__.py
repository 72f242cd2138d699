"""Peers of the program that flies a policy on a vehicle (docs/onboard.md)."""
