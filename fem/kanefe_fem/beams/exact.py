"""Beams that bend far, from sections along a line: `exact_beam`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from kanefe.arguments import checked
from kanefe.bodies.exact.beam import ExactBeam, exact_beam_body
from kanefe.bodies.exact.beam_line import BeamLine, magnus, turns_of_vectors
from kanefe.bodies.exact.build import STRAINS, SectionFields, beam_line
from kanefe.bodies.exact.inertia import BeamInertia
from kanefe.bodies.exact.strain_basis import Legendre, StrainBasis
from kanefe.bodies.source import sourced
from kanefe.errors import ModelError
from kanefe.fe_model.damping import ModalDamping, RayleighDamping, damping_of
from kanefe.fe_model.model import Elasticity
from kanefe.frames import numbers
from kanefe_fem.beams.beam_section import BeamSection
from kanefe_fem.beams.checks import check_material
from kanefe_fem.beams.exact_source import source_of_beam
from kanefe_fem.beams.properties import section_elasticity
from kanefe_fem.materials.damping import refuse_losses

if TYPE_CHECKING:
    from kanefe_fem.materials.isotropic import Material

Theory = Literal["shear-rigid", "stretching", "shear-deformable"]

SectionAt = Callable[[float], BeamSection]

KEPT: dict[str, tuple[str, ...]] = {
    "shear-rigid": ("twist", "curvature_y", "curvature_z"),
    "stretching": ("stretch", "twist", "curvature_y", "curvature_z"),
    "shear-deformable": STRAINS,
}
"""Strains that a beam of a theory has."""

IN_PLANE = ("stretch", "shear_y", "curvature_z")
"""Strains of motions in the x-y plane."""

SPARE_POINTS = 4
"""Gauss points of a cell beyond the number of functions of a strain. The error of the 45-degree bend (two radians, 8
functions a strain) falls from 5e-10 to 2e-10 of the length from 4 to 6."""


@checked("length", "planar")
def exact_beam(
    length: float,
    section: BeamSection | Callable[[float], BeamSection],
    material: Material | None = None,
    *,
    theory: Theory = "shear-rigid",
    planar: bool = False,
    basis: int | StrainBasis | Mapping[str, int | StrainBasis] = 8,
    curvature: Sequence[float] | Callable[[float], Sequence[float]] = (0.0, 0.0, 0.0),
    axes: Sequence[Sequence[float]] | np.ndarray | None = None,
    interfaces: Mapping[str, float] | None = None,
    damping: RayleighDamping | ModalDamping | None = None,
) -> ExactBeam:
    """Return a geometrically exact beam, which may bend and turn as far as it likes, as a flexible body.

    Its coordinates are those of the strains along it (Boyer et al. 2021; Renda et al. 2020), which converge
    exponentially where sections and loads are smooth. The frame G of the body is fixed to the root section.

    Parameters
    ----------
    length : float
        Along the axis at rest, m.
    section : BeamSection or callable
        See `kanefe_fem.beams.sections`; a function of the arc length (m) for a taper.
    material : Material, optional
        None: sections by stiffness have none.
    theory : {"shear-rigid", "stretching", "shear-deformable"}
        Which strains there are besides twist and bending: none, stretch, or stretch and shear. A slender beam needs
        none; stretch and shear are stiff, so that explicit methods take small steps.
    planar : bool
        Motion in the x-y plane of the section axes only; the bending stiffness is the section's `I_z`.
    basis : int, StrainBasis, or mapping of str to either
        Functions of each strain: so many Legendre polynomials, or `kanefe.Legendre`, `kanefe.BSpline`; by the name of
        the strain ("twist", "curvature_y", "curvature_z", "stretch", "shear_y", "shear_z") where they differ.
    curvature : array_like, shape (3,), or callable
        Twist, and curvature about y and about z, of the beam at rest, 1/m; a function of the arc length where they
        vary.
    axes : array_like, shape (3, 3), optional
        Axes of the root section, at the origin of G, as columns, x along the beam. Default: those of G.
    interfaces : mapping of str to float, optional
        Arc lengths (m) of the sections to which something is attached, or where sections or curvatures jump; with the
        axes of G at rest, see `ExactBeam.section_orientation`. Default: "root" at 0 and "tip" at the end.
    damping : RayleighDamping or ModalDamping, optional
        Of the rates of the strains, which rigid motions do not have, with the modes and the mass of the beam at rest.
        ``RayleighDamping(stiffness=...)`` is a viscous material.

    Returns
    -------
    ExactBeam

    Raises
    ------
    ModelError
        If an argument is not valid; the message names it.

    Examples
    --------
    >>> from kanefe_fem import Material, Rectangle
    >>> spring_steel = Material(E=210e9, nu=0.3, rho=7850.0)
    >>> strip = exact_beam(1.0, Rectangle(0.001, 0.02), spring_steel)
    >>> strip.free_count
    24
    """
    if not 0.0 < length < np.inf:
        raise ModelError(f"exact_beam: length = {length!r} must be positive and finite. Remedy: give it in m")
    length = float(length)
    if not isinstance(theory, str) or theory not in KEPT:
        raise ModelError(f"exact_beam: unknown theory {theory!r}. Remedy: one of {', '.join(map(repr, KEPT))}")
    kept = [name for name in KEPT[theory] if not planar or name in IN_PLANE]
    bases = _bases(basis, kept)
    where = _interfaces(interfaces, length)
    inner = sorted({*where.values()} - {0.0, length})
    root = _root(axes)
    section_at = _sections(section, material)
    fields = _fields(section_at, material, curvature, planar)
    _check_positive(fields, length, [STRAINS.index(name) for name in kept], inner)
    points = max(b.degree for b in bases.values()) + 1 + SPARE_POINTS
    line, K = beam_line(length, fields, bases, inner, points, root)
    if damping is not None and not isinstance(damping, (RayleighDamping, ModalDamping)):
        raise ModelError(f"exact_beam: damping = {damping!r}. Remedy: kanefe.RayleighDamping or kanefe.ModalDamping")
    C = np.zeros_like(K) if damping is None else damping_of(damping, K, BeamInertia(line).elastic_mass)
    ends = np.cumsum(line.lengths)
    stations = {name: 0 if s == 0.0 else line.end_node(int(np.abs(ends - s).argmin())) for name, s in where.items()}
    provenance = {"source": "kanefe_fem.exact_beam", "theory": theory, "planar": planar, "length": length}
    body = exact_beam_body(line, K, C, stations, provenance, _elasticity(line, section_at, material, planar))
    options: dict[str, Any] = {
        "length": length,
        "section": section,
        "material": material,
        "theory": theory,
        "planar": planar,
    }
    options |= {"curvature": curvature, "axes": axes, "interfaces": interfaces, "damping": damping}
    return sourced(body, source_of_beam(exact_beam, basis, options))


def _bases(given: Any, kept: Sequence[str]) -> dict[int, StrainBasis]:
    """Return the functions of each strain by its number."""
    by_name = given if isinstance(given, Mapping) else dict.fromkeys(kept, given)
    unknown = [name for name in by_name if name not in kept]
    if unknown or not by_name:
        raise ModelError(f"exact_beam: basis names {unknown or 'no strain'}; this beam has {', '.join(kept)}")
    missing = [name for name in kept if name not in by_name]
    if missing:
        raise ModelError(f"exact_beam: basis has no functions for {', '.join(missing)}. Remedy: give them a number")
    found = {}
    for name in sorted(by_name, key=STRAINS.index):
        one = by_name[name]
        if isinstance(one, StrainBasis):
            found[STRAINS.index(name)] = one
        elif isinstance(one, (int, np.integer)) and not isinstance(one, bool) and one >= 1:
            found[STRAINS.index(name)] = Legendre(int(one))
        else:
            raise ModelError(
                f"exact_beam: basis of {name} = {one!r}. Remedy: a number of polynomials from 1, Legendre or BSpline"
            )
    return found


def _interfaces(given: Mapping[str, float] | None, length: float) -> dict[str, float]:
    """Return the arc length of each interface."""
    if given is None:
        return {"root": 0.0, "tip": length}
    if not isinstance(given, Mapping) or not given:
        raise ModelError(
            "exact_beam: interfaces is not a mapping of names. Remedy: arc lengths in m by name, such as {'tip': 1.0}"
        )
    places = _places(list(given.values()), length)
    return dict(zip(given, places, strict=True))


def _places(given: Sequence[float], length: float) -> list[float]:
    """Return arc lengths within the beam; those within round-off of an end are there."""
    s = numbers(given)
    if s.ndim != 1 or not np.all((s >= -1e-12 * length) & (s <= (1.0 + 1e-12) * length)):
        raise ModelError(
            f"exact_beam: interfaces: {given!r} must be arc lengths within the beam, from 0 to {length:g} m"
        )
    near = np.where(s <= 1e-12 * length, 0.0, np.where(s >= (1.0 - 1e-12) * length, length, s))
    return [float(value) for value in near]


def _root(axes: Any) -> np.ndarray:
    """Return the axes of the root section."""
    root = np.eye(3) if axes is None else numbers(axes).astype(float)
    if root.shape != (3, 3) or np.abs(root.T @ root - np.eye(3)).max() > 1e-9 or np.linalg.det(root) < 0.0:
        raise ModelError(
            "exact_beam: axes must be a rotation matrix (3, 3) with the axes of the root section as columns"
        )
    return root


def _sections(section: Any, material: Any) -> SectionAt:
    """Return a function that gives the section at an arc length, checked."""
    made: dict[float, BeamSection] = {}
    if not isinstance(section, BeamSection) and not callable(section):
        raise ModelError(f"exact_beam: section = {section!r}. Remedy: a section such as Rectangle, or a function of s")

    def section_at(s: float) -> BeamSection:
        if s not in made:
            found = section if isinstance(section, BeamSection) else section(float(s))
            if not isinstance(found, BeamSection):
                raise ModelError(f"exact_beam: section at {s:g} m is {found!r}. Remedy: see kanefe_fem.Rectangle")
            check_material(found, material, "an exact beam")
            refuse_losses(material, "an exact beam", "damping=RayleighDamping(stiffness=...) of the beam")
            made[s] = found
        return made[s]

    return section_at


def _elasticity(line: BeamLine, section_at: SectionAt, material: Any, planar: bool) -> Elasticity:
    """Return stiffness, axes and fibres of the sections in the middle between stations, for pictures and stresses."""
    middles = [section_at(s) for s in 0.5 * (line.stations[1:] + line.stations[:-1])]
    different = {id(one): one for one in middles}
    stiffness = {key: one.stiffness_of(material, planar=planar) for key, one in different.items()}
    fibres = {key: one.fibres_of(material) for key, one in different.items()}
    half = turns_of_vectors(0.5 * magnus(line.turn_rest.reshape(-1, 3, 3))[0])
    numbers_of = [id(one) for one in middles]
    return section_elasticity(
        np.array([stiffness[i] for i in numbers_of]), line.at_rest[0][:-1] @ half, [fibres[i] for i in numbers_of]
    )


def _fields(section_at: SectionAt, material: Any, curvature: Any, planar: bool) -> SectionFields:
    """Return the properties of the sections over the arc length."""

    def stiffness(s: np.ndarray) -> np.ndarray:
        found = np.array([section_at(x).stiffness_of(material, planar=planar) for x in s])
        return np.where(np.isfinite(found), found, 0.0)

    def inertia(s: np.ndarray) -> np.ndarray:
        found = np.zeros((len(s), 3, 3))
        for one, x in zip(found, s, strict=True):
            second = section_at(x).mass_of(material).second
            one[0, 0] = np.trace(second)
            one[1:, 1:] = np.trace(second) * np.eye(2) - second
        return found

    def centre(s: np.ndarray) -> np.ndarray:
        return np.array([(0.0, *section_at(x).mass_of(material).centre) for x in s])

    def mass(s: np.ndarray) -> np.ndarray:
        return np.array([section_at(x).mass_of(material).rho_A for x in s])

    def curved(s: np.ndarray) -> np.ndarray:
        found = np.array([numbers(curvature(float(x)) if callable(curvature) else curvature) for x in s], dtype=float)
        if found.shape != (len(s), 3) or not np.isfinite(found).all():
            raise ModelError("exact_beam: curvature must be three finite numbers: twist, curvature about y and about z")
        if planar and found[:, :2].any():
            raise ModelError("exact_beam: a planar beam has no twist and no curvature about y. Remedy: planar=False")
        return found

    return SectionFields(stiffness, mass, centre, inertia, curved)


def _check_positive(fields: SectionFields, length: float, kept: list[int], inner: Sequence[float]) -> None:
    """Raise an error where a strain that the beam has meets no stiffness."""
    ends = np.array([0.0, *inner, length])
    for s in np.concatenate((ends[:-1], 0.5 * (ends[:-1] + ends[1:]))):
        D = fields.stiffness(np.array([s]))[0]
        for strain in kept:
            if not D[strain, strain] > 0.0:
                raise ModelError(
                    f"exact_beam: the section at {s:g} m has no finite, positive stiffness against {STRAINS[strain]}. "
                    "Remedy: give it; or a theory without this strain"
                )
        own = D[np.ix_(kept, kept)]
        size = np.sqrt(np.diag(own))
        if np.linalg.eigvalsh(own / np.outer(size, size))[0] <= 0.0:
            raise ModelError(
                f"exact_beam: the stiffness of the section at {s:g} m is not positive. Remedy: check its signs"
            )
