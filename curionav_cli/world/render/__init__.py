"""Rendering of a scene: camera, culling, two engines."""
