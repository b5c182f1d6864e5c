"""SegmentedBody: a slender body cut into a chain of linear ones, each with its own floating frame.

The finite-segment method of the paper's introduction: each segment has a frame G of its own, in which it is linear, so
that the whole can bend without limit. G of a segment sits on the cut face of its neighbour towards the base. With one
element a segment it is the method of intermediate element coordinate systems (IECS).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, Self

import numpy as np

from kanefe.arguments import checked
from kanefe.bodies.made_from_source import MadeFromSource
from kanefe.errors import ModelError

if TYPE_CHECKING:
    from kanefe.bodies.flexible import FlexibleBody

CUT = "cut "
"""First letters of the names of the interfaces at cuts; their numbers follow."""


@dataclass(frozen=True, eq=False, repr=False)
class Segment:
    """A part of a segmented body.

    Attributes
    ----------
    body : FlexibleBody
        In axes parallel to those of the whole; its provenance has its place in the whole under "segment".
    origin : ndarray, shape (3,)
        Origin of its G in G of the whole, undeformed, m.
    nodes : ndarray of int
        Numbers in the whole of its nodes.
    cells : ndarray of int
        Numbers in the whole of its cells.
    """

    body: FlexibleBody
    origin: np.ndarray
    nodes: np.ndarray
    cells: np.ndarray


@dataclass(frozen=True, eq=False, repr=False)
class SegmentedBody(MadeFromSource):
    """A slender body as a chain of linear segments, made by `kanefe_fem.segmented`.

    Attributes
    ----------
    segments : tuple of Segment
        Along the centre line.
    base : int
        Number of the segment whose G is that of the whole.
    nodes : ndarray, shape (n, 3)
        Of the whole, in its G, m.
    line : ndarray, shape (p, 3)
        Centre line, m.
    found : mapping
        What ``accuracy=`` found: differences between this and twice the number of segments.

    Examples
    --------
    >>> import kanefe as kf
    >>> from kanefe_fem import Material, Rectangle, segmented, straight_beam
    >>> steel = Material(E=210e9, nu=0.3, rho=7850.0)
    >>> beam = straight_beam(1.0, Rectangle(0.02, 0.02), steel, elements=24)
    >>> chain = segmented(beam, {"root": "clamped", "tip": "rigid"}, segments=12)
    >>> scene = kf.System(gravity=(0, 0, -9.81))
    >>> blade = scene.add_segmented_body("blade", chain)
    >>> scene.add_force(blade.interface("tip"), (0, 0, -500.0))
    >>> rest = kf.equilibrium(scene)
    >>> rest.nodal_positions("blade").shape
    (25, 3)
    """

    segments: tuple[Segment, ...]
    base: int
    nodes: np.ndarray
    line: np.ndarray
    found: Mapping[str, Any] = field(default_factory=dict)

    def __repr__(self) -> str:
        found = "".join(f", {name} {value:.2g}" for name, value in self.found.items())
        return (
            f"SegmentedBody({self.mass:.6g} kg, {len(self.segments)} segments, {len(self.nodes)} nodes, interfaces: "
            f"{', '.join(self.interfaces) or 'none'}{found})"
        )

    @property
    def interfaces(self) -> tuple[str, ...]:
        """Names of the interfaces of the whole, without those at cuts."""
        return tuple(self._owners)

    @property
    def mass(self) -> float:
        """Mass in kg."""
        return sum(segment.body.mass for segment in self.segments)

    @property
    def center_of_mass(self) -> np.ndarray:
        """Undeformed centre of mass in G of the whole, shape (3,), m."""
        parts = [s.body.mass * (s.origin + s.body.center_of_mass) for s in self.segments]
        return np.asarray(np.sum(parts, axis=0) / self.mass)

    @property
    def inertia(self) -> np.ndarray:
        """Undeformed inertia about the origin of G of the whole, in its components, shape (3, 3), kg m2."""
        total = np.zeros((3, 3))
        for segment in self.segments:
            m, c, p = segment.body.mass, segment.body.center_of_mass, segment.origin
            shift = 2.0 * c + p  # J_O = J_G + m ((2 c + p) . p 1 - sym (2 c + p) p^T)
            outer = np.outer(shift, p)
            total += segment.body.inertia + m * (shift @ p * np.eye(3) - 0.5 * (outer + outer.T))
        return total

    @checked
    def segment_of(self, interface: str) -> int:
        """Return the number of the segment that has an interface of the whole, from 0.

        Raises
        ------
        ModelError
            If there is none of that name, or it is a cut.
        """
        known = ", ".join(self.interfaces) or "none"
        if interface.startswith(CUT):
            raise ModelError(
                f"{interface!r} is a face inside the body, where segments are joined. Remedy: one of the whole "
                f"({known}), or node(number)"
            )
        if interface not in self._owners:
            raise ModelError(f"this segmented body has no interface called {interface!r}. It has: {known}")
        return self._owners[interface]

    @checked
    def place_of_node(self, node: int) -> tuple[int, int]:
        """Return the segment of a node of the whole and its number there; at a cut, the segment nearer to the base."""
        if not 0 <= node < len(self.nodes):
            raise ModelError(f"node {node} is not one of the {len(self.nodes)} nodes of this body")
        for number in sorted(range(len(self.segments)), key=lambda i: abs(i - self.base)):
            found = np.flatnonzero(self.segments[number].nodes == node)
            if found.size:
                return number, int(found[0])
        raise ModelError(f"node {node} is in no segment of this body")

    @checked("refined", "order", "segments")
    def rebuilt(
        self,
        reduction: Any = None,
        stiffening: Literal["none", "inertial", "full"] | None = None,
        refined: int = 0,
        order: int | None = None,
        segments: int | None = None,
    ) -> Self:
        """Return the chain made again from the same source: see `FlexibleBody.rebuilt`.

        Parameters
        ----------
        reduction, stiffening, refined, order
            As there; the reduction is that of each segment.
        segments : int, optional
            Number of segments. Default: as it was.

        Raises
        ------
        ModelError, FileError
            As there, and as `kanefe_fem.segmented`.
        """
        from kanefe.bodies.source import Changes, rebuilt_body

        chain: Self = rebuilt_body(self, Changes(reduction, stiffening, refined, order, segments))
        return chain

    @cached_property
    def _owners(self) -> dict[str, int]:
        return {
            frame.name: number
            for number, segment in enumerate(self.segments)
            for frame in segment.body.interfaces
            if not frame.name.startswith(CUT)
        }
