"""ExactBeam: a beam that bends and turns as far as it likes, as a flexible body."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import cast

import numpy as np

from kanefe.arguments import checked
from kanefe.bodies.exact.beam_line import BeamLine
from kanefe.bodies.exact.inertia import BeamInertia
from kanefe.bodies.flexible import FlexibleBody, InterfaceFrame
from kanefe.bodies.inner_motion import InnerMotion
from kanefe.bodies.slopes import SLOPE_MEASURES, SlopeMeasure
from kanefe.errors import ModelError
from kanefe.fe_model.model import COMPONENTS, Cells, Elasticity
from kanefe.frames import (
    Matrix,
    Vector,
    euler_parameters_from_matrices,
    euler_parameters_from_matrix,
    rotation_vectors,
    shaped_numbers,
)
from kanefe.storage.scipy_later import sp
from kanefe.storage.serialise import NOT_SAVED


@dataclass(frozen=True, eq=False, repr=False)
class SectionFrame(InterfaceFrame):
    """A frame that is fixed to a section of an `ExactBeam`, parallel to G at rest.

    Attributes
    ----------
    line : BeamLine
    station : int
        Which of its stations; -1: the last.
    at_rest : ndarray, shape (3, 3)
        Axes of the section at rest in G.
    """

    line: BeamLine = field(default=None, metadata=NOT_SAVED)  # type: ignore[assignment]
    station: int = 0
    at_rest: np.ndarray = None  # type: ignore[assignment]

    @property
    def is_linear(self) -> bool:
        """False."""
        return False

    @property
    def turns(self) -> bool:
        """True: a section is rigid."""
        return True

    def loose_rotations(self, components: tuple[str, ...]) -> tuple[str, ...]:
        """Return nothing: what a section carries follows all its rotations."""
        return ()

    @property
    def is_held(self) -> bool:
        """Whether it is the root, which is fixed in G."""
        return self.station == 0

    def inner_motion(self, eta: Vector, deta: Vector, slopes: SlopeMeasure) -> InnerMotion:
        """Return the motion of the frame seen from G: its rotation is exact, whatever the measure of slopes."""
        found, i = self.line.motion(eta, deta), self.station
        motion = np.vstack((found.V[i], found.W[i]))
        return InnerMotion(
            found.p[i], found.A[i] @ self.at_rest.T, found.v[i], found.w[i], motion, found.z[i], found.y[i]
        )

    def moved(self, eta: Vector) -> tuple[Vector, Matrix]:
        """Return translation and rotation vector of the frame, (6,), and their derivatives (6, k).

        The rotation vector is the shortest one, up to half a turn.
        """
        found, i = self.line.motion(eta, np.zeros_like(eta)), self.station
        displacement = self._displacements(found.A[[i]], found.p[[i]])[0]
        turns = np.linalg.solve(SLOPE_MEASURES["rotation-vector"].tangent(displacement[3:]), found.W[i])
        return displacement, np.vstack((found.V[i], turns))

    def displacements(self, eta: np.ndarray) -> np.ndarray:
        """Return translations and rotation vectors of the frame, (T, 6), at many states eta (T, k)."""
        return self._displacements(*(of[:, self.station] for of in self.line.places(eta)))

    def _displacements(self, A: np.ndarray, p: np.ndarray) -> np.ndarray:
        turned = rotation_vectors(euler_parameters_from_matrices(A @ self.at_rest.T))
        return np.hstack((p - self.position, turned))

    def remainder(self, deta: np.ndarray) -> np.ndarray:
        """Not defined without a state: see `inner_motion`."""
        raise TypeError("the remainders of a section depend on the state of its beam")


@dataclass(frozen=True, eq=False, repr=False)
class ExactBeam(FlexibleBody):
    """A geometrically exact beam in coordinates of its strains; made by `kanefe_fem.exact_beam`.

    Its frame G is fixed to the root section. Stiffness and damping are constant, since they are of the strains; inertia
    and the motion of the sections depend on the state without approximation. The basis is that of small motions about
    the undeformed beam, for reports and pictures of modes.

    Attributes
    ----------
    line : BeamLine
    """

    line: BeamLine = None  # type: ignore[assignment]

    def __post_init__(self) -> None:
        super().__post_init__()
        for part in (*self.interfaces, self.moments):  # one line for all, also of a body from a file
            object.__setattr__(part, "line", self.line)

    @property
    def is_floating(self) -> bool:
        """False: the root section is fixed in G."""
        return False

    @checked
    def node_frame(self, node: int) -> InterfaceFrame:
        """Return the frame of one station of the beam: an interface, or one that is no interface."""
        if not 0 <= node < len(self.nodes):
            raise ModelError(f"node {node} is not one of the {len(self.nodes)} nodes of this body")
        for frame in self.interfaces:
            if isinstance(frame, SectionFrame) and frame.station == node:
                return frame
        return section_frame(self.line, node, f"node {node}")

    @checked
    def section_orientation(self, interface: str) -> Vector:
        """Return the axes of the section at an interface at rest, for ``orientation=`` of what goes on along it.

        Interfaces have the axes of G at rest, also where the beam is curved or twisted there.

        Parameters
        ----------
        interface : str

        Returns
        -------
        ndarray, shape (4,)
            Euler parameters of the section in G.

        Raises
        ------
        ModelError
            If there is no such interface.

        Examples
        --------
        Two quarter circles, joined to half a circle:

        >>> import numpy as np
        >>> import kanefe as kf
        >>> from kanefe_fem import Material, Rectangle, exact_beam
        >>> steel = Material(E=210e9, nu=0.3, rho=7850.0)
        >>> quarter = exact_beam(np.pi / 2, Rectangle(0.01, 0.02), steel, curvature=(0, 0, 1))
        >>> scene = kf.System()
        >>> first = scene.add_flexible_body("first", quarter, joint=kf.Fixed())
        >>> on = quarter.section_orientation("tip")
        >>> second = scene.add_flexible_body("second", quarter, parent=first.interface("tip"), orientation=on)
        >>> print(abs(kf.equilibrium(scene).position("second", "tip").round(6)))
        [0. 2. 0.]
        """
        return euler_parameters_from_matrix(cast("SectionFrame", self.interface(interface)).at_rest)

    @checked
    def node_displacements(self, eta: np.ndarray) -> np.ndarray:
        """Return the displacement of every station in G, shape (n, 3) in m, from the coordinates (k,)."""
        given = shaped_numbers(eta, (self.free_count,), "eta, the free coordinates of this body,")
        return self.line.places(given[None])[1][0] - self.nodes

    @checked
    def node_velocities(self, eta: np.ndarray, deta: np.ndarray) -> np.ndarray:
        """Return the velocity of every station in G, shape (n, 3) in m/s, from the coordinates and their rates (k,)."""
        given = (shaped_numbers(x, (self.free_count,), "coordinates and rates of this body") for x in (eta, deta))
        return self.line.motion(*given).v


def section_frame(line: BeamLine, station: int, name: str) -> SectionFrame:
    """Return the frame of a station of a beam."""
    still = np.zeros(line.count)
    found = line.motion(still, still)
    motion = np.vstack((found.V[station], found.W[station]))
    return SectionFrame(
        name, found.p[station].copy(), motion, line=line, station=station, at_rest=found.A[station].copy()
    )


def exact_beam_body(
    line: BeamLine,
    stiffness: Matrix,
    damping: Matrix,
    stations: Mapping[str, int],
    provenance: Mapping[str, object],
    elasticity: Elasticity | None = None,
) -> ExactBeam:
    """Return a beam as a body.

    Parameters
    ----------
    line : BeamLine
    stiffness, damping : ndarray, shape (k, k)
    stations : mapping of str to int
        Interfaces by name.
    provenance : mapping
        Where the body comes from.
    elasticity : Elasticity, optional
        Of the lines from station to station.
    """
    still = np.zeros(line.count)
    rest = line.motion(still, still)
    nodes = rest.p
    n = len(nodes)
    basis = np.concatenate((rest.V, rest.W), axis=1).reshape(6 * n, line.count)
    gauss = line.gauss_nodes.ravel()
    pairs = np.column_stack((np.arange(n - 1), np.arange(1, n)))
    return ExactBeam(
        nodes=nodes,
        components=COMPONENTS,
        basis=basis,
        free_count=line.count,
        stiffness=stiffness,
        damping=damping,
        moments=BeamInertia(line),  # type: ignore[arg-type]
        interfaces=tuple(section_frame(line, station, name) for name, station in stations.items()),
        inertia_points=nodes[gauss],
        inertia_mass=sp.csr_matrix(sp.diags(line.masses.ravel())),
        inertia_basis=rest.V[gauss].reshape(3 * len(gauss), line.count),
        cells=(Cells("line", pairs),),
        elasticity=elasticity,
        provenance=dict(provenance),
        line=line,
    )
