"""The source of an exact beam: more functions of its strains in place of a finer mesh."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from kanefe.bodies.exact.beam import ExactBeam
from kanefe.bodies.exact.strain_basis import BSpline, Legendre, StrainBasis
from kanefe.bodies.source import Changes, Rebuildable, Source, now_of
from kanefe.errors import ModelError
from kanefe.fe_model.source import Changeable

EXACT = "an exact beam is stiffened by its loads as it is"

NO_ORDER = "an exact beam has functions of its strains in place of elements"


def source_of_beam(make: Callable[..., ExactBeam], basis: Any, options: Mapping[str, Any]) -> Source:
    """Return the source of a beam that ``make(basis=basis, **options)`` makes."""
    options = dict(options)

    def again(body: ExactBeam, changes: Changes) -> ExactBeam:
        own = basis if changes.reduction is None else changes.reduction
        if isinstance(own, str):
            raise ModelError(
                f"reduction={own!r} of an exact beam. Remedy: a number of polynomials, Legendre or BSpline"
            )
        return make(basis=_finer(own, changes.refined), **options)

    def about(body: ExactBeam) -> Rebuildable:
        return replace(
            now_of(body),
            reduction=Changeable(basis),
            stiffening=Changeable("none", EXACT),
            mesh=Changeable(now_of(body).mesh.now, told="refined= doubles the number of functions of each strain"),
            order=Changeable(None, NO_ORDER),
        )

    return Source(again, about)


def _finer(basis: Any, times: int) -> Any:
    """Return functions of which there are twice as many, so many times."""
    if isinstance(basis, Mapping):
        return {name: _finer(one, times) for name, one in basis.items()}
    if not times:
        return basis
    parts = 2**times
    if isinstance(basis, Legendre):
        return Legendre(basis.count * parts)
    if isinstance(basis, BSpline):
        if isinstance(basis.knots, (int, np.integer)):
            return BSpline(basis.degree, int(basis.knots) * parts)
        ends = np.concatenate(([0.0], np.unique(basis.knots), [1.0]))
        within = (ends[:-1, None] + np.diff(ends)[:, None] * np.arange(1, parts) / parts).ravel()
        return BSpline(basis.degree, tuple(np.sort(np.concatenate((basis.knots, within))).tolist()))
    if isinstance(basis, StrainBasis):
        raise ModelError(
            f"the functions {basis!r} of an exact beam have no finer ones that are known. Remedy: reduction=, with them"
        )
    return basis * parts
