"""Measurements of Skybody, and the pages of docs/results and docs that they write."""
