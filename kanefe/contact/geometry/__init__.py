"""Shapes that touch: signed distances, meshes and points."""
