"""Hilber, Hughes and Taylor's method: generalised-alpha in its earlier form."""

from __future__ import annotations

from kanefe.integrate.methods.generalised_alpha import SPECTRAL_RADIUS, compiled_alpha
from kanefe.integrate.methods.generalised_alpha_formula import GeneralisedAlpha
from kanefe.integrate.methods.method import Method, without_rigid_contacts

METHOD = Method(
    name="hht",
    about="the earlier form of generalised-alpha, of Hilber, Hughes & Taylor",
    stepper=compiled_alpha(GeneralisedAlpha(SPECTRAL_RADIUS, is_hht=True)),
    order=2,
    has_fixed_steps=True,
    serves=without_rigid_contacts,
    keeps_fixed_steps=True,
)
