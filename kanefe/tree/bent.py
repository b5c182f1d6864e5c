"""Whether a body that stiffens is bent beyond what its second-order displacement holds for."""

from __future__ import annotations

import numpy as np

from kanefe.bodies.inner_rotations import inner_rotations
from kanefe.frames import Matrix, Vector
from kanefe.storage.scipy_later import scipy
from kanefe.tree.bending import LEAST
from kanefe.tree.body_terms import FlexibleTerms, is_unreduced
from kanefe.tree.route import Evaluates


def bent_too_far(route: Evaluates, t: float, q: Vector, u: Vector) -> str:
    """Return, with a remedy, which body is bent so far that a motion has lost its inertia; empty: none is.

    The inertia of second-order displacements is kept to first order in the coordinates, as is their work: this is what
    their stiffening needs. The square that completes it to a sum over mass points is missing, and from some slope
    on there is a motion, of the body and its joints together, whose kinetic energy vanishes.
    """
    flexible = [(body.name, body.flexible) for body in route.model.bodies if body.flexible is not None]
    if any(is_unreduced(terms.body) for _, terms in flexible):
        return ""  # no dense mass matrix
    stiffened = [(name, terms) for name, terms in flexible if terms.free_moments.quadratic_first is not None]
    straight = q.copy()
    for _, terms in stiffened:
        straight[terms.eta] = 0.0
    if not stiffened or not np.all(np.isfinite(q)) or np.array_equal(q, straight):
        return ""
    still = np.zeros_like(u)
    M, at_rest = (_free_mass(route, t, place, still) for place in (q, straight))
    if not np.all(np.isfinite(M)):
        return ""
    try:
        shares, motions = scipy.linalg.eigh(M, at_rest)
    except np.linalg.LinAlgError:
        return ""  # something has no inertia at rest either
    if not len(shares) or shares[0] > LEAST:
        return ""
    sizes = np.sqrt(np.diag(at_rest)) * motions[:, 0]
    own = [float(np.linalg.norm(sizes[terms.speeds])) for _, terms in stiffened]
    name, terms = stiffened[int(np.argmax(own))]
    return (
        f"flexible body {name!r} is bent by {_size(terms, q[terms.eta])}, beyond the valid range of its stiffening: "
        f"a motion has {100 * shares[0]:.2g} % of its inertia at rest. Remedy: divide {name!r} into several flexible "
        "bodies in a chain, so that each bends less; or fewer modes; or stiffening='none' where nothing pulls it "
        "straight"
    )


def _free_mass(route: Evaluates, t: float, q: Vector, u: Vector) -> Matrix:
    n = len(u)
    return route.mass_matrix(t, np.concatenate((q, u, route.model.initial_states)))[:n, :n]


def _size(terms: FlexibleTerms, eta: Vector) -> str:
    inner = inner_rotations(terms.body)
    if inner is None:
        return "nothing"
    place, turned = inner.largest(eta)
    size = np.linalg.norm(turned)
    return f"{size:.2g} of its length" if inner.of_displacements else f"slopes of {size:.2g} rad at {place}"
