"""Hilber, Hughes and Taylor's method: generalised-alpha in its earlier form."""

from __future__ import annotations

from dataclasses import replace

from kanefe.integrate.methods import generalised_alpha_unreduced
from kanefe.integrate.methods.generalised_alpha import SPECTRAL_RADIUS, compiled_alpha
from kanefe.integrate.methods.generalised_alpha_formula import GeneralisedAlpha
from kanefe.integrate.methods.method import Method, without_rigid_contacts

FORMULA = GeneralisedAlpha(SPECTRAL_RADIUS, is_hht=True)

METHOD = Method(
    name="hht",
    about="the earlier form of generalised-alpha, of Hilber, Hughes & Taylor",
    stepper=compiled_alpha(FORMULA),
    order=2,
    has_fixed_steps=True,
    serves=without_rigid_contacts,
    keeps_fixed_steps=True,
)


class UnreducedHHT(generalised_alpha_unreduced.UnreducedStepper):
    """Its steps for scenes with unreduced bodies."""

    formula = FORMULA


UNREDUCED = replace(
    generalised_alpha_unreduced.METHOD,
    name="hht",
    about="the earlier form, for unreduced bodies, factored once per step size",
    stepper=UnreducedHHT,
)
