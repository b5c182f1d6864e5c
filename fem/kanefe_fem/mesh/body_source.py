"""The source of bodies and models made from a mesh: the mesh or its file, and what else their maker was given."""

from __future__ import annotations

import hashlib
import os
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from kanefe.bodies.flexible import FlexibleBody
from kanefe.bodies.source import Changes, Rebuildable, Source, belongs_to_nodes, kept_places, now_of
from kanefe.errors import AccuracyWarning, FileError
from kanefe.fe_model.model import FiniteElementModel
from kanefe.fe_model.place_field import LoadShape
from kanefe.fe_model.places import PlaceLike
from kanefe.fe_model.skin import facets_at, group_at
from kanefe.fe_model.source import Changeable, ModelSource
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.mesh.refinement import refined_mesh

SAME_SHAPE = "smaller cells keep the shape of those they come from"
"""Limit of splitting in a mesh whose source is curved, or not known."""

Read = Callable[[Mesh | str | Path, int, str | Sequence[str] | None], Mesh]


@dataclass(frozen=True, eq=False)
class MeshSource:
    """A mesh, or its file, with the arguments of the maker of a model or a body.

    Attributes
    ----------
    read : callable
        ``read(mesh, order, cells) -> Mesh``.
    mesh : Mesh, str or Path
    options : dict
        Other keywords of the maker, among them "cells".
    order : int
        Of the displacement.
    fixed_order : str
        Why the order cannot be changed; empty if it can.
    by_number : str
        What belongs to the numbers of nodes of this mesh.
    """

    read: Read
    mesh: Mesh | str | Path
    options: Mapping[str, Any]
    order: int
    fixed_order: str = ""
    by_number: str = ""

    def split(self, refined: int, places: Mapping[str, PlaceLike], sha256: str | None) -> dict[str, Any]:
        """Return the keywords of the maker with a mesh whose cells are split, after places became groups of it."""
        is_shell = bool(self.fixed_order)
        self.check_file(sha256)
        if not refined:
            return {"mesh": self.mesh, **self.options}
        mesh = self.read(self.mesh, self.order, self.options.get("cells"))
        options = {**self.options, "cells": None}
        if isinstance(options.get("surfaces"), Mapping) and not is_shell:
            mesh, options["surfaces"] = _on_groups(mesh, options["surfaces"])
        return {**options, "mesh": refined_mesh(placed(mesh, places, is_shell=is_shell), refined)}

    def check_file(self, sha256: str | None) -> None:
        """Raise a FileError if the file of the mesh is not that of which the body was made."""
        if isinstance(self.mesh, Mesh):
            return
        path = Path(self.mesh)
        if os.path.isfile(path) and sha256 not in (None, hashlib.sha256(path.read_bytes()).hexdigest()):
            raise FileError(
                f"{path.name} is not the file any more of which the body was made. Remedy: make the body again from it"
            )

    def changeable(self) -> tuple[Changeable, Changeable]:
        """Return whether mesh and order can be changed."""
        gone = "" if isinstance(self.mesh, Mesh) or os.path.isfile(self.mesh) else f"there is no file {self.mesh} now"
        told = SAME_SHAPE
        if self.fixed_order and isinstance(self.options.get("surfaces"), Mapping):
            told = f"{SAME_SHAPE}; surfaces by place hold the smaller cells that lie in it"
        mesh = Changeable(None, gone or self.by_number, told)
        return mesh, Changeable(self.order, self.fixed_order or gone or self.by_number)


def body_source(
    make: Callable[..., FlexibleBody], source: MeshSource, of_body: Mapping[str, Any], interfaces: Mapping[str, Any]
) -> Source:
    """Return the source of a body that ``make(mesh=..., interfaces=..., **options)`` makes.

    Parameters
    ----------
    make : callable
    source : MeshSource
    of_body : dict
        reduction, damping, stiffening.
    interfaces : dict of str to str or Interface
    """
    interfaces = dict(interfaces)
    by_number = source.by_number or belongs_to_nodes(interfaces, of_body["damping"])
    source = replace(source, by_number=by_number)

    def again(body: FlexibleBody, changes: Changes) -> FlexibleBody:
        own, places = kept_places(interfaces) if changes.refined else (dict(interfaces), {})
        given = source.split(changes.refined, places, body.provenance.get("sha256"))
        if changes.order is not None:
            given["order"] = changes.order
        return make(
            interfaces=own, **given, **{**of_body, **changes.of_body(of_body["reduction"], of_body["stiffening"])}
        )

    def about(body: FlexibleBody) -> Rebuildable:
        mesh, order = source.changeable()
        now = replace(
            now_of(body), reduction=Changeable(of_body["reduction"]), stiffening=Changeable(of_body["stiffening"])
        )
        return replace(now, mesh=replace(mesh, now=now.mesh.now), order=order)

    return Source(again, about)


def model_source(make: Callable[..., FiniteElementModel], source: MeshSource, sha256: str | None) -> ModelSource:
    """Return the source of a model that ``make(mesh=..., **options)`` makes."""

    def again(refined: int, order: int | None, places: Mapping[str, PlaceLike]) -> FiniteElementModel:
        given = source.split(refined, places, sha256)
        return make(**given, **({} if order is None else {"order": order}))

    return ModelSource(again, *source.changeable())


def _on_groups(mesh: Mesh, surfaces: Mapping[str, Any]) -> tuple[Mesh, dict[str, Any]]:
    """Return the mesh with groups for surfaces by place, and the surfaces by these groups."""
    kept, places = dict(surfaces), dict[str, PlaceLike]()
    for name, what in surfaces.items():
        of = what.of if isinstance(what, LoadShape) else what
        if not isinstance(of, str):
            group = f"{name} (by its place)"
            places[group] = of
            kept[name] = replace(what, of=group) if isinstance(what, LoadShape) else group
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", AccuracyWarning)  # facets that a border cuts were told of the body before
        return mesh.with_groups(places), kept


def placed(mesh: Mesh, places: Mapping[str, PlaceLike], *, is_shell: bool) -> Mesh:
    """Return the mesh with groups of the facets, or else of the nodes, that lie in places."""
    facets, points = dict(mesh.facets), dict(mesh.points)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", AccuracyWarning)  # facets that a border cuts were told of the body before
        for name, place in places.items():
            where = mesh.nodes, mesh.cell_blocks, place, f"interface {name!r}"
            if found := facets_at(*where, is_shell=is_shell):
                facets[name] = found
            else:
                points[name] = group_at(*where, is_shell=is_shell).nodes
    return replace(mesh, facets=facets, points=points)
