"""Recorded flights of real vehicles, beside the engine and other simulators."""
