"""Meshes: nodes, cells, groups and surfaces as arrays, and their checks."""
