"""Displacement, strain and stress of a flexible body at output times of a run, and their extremes over these."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Literal

import numpy as np

from kanefe.errors import AccuracyWarning, ModelError, outside
from kanefe.results.reader import LARGEST_TABLE, Reader
from kanefe_fem.recovery import scalars as measures
from kanefe_fem.recovery.envelope import Envelope, envelope_of, error_of_mesh
from kanefe_fem.recovery.fibre_stress import fibre_stress
from kanefe_fem.recovery.given_stresses import GivenStresses
from kanefe_fem.recovery.joined_fields import JoinedFields, fields_of_shell
from kanefe_fem.recovery.scalars import Scalar
from kanefe_fem.recovery.shell_fields import ShellStrainFields
from kanefe_fem.recovery.strain_fields import Place, StrainFields, Tensor

if TYPE_CHECKING:
    from kanefe.fatigue import MeanStress, SNCurve
    from kanefe_fem.recovery.damage_map import DamageMap

Face = Literal["top", "bottom", "middle"]


class FieldsAtTimes:
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

    def __repr__(self) -> str:
        """Return the body and the times."""
        of_times = f"{len(self.times)} times from {self.times[0]:g} to {self.times[-1]:g} s"
        return f"{type(self).__name__}({self.name!r}, {of_times})"

    @property
    def times(self) -> np.ndarray:
        """Times of the fields, shape (T,), s."""
        return self.result.times[self.frames]

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
        its P places (see `kanefe.fe_model.shell_stack.FacePlaces`); then those of the nodes on the skin of solids and
        of fibres of beams in one mesh with it (see `kanefe.fe_model.drawn_shell`).
        """
        if self.is_of_beams:
            return fibre_stress(self.result.body(self.name), np.atleast_2d(eta))
        fields = self._fields()
        if isinstance(fields, ShellStrainFields):
            return fields.faces_of(np.atleast_2d(eta))
        return fields.evaluate("stress", "nodes", np.atleast_2d(eta), self.material)

    def mesh_error_of(self, eta: np.ndarray, /) -> float:
        """Return the estimated error of the largest von Mises stress of coordinates (k,), relative to it.

        See `Envelope.mesh_error`; NaN for beams and where it is not known.
        """
        if self.is_of_beams:
            return np.nan
        return error_of_mesh(self._fields(), np.atleast_2d(eta), None, self.material)

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

        Of a shell it is the worst of both faces, of the solids and of the fibres of stiffeners at each node, or that of
        the face or the `material` that was chosen.

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

        fields = self._fields()
        is_part = isinstance(fields, JoinedFields) and fields.ribs is not None and fields.is_chosen
        if is_part and self.material is None:
            warnings.warn(
                f"the damage of {self.name!r} at a face leaves its stiffeners out. Remedy: no face= and ply=, for the "
                "worst of all at each node, or material= for a stiffener",
                AccuracyWarning,
                stacklevel=outside(),
            )
        return damage_map(fields, self.eta, curve, mean_stress, quantity, floor, self.material)

    def _fields(self) -> StrainFields:
        body = self.result.body(self.name)
        if body.elasticity is not None and body.elasticity.shell is not None:
            return fields_of_shell(body, *self.level)
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
