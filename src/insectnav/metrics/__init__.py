"""Measures of how well an animal or a model did; they know of no model."""
