"""Hilber, Hughes and Taylor's method: generalised-alpha in its earlier form."""

from __future__ import annotations

from functools import partial

from kanefe.integrate.methods.generalised_alpha import SPECTRAL_RADIUS, GeneralisedAlphaStepper
from kanefe.integrate.methods.generalised_alpha_formula import GeneralisedAlpha
from kanefe.integrate.methods.method import Method, no_reactions_or_rigid_contacts

METHOD = Method(
    name="hht",
    about="the earlier form of generalised-alpha, of Hilber, Hughes & Taylor",
    stepper=partial(GeneralisedAlphaStepper, formula=GeneralisedAlpha(SPECTRAL_RADIUS, is_hht=True)),
    order=2,
    has_fixed_steps=True,
    serves=no_reactions_or_rigid_contacts,
)
