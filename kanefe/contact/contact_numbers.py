"""A contact as numbers for its kernel: see `kanefe.kernels.contact.contact_forces`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from kanefe.contact.laws.bristles import LuGre
from kanefe.contact.laws.compiled_law import CompiledLaw
from kanefe.contact.laws.table_law import TableLaw
from kanefe.loads.base import LoadKernel

if TYPE_CHECKING:
    from kanefe.contact.geometry.shape import Probe, SurfaceShape
    from kanefe.contact.laws.friction_laws import Coulomb
    from kanefe.contact.laws.normal_laws import NormalLaw
    from kanefe.contact.rest import Rest


class Numbered(Protocol):
    """What has a kernel: see `kanefe.contact.contact.Contact`."""

    @property
    def ends(self) -> Sequence[Any]:
        """Its ends."""
        ...

    @property
    def shape(self) -> SurfaceShape:
        """That of the surface."""
        ...

    @property
    def probes(self) -> Sequence[tuple[int, Probe]]:
        """With the number of the end of each."""
        ...

    @property
    def normal(self) -> NormalLaw:
        """Its normal law."""
        ...

    @property
    def friction(self) -> Coulomb | LuGre | None:
        """Its friction."""
        ...

    @property
    def belt(self) -> np.ndarray:
        """Velocity of the surface."""
        ...

    @property
    def rest(self) -> Rest | None:
        """What it is looked at about."""
        ...

    @property
    def reports_points(self) -> bool:
        """Whether its events are those of each probe too."""
        ...


def kernel_of(contact: Numbered) -> LoadKernel:
    """Return the kernel of a contact, with its numbers."""
    from kanefe.kernels.contact import contact_forces as kernels
    from kanefe.kernels.contact import contact_places as places

    law, rest = contact.normal, contact.rest
    kind, of_friction = _of_friction(contact.friction)
    has_memory = contact.friction is not None and contact.friction.has_memory
    probes = [
        (float(end), *probe.point, probe.radius, probe.share, probe.ring, *probe.axis) for end, probe in contact.probes
    ]
    head: list[float] = [
        len(contact.probes),
        len(contact.ends),
        0.0,
        kind,
        has_memory,
        law.restitution is not None,
        0.0,
        0.0 if rest is None else rest.softness,
        law.kind,
        law.stiffness,
        law.exponent,
        law.damping,
        *of_friction,
        *contact.belt,
        contact.reports_points,
    ]
    parts = [np.array(head, dtype=float), np.ravel(probes)]
    if rest is not None:
        parts[0][places.RESTS_AT] = sum(map(len, parts))
        parts.append(np.hstack((rest.material, rest.marks, rest.turns.reshape(-1, 9))).ravel())
    parts[0][places.SHAPE] = sum(map(len, parts))
    parts += [np.array((float(contact.shape.kind),)), contact.shape.numbers]
    if isinstance(law, TableLaw):  # where its pieces are, in the place of an exponent
        parts[0][places.EXPONENT] = sum(map(len, parts))
        parts += [np.array((float(len(law.pieces)),)), law.pieces.ravel()]
    if isinstance(law, CompiledLaw):  # where it is, likewise
        parts[0][places.EXPONENT] = sum(map(len, parts))
        parts += [np.array((float(law.address), float(law.has_slopes))), law.constants]
    numbers = np.concatenate(parts)
    return LoadKernel(kernels.contact, numbers, kernels.contact, kernels.contact_watch)


def _of_friction(law: Coulomb | LuGre | None) -> tuple[float, list[float]]:
    """Return the kind of friction, and its numbers."""
    from kanefe.kernels.contact.contact_places import ANCHORED, BRISTLES

    if law is None:
        return 0.0, [0.0] * 11
    if isinstance(law, LuGre):
        own = [law.coulomb, law.coulomb, law.static / law.coulomb, law.stribeck_speed, law.sigma0, law.sigma1]
        return BRISTLES, [*own, law.sigma2, 0.0, 0.0, 0.0, 0.0]
    return ANCHORED, [
        *law.coefficients,
        law.static_ratio,
        law.stribeck_speed,
        float(law.stiffness or 0.0),
        float(law.damping or 0.0),
        law.torsional,
        law.rolling,
        *law.axis,
    ]
