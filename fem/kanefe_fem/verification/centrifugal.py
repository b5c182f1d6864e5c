"""Centrifugal statics of a bar (E02a): relative equilibria of a spinning scene, for bars of any elements."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

import numpy as np

from kanefe.bodies.flexible import FlexibleBody
from kanefe.checks.verification import Check, Reference
from kanefe.equations.model import Model
from kanefe.errors import SimulationError
from kanefe.joints import Free, Motion, Revolute
from kanefe.kane.assemble import assemble
from kanefe.kane.coupling import recovered_forces
from kanefe.states.state import State
from kanefe.system import System

LENGTH, RATE, YOUNG, DENSITY, AREA = 2.0, 100.0, 70e9, 2700.0, 1e-3
"""Bar: length, m; angular velocity, rad/s; Young's modulus, Pa; density, kg/m3; area, m2; nu = 0."""

HUB_RADIUS, TIP_MASS = 0.5, 0.1 * DENSITY * AREA * LENGTH

TOLERANCE = 1e-6

Bar = Callable[[Mapping[str, str]], FlexibleBody]
"""Function of the interfaces that makes the unreduced bar from (0, 0, 0) to (LENGTH, 0, 0) with the groups "root" and
"tip"."""


def centrifugal_statics(reference: Reference, bar: Bar, label: str) -> Iterator[Check]:
    """Yield the checks of E02a for one kind of bar, spun about y."""
    values = reference.values
    scene = System()
    clamped = bar({"root": "clamped"})
    scene.add_flexible_body("bar", clamped, joint=Revolute("y", motion=Motion.steady(RATE)))
    model = scene.freeze()
    loaded, balanced = _equilibria(model)
    for name, eta in (("tip_linear", loaded), ("tip_softened", balanced)):
        what = "under the load on the undeformed bar" if name == "tip_linear" else "in equilibrium"
        yield Check.relative(f"tip displacement {what}, {label} [m]", _end(clamped, eta), values[name], TOLERANCE)
    still = np.zeros(model.free_count)
    _, coupling = recovered_forces(State(model, 0.0, np.zeros(model.coordinate_count), still), still)
    # the recovered force balances the share of the load at the root node; the stretched bar transmits the rest;
    # the force points inwards if the bar is in tension
    coupling += clamped.stiffness[clamped.free_count :, : clamped.free_count] @ loaded
    stress = -coupling[0] / AREA
    yield Check.relative(f"root stress of the undeformed bar, {label} [Pa]", stress, values["root_stress"], TOLERANCE)

    scene = System()
    hub = scene.add_rigid_body("hub", mass=1.0, inertia=1.0, joint=Revolute("y", motion=Motion.steady(RATE)))
    scene.add_flexible_body("bar", clamped, parent=hub, at=(HUB_RADIUS, 0.0, 0.0))
    loaded, _ = _equilibria(scene.freeze())
    expected = values["hub_offset_r0p5_linear"]
    quantity = f"tip displacement on a hub of 0.5 m, undeformed load, {label} [m]"
    yield Check.relative(quantity, _end(clamped, loaded), expected, TOLERANCE)

    scene = System()
    carrier = bar({"root": "clamped", "tip": "rigid"})
    member = scene.add_flexible_body("bar", carrier, joint=Revolute("y", motion=Motion.steady(RATE)))
    scene.add_rigid_body("tip", TIP_MASS, parent=member.interface("tip"))
    loaded, _ = _equilibria(scene.freeze())
    expected = values["tipmass_0p1rhoAL_linear"]
    quantity = f"tip displacement with a tip mass, undeformed load, {label} [m]"
    yield Check.relative(quantity, _end(carrier, loaded), expected, TOLERANCE)

    scene = System()
    free = bar({})
    spin = Free(velocity=(0.0, 0.0, -RATE * LENGTH / 2), angular_velocity=(0.0, RATE, 0.0))
    scene.add_flexible_body("bar", free, joint=spin)
    for name, eta in zip(("tip_freefree_half", "tip_freefree_half_softened"), _equilibria(scene.freeze()), strict=True):
        what = "under the undeformed load" if name == "tip_freefree_half" else "in equilibrium"
        half = 0.5 * (_end(free, eta) - _end(free, eta, start=True))
        yield Check.relative(f"half the stretch of the free bar {what}, {label} [m]", half, values[name], TOLERANCE)


def _equilibria(model: Model) -> tuple[np.ndarray, np.ndarray]:
    """Return eta under the load on the undeformed bar, and eta in equilibrium with the load on the deformed bar.

    At rest in the spinning frame the elastic rows are ``F(eta) = load(eta) - K eta``. The derivative of the load is
    about 6e-4 of K, so ``eta += K^-1 F(eta)`` converges quickly; its first step is the first result.
    """
    terms = model.flexible_terms("bar")
    k = terms.body.free_count
    flexibility = np.linalg.inv(terms.body.stiffness[:k, :k])
    q = model.initial_coordinates.copy()
    steps = []
    for _ in range(12):
        _, F = assemble(State(model, 0.0, q, model.initial_speeds))
        steps.append(flexibility @ F[terms.speeds])
        q[terms.eta] += steps[-1]
        # round-off limits the accuracy: K has a condition number of 1e5
        if np.linalg.norm(steps[-1]) <= 1e-10 * np.linalg.norm(q[terms.eta]):
            return steps[0], q[terms.eta]
    raise SimulationError("the spinning bar found no equilibrium. Remedy: report this as an error of kanefe")


def _end(body: FlexibleBody, eta: np.ndarray, start: bool = False) -> float:
    """Return the mean displacement along x of the nodes at the bar's tip, or at its start."""
    at_end = np.abs(body.nodes[:, 0] - (0.0 if start else LENGTH)) < 1e-9 * LENGTH
    return float(body.node_displacements(eta)[at_end, 0].mean())
