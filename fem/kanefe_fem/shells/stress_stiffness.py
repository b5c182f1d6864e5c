"""Geometric stiffness of shells: the work of the forces of a static state on the strains of second order.

``1/2 q K_g q = int N : e2 + M : k2 + Q . g2`` with the strains of `kanefe_fem.shells.forms.Surface.second`, in which
directors turn without growing and rotations at the nodes are rotation vectors. Forces come from the strains of the
stiffness, by its rules and its assumed strains, so that a rigid turn of a loaded shell is not resisted, to round-off:
``K_g`` times a turn is the turn of the forces at the nodes. Motions in the surface which assumed strains do not see
have no part: see `kanefe_fem.shells.unresisted`.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from itertools import chain
from typing import Any

import numpy as np
import scipy.sparse as sp

from kanefe.fe_model.model import StressStiffness
from kanefe_fem import _fenicsx
from kanefe_fem.shells.problem import RULES, ShellProblem, blocks_at_nodes
from kanefe_fem.shells.unresisted import unresisted_work


class _Stressed:
    """The cells of one shape under a static displacement; forms are compiled at first use."""

    def __init__(self, problem: ShellProblem) -> None:
        self.problem, self.surface = problem, problem.surface
        ufl = problem.fx.ufl
        self.w, self.v = ufl.TrialFunction(problem.space), ufl.TestFunction(problem.space)

    @cached_property
    def load(self) -> Any:
        """The function with the static displacement."""
        return self.problem.fx.fem.Function(self.problem.space)

    @cached_property
    def _bubble(self) -> tuple[Any, sp.csr_matrix]:
        """The function with the displacement inside triangles, and what makes it of the static one, reversed."""
        one = self.problem
        return one.fx.fem.Function(one.bubble_space), one.bubbles(self.w)[1]

    @cached_property
    def _of_points(self) -> list[Any]:
        """Compiled forms of the forces at the points of each rule."""
        one, surface = self.problem, self.surface
        strains = surface.strains(self.load)
        if one.element.is_simplex:
            inner = surface.strains(self._bubble[0])
            strains = type(strains)(*(x + y for x, y in zip(strains, inner, strict=True)))
        parts = one.energy(strains, surface.second(self.w, self.v))
        return [one.fx.fem.form(parts[name] * one.measure(rule)) for rule, name in enumerate(RULES)]

    @cached_property
    def _of_moments(self) -> tuple[list[tuple[Any, sp.csr_matrix]], Any]:
        """Functions with the forces of assumed strains, what makes them of a displacement, and the compiled form."""
        one = self.problem
        parts = one.assumed(self.v)
        functions = {part: one.of_moments() for part in parts}
        integrand = sum(
            functions[part][i] * density
            for part in parts
            for i, density in enumerate(self.surface.second_moments(self.w, self.v, part))
        )
        made = [(functions[part], forces) for part, (_, forces) in parts.items()]
        return made, one.fx.fem.form(integrand * one.measure(0))

    @cached_property
    def _of_layers(self) -> tuple[Any, Any]:
        """The compiled form of what the curvature adds at a point of each layer, and the function of that point."""
        one, surface = self.problem, self.surface
        layer, height = one.layer()
        flat = surface.strains(self.load), surface.second(self.w, self.v)
        curved = surface.at(height, self.load), surface.second_at(height, self.w, self.v)
        return one.through_thickness(flat, curved, layer), layer

    def matrix(self, u: np.ndarray) -> sp.csr_matrix:
        """Return the geometric stiffness of displacements (n, 6) of all nodes, in their order."""
        one = self.problem
        own = u[one.nodes_of_space].ravel()
        self.load.x.array[:] = own
        if one.element.is_simplex:
            inner, made = self._bubble
            inner.x.array[:] = -(made @ own)
        if one.element.is_simplex:
            return self._integrated(len(u), [])
        made, form = self._of_moments
        of_cells = [(forces @ own).reshape(len(one.cells), -1) for _, forces in made]
        for (function, _), values in zip(made, of_cells, strict=True):
            _fenicsx.put_in_cells(function, values)
        return self._integrated(len(u), [form]) - unresisted_work(one.cells, one.nodes, one.normals, of_cells[0])

    def _integrated(self, count: int, assumed: list[Any]) -> sp.csr_matrix:
        """Return the sum of all forms, with those of assumed strains, in the order of `count` nodes."""
        one = self.problem
        of_layers = one.at_points(*self._of_layers) if one.curved else ()
        total = _fenicsx.assemble_sum(one.fx, chain(self._of_points, assumed, of_layers))
        return blocks_at_nodes(total, one.nodes_of_space, count)


def stress_stiffness(problems: Sequence[ShellProblem], count: int) -> StressStiffness:
    """Return the geometric stiffness (N, N) of the stress of a static displacement, as a function of the latter."""
    stressed = [_Stressed(problem) for problem in problems]

    def geometric_stiffness(displacement: np.ndarray, load: np.ndarray | None = None) -> sp.csr_matrix:
        total = sp.csr_matrix((6 * count, 6 * count))
        for one in stressed:
            with _fenicsx.quiet(), _fenicsx.compiling(one.problem.fx):
                total = total + one.matrix(np.asarray(displacement).reshape(count, 6))
        return total.tocsr()

    return geometric_stiffness
