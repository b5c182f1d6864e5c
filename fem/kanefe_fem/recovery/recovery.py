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
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import AccuracyWarning, ModelError, outside
from kanefe.instants.instant import Instant
from kanefe.results.reader import LARGEST_TABLE, Reader
from kanefe.results.selection import Frames, frame_index
from kanefe_fem.recovery import scalars as measures
from kanefe_fem.recovery.choices import material_row, nearest_frames
from kanefe_fem.recovery.envelope import Envelope, envelope_of
from kanefe_fem.recovery.fibre_stress import fibre_stress
from kanefe_fem.recovery.gauges import gauge_strains, rosette_directions
from kanefe_fem.recovery.given_stresses import GivenStresses
from kanefe_fem.recovery.scalars import Scalar
from kanefe_fem.recovery.shell_fields import ShellStrainFields
from kanefe_fem.recovery.shell_points import ShellStrains
from kanefe_fem.recovery.strain_fields import Place, StrainFields, Tensor
from kanefe_fem.recovery.vtk_arrays import shell_vtk_arrays, vtk_arrays

if TYPE_CHECKING:
    from kanefe.fatigue import MeanStress, SNCurve
    from kanefe_fem.recovery.damage_map import DamageMap
    from kanefe_fem.recovery.expressions import ExpressionTerms
    from kanefe_fem.recovery.section_forces import SectionForces
    from kanefe_fem.recovery.shell_forces import ShellForces

Face = Literal["top", "bottom", "middle"]


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
        Row of the body's table of moduli, or the group of cells that has it. Only its cells are used, and values at
        nodes elsewhere are NaN. Without it, stresses at nodes between two materials are means over both sides.
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
    if (face is not None or ply is not None) and (own is None or own.shell is None):
        raise ModelError(f"{name!r} is no shell and has no face or ply. Remedy: leave out face= and ply=")
    if f"relaxation of {name}" in result.loads:
        warnings.warn(
            f"stresses of the viscoelastic body {name!r} are those of its long-term moduli: what its arms carry while "
            "they relax is left out. Remedy: none is needed where motions are slow against the relaxation times",
            AccuracyWarning,
            stacklevel=outside(),
        )
    return Recovery(result, name, rows, eta[rows], row, (face, ply))


class Recovery:
    """Fields of a flexible body at T output times of a run, made by `recover`.

    Displacements are in m, stresses in Pa; all are components in the mesh frame G, xx, yy, zz, yz, xz, xy, with
    engineering shear strains. A stress at a node is extrapolated from the Gauss points and averaged over the adjacent
    cells.

    Parameters
    ----------
    result : Result
    name : str
        Name of the body.
    frames : ndarray of int, shape (T,)
        Indices of the output times.
    eta : ndarray, shape (T, k)
        Modal coordinates.
    material : int, optional
        Row of the table of moduli.
    level : tuple of str and int, optional
        Face and ply of a shell.

    Notes
    -----
    Stresses are those of the kept modes. They miss the quasi-static part of the modes that the reduction dropped, which
    matters near concentrated loads.
    """

    def __init__(
        self,
        result: Reader,
        name: str,
        frames: np.ndarray,
        eta: np.ndarray,
        material: int | None = None,
        level: tuple[Face | None, int | None] = (None, None),
    ) -> None:
        self.result = result
        self.name = name
        self.frames = frames
        self.eta = eta
        self.material = material
        self.level = level
        self._envelopes: dict[tuple[str, str], Envelope] = {}

    @property
    def times(self) -> np.ndarray:
        """Times of the fields, shape (T,), s."""
        return self.result.times[self.frames]

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

    @property
    def is_of_beams(self) -> bool:
        """Whether the body is made of beams, which have section forces instead of a stress field."""
        elasticity = self.result.body(self.name).elasticity
        return elasticity is not None and elasticity.axes is not None

    def displacement(self) -> np.ndarray:
        """Return the displacement of the nodes, shape (T, n, 3), m."""
        return self.result.nodal_displacements(self.name, self.frames)

    def strain_at_nodes(self) -> np.ndarray:
        """Return the strain at the nodes, shape (T, n, 6)."""
        return self._tensor("strain", "nodes")

    def stress_at_nodes(self) -> np.ndarray:
        """Return the stress at the nodes, shape (T, n, 6), Pa."""
        return self._tensor("stress", "nodes")

    def stress_of(self, eta: np.ndarray, /) -> np.ndarray:
        """Return the stress at the nodes for given modal coordinates (r, k), shape (r, n, 6), Pa.

        For m beams it is the stress in p outer fibres at both ends of each, shape (r, m 2 p, 6); see
        `kanefe_fem.recovery.fibre_stress`. For a shell it is that at its bottom and then at its top, (r, 2 P, 6), at
        its P places (see `kanefe.fe_model.shell_stack.FacePlaces`).
        """
        if self.is_of_beams:
            return fibre_stress(self.result.body(self.name), np.atleast_2d(eta))
        fields = self._fields()
        if isinstance(fields, ShellStrainFields):
            return fields.faces_of(np.atleast_2d(eta))
        return fields.evaluate("stress", "nodes", np.atleast_2d(eta), self.material)

    def strain_at_cells(self, at: Literal["centroid", "gauss"] = "centroid") -> np.ndarray:
        """Return the strain at the centre of each cell (T, cells, 6), or at its Gauss points (T, cells, g, 6)."""
        return self._tensor("strain", _place(at))

    def stress_at_cells(self, at: Literal["centroid", "gauss"] = "centroid") -> np.ndarray:
        """Return the stress at the centre of each cell (T, cells, 6), or at its Gauss points (T, cells, g, 6), Pa."""
        return self._tensor("stress", _place(at))

    def stress_in_layer(self, at: Literal["nodes", "cells"] = "nodes") -> np.ndarray:
        """Return the stress of a shell in the axes of the ply, (T, n, 6) or (T, cells, 6), Pa: 11, 22, 33, 23, 13, 12.

        Raises
        ------
        ModelError
            If the body is no shell, or no face was chosen.

        Examples
        --------
        ``along_fibres = recover(result, "skin", ply=3, face="top").stress_in_layer()[..., 0]``
        """
        fields = self._fields()
        if not isinstance(fields, ShellStrainFields):
            raise ModelError(f"{self.name!r} is no shell and has no layers. Remedy: stress_at_nodes")
        return fields.in_layers(at, self.eta, self.material)

    def scalar(self, quantity: Scalar, at: Literal["nodes", "cells"] = "nodes") -> np.ndarray:
        """Return a scalar of the stress at the nodes (T, n) or cells (T, cells), Pa; failure indices: 1.

        Parameters
        ----------
        quantity, at
            As for `envelope`.
        """
        fields = self._fields()
        if quantity not in fields.scalars or at not in ("nodes", "cells"):
            raise ModelError(f"no scalar {quantity!r} at {at!r}. There are: {', '.join(fields.scalars)}; nodes, cells")
        self._check_size(quantity, 6 * len(fields.nodes if at == "nodes" else fields.centroids))
        return fields.scalar(quantity, at, self.eta, self.material)

    @property
    def von_mises(self) -> np.ndarray:
        """Von Mises' stress at the nodes, shape (T, n), Pa."""
        return self.scalar("von_mises")

    @property
    def principal(self) -> np.ndarray:
        """Principal stresses at the nodes, greatest first, shape (T, n, 3), Pa."""
        return measures.principal(self.stress_at_nodes())

    @property
    def principal_strain(self) -> np.ndarray:
        """Principal strains at the nodes, greatest first, shape (T, n, 3)."""
        return measures.principal_strains(self.strain_at_nodes())

    def envelope(self, quantity: Scalar = "von_mises", at: Literal["nodes", "cells"] = "nodes") -> Envelope:
        """Return the greatest value of a scalar over the times of these fields, at every node or cell.

        Parameters
        ----------
        quantity : {"von_mises", "tresca", "max_principal", "min_principal", "max_shear", "tsai_wu", "max_stress"}
            The least value is taken for "min_principal". The last two are failure indices of the layers of shells, 1
            at failure.
        at : {"nodes", "cells"}

        Raises
        ------
        ModelError
            If there is no such quantity or place.

        Examples
        --------
        ``worst = kanefe_fem.recover(result, "arm").envelope(); print(worst.peak, worst.peak_time)``
        """
        key = (quantity, at)
        if key not in self._envelopes:
            self._envelopes[key] = envelope_of(self._fields(), self.eta, self.times, quantity, at, self.material)
        return self._envelopes[key]

    def damage(
        self,
        curve: SNCurve,
        *,
        mean_stress: MeanStress | None = None,
        quantity: str = "signed_von_mises",
        floor: float = 1e-3,
    ) -> DamageMap:
        """Return the damage by fatigue at the nodes of the surface: rainflow counting and Miner's rule.

        Parameters
        ----------
        curve : kanefe.fatigue.SNCurve
        mean_stress : Goodman, Gerber or Walker of kanefe.fatigue, optional
            Default: mean stress is not regarded.
        quantity : str
            "signed_von_mises" with the sign of the trace, or a component in G: "xx", "yy", "zz", "yz", "xz", "xy".
        floor : float
            Share of the largest damage below which nodes are not counted: they get an upper bound.

        Raises
        ------
        ModelError
            If there is no such quantity, the run has one time only, or the mean stress alone breaks the material.

        Examples
        --------
        ``print(kanefe_fem.recover(result, "arm").damage(kf.fatigue.SNCurve(160e6, 1e6, 5, 9)))``
        """
        from kanefe_fem.recovery.damage_map import damage_map

        return damage_map(self._fields(), self.eta, curve, mean_stress, quantity, floor, self.material)

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
            If the body is not made of beams; with `inertia` also if distributed loads act on it, the result was
            read from a file, or an interface has several nodes.
        """
        from kanefe_fem.recovery.section_forces import section_forces

        if inertia and self.name in self.result.segmented:
            raise ModelError(
                f"{self.name!r} is cut into segments, whose static modes give section forces without inertia=True. "
                "Remedy: leave it out, or recover(result, name) of a segment"
            )
        return section_forces(self.result, self.name, self.frames, self.eta, stations, inertia)

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
            with values at the bottom and top of each.
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
        if isinstance(fields, ShellStrainFields) and len(fields.cells) < len(self.result.body(self.name).cells):
            raise ModelError(
                f"{self.name!r} has a shell beside beams or solids, whose stresses are not written together. Remedy: "
                "Result.to_vtk, and the arrays of recover(...)"
            )

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

        A shell is drawn with its thickness and the values of both faces, or of the face or ply that was chosen.

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

    def _fields(self) -> StrainFields:
        body = self.result.body(self.name)
        if body.elasticity is not None and body.elasticity.shell is not None:
            return ShellStrainFields(ShellStrains.of_body(body), self.name, *self.level)
        if body.stress_modes is not None:
            return GivenStresses(self.name, body, body.stress_modes)
        return StrainFields.of_body(self.name, body)

    def _tensor(self, what: Tensor, at: Place) -> np.ndarray:
        fields = self._fields()
        points = len(fields.nodes) if at == "nodes" else fields.cell_count * (8 if at == "gauss" else 1)
        self._check_size(what, 6 * points)
        return fields.evaluate(what, at, self.eta, self.material)

    def _check_size(self, what: str, values: int) -> None:
        size = 8 * len(self.eta) * values
        if size > LARGEST_TABLE:
            raise ModelError(
                f"the {what} of {self.name!r} at {len(self.eta)} times takes up to {size / 2**30:.1f} GiB. Remedy: "
                "choose times with recover(..., times=[...]), or take envelope()"
            )


def _place(at: str) -> Place:
    places: dict[str, Place] = {"centroid": "cells", "gauss": "gauss"}
    if at not in places:
        raise ModelError(f"a field at cells is at their 'centroid' or 'gauss' points, not {at!r}")
    return places[at]
