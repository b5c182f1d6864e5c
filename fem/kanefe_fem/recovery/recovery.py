"""Recovery: displacement, strain and stress of a flexible body at the times of a run, or as an envelope over them.

``stress = sum_i eta_i(t) s_i`` with the stress modes ``s_i = C : sym grad psi_i``, computed once per body. This is the
mode-displacement method: it gives the stress of the kept modes and misses the quasi-static part of the modes that the
reduction dropped. This part matters near concentrated loads, and for loads whose static deformation is not spanned by
the kept modes. Remedies: more modes, or a reduction with the static shapes of the loads (load-dependent vectors).
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, cast

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import AccuracyWarning, ModelError, outside
from kanefe.instants.instant import Instant
from kanefe.results.reader import Reader
from kanefe.results.selection import Frames, frame_index
from kanefe_fem.recovery.choices import material_row, nearest_frames
from kanefe_fem.recovery.fibre_stress import ENDS, normal_stress
from kanefe_fem.recovery.fields_at_times import Face, FieldsAtTimes
from kanefe_fem.recovery.gauges import gauge_strains, rosette_directions
from kanefe_fem.recovery.joined_fields import JoinedFields
from kanefe_fem.recovery.rib_fields import RibFields
from kanefe_fem.recovery.scalars import Scalar
from kanefe_fem.recovery.section_forces import section_forces, stations_of
from kanefe_fem.recovery.shell_fields import ShellStrainFields
from kanefe_fem.recovery.vtk_arrays import shell_vtk_arrays, vtk_arrays

if TYPE_CHECKING:
    from kanefe_fem.recovery.expressions import ExpressionTerms
    from kanefe_fem.recovery.section_forces import SectionForces
    from kanefe_fem.recovery.shell_forces import ShellForces


@checked("name", "face", "ply")
def recover(
    result: Reader | Instant,
    name: str,
    *,
    times: Sequence[float] | np.ndarray | None = None,
    frames: Frames | None = None,
    material: int | str | None = None,
    face: Face | None = None,
    ply: int | None = None,
) -> Recovery:
    """Return the fields of a flexible body in a run; each is computed on demand.

    Parameters
    ----------
    result : Result, Equilibrium or Instant
        Result of a run, or read from a file. For a result at one time the first axis of the fields has length one.
    name : str
        Name of the body.
    times : sequence of float, optional
        Times in s; the nearest output times are taken (`Recovery.times`). Default: all output times.
    frames : int, slice or sequence of int, optional
        Indices of output times, instead of `times`.
    material : int or str, optional
        Row of the body's table of moduli, or the group of cells that has it, or the name of stiffeners of a shell. Only
        its cells are used, and values at nodes elsewhere are NaN. Without it, stresses at nodes between two materials
        are means over both sides, and scalars of a shell with stiffeners and solids are the worst of all at each node.
    face : {"top", "bottom", "middle"}, optional
        Of a shell, or of its ply: "top" is where the normal points. Without it scalars, such as `Recovery.von_mises`
        and `Recovery.envelope`, are the worst of all faces and middles through the thickness.
    ply : int, optional
        Number of a ply of a laminate, from 0 at the bottom.

    Returns
    -------
    Recovery

    Raises
    ------
    ModelError
        If the body is rigid, a time or frame was not stored, or there is no such material.

    Examples
    --------
    >>> import kanefe_fem
    >>> fields = kanefe_fem.recover(result, "arm", times=[0.1, 0.2])         # doctest: +SKIP
    >>> fields.von_mises.shape                                              # doctest: +SKIP
    (2, 4406)
    >>> kanefe_fem.recover(result, "arm").envelope("von_mises").peak         # doctest: +SKIP
    """
    if isinstance(result, Instant):
        result = result.history
    if not hasattr(result, "modal_coordinates"):
        raise ModelError(f"result must be a Result, an Instant or a file that load_result reads, not {result!r}")
    shape = result.body(name)
    eta = result.modal_coordinates(name)  # refuses a rigid body by name
    if times is not None and frames is not None:
        raise ModelError("give times= or frames=, not both")
    chosen = frame_index(frames, len(result.times)) if times is None else nearest_frames(result.times, times)
    rows = np.atleast_1d(np.arange(len(result.times))[chosen])
    row = None if material is None else material_row(name, shape, material)
    own = shape.elasticity
    is_shell = own is not None and own.shell is not None and (row is None or row < len(own.shell.forces))
    if (face is not None or ply is not None) and not is_shell:
        what = repr(name) if material is None else f"material={material!r} of {name!r}"
        raise ModelError(f"{what} is no shell and has no face or ply. Remedy: leave out face= and ply=")
    if own is not None and own.ribs is not None and not own.ribs.has_shape.all():
        known = zip(shape.provenance["stiffeners"], own.ribs.has_shape, strict=True)
        unknown = ", ".join(rib for rib, is_known in known if not is_known)
        warnings.warn(
            f"the sections of the stiffeners {unknown} of {name!r} have constants but no shape: stresses leave their "
            "fibres out. Remedy: Rectangle, Box, Tube or SolidCircle, or section_forces()",
            AccuracyWarning,
            stacklevel=outside(),
        )
    if f"relaxation of {name}" in result.loads:
        warnings.warn(
            f"stresses of the viscoelastic body {name!r} are those of its long-term moduli: what its arms carry while "
            "they relax is left out. Remedy: none is needed where motions are slow against the relaxation times",
            AccuracyWarning,
            stacklevel=outside(),
        )
    return Recovery(result, name, rows, eta[rows], row, (face, ply))


class Recovery(FieldsAtTimes):
    """Fields, gauges, section forces and pictures of a flexible body at output times of a run, made by `recover`."""

    def segments(self) -> list[Recovery]:
        """Return the fields of each segment of a segmented body.

        Its own fields are those of the whole. Stresses are in the frames of the segments, whose undeformed axes are
        those of the whole; nodes of cuts have them from the side of the base, and after all nodes from the other side.
        """
        names = self.result.segmented.get(self.name, (self.name,))
        made = []
        for name in names:
            eta = self.result.modal_coordinates(name)[self.frames]
            made.append(Recovery(self.result, name, self.frames, eta, self.material, self.level))
        return made

    def gauge(self, position: Sequence[float] | np.ndarray, direction: Sequence[float] | np.ndarray) -> np.ndarray:
        """Return the history of a strain gauge, shape (T,).

        Parameters
        ----------
        position : array_like, shape (3,)
            Position of the gauge in G, m: on the mesh, or off it by at most a tenth of a cell (curved surfaces). On a
            shell it may be on the mesh, if a face was chosen, or on the face itself, which then needs no choice.
        direction : array_like, shape (3,)
            Direction of measurement in G, of any length.

        Raises
        ------
        ModelError
            If the position is not on the mesh, or the direction is zero.

        Examples
        --------
        ``recover(result, "arm").gauge((0.05, 0.0, 0.02), (1, 0, 0))``
        """
        return gauge_strains(self._fields(), self.eta, position, [direction], self.material)[:, 0]

    def rosette(
        self,
        position: Sequence[float] | np.ndarray,
        direction: Sequence[float] | np.ndarray,
        normal: Sequence[float] | np.ndarray,
        angles: Sequence[float] = (0.0, np.pi / 4, np.pi / 2),
    ) -> np.ndarray:
        """Return the histories of the gauges of a rosette, shape (T, gauges).

        Parameters
        ----------
        position : array_like, shape (3,)
            Position in G, m.
        direction : array_like, shape (3,)
            Direction of the angle zero, in G, projected onto the surface.
        normal : array_like, shape (3,)
            Outward normal of the surface in G, the right-handed axis of the angles.
        angles : sequence of float
            Angles of the gauges in rad. Default: 0, 45 and 90 degrees.
        """
        directions = rosette_directions(direction, normal, angles)
        return gauge_strains(self._fields(), self.eta, position, directions, self.material)

    def shell_forces(self, along: Sequence[float] | np.ndarray | None = None) -> ShellForces:
        """Return membrane forces, moments and shear forces per length of a shell; see `ShellForces`.

        Parameters
        ----------
        along : array_like, shape (3,), optional
            Direction in G whose part in the surface is axis 1. Default: axis 1 of the material; of one material without
            axes, x, or y where the surface is nearly across x.

        Raises
        ------
        ModelError
            If the body is no shell, or the direction is not valid or across the surface somewhere.

        Examples
        --------
        ``around = recover(result, "tank").shell_forces(along=(0, 0, 1))["N22"]``
        """
        from kanefe_fem.recovery.shell_forces import shell_forces

        fields = self._fields()
        if not isinstance(fields, ShellStrainFields):
            raise ModelError(f"{self.name!r} is no shell. Remedy: section_forces() of beams, or stress_at_nodes()")
        self._check_size("section forces", 40 * len(fields.stack.places.node))
        return shell_forces(fields, self.times, self.eta, along)

    def section_forces(self, stations: int = 2, *, inertia: bool = False) -> SectionForces:
        """Return the section forces along the elements of a body of beams; see `kanefe_fem.recovery.section_forces`.

        Of a shell they are those of its stiffeners, about their own axes: elements are the lines of the mesh, and
        `SectionForces.groups` has the stiffener of each.

        The elements of an exact beam are its cells, and forces are in the axes of the turned sections. Forces whose
        strains its theory does not have are those in balance with all loads beyond the section; NaN in a result that
        was read from a file, which does not have the loads.

        Parameters
        ----------
        stations : int
            Number of equally spaced stations of each element, both ends included.
        inertia : bool
            Solve for the static deflection under the loads of each instant (gravity, inertia, and forces at interfaces
            and nodes) instead of taking the deflection of the kept modes: the mode-acceleration method, which is exact
            in statics for any modes. Of an exact beam: all six by balance instead of by strains.

        Raises
        ------
        ModelError
            If the body has no beams; with `inertia` also if it is a shell, distributed loads act on it, the result was
            read from a file, or an interface has several nodes.

        Examples
        --------
        ``most = abs(recover(result, "panel", material="rib").section_forces()["My"]).max()``
        """
        beams = self._beams()
        if beams is not None:
            if inertia:
                raise ModelError(f"{self.name!r} is a shell with stiffeners. Remedy: leave out inertia=True")
            return beams[0].section_forces(self.times, stations_of(stations), self.eta, beams[1])
        if inertia and self.name in self.result.segmented:
            raise ModelError(
                f"{self.name!r} is cut into segments, whose static modes give section forces without inertia=True. "
                "Remedy: leave it out, or recover(result, name) of a segment"
            )
        return section_forces(self.result, self.name, self.frames, self.eta, stations, inertia)

    def fibre_stress(self) -> np.ndarray:
        """Return the normal stress in p fibres around both ends of each of m beams, shape (T, m, 2, p), Pa.

        Beams are those of `section_forces`, of a shell its stiffeners; fibres go around the outline of the section, of
        a rectangle from the corner -y, -z over y, -z. NaN where the shape of a section is not known.

        Raises
        ------
        ModelError
            If the body has no beams, or the shape of no section is known.

        Examples
        --------
        ``worst = abs(recover(result, "panel", material="rib").fibre_stress()).max()``
        """
        self._check_size("stress in fibres", 32 * sum(len(block.nodes) for block in self.result.body(self.name).cells))
        found = self._beams()
        if found is None:
            return normal_stress(self.result.body(self.name), self.eta)
        return found[0].stress(ENDS, self.eta)[:, found[1]]

    def expression(
        self, function: Callable[[ExpressionTerms], Any], at: Literal["nodes", "cells", "gauss"] = "nodes"
    ) -> np.ndarray:
        """Return the values of a UFL expression of the displacement; needs dolfinx.

        Parameters
        ----------
        function : callable
            ``function(terms) -> UFL expression``; `terms` is a `kanefe_fem.recovery.expressions.ExpressionTerms`.
        at : {"nodes", "cells", "gauss"}
            At the nodes (means over the adjacent cells), the centres of the cells, or their Gauss points.

        Returns
        -------
        ndarray, shape (T, n, ...), (T, cells, ...) or (T, cells, g, ...)
            Real values; the last axes are those of the expression.

        Examples
        --------
        Elastic energy: ``fields.expression(lambda f: 0.5 * f.ufl.inner(f.stress, f.strain), at="cells")``, J/m3.
        """
        from kanefe_fem.recovery.expressions import evaluate_expression

        if self.name in self.result.segmented:
            raise ModelError(f"{self.name!r} is cut into segments. Remedy: an expression of each of segments()")
        return evaluate_expression(self.name, self.result.body(self.name), self.displacement(), function, at)

    def to_vtk(self, path: str | Path, *, quantities: Sequence[str] = ("von_mises",), scale: float = 1.0) -> Path:
        """Write the scene at these times for ParaView, with fields on this body; see `Result.to_vtk`.

        Parameters
        ----------
        path : path
            Path of the .pvd file.
        quantities : sequence of str
            Scalars of `envelope` and "stress", "strain" (six components each, in the axes of G), at the nodes. Scalars
            are also written at the centres of the cells, without averaging. A shell is written as cells of its layers,
            with values at the bottom and top of each, and with the solids and beams in one mesh with it.
        scale : float
            Factor on the elastic displacements.

        Raises
        ------
        ModelError, FileError, MissingDependency
            If there is no such quantity, the files cannot be written, or pyevtk is not installed.
        """
        from kanefe.views.vtk import write_series

        known = (*self._fields().scalars, "stress", "strain")
        if isinstance(quantities, str) or any(q not in known for q in quantities):
            raise ModelError(f"quantities={quantities!r}: choose a list of {', '.join(known)}")
        place = {int(frame): row for row, frame in enumerate(self.frames)}

        fields = self._fields()
        if isinstance(fields, ShellStrainFields) and (self.level != (None, None) or self.material is not None):
            raise ModelError("files of a shell have all its layers. Remedy: leave out face=, ply= and material=")

        def data(frame: int) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
            eta = self.eta[place[frame]][None]
            if isinstance(fields, ShellStrainFields):
                return shell_vtk_arrays(fields, eta, quantities), {}
            return vtk_arrays(fields, eta, quantities, self.material)

        return write_series(self.result, path, frames=self.frames, fields={self.name: data}, scale=scale)

    def picture(
        self,
        path: str | Path,
        quantity: Scalar = "von_mises",
        *,
        frame: int | None = None,
        scale: float | None = None,
        view: Sequence[float] = (1.0, -1.3, 0.9),
        title: str | None = None,
        limit: float | None = None,
    ) -> Path:
        """Draw the deformed body with a scalar of its stress in colours; needs pyvista.

        A shell is drawn with its thickness and the values of both faces, or of the face or ply that was chosen; with
        the solids and beams in one mesh with it.

        Parameters
        ----------
        path : path
            Path of the picture (.png).
        quantity : str
            One of the quantities of `envelope`.
        frame : int, optional
            Index of one of these times, to show the deformed body. Default: the undeformed body with the envelope over
            all times.
        scale : float, optional
            Factor on the displacements. Default: the largest is shown as a twentieth of the body's size.
        view : array_like, shape (3,)
            Direction in G from the body towards the viewer.
        title : str, optional
        limit : float, optional
            Upper end of the colour scale, Pa. Default: the largest value.

        Raises
        ------
        MissingDependency
            If pyvista is not installed: ``pip install 'kanefe[report]'``.
        """
        from kanefe_fem.recovery.pictures import write_picture

        options = {"view": view, "title": title, "limit": limit}
        return write_picture(self, self._fields(), path, quantity, frame, scale, options)

    def _beams(self) -> tuple[RibFields, np.ndarray] | None:
        """Return the fields of the stiffeners of a shell, and which lines are chosen; None of other bodies."""
        known = self.result.body(self.name).elasticity
        if known is None or known.ribs is None:
            return None
        fields = cast(JoinedFields, self._fields())
        beams = cast(RibFields, fields.ribs)
        part, row = fields.part_of(self.material)
        if part not in (None, "beams"):
            raise ModelError(
                f"material={fields.groups[self.material or 0]!r} of {self.name!r} has no beams. Remedy: one of "
                f"{', '.join(beams.names)}"
            )
        of_line = beams.ribs.of_line
        return beams, np.full(len(of_line), True) if row is None else of_line == row
