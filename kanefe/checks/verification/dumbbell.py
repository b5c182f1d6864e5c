"""Case of a flexible body from matrices, for which the floating-frame equations are exact: two masses and a spring."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from kanefe.checks.verification.case import Case, Check, Reference
from kanefe.checks.verification.scenes import Sample, states_at, zero_crossings
from kanefe.imports.from_matrices import model_from_matrices
from kanefe.joints import Planar
from kanefe.reduction import flexible_body
from kanefe.system import System
from kanefe.tree.body_terms import FlexibleTerms

STIFFNESS, LENGTH, RATE = 100.0, 1.0, 5.0

RTOL = 1e-12


def spinning_dumbbell(reference: Reference) -> Iterator[Check]:
    """E04: two masses joined by a linear bar spin in a plane; the bar stretches by 20 %."""
    row = np.array([1.0, 0.0, -1.0, 0.0])
    nodes = [[-0.5 * LENGTH, 0.0, 0.0], [0.5 * LENGTH, 0.0, 0.0]]
    exact = model_from_matrices(np.eye(4), STIFFNESS * np.outer(row, row), nodes, components=("x", "y"))
    expected = np.array(reference.values["r_rdot_theta"])
    # for nodes that only translate the paper's nodal form is exact as well
    for form, full_model in (("mass field", exact), ("nodal form", replace(exact, mass_field=None))):
        scene = System()
        scene.add_flexible_body("dumbbell", flexible_body(full_model, {}), joint=Planar(rate=RATE))
        model = scene.freeze()
        terms = model.flexible_terms("dumbbell")
        stretch = terms.body.basis[2] - terms.body.basis[0]
        found = np.array(
            [
                (LENGTH + stretch @ q[terms.eta], stretch @ u[terms.speeds], q[2])
                for _, q, u in states_at(model, reference.values["times"], RTOL)
            ]
        )
        for column, quantity in enumerate(("length [m]", "rate of the length [m/s]", "angle [rad]")):
            yield Check.absolute(f"{quantity} to t = 5 s, {form}", found[:, column], expected[:, column], 1e-7)

        def rate(state: Sample, stretch: np.ndarray = stretch, terms: FlexibleTerms = terms) -> float:
            return float(stretch @ state[2][terms.speeds])

        (turn,) = zero_crossings(model, rate, 1, stop=1.0, rtol=RTOL)
        greatest = LENGTH + stretch @ states_at(model, [turn], RTOL)[0][1][terms.eta]
        yield Check.absolute(f"greatest length [m], {form}", greatest, reference.values["r_max"][0], 1e-7)


CASES = (Case("E04", spinning_dumbbell),)
