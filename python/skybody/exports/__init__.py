"""Flights in formats of other programs: `skybody export`; docs/exports.md."""
