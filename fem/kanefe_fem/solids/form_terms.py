"""What a form of the user is made of: functions, measures, and the forms of the materials, in UFL."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any

import numpy as np

from kanefe.errors import ModelError
from kanefe_fem import _fenicsx
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.solids import forms as solid_forms
from kanefe_fem.solids.forms import stiffness_degree
from kanefe_fem.solids.measures import measures
from kanefe_fem.solids.problem import SolidProblem

OfDisplacement = Callable[["FormTerms", Any], Any]
"""Function of the terms and of a displacement that returns UFL."""


class FormTerms:
    """Terms for the forms of a solid, all in the axes of the mesh frame G.

    Attributes
    ----------
    ufl : module
        UFL itself.
    u, v : UFL arguments
        Trial and test displacement, vectors of the dimension of the mesh.
    p, q : UFL arguments
        Trial and test function of the scalar space, for the mass.
    x : UFL expression
        Position, m.
    n : UFL expression
        Outward normal, on facets.
    thickness : float
        Of a plane body in m, whose integrals are over its plane: a factor of each form. 1 of a solid.
    """

    def __init__(
        self,
        problem: SolidProblem,
        mesh: Mesh,
        density: np.ndarray,
        thickness: float,
        stress: OfDisplacement | None = None,
    ) -> None:
        fx, self._problem, self._mesh, self._density = problem.fx, problem, mesh, density
        self.ufl = fx.ufl
        self.u, self.v = fx.ufl.TrialFunction(problem.vector), fx.ufl.TestFunction(problem.vector)
        self.p, self.q = fx.ufl.TrialFunction(problem.scalar), fx.ufl.TestFunction(problem.scalar)
        self.x, self.n = fx.ufl.SpatialCoordinate(problem.mesh), fx.ufl.FacetNormal(problem.mesh)
        self.thickness = thickness
        self._stress = stress

    @cached_property
    def _measures(self) -> tuple[Callable[..., Any], Callable[..., Any]]:
        return measures(self._problem, self._mesh)

    @property
    def dx(self) -> Any:
        """Measure of the whole body: ``f.dx``, or with a degree of quadrature ``f.dx(degree=4)``."""
        return self._problem.fx.ufl.Measure("dx", domain=self._problem.mesh)

    def cells(self, name: str) -> Any:
        """Return the measure of a group of cells."""
        return self._measures[0](name)

    def ds(self, name: str) -> Any:
        """Return the measure of a group of outer facets."""
        return self._measures[1](name)

    def strain(self, u: Any) -> Any:
        """Return the small strain of a displacement, a tensor."""
        return solid_forms.strain(self._problem.fx, u)

    def stress(self, u: Any) -> Any:
        """Return the stress of a displacement in Pa: that of the form `stress`, or of the materials."""
        if self._stress is not None:
            return self._checked(self._stress(self, u))
        return self._problem.stress(u) / self.thickness

    @property
    def stiffness(self) -> Any:
        """Form of the stiffness by `stress`, ``s(u) : e(v)``."""
        integrand = self.thickness * self.ufl.inner(self.stress(self.u), self.strain(self.v))
        if self._stress is not None:
            return integrand * self.dx
        return integrand * self._problem.measure(stiffness_degree(self._problem.element, self._problem.geometry))

    @property
    def mass(self) -> Any:
        """Form of the mass of the materials, ``rho p q``."""
        rho = _fenicsx.cell_function(self._problem.fx, self._problem.mesh, self._density)
        degree = solid_forms.mass_degree(self._problem.element, self._problem.geometry)
        return rho * self.p * self.q * self._problem.measure(degree)

    def _checked(self, stress: Any) -> Any:
        d = self._mesh.dimension
        if getattr(stress, "ufl_shape", None) != (d, d):
            raise ModelError(
                f"the stress of the form is {stress!r}, not a tensor of {d} x {d}. Remedy: return UFL, such as 2 * mu "
                "* f.strain(u)"
            )
        return stress
