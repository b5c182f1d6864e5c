"""A chain of beam elements, and parts of its model: matrices and mass of some elements, without new integrals."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from kanefe.errors import ModelError
from kanefe.fe_model.model import Cells, Elasticity, FiniteElementModel, MassField, NodeGroup
from kanefe_fem.beams.body import assemble_stiffness, symmetric
from kanefe_fem.beams.geometric_stiffness import BeamStressStiffness
from kanefe_fem.beams.line_loads import line_pattern
from kanefe_fem.beams.properties import properties_of


@dataclass(frozen=True, eq=False)
class BeamChain:
    """A beam model whose elements form one chain.

    Attributes
    ----------
    model : FiniteElementModel
    nodes, elements : ndarray of int
        In their order along the chain, from the node that comes first in the model.
    width : float
        Of the widest section: the diameter of a full circle with its radius of gyration, m.
    """

    model: FiniteElementModel
    nodes: np.ndarray
    elements: np.ndarray
    width: float


def beam_chain(model: FiniteElementModel) -> BeamChain:
    """Return the chain that the elements of a beam model form.

    Raises
    ------
    ModelError
        If they branch or close, or something is attached to them.
    """
    stress = model.stress_stiffness
    if not isinstance(stress, BeamStressStiffness) or model.elasticity is None:
        raise ModelError(
            "only models of beam_model, straight_beam and beam_model_from_mesh can be cut. Remedy: one of these; of a "
            "solid give the mesh and materials= instead of the model"
        )
    if "lumped" in model.provenance or model.damping is not None:
        raise ModelError(
            "a beam model with lumped masses, springs or a damping matrix cannot be cut. Remedy: attach them to "
            "interfaces, as rigid bodies, bushings and damping=RayleighDamping(...)"
        )
    table = model.cells[0].nodes
    ends = np.bincount(table.ravel(), minlength=len(model.nodes))
    if (ends > 2).any():
        raise ModelError(
            f"the beams branch at node {int(np.argmax(ends > 2))}, so that there is no centre line. Remedy: a body for "
            "each branch, joined by loop joints or as parent and child"
        )
    if not (ends == 1).any():
        raise ModelError("the beams form a ring. Remedy: leave one node open and close it by add_loop_joint")
    elements: list[int] = []
    nodes = [int(np.argmax(ends == 1))]
    while len(elements) < len(table):
        around = np.flatnonzero((table == nodes[-1]).any(axis=1))
        following = int(next(e for e in around if not elements or e != elements[-1]))
        elements.append(following)
        nodes.append(int(table[following].sum() - nodes[-1]))
    own, is_planar = stress.properties, "z" not in model.components
    radius = np.sqrt((own.EI_z if is_planar else np.maximum(own.EI_z, own.EI_y)) / own.EA)
    return BeamChain(model, np.array(nodes), np.array(elements), float(4.0 * radius.max()))


def beam_part(chain: BeamChain, elements: np.ndarray, origin: np.ndarray) -> tuple[FiniteElementModel, np.ndarray]:
    """Return the model of some elements, about an origin (3,) in m, and the numbers of its nodes in the whole."""
    model, stress, elasticity = chain.model, chain.model.stress_stiffness, chain.model.elasticity
    field = model.mass_field
    if not isinstance(stress, BeamStressStiffness) or elasticity is None or elasticity.axes is None or field is None:
        raise ModelError("only models of beams have parts")
    table = model.cells[0].nodes[elements]
    used = np.unique(table)
    table = np.searchsorted(used, table)
    points, axes, width = model.nodes[used] - origin, elasticity.axes[elements], len(model.components)
    dofs = (table[:, :, None] * width + np.arange(width)).reshape(len(table), -1)
    size, planar = len(used) * width, width == 3
    own = Elasticity(elasticity.table, elasticity.of_cell[elements], axes, elasticity.fibres)
    properties = properties_of(own, np.linalg.norm(points[table[:, 1]] - points[table[:, 0]], axis=1))

    of_element = len(field.points) // len(model.cells[0].nodes)
    rows = (elements[:, None] * of_element + np.arange(of_element)).ravel()
    vectors = (rows[:, None] * 3 + np.arange(3)).ravel()
    columns = (used[:, None] * width + np.arange(width)).ravel()
    part = MassField(
        points=field.points[rows] - origin,
        mass=field.mass[rows][:, rows],
        interpolation=field.interpolation[vectors][:, columns],
        turns=None if field.turns is None else field.turns[vectors][:, columns],
        arms=None if field.arms is None else field.arms[rows],
    )
    return (
        replace(
            model,
            nodes=points,
            stiffness=assemble_stiffness(properties, axes, dofs, size, planar),
            mass=symmetric(part.mass_matrix()),
            mass_field=part,
            cells=(Cells("line", table),),
            groups=_groups(model, used, origin),
            load_patterns={
                name: line_pattern(np.flatnonzero(inside), points[table], properties, axes, dofs, planar, size)
                for name, pattern in model.load_patterns.items()
                if pattern.cells is not None and (inside := np.isin(elements, pattern.cells)).any()
            },
            elasticity=own,
            stress_stiffness=BeamStressStiffness(
                properties,
                stress.polar_radius[elements],
                axes,
                dofs,
                size,
                stress.arms[elements],
                stress.rotary_inertia,
            ),
        ),
        used,
    )


def _groups(model: FiniteElementModel, used: np.ndarray, origin: np.ndarray) -> dict[str, NodeGroup]:
    """Return the groups whose nodes are all among some."""
    return {
        name: replace(group, nodes=np.searchsorted(used, group.nodes), position=group.position - origin)
        for name, group in model.groups.items()
        if np.isin(group.nodes, used).all()
    }
