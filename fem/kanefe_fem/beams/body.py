"""Frames of beams: a `FiniteElementModel` from nodes and line elements, with numpy and scipy only.

The inertia comes from the displacement field (`kanefe_fem.beams.mass`), not from nodal accelerations.

Static deflections under loads at nodes are exact with one element. Frequencies converge with order 4 in the length h
of an element for Euler-Bernoulli bending (relative error (k h)^4/1440 at the wave number k), and with order 2 for
stretch and twist ((k h)^2/24) and for Timoshenko bending, whose shear strain is constant in an element.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import scipy
import scipy.sparse as sp

from kanefe.arguments import checked
from kanefe.errors import ModelError
from kanefe.fe_model.model import COMPONENTS, Cells, FiniteElementModel
from kanefe.fe_model.source import changed_model, with_source
from kanefe.frames import numbers
from kanefe_fem.beams import elements as be
from kanefe_fem.beams.beam_section import BeamSection
from kanefe_fem.beams.checks import Groups, check_elements, check_groups, check_nodes, per_element, warn_of_beam_units
from kanefe_fem.beams.damping import damping_of_beams
from kanefe_fem.beams.geometric_stiffness import BeamStressStiffness
from kanefe_fem.beams.line_loads import check_lines, chosen_lines, line_groups, line_pattern
from kanefe_fem.beams.mass import AXIAL_STATIONS, mass_field
from kanefe_fem.beams.properties import ElementProperties, of_matrices, section_elasticity
from kanefe_fem.beams.split import SplitBeams
from kanefe_fem.machine.memory import check_size
from kanefe_fem.materials.damping import losses_of

if TYPE_CHECKING:
    from kanefe.bodies.flexible import FlexibleBody
    from kanefe.reduction.stiffening import StiffeningLevel
    from kanefe_fem.materials.isotropic import Material

Theory = Literal["timoshenko", "euler-bernoulli"]

ENDS: Groups = {"root": 0, "tip": -1}


@checked("elements", "planar", "rotary_inertia")
def beam_model(
    nodes: np.ndarray | Sequence[Sequence[float]],
    elements: np.ndarray | Sequence[Sequence[int]],
    section: BeamSection | Sequence[BeamSection],
    material: Material | Sequence[Material | None] | None = None,
    *,
    theory: Theory = "timoshenko",
    planar: bool = False,
    orientation: np.ndarray | Sequence[float] | Sequence[Sequence[float]] | None = None,
    rotary_inertia: bool = True,
    groups: Groups = ENDS,
    lines: Groups | None = None,
) -> FiniteElementModel:
    """Return the model of a frame of straight beams, rigidly joined at their nodes (Eq. 40-42).

    Parameters
    ----------
    nodes : array_like, shape (n, 3), or (n, 2) if planar
        Positions in G in m.
    elements : array_like of int, shape (m, 2)
        Node numbers of each element, from 0.
    section : BeamSection or sequence of m of them
        See `kanefe_fem.beams.sections`.
    material : Material or sequence of m of them, optional
        See `kanefe_fem.materials.isotropic`. None: sections by stiffness have none.
    theory : {"timoshenko", "euler-bernoulli"}
        With or without shear strain.
    planar : bool
        Motion in the x-y plane only, three degrees of freedom (x, y, rz) a node. Local z is then the normal of the
        plane: the bending stiffness is the section's `I_z`.
    orientation : array_like, shape (3,) or (m, 3), optional
        Direction in G of local z of the section (its part across the axis). Default: (0, 0, 1), and for elements along
        it any direction if the section is the same in both.
    rotary_inertia : bool
        False: sections have no inertia about y and z when the beam bends (the textbook Euler-Bernoulli beam; Eq. 41).
        In space the polar inertia of twisting is kept, since torsion would have no mass without it. Keep True for
        bodies that move in space: only then the mass matrix has the inertia of every rigid rotation.
    groups : mapping of str to int or sequence of int
        Named nodes, the candidates for interfaces; negative numbers count from the end. Default: the first node is
        "root", the last is "tip".
    lines : mapping of str to int or sequence of int, optional
        Named sets of elements that can carry a load along their axes, and whose nodes are a group unless `groups` has
        one of this name; negative numbers count from the end. Default: all elements are "span", for loads only.

    Returns
    -------
    FiniteElementModel
        In G, with components (x, y, z, rx, ry, rz), or (x, y, rz) if planar.

    Raises
    ------
    ModelError
        If an array has the wrong shape or is not finite, an element has no length, is given twice or has unknown
        nodes, a node is unused, the frame falls into parts, or an orientation is parallel to its element.

    Examples
    --------
    >>> from kanefe_fem.materials.isotropic import Material
    >>> from kanefe_fem.beams.sections import Tube
    >>> steel = Material(E=210e9, nu=0.3, rho=7850.0)
    >>> frame = beam_model([[0, 0, 0], [1, 0, 0], [1, 1, 0]], [[0, 1], [1, 2]], Tube(0.05, 0.003), steel)
    >>> frame.size
    18
    """
    started = time.perf_counter()
    points = check_nodes(nodes, planar)
    connectivity = check_elements(elements, points)
    sections, materials = per_element(section, material, len(connectivity))
    if not isinstance(theory, str) or theory not in ("timoshenko", "euler-bernoulli"):
        raise ModelError(f"unknown beam theory {theory!r}. Remedy: 'timoshenko' or 'euler-bernoulli'")
    node_groups = check_groups(groups, points)
    spans = check_lines({"span": range(len(connectivity))} if lines is None else lines, len(connectivity))

    axes = _element_axes(points, connectivity, sections, orientation, planar)
    losses = [losses_of(material) for material in materials]
    long_term = np.array([own.long_term for own in losses])
    of_sections = long_term[:, None, None] * _section_stiffness(sections, materials, theory, planar)
    lengths = np.linalg.norm(points[connectivity[:, 1]] - points[connectivity[:, 0]], axis=1)
    properties = of_matrices(lengths, of_sections)
    components = tuple(COMPONENTS[row] for row in be.PLANAR_ROWS) if planar else COMPONENTS
    dofs = (connectivity[:, :, None] * len(components) + np.arange(len(components))).reshape(len(connectivity), -1)
    size = len(points) * len(components)

    elastic = properties, axes, dofs, size, planar
    stiffness = assemble_stiffness(*elastic)
    polar_radius = np.sqrt((properties.EI_y + properties.EI_z) / properties.EA)
    masses = [s.mass_of(m) for s, m in zip(sections, materials, strict=True)]
    warn_of_beam_units(lengths, masses, of_sections, materials)
    field = mass_field(points, connectivity, masses, properties, axes, dofs, planar, rotary_inertia)
    mass = symmetric(field.mass_matrix())
    arms = np.asarray(field.arms).reshape(len(connectivity), AXIAL_STATIONS, -1, 3)
    stress_stiffness = BeamStressStiffness(properties, polar_radius, axes, dofs, size, arms, rotary_inertia)
    split = SplitBeams(points, connectivity, sections, materials, orientation, node_groups, spans, lines is not None)
    model = FiniteElementModel(
        nodes=points,
        components=components,
        stiffness=stiffness,
        mass=mass,
        mass_field=field,
        cells=(Cells("line", connectivity),),
        groups={**({} if lines is None else line_groups(spans, points, connectivity)), **node_groups},
        load_patterns={
            name: line_pattern(numbers, points[connectivity], properties, axes, dofs, planar, size)
            for name, numbers in spans.items()
        },
        elasticity=section_elasticity(
            of_sections, axes, _for_pairs(sections, materials, lambda section, material: section.fibres_of(material))
        ),
        stress_stiffness=stress_stiffness,
        **damping_of_beams(losses, mass, lambda shares: assemble_stiffness(*elastic, shares / long_term)),
        provenance={
            "source": "kanefe_fem.beam_model",
            "theory": theory,
            "planar": planar,
            "rotary_inertia": rotary_inertia,
            "nodes": len(points),
            "elements": len(connectivity),
            "dofs": size,
            "versions": {"numpy": np.__version__, "scipy": scipy.__version__},
            "seconds": {"assembly": time.perf_counter() - started},
        },
    )
    options: dict[str, Any] = {"theory": theory, "planar": planar, "rotary_inertia": rotary_inertia}
    return with_source(model, split.source(lambda arrays: beam_model(**arrays, **options)))


@checked("direction", "start", "planar", "rotary_inertia")
def straight_beam(
    length: float,
    section: BeamSection,
    material: Material | None = None,
    *,
    elements: int = 20,
    direction: Sequence[float] = (1.0, 0.0, 0.0),
    start: Sequence[float] = (0.0, 0.0, 0.0),
    theory: Theory = "timoshenko",
    planar: bool = False,
    orientation: Sequence[float] | None = None,
    rotary_inertia: bool = True,
) -> FiniteElementModel:
    """Return the model of one straight uniform beam, with the groups "root" (at `start`) and "tip".

    Parameters
    ----------
    length : float
        In m.
    section, material, theory, planar, orientation, rotary_inertia
        As in `beam_model`.
    elements : int
        Number of equal elements.
    direction, start : array_like, shape (3,)
        Direction of the axis (of any length) and position of the root in m, in G.

    Returns
    -------
    FiniteElementModel
        As from `beam_model`.

    Raises
    ------
    ModelError
        If the length, the direction or the number of elements is not valid; and as `beam_model`.

    Examples
    --------
    >>> from kanefe_fem.materials.isotropic import Material
    >>> from kanefe_fem.beams.sections import Rectangle
    >>> steel = Material(E=210e9, nu=0.3, rho=7850.0)
    >>> beam = straight_beam(1.0, Rectangle(0.05, 0.1), steel, elements=10)
    >>> sorted(beam.groups)
    ['root', 'tip']
    """
    if numbers(length).shape != () or not 0.0 < numbers(length) < np.inf:
        raise ModelError(f"straight_beam: length = {length!r} must be positive and finite. Remedy: give it in m")
    if not isinstance(elements, (int, np.integer)) or elements < 1:
        raise ModelError(f"straight_beam: elements = {elements!r} must be a whole number of at least 1")
    check_size(int(elements), f"straight_beam: elements={elements!r}")
    axis, origin = np.asarray(direction, dtype=float), np.asarray(start, dtype=float)
    if axis.shape != (3,) or origin.shape != (3,) or not np.linalg.norm(axis) > 0.0:
        raise ModelError("straight_beam: direction and start must have three components, direction not all zero")
    stations = np.linspace(0.0, length, elements + 1)
    nodes = origin + stations[:, None] * axis / np.linalg.norm(axis)
    first = np.arange(elements)
    return beam_model(
        nodes,
        np.column_stack([first, first + 1]),
        section,
        material,
        theory=theory,
        planar=planar,
        orientation=orientation,
        rotary_inertia=rotary_inertia,
    )


@checked("model", "interfaces")
def beam_body(
    model: FiniteElementModel,
    interfaces: Mapping[str, Any],
    reduction: Any = None,
    damping: Any = None,
    *,
    stiffening: StiffeningLevel = "none",
    lines: Sequence[str] | None = None,
) -> FlexibleBody:
    """Return the flexible body of a beam model, for a scene.

    Parameters
    ----------
    model : FiniteElementModel
        From `beam_model`, `straight_beam` or `beam_model_from_mesh`.
    interfaces, reduction, damping, stiffening
        As in `kanefe.reduction.flexible_body`.
    lines : sequence of str, optional
        Lines of the model that the body keeps for loads along them. Default: all.

    Returns
    -------
    FlexibleBody
        The reduced (or, with ``reduction=None``, full) body.

    Raises
    ------
    ModelError
        If the model has no such line; and as `kanefe.reduction.flexible_body`.
    """
    from kanefe.reduction import flexible_body

    if lines is not None:
        chosen_lines(model.load_patterns, lines)  # refuses unknown ones
        model = changed_model(
            model, lambda whole: replace(whole, load_patterns=chosen_lines(whole.load_patterns, lines))
        )
    return flexible_body(model, interfaces, reduction=reduction, damping=damping, stiffening=stiffening)


def _element_axes(
    points: np.ndarray, table: np.ndarray, sections: list[BeamSection], orientation: Any, planar: bool
) -> np.ndarray:
    """Return A_GL of each element, local axes as columns, shape (m, 3, 3)."""
    x = points[table[:, 1]] - points[table[:, 0]]
    x /= np.linalg.norm(x, axis=1)[:, None]
    towards = numbers((0.0, 0.0, 1.0) if orientation is None else orientation)
    if towards.shape not in ((3,), x.shape) or not np.isfinite(towards).all():
        raise ModelError(f"orientation has shape {towards.shape}. Remedy: a direction (3,), or one for each element")
    towards = np.broadcast_to(towards, x.shape).copy()
    if planar and (towards[:, :2] != 0.0).any():
        raise ModelError("orientation: local z of a planar model is the normal of the plane. Remedy: leave it out")
    scale = np.linalg.norm(towards, axis=1)
    # below a thousandth of a radian the direction of the part across is practically arbitrary
    lost = np.linalg.norm(np.cross(x, towards), axis=1) <= 1e-3 * scale
    for number in np.flatnonzero(lost):
        if orientation is not None or not sections[number].turns_freely:
            raise ModelError(
                f"the orientation {towards[number].tolist()} of element {number} (nodes {table[number].tolist()}) is "
                "zero or parallel to the element, so that its section can turn freely. Remedy: give "
                "`orientation`, for this element a direction across it"
            )
        towards[number] = np.eye(3)[np.argmin(np.abs(x[number]))]
    y = np.cross(towards, x)
    y /= np.linalg.norm(y, axis=1)[:, None]
    return np.stack([x, y, np.cross(x, y)], axis=-1)


def _section_stiffness(
    sections: list[BeamSection], materials: list[Material | None], theory: Theory, planar: bool
) -> np.ndarray:
    """Return the stiffness of each element's section, shape (m, 6, 6)."""
    table = np.array(
        _for_pairs(sections, materials, lambda section, material: section.stiffness_of(material, planar=planar))
    )
    if theory == "euler-bernoulli":
        table[:, 1:3, :] = table[:, :, 1:3] = 0.0
        table[:, [1, 2], [1, 2]] = np.inf
    return table


def _for_pairs(
    sections: list[BeamSection],
    materials: list[Material | None],
    function: Callable[[BeamSection, Material | None], Any],
) -> list[Any]:
    """Return a function of section and material for each element, computed once for each different pair."""
    made: dict[tuple[int, int], Any] = {}
    for section, material in zip(sections, materials, strict=True):
        if (id(section), id(material)) not in made:
            made[id(section), id(material)] = function(section, material)
    return [made[id(section), id(material)] for section, material in zip(sections, materials, strict=True)]


def assemble_stiffness(
    properties: ElementProperties,
    axes: np.ndarray,
    dofs: np.ndarray,
    size: int,
    planar: bool,
    shares: np.ndarray | None = None,
) -> sp.csr_matrix:
    """Return K of elements with the axes A_GL and these degrees of freedom, (size, size), or of shares of each (m,)."""
    K = be.rotate_element_matrix(be.spatial_stiffness(properties), be.spatial_transformation(axes))
    if shares is not None:
        K = shares[:, None, None] * K
    if planar:
        K = K[:, be.PLANAR_DOFS][:, :, be.PLANAR_DOFS]
    width = dofs.shape[1]
    rows, columns = np.repeat(dofs, width, axis=1).ravel(), np.tile(dofs, width).ravel()
    return symmetric(sp.coo_matrix((K.ravel(), (rows, columns)), shape=(size, size)).tocsr())


def symmetric(matrix: sp.csr_matrix) -> sp.csr_matrix:
    """Return the symmetric part, since products in floating point are symmetric only up to round-off."""
    return (0.5 * (matrix + matrix.T)).tocsr()
