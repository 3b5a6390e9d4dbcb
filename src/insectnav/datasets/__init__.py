"""Readers of recorded data; each loader is imported from its own module."""
