"""The source of a segmented body: the model or mesh that was cut, and into how many segments."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from kanefe.bodies.segmented import SegmentedBody
from kanefe.bodies.source import Changes, Rebuildable, Source, belongs_to_nodes, kept_places
from kanefe.fe_model.model import FiniteElementModel
from kanefe.fe_model.source import Changeable
from kanefe_fem.mesh.body_source import MeshSource
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.mesh_files import read_mesh

AS_CUT = "the number of segments stays; segments= changes it"

GIVEN = "the model was changed after it was made"


def _read(mesh: Any, order: int, cells: Any) -> Mesh:
    """Return the mesh as `segmented` reads it."""
    return mesh if isinstance(mesh, Mesh) else read_mesh(mesh, order=2 if order == 2 else None, cells=cells)


def source_of_chain(
    make: Callable[..., SegmentedBody], body: Any, interfaces: Mapping[str, Any], options: Mapping[str, Any]
) -> Source:
    """Return the source of a chain that ``make(body, interfaces, segments=..., **options)`` makes."""
    interfaces, options, order = dict(interfaces), dict(options), options.get("order", 2)
    of_mesh = None if isinstance(body, FiniteElementModel) else MeshSource(_read, body, options, order)

    def again(chain: SegmentedBody, changes: Changes) -> SegmentedBody:
        own, places = kept_places(interfaces) if changes.refined else (interfaces, {})
        given = {**options, "segments": changes.segments or len(chain.segments)}
        whole = body
        if of_mesh is not None:
            given |= of_mesh.split(changes.refined, places, chain.segments[0].body.provenance.get("sha256"))
            whole = given.pop("mesh")
        elif changes.refined:
            whole = body.source.make(changes.refined, None, places)
        changed = changes.of_body(options.get("reduction"), options.get("stiffening", "none"))
        given |= changed | ({} if changes.order is None else {"order": changes.order})
        return make(whole, own, **{name: value for name, value in given.items() if value is not None})

    def about(chain: SegmentedBody) -> Rebuildable:
        if of_mesh is None:
            unknown = GIVEN if body.source is None else ""
            mesh, degree = Changeable(None, unknown), Changeable(1, "elements of beams have one order")
        else:
            mesh, degree = of_mesh.changeable()
        cells = sum(len(block.nodes) for segment in chain.segments for block in segment.body.cells)
        by_number = belongs_to_nodes(interfaces, None)
        return Rebuildable(
            Changeable(chain.segments[0].body.rebuildable.reduction.now),
            Changeable(options.get("stiffening", "none")),
            Changeable(cells, mesh.why_not, AS_CUT).but(by_number),
            degree.but(by_number),
        )

    return Source(again, about)
