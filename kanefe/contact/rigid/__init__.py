"""Rigid contacts: unilateral constraints with Coulomb's set-valued friction."""
