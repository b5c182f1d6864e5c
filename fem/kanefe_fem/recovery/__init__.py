"""Stresses, strains and section forces of a run."""
