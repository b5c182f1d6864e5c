"""Cut for me: a slender beam or solid as a chain of linear segments (finite-segment method, IECS)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal, Unpack

import numpy as np

from kanefe.arguments import checked, told
from kanefe.bodies.segmented import CUT, Segment, SegmentedBody
from kanefe.bodies.source import sourced
from kanefe.errors import ModelError
from kanefe.fe_model.damping import RayleighDamping
from kanefe.fe_model.factorise import splu_factorise
from kanefe.fe_model.interface import Interface
from kanefe.fe_model.model import FiniteElementModel
from kanefe.reduction import CraigBampton, flexible_body
from kanefe.reduction.stiffening import StiffeningLevel
from kanefe_fem.mesh.mesh import Mesh, part_of
from kanefe_fem.mesh_files import read_mesh
from kanefe_fem.segments.accuracy import converged
from kanefe_fem.segments.source import source_of_chain
from kanefe_fem.segments.whole import BeamWhole, Division, SolidWhole, Whole
from kanefe_fem.solids.model import SolidKeywords


class SegmentKeywords(SolidKeywords, total=False):
    """Keywords of the segments of `segmented`."""

    reduction: Any
    damping: Any
    stiffening: StiffeningLevel
    cuts: Literal["rigid", "average"]


@checked("segments", "accuracy", "loads")
def segmented(
    body: FiniteElementModel | Mesh | str | Path,
    interfaces: Mapping[str, str | Interface],
    materials: Any = None,
    *,
    segments: int | None = None,
    accuracy: float | None = None,
    loads: Mapping[str, Sequence[float]] | None = None,
    along: Callable[[SegmentedBody], Any] | None = None,
    line: Sequence[Sequence[float]] | None = None,
    **options: Unpack[SegmentKeywords],
) -> SegmentedBody:
    """Cut a slender beam or solid into a chain of linear bodies, which can bend without limit.

    Each segment is a flexible body with its own frame G (finite-segment method); cut faces are interfaces with their
    static modes, and a segment is fixed on that of its neighbour. One element a segment is the limit (IECS). The error
    falls with the square of the number of segments: 16 of them have about 1e-3 of the length in a beam whose tip turns
    by a radian.

    Parameters
    ----------
    body : FiniteElementModel, Mesh, str or Path
        A model of `beam_model`, `straight_beam` or `beam_model_from_mesh`; or the mesh of a solid, or its file.
    interfaces : dict of str to str or Interface
        As for `beam_body` and `solid_body`; each in one segment, away from cuts. Those fixed in G must be in one
        segment. Without such, G of the whole moves with a cut in the middle, and the body needs a free joint.
    materials : SolidMaterial or dict of str to SolidMaterial, optional
        Of a mesh.
    segments : int, optional
        Number of segments, of equal lengths as far as elements allow.
    accuracy : float, optional
        Instead of `segments`, or from that number on: the number is doubled until twice as many change the
        displacements of the interfaces (over the length), their rotations (rad) and the first three frequencies (over
        themselves) by less, extrapolated with order 2. ``chain.found`` has the differences.
    loads : dict of str to array_like, shape (6,), optional
        Force (N) and moment (N m) at interfaces, in axes of G and of fixed direction, under which they are compared.
        Default: weight of 1 g along each axis in turn.
    along : callable, optional
        ``along(chain) -> Result`` of a run in which the chain is the body called "body", to compare along it instead.
    line : array_like, shape (p, 3), optional
        Centre line of a solid, m. Default: found.
    **options
        The other parameters below.

    Other Parameters
    ----------------
    reduction : optional
        Of each segment. Default: ``CraigBampton(modes=0)``, the static modes of the cuts.
    damping : RayleighDamping, optional
        In proportion to the stiffness alone: other kinds would damp the modes of each segment.
    stiffening : "none", "inertial" or "full"
        With "full", cut faces also move by the foreshortening of a segment, so that errors in statics fall with the
        cube of the number. Runs and modes then need segments that bend by at most half their thickness over their
        length (rad).
    cuts : "average" or "rigid"
        How the cut faces of a solid are tied (see `Interface`): they deform freely and segments move with their mean,
        or they stay plane, which stiffens the body. Default: "average".
    order, plane, thickness, surfaces, cells, densities
        As for `solid_model`.

    Returns
    -------
    SegmentedBody
        For `System.add_segmented_body`.

    Raises
    ------
    ModelError, MeshError
        If the body is too stout or its centre line branches, closes or crosses itself; if an interface lies at a cut or
        in several segments; if interfaces of several segments are fixed; or the accuracy is not reached.

    Examples
    --------
    >>> from kanefe_fem import Material, Rectangle, straight_beam
    >>> beam = straight_beam(2.0, Rectangle(0.01, 0.02), Material(E=70e9, nu=0.3, rho=2700.0), elements=32)
    >>> segmented(beam, {"root": "clamped", "tip": "rigid"}, segments=8)
    SegmentedBody(1.08 kg, 8 segments, 33 nodes, interfaces: root, tip)
    """
    given: dict[str, Any] = dict(options)
    own: dict[str, Any] = {
        name: given.pop(name) for name in ("reduction", "damping", "stiffening", "cuts") if name in given
    }
    if not isinstance(cuts := own.get("cuts", "average"), str) or cuts not in ("average", "rigid"):
        raise ModelError(f"cuts={told(cuts)} of segments. Remedy: 'average' or 'rigid'")
    _check_damping(own.get("damping"))
    whole = _whole(body, interfaces, materials, line, given)
    if segments is None and accuracy is None:
        raise ModelError("segmented needs segments=<number> or accuracy=<relative error>")
    if accuracy is None:
        if loads is not None or along is not None:
            raise ModelError("loads= and along= say where accuracy= is measured. Remedy: give accuracy too")
        chain = _chain(whole, int(1 if segments is None else segments), own)
    else:
        chain = converged(lambda count: _chain(whole, count, own), segments, accuracy, loads, along)
    asked = {"materials": materials, "line": line, **options}
    return sourced(chain, source_of_chain(segmented, body, interfaces, asked))


def _check_damping(damping: Any) -> None:
    """Refuse damping that acts on the modes of each segment instead of those of the whole."""
    if damping is None or (isinstance(damping, RayleighDamping) and damping.mass == 0.0):
        return
    raise ModelError(
        f"damping={told(damping)} of segments would act on the modes of each segment, not of the whole. Remedy: "
        "RayleighDamping(mass=0.0, stiffness=ratio / (pi f)), which has this ratio at the frequency f in Hz"
    )


def _whole(body: Any, interfaces: Mapping[str, Any], materials: Any, line: Any, options: Mapping[str, Any]) -> Whole:
    if not isinstance(interfaces, Mapping):
        raise ModelError(f"interfaces={interfaces!r} must be a dict of names to kinds: {{'root': 'clamped'}}")
    named = [name for name in interfaces if str(name).startswith(CUT)]
    if named:
        raise ModelError(f"interface {named[0]!r} has a name of the faces of cuts. Remedy: another name")
    if isinstance(body, FiniteElementModel):
        given = [name for name, value in (("materials", materials), ("line", line)) if value is not None]
        given += list(options)
        if given:
            raise ModelError(f"{given[0]} is for meshes of solids; a beam model has its own. Remedy: leave it out")
        return BeamWhole(body, interfaces)
    if isinstance(body, (str, Path)):
        body = read_mesh(body, order=2) if options.get("order", 2) == 2 else read_mesh(body)
    if not isinstance(body, Mesh):
        raise ModelError(f"the body to be cut is a beam model or a mesh, not {told(body)}. Remedy: beam_model(...)")
    if materials is None:
        raise ModelError("a mesh of a solid needs materials=, as in solid_body")
    keywords: dict[str, Any] = dict(options)
    return SolidWhole(part_of(body, keywords.pop("cells", None)), materials, interfaces, line, keywords)


def _chain(whole: Whole, count: int, options: Mapping[str, Any]) -> SegmentedBody:
    if count < 1:
        raise ModelError(f"segments = {count} must be a whole number of at least 1")
    division = whole.divided(count)
    owners = {name: _owner(whole, division, name, spec) for name, spec in whole.interfaces.items()}
    base, holds = _base(whole, owners, count)
    segments = []
    for number in range(count):
        inner = number if number > base else number + 1  # the cut towards the base
        origin = np.zeros(3) if number == base else division.middles[inner - 1]
        model, nodes, cells = whole.part(division, number, origin)
        own = {
            name: replace(spec, position=tuple(np.array(spec.position) - origin)) if spec.position is not None else spec
            for name, spec in whole.interfaces.items()
            if owners[name] == number
        }
        if number == base:
            inner = 0 if holds else max(1, base) if count > 1 else 0
        for cut in (number, number + 1):
            if 0 < cut < count:
                kind = options.get("cuts", "average")
                place = tuple((division.middles[cut - 1] - origin).tolist())
                fixed = "all" if cut == inner else ()
                own[f"{CUT}{cut}"] = Interface(fixed, kind=kind, position=place, groups=f"{CUT}{cut}")
        made = _segment(model, own, options)
        told_place = {"number": number, "count": count, "base": base, "origin": origin.tolist()}
        told_place |= {"nodes": nodes.tolist(), "cells": cells.tolist()}
        told_place["interfaces"] = {
            frame.name: {"position": (frame.position + origin).tolist(), "axes": frame.axes.tolist()}
            for frame in made.interfaces
        }
        made = replace(made, provenance={**made.provenance, "segment": told_place})
        segments.append(Segment(made, origin, nodes, cells))
    return SegmentedBody(tuple(segments), base, whole.nodes, whole.line)


def _segment(model: FiniteElementModel, interfaces: Mapping[str, Interface], options: Mapping[str, Any]) -> Any:
    reduction = options.get("reduction")
    if reduction is None:
        is_moved = any(len(spec.fixed) == 0 for spec in interfaces.values())
        reduction = CraigBampton(modes=0 if is_moved else 6 if "z" in model.components else 3)
    return flexible_body(
        model,
        interfaces,
        reduction=reduction,
        damping=options.get("damping"),
        stiffening=options.get("stiffening", "none"),
        factorise=_factorise(model),
    )


def _factorise(model: FiniteElementModel) -> Any:
    if model.cells[0].kind == "line":
        return splu_factorise
    from kanefe_fem._petsc import factorise

    return factorise


def _owner(whole: Whole, division: Division, name: str, spec: Interface) -> int:
    """Return the segment that has an interface."""
    nodes = np.concatenate([whole.group(group) for group in spec.group_names(name)])
    count = len(division.nodes)
    for cut, face in enumerate(division.faces, 1):
        if np.isin(nodes, face).any():
            raise ModelError(
                f"interface {name!r} lies at the cut between segments {cut} and {cut + 1} of {count}. Remedy: another "
                "number of segments, or node(number) for loads and springs"
            )
    owners = [number for number, own in enumerate(division.nodes) if np.isin(nodes, own).any()]
    if len(owners) > 1:
        raise ModelError(
            f"interface {name!r} reaches from segment {owners[0] + 1} to {owners[-1] + 1} of {count}. Remedy: fewer "
            "segments, or an interface of a shorter part"
        )
    return owners[0]


def _base(whole: Whole, owners: Mapping[str, int], count: int) -> tuple[int, bool]:
    """Return the segment whose G is that of the whole, and whether an interface is fixed in it."""
    fixed = {name: owners[name] for name, spec in whole.interfaces.items() if len(spec.fixed)}
    if len(set(fixed.values())) > 1:
        one = next(iter(fixed))
        other = next(name for name in fixed if fixed[name] != fixed[one])
        raise ModelError(
            f"interfaces {one!r} and {other!r} are fixed in G, but belong to segments {fixed[one] + 1} and "
            f"{fixed[other] + 1}. Remedy: make one of them 'rigid', and hold it by scene.add_loop_joint"
        )
    return (next(iter(fixed.values())), True) if fixed else (count // 2, False)
