"""Skybody's policies in simulators that share no code with it."""
