"""Identifies a vehicle from recorded flights: `skybody identify`; docs/identify.md."""
