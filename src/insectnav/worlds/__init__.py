"""Worlds: what stands on the ground, the sky above it, and the light of both."""

from insectnav.worlds.lit_world import Grain, LitWorld, light_world
from insectnav.worlds.mesh_files import read_mesh
from insectnav.worlds.renderer import render_layers, render_panorama
from insectnav.worlds.skyline import skyline
from insectnav.worlds.views import render
from insectnav.worlds.world import World, flat_world, load_world

__all__ = [
    "Grain",
    "LitWorld",
    "World",
    "flat_world",
    "light_world",
    "load_world",
    "read_mesh",
    "render",
    "render_layers",
    "render_panorama",
    "skyline",
]
