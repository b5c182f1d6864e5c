"""Joints that the faces of two parts propose: what motion the cylinders and planes where they meet leave free.

Each shaft in a hole keeps two points of its axis from moving across it, each pair of planes keeps their distance and
their angles. What twists are left, by the null space of these conditions, is the joint.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.frames import turn_to
from kanefe.joints.base import Joint
from kanefe.joints.cylindrical import Cylindrical
from kanefe.joints.fixed import Fixed
from kanefe.joints.prismatic import Prismatic
from kanefe.joints.revolute import Revolute
from kanefe_fem.assemblies.meetings import Contact, Fit
from kanefe_fem.cad.shapes import without_noise

FREE = 1e-4
"""Singular value below which a twist is free, relative to the largest: axes of files are parallel to 1e-5."""

KINDS = {"fixed": Fixed, "revolute": Revolute, "cylindrical": Cylindrical, "prismatic": Prismatic}
"""Joints by name; planes alone that leave more free propose none that holds by itself."""


@dataclass(frozen=True, eq=False)
class ProposedJoint:
    """A joint that two parts may have where their faces meet; none is taken unless it is asked for.

    Attributes
    ----------
    name : str
        Such as "pin in arm".
    parts : (str, str)
        Names of the parts.
    kind : str
        "fixed", "revolute", "cylindrical", "prismatic", or "planar" and "loose" where faces hold less.
    point, axis : ndarray, shape (3,)
        m, and direction, in the axes of the assembly.
    radius, play : float
        Of shaft and hole, m; zero for planes.
    certainty : {"likely", "possible", "doubtful"}
    reason : str
        What was found, and what it could be instead.
    """

    name: str
    parts: tuple[str, str]
    kind: str
    point: np.ndarray
    axis: np.ndarray
    radius: float
    play: float
    certainty: str
    reason: str
    faces: dict[str, tuple[int, ...]] = field(default_factory=dict, repr=False)

    @checked
    def joint(self, kind: str | None = None) -> Joint:
        """Return the joint about its axis, of another kind if one is given.

        Raises
        ------
        ModelError
            If the kind is not one of a joint.
        """
        wanted = kind or self.kind
        if wanted not in KINDS:
            raise ModelError(
                f"{self.name!r} is {wanted}, which is no joint that holds by itself. Remedy: another kind for it, one "
                f"of {', '.join(KINDS)}"
            )
        made = KINDS[wanted]
        joint: Joint = made() if made is Fixed else made(tuple(self.axis.tolist()))
        return joint

    def __str__(self) -> str:
        """Return the proposal in one line."""
        at = ", ".join(f"{one:.4g}" for one in self.point)
        about = "" if self.kind in {"fixed", "loose"} else " along (" + ", ".join(f"{x:.3g}" for x in self.axis) + ")"
        return f"{self.name}: {self.kind} at ({at}) m{about}, {self.certainty}: {self.reason}"


def propose(fits: Sequence[Fit], contacts: Sequence[Contact]) -> list[ProposedJoint]:
    """Return the proposed joints, one for each two parts that meet."""
    pairs: dict[frozenset[int], tuple[list[Fit], list[Contact]]] = {}
    for fit in fits:
        pairs.setdefault(frozenset((fit.shaft.solid.tag, fit.hole.solid.tag)), ([], []))[0].append(fit)
    for contact in contacts:
        pairs.setdefault(frozenset(one.tag for one in contact.solids), ([], []))[1].append(contact)
    return [_of_pair(*each) for each in pairs.values()]


def _of_pair(fits: list[Fit], contacts: list[Contact]) -> ProposedJoint:
    centre = fits[0].point if fits else np.mean([contact.point for contact in contacts], axis=0)
    size = max([np.linalg.norm(fit.point - centre) + fit.hole.radius for fit in fits], default=0.0)
    size = max([size, *(np.linalg.norm(contact.point - centre) for contact in contacts)]) or 1.0
    solids = (fits[0].shaft.solid, fits[0].hole.solid) if fits else contacts[0].solids
    extent = max(float(np.linalg.norm(solid.high - solid.low)) for solid in solids)
    kind, axis = _freedom(_conditions(fits, contacts, centre, float(size)))
    faces: dict[str, tuple[int, ...]] = {}
    if fits:
        shaft, hole = fits[0].shaft.solid.name, fits[0].hole.solid.name
        name, parts = f"{shaft} in {hole}", (shaft, hole)
        for fit in fits:
            for barrel in (fit.shaft, fit.hole):
                tags = {face.tag for face in barrel.faces} | set(faces.get(barrel.solid.name, ()))
                faces[barrel.solid.name] = tuple(sorted(tags))
        if axis is None or kind in {"planar", "loose"}:
            axis = fits[0].axis
    else:
        one, other = (solid.name for solid in contacts[0].solids)
        name, parts = f"{one} on {other}", (one, other)
        for contact in contacts:
            for solid, face in zip(contact.solids, contact.faces, strict=True):
                faces[solid.name] = tuple(sorted({face.tag, *faces.get(solid.name, ())}))
        axis = contacts[0].normal if axis is None else axis
    certainty, reason = _certainty(kind, fits, contacts)
    return ProposedJoint(
        name=name,
        parts=parts,
        kind=kind,
        point=without_noise(np.asarray(centre, dtype=float), extent),
        axis=_upright(axis),
        radius=fits[0].shaft.radius if fits else 0.0,
        play=fits[0].play if fits else 0.0,
        certainty=certainty,
        reason=reason,
        faces=faces,
    )


def _upright(axis: np.ndarray) -> np.ndarray:
    """Return a unit vector whose largest component is positive, without round-off beside it."""
    unit = axis / np.linalg.norm(axis)
    unit = np.where(np.abs(unit) < 1e-9, 0.0, unit)
    return np.asarray(unit * np.sign(unit[np.argmax(np.abs(unit))]) + 0.0)


def _conditions(fits: list[Fit], contacts: list[Contact], centre: np.ndarray, size: float) -> np.ndarray:
    """Return rows on the twist (angular velocity times size, velocity of the centre) that the faces keep at zero."""
    rows = [np.zeros(6)]
    for fit in fits:
        for across in turn_to(fit.axis).T[:2]:
            arm = np.cross((fit.point - centre) / size, across)
            rows += [np.concatenate([arm, across]), np.concatenate([across, np.zeros(3)])]
    for contact in contacts:
        normal = contact.normal
        rows.append(np.concatenate([np.cross((contact.point - centre) / size, normal), normal]))
        rows += [np.concatenate([one, np.zeros(3)]) for one in turn_to(normal).T[:2]]
    return np.array(rows)


def _freedom(rows: np.ndarray) -> tuple[str, np.ndarray | None]:
    """Return the kind of joint and its axis by the twists that are left free."""
    _, values, vectors = np.linalg.svd(rows)
    rank = int(np.count_nonzero(values > FREE * values[0])) if values[0] > 0.0 else 0
    left = vectors[rank:]
    if len(left) == 0:
        return "fixed", None
    turns = int(np.linalg.matrix_rank(left[:, :3], tol=1e-3))
    if len(left) == 1:
        return ("revolute", left[0, :3]) if turns else ("prismatic", left[0, 3:])
    if len(left) == 2 and turns == 1:
        turning = left[np.argmax(np.linalg.norm(left[:, :3], axis=1)), :3]
        return "cylindrical", turning
    if len(left) == 3 and turns == 1:
        return "planar", left[np.argmax(np.linalg.norm(left[:, :3], axis=1)), :3]
    return "loose", None


def _certainty(kind: str, fits: list[Fit], contacts: list[Contact]) -> tuple[str, str]:
    """Return how certain a proposal is, and why."""
    flat = f"{len(contacts)} planes face to face" if len(contacts) > 1 else "a plane face to face"
    if not fits:
        if kind == "prismatic":
            return "possible", f"{flat} leave one direction free: a slide, or parts that are screwed together"
        return "doubtful", f"{flat}: parts that lie on each other, are screwed or glued together, or slide"
    fit = fits[0]
    play = f"play {1e3 * fit.play:.3g} mm" if fit.play > 1e-3 * fit.hole.radius else "no play"
    shafts = f"a shaft of radius {1e3 * fit.shaft.radius:.4g} mm in a hole, {play}, over {1e3 * fit.length:.3g} mm"
    if len(fits) > 1 and kind in {"fixed", "prismatic"}:
        return "possible", f"{len(fits)} shafts in holes of different axes, which cannot turn: pins or bolts"
    if not contacts:
        return "likely", f"{shafts}; it turns, and slides unless another part holds it: 'revolute' then"
    if kind == "revolute":
        return "possible", f"{shafts}, and {flat}: a hinge with a shoulder, or a bolt, which is fixed"
    return "possible", f"{shafts}, and {flat} that keep it from turning"
