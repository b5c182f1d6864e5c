"""Geometry of CAD programs, STEP and BREP: what is in it, and meshes from it, by gmsh's OpenCASCADE."""
