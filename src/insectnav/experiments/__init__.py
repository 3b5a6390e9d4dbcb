"""Experiments: simulate, summarise, draw, and leave everything in a folder."""
