"""Robustness cases that need finite elements."""

from robustness.finite_elements import materials, meshes, spin, unit_systems

CASES = (*meshes.CASES, *materials.CASES, *unit_systems.CASES, *spin.CASES)
