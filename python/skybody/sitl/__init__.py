"""Autopilots in the loop: ArduPilot, PX4 and Betaflight fly a scenario's robot in lockstep.

docs/sitl.md has the commands, frames, motor orders and ranges.
"""
