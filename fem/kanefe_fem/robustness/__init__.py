"""Stress cases that need finite elements: what ``kanefe stress`` adds where `kanefe_fem` is installed."""

from kanefe_fem.robustness import materials, meshes, spin, unit_systems

CASES = (*meshes.CASES, *materials.CASES, *unit_systems.CASES, *spin.CASES)
