"""Measured experiments: runs that are wrong on purpose are rejected by the limits that the right ones keep."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import kanefe as kf
from kanefe.checks.verification.case import Reference
from kanefe.checks.verification.references import load_references
from kanefe.tree.stiffening_check import StiffeningWarning
from kanefe_fem import Material, Rectangle, beam_body, straight_beam
from kanefe_fem.verification import experiments


def with_values(name: str, **changes: object) -> Reference:
    reference = load_references()[name]
    return replace(reference, values={**reference.values, **changes})


@pytest.mark.fenicsx
def test_a_blade_of_another_gauge_is_rejected():
    """0.105 inch instead of 0.12, the next gauge of sheet."""
    checks = list(experiments.curved_blade(with_values("X1", thickness=0.105 * 0.0254)))
    assert not any(check.passed for check in checks)


def test_a_rotor_without_centrifugal_stiffening_is_rejected(monkeypatch: pytest.MonkeyPatch):
    def linear(length: float, section: object, basis: int) -> kf.FlexibleBody:
        values = load_references()["X2"].values
        aluminium = Material(E=values["E"] * 6894.757, nu=values["nu"], rho=values["rho"] * 1.06869e7)
        # `Rectangle` is as wide along y as the strip, and as thick along z
        model = straight_beam(length, Rectangle(0.0254, values["thickness"] * 0.0254), aluminium, elements=8)
        return beam_body(model, {"root": "clamped", "tip": "rigid"}, kf.CraigBampton(modes=basis))

    monkeypatch.setattr(experiments, "exact_beam", linear)
    values = {**load_references()["X2"].values, "sweeps": [0]}
    with pytest.warns(StiffeningWarning, match="no stiffening"):
        found = experiments.frequencies_out_of_plane(experiments.swept_rotor(values, 0.0, 750.0), 0.15)
    assert found[0] < 0.5 * values["rotating"]["750"][0][0]


def test_laminates_without_coupling_are_rejected():
    """At 45 degrees, where the twist shows; with the width level the coupling is below the limit."""
    values = load_references()["X3"].values
    laminates = values["laminates"]
    plain = {name: {**one, "couplings": []} for name, one in laminates.items()}
    curve = next(one for one in values["curves"] if one["laminate"] == "[45/0]3s" and one["angle"] == 45)
    for given, passes in ((laminates, True), (plain, False)):
        found, measured = experiments.strip_errors({**values, "laminates": given}, curve)
        assert (np.abs(found - measured).max() <= 0.11) == passes
