"""The cache of bodies and models made from a mesh.

The key is a digest of the bytes of the mesh file, of all options, of kanefe's own code, and of the versions of the
packages on which the results depend. It needs neither gmsh nor dolfinx.
"""

from __future__ import annotations

import ast
import importlib.util
import os
import re
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import fields, replace
from importlib import import_module
from pathlib import Path
from typing import Any

import kanefe
from kanefe.bodies import cache
from kanefe.bodies.flexible import FlexibleBody, file_kind
from kanefe.errors import outside
from kanefe.fe_model.model import FiniteElementModel
from kanefe.storage.digest import Unhashable, code_stamp, digest, installed_versions
from kanefe.storage.files import cache_folder
from kanefe.storage.unfinished import resumable
from kanefe_fem.machine.memory import MemoryWarning
from kanefe_fem.mesh.mesh import Mesh

PACKAGES = ("fenics-dolfinx", "dolfinx-solver-real", "petsc4py", "numpy", "scipy", "meshio")
"""Distributions whose versions are part of the key."""

WHOLE = (".msh", ".vtu", ".vtk", ".med", ".mesh", ".meshb", ".inp", ".bdf", ".nas", ".cdb", ".geo", ".py")
"""Formats with the whole mesh in one file, unless it includes others. Files of all other formats are read first."""

WARNINGS = {
    "accuracy": "kanefe_fem.materials.isotropic:AccuracyWarning",
    "deck": "kanefe.imports.included:DeckWarning",
    "error": "kanefe.errors:AccuracyWarning",
    "imported body": "kanefe.imports.sid_file:SidWarning",
    "mesh": "kanefe_fem.mesh.checks:MeshWarning",
    "modes": "kanefe.reduction.normal_modes:ModesWarning",
    "nodal form": "kanefe.imports.nodal_inertia:NodalFormWarning",
    "simulation": "kanefe.errors:SimulationWarning",
    "tie": "kanefe.fe_model.rigid_patch_error:TieWarning",
    "units": "kanefe.errors:UnitWarning",
}
"""Warnings that are kept with a body, as "module:Class" by name: see `kanefe.storage.saved_classes`."""

_INCLUDES = re.compile(rb"^\s*\*?(include|merge)\b", re.IGNORECASE | re.MULTILINE)
_PURE_MODULES = {"__future__", "math", "cmath", "itertools", "functools", "collections", "typing", "numpy", "gmsh"}
_WAYS_OUT = {"open", "exec", "eval", "__import__", "compile", "input", "globals", "__file__", "merge"}
_WAYS_OUT |= {"load", "loadtxt", "genfromtxt", "fromfile"}


def cached_body(
    mesh: Mesh | str | Path, options: Mapping[str, Any], make: Callable[[Mesh | str | Path], FlexibleBody]
) -> FlexibleBody:
    """Return the body that ``make(mesh)`` makes, from the cache if it was made before.

    Its ``provenance["cache"]`` is ``{"key", "found"}``, or ``{"skipped": reason}`` if the content of an option cannot
    be digested. For a new body, its entry "model" is the same for the model from which it was made. The warnings that
    were given when a body was made are repeated. Long work that was ended is taken up again (see
    `kanefe.storage.unfinished`).

    Parameters
    ----------
    mesh : Mesh, str or Path
    options : dict
        Everything else from which the body is made.
    make : callable
        Function of the mesh that makes the body.
    """
    if not cache.is_on():
        return make(mesh)
    mesh = _read_where_needed(mesh, options.get("order", 1), options.get("cells"))
    try:
        key = _key(mesh, options)
    except Unhashable as reason:
        return _noted(make(mesh), {"skipped": str(reason)})
    found = cache.find(key)
    if found is not None:
        _warn_again(found.provenance)
        return replace(found, provenance={**found.provenance, "cache": {"key": key, "found": True}})
    with _own_warnings() as heard, resumable(cache_folder() / "unfinished" / key):
        body = make(mesh)
    if type(body) is not FlexibleBody:
        # its matrices are those of its model, which is in the cache
        return _noted(body, {"skipped": "the body is not reduced"})
    body = _noted(replace(body, provenance={**body.provenance, "warnings": heard}), {"key": key, "found": False})
    cache.keep(key, body)
    return body


def cached_model(
    mesh: Mesh | str | Path, options: Mapping[str, Any], make: Callable[[], FiniteElementModel]
) -> FiniteElementModel:
    """Return the full-order model that ``make()`` makes, from the cache if it was made before; see `cached_body`.

    A model from the cache has no function of the geometric stiffness.

    Parameters
    ----------
    mesh : Mesh, str or Path
    options : dict
        Everything else from which the model is made.
    make : callable
        Function without arguments that makes the model.
    """
    if not cache.is_on():
        return make()
    try:
        key = _key(mesh, {"model": options})
    except Unhashable as reason:
        model = make()
        return replace(model, provenance={**model.provenance, "cache": {"skipped": str(reason)}})
    found = cache.find_model(key)
    if found is not None:
        _warn_again(found.provenance)
        return replace(found, provenance={**found.provenance, "cache": {"key": key, "found": True}})
    with _own_warnings() as heard:
        model = make()
    note = {"warnings": heard, "cache": {"key": key, "found": False}}
    model = replace(model, provenance={**model.provenance, **note})
    cache.keep_model(key, model)
    return model


def is_whole(path: Path) -> bool:
    """Return whether a mesh depends only on the bytes of its file, which neither includes files nor runs other code."""
    suffix = path.suffix.lower()
    if suffix not in WHOLE:
        return False
    if suffix == ".py":
        return _is_pure(path)
    return suffix not in (".geo", ".inp", ".bdf", ".nas", ".cdb") or _INCLUDES.search(path.read_bytes()) is None


def _is_pure(path: Path) -> bool:
    """Return whether the result of a Python source depends only on its text and a few known modules."""
    try:
        tree = ast.parse(path.read_bytes())
    except (SyntaxError, ValueError):
        return False
    for node in ast.walk(tree):
        modules: list[str] = []
        if isinstance(node, ast.Import):
            modules = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            modules = ["." * node.level + (node.module or "")]
        used = node.id if isinstance(node, ast.Name) else node.attr if isinstance(node, ast.Attribute) else ""
        if used in _WAYS_OUT or any(module.partition(".")[0] not in _PURE_MODULES for module in modules):
            return False
    return True


def _read_where_needed(mesh: Mesh | str | Path, order: int, cells: str | Sequence[str] | None) -> Mesh | str | Path:
    """Return the mesh, read from its file if its content does not depend on the bytes of this file alone."""
    if isinstance(mesh, Mesh) or not os.path.isfile(mesh) or is_whole(Path(mesh)):
        return mesh
    from kanefe_fem.mesh_files import read_to_assemble

    return read_to_assemble(mesh, order, cells)


def _key(mesh: Mesh | str | Path, options: Mapping[str, Any]) -> str:
    """Return the digest of a mesh, of options, and of the versions on which the results depend."""
    return digest(mesh=_content(mesh), options=options, kanefe=_versions(mesh))


def _noted(body: FlexibleBody, note: dict[str, Any]) -> FlexibleBody:
    """Return a new body with a note on the cache, to which the note of its model is added."""
    of_model = body.provenance.get("cache")
    return replace(
        body, provenance={**body.provenance, "cache": note if of_model is None else {**note, "model": of_model}}
    )


def _warn_again(provenance: Mapping[str, Any]) -> None:
    """Repeat the warnings that were given when the body or model was made."""
    for category, text in provenance.get("warnings", ()):
        warnings.warn(text, _category(category), stacklevel=outside())


def _content(mesh: Mesh | str | Path) -> Any:
    """Return the content of a mesh for the digest."""
    if isinstance(mesh, Mesh):
        return {f.name: getattr(mesh, f.name) for f in fields(mesh)}
    path = Path(mesh)
    if not os.path.isfile(path):
        raise Unhashable(f"there is no file {path.name}")  # making the body gives a better message
    return {"name": path.name, "content": path}


def _versions(mesh: Mesh | str | Path) -> dict[str, Any]:
    """Return the versions of our own code, of packages, and of gmsh if it makes the mesh."""
    found: dict[str, Any] = {
        "format": file_kind().version,
        "code": code_stamp(Path(kanefe.__file__).parent, Path(__file__).parent),
        **installed_versions(*PACKAGES),
    }
    if not isinstance(mesh, Mesh) and Path(mesh).suffix.lower() in (".geo", ".py"):
        # Debian's gmsh is not a Python distribution, but its module contains its version
        spec = importlib.util.find_spec("gmsh")
        found["gmsh"] = Path(spec.origin) if spec and spec.origin else None
    return found


@contextmanager
def _own_warnings() -> Iterator[list[list[str]]]:
    """Record the warnings of kanefe, as [word of the category, text], and show them as usual."""
    heard: list[list[str]] = []
    words = {place: word for word, place in WARNINGS.items()}
    with warnings.catch_warnings():
        usual = warnings.showwarning

        def note(message: Any, category: Any, *where: Any, **more: Any) -> None:
            own = category.__module__.partition(".")[0] in ("kanefe", "kanefe_fem")
            if own and category not in (MemoryWarning, cache.CacheWarning):  # of the machine, not of the body
                place = f"{category.__module__}:{category.__qualname__}"
                heard.append([words.get(place, category.__qualname__), str(message)])
            usual(message, category, *where, **more)

        warnings.showwarning = note
        yield heard


def _category(word: str) -> type[Warning]:
    """Return a category of warnings by its word."""
    if word not in WARNINGS:
        return UserWarning
    module, _, name = WARNINGS[word].partition(":")
    found: type[Warning] = getattr(import_module(module), name)
    return found
