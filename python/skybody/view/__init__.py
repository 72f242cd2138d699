"""Flights in a browser: one HTML file that plays them, or a page with a running simulation."""
