"""Interface to gmsh: a `Mesh` from .msh files and .geo / .py sources. The only file that imports gmsh."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import tempfile
import threading
import uuid
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

import numpy as np

from kanefe.errors import FileError, MeshError, MissingDependency, outside
from kanefe.fe_model.model import Cells
from kanefe.fe_model.shapes import row_numbers, shape
from kanefe.storage.watched import long_work
from kanefe_fem.mesh.checks import MeshWarning, refuse_shape
from kanefe_fem.mesh.claimed_counts import check_all_read
from kanefe_fem.mesh.geo_commands import harmless_script, refuse_options
from kanefe_fem.mesh.gmsh_options import kept_options
from kanefe_fem.mesh.mesh import WHOLE_BODY, Mesh
from kanefe_fem.mesh.msh_file import REMEDY, check_complete, msh_version, named_groups
from kanefe_fem.mesh.partitions import ghost_count, own_entities, refuse_parts_of_format_2, refuse_piece
from kanefe_fem.mesh.sagitta import sagitta
from kanefe_fem.mesh.step_unit import own_unit
from kanefe_fem.mesh.unfolded import unfolded

_KINDS = {
    1: "line",
    2: "triangle",
    3: "quad",
    4: "tetra",
    5: "hexahedron",
    6: "wedge",
    7: "pyramid",
    8: "line3",
    9: "triangle6",
    10: "quad9",
    11: "tetra10",
    12: "hexahedron27",
    13: "wedge18",
    14: "pyramid14",
    15: "vertex",
    16: "quad8",
    17: "hexahedron20",
    18: "wedge15",
    19: "pyramid13",
}
_LOCK = threading.Lock()
"""Lock for gmsh, which has one state per process and so serves one reader at a time."""

Block = tuple[int, np.ndarray]
"""Element type of gmsh and node tags (m, nodes per element) of its elements."""


def read(path: Path, order: int | None, trusted: bool = False) -> Mesh:
    """Return the mesh of a .msh file, or of a .geo or .py source meshed with elements of the given order.

    Raises
    ------
    FileError
        If the file is truncated or not a mesh, or if the source has an error, or opens files or runs programs without
        being trusted.
    MeshError
        If there is no usable physical group.
    """
    suffix = path.suffix.lower()
    if suffix == ".msh":
        check_complete(path)
    build = _build_function(path) if suffix == ".py" else None
    script = path.read_text(encoding="utf-8", errors="replace") if suffix == ".geo" else ""
    with _to_merge(path, trusted) as merged, _LOCK, session() as gmsh, _unit(gmsh, suffix), kept_options(gmsh, script):
        if suffix == ".msh":
            refuse_parts_of_format_2(version(gmsh), path)
        try:
            if build is not None:
                build(gmsh)
            else:
                gmsh.merge(str(merged))
            if suffix != ".msh":
                generate(gmsh, order)
            messages = [m for m in gmsh.logger.get() if m.startswith("Error")]
        except Exception as problem:  # gmsh raises bare Exception
            if type(problem) is not Exception:  # an error of the Python source, not of gmsh
                raise
            messages = [m for m in gmsh.logger.get() if m.startswith("Error")] or [str(problem)]
        if messages:
            text = "; ".join(m.removeprefix("Error").lstrip(" :") for m in messages[:3])
            text = text.replace(str(merged), path.name)
            raise FileError(f"gmsh cannot use {path.name}: {text}. Remedy: open the file in gmsh and correct it")
        try:
            mesh = extract(gmsh, path)
        except UnicodeDecodeError as problem:
            raise FileError(f"{path.name} is damaged: a name is not text ({problem}). {REMEDY}") from problem
        if suffix == ".msh" or mesh.dimension == 1:
            return mesh
        return unfolded(mesh) if mesh.order == 2 else replace(mesh, sagitta=sagitta(gmsh))


def _unit(gmsh: Any, suffix: str) -> contextlib.AbstractContextManager[None]:
    """Return what keeps the unit of imported geometry; a mesh has none."""
    return contextlib.nullcontext() if suffix == ".msh" else own_unit(gmsh)


@contextlib.contextmanager
def _to_merge(path: Path, trusted: bool) -> Iterator[Path]:
    """Yield the file for gmsh: a checked copy if the file is a script that is not trusted."""
    if trusted or path.suffix.lower() == ".py":
        yield path
    elif path.suffix.lower() == ".msh":
        refuse_options(path)
        yield path
    else:
        script = harmless_script(path)
        with tempfile.TemporaryDirectory(prefix="kanefe-") as folder:
            copy = Path(folder) / path.name
            copy.write_bytes(script)
            yield copy


@contextlib.contextmanager
def session() -> Iterator[Any]:
    """Yield gmsh with a new empty model and without terminal output; restore a session of the user afterwards."""
    gmsh = _import_gmsh()
    mine = not _is_initialised(gmsh)
    if mine:
        try:
            # interruptible=True installs a signal handler, which only the main thread may do
            gmsh.initialize(["kanefe"], readConfigFiles=False, interruptible=False)
        except TypeError:  # gmsh before 4.11 has no such argument, and installs no handler
            gmsh.initialize(["kanefe"], readConfigFiles=False)
    previous = gmsh.model.getCurrent()
    terminal = gmsh.option.getNumber("General.Terminal")
    gmsh.option.setNumber("General.Terminal", 0)
    name = f"kanefe-{uuid.uuid4().hex[:8]}"
    gmsh.model.add(name)
    gmsh.logger.start()
    try:
        yield gmsh
    finally:
        gmsh.logger.stop()
        if mine:
            _finalise(gmsh)
        else:
            if name in gmsh.model.list():
                gmsh.model.setCurrent(name)
                gmsh.model.remove()
            if previous in gmsh.model.list():
                gmsh.model.setCurrent(previous)
            gmsh.option.setNumber("General.Terminal", terminal)


def _import_gmsh() -> ModuleType:
    """Import gmsh, and keep the handler of the interrupt signal (Ctrl-C), which versions before 4.9 replace."""
    loaded = sys.modules.get("gmsh")
    if loaded is not None:
        return loaded
    handler, install = signal.getsignal(signal.SIGINT), signal.signal
    in_main_thread = threading.current_thread() is threading.main_thread()
    if not in_main_thread:
        # only the main thread may set a handler; otherwise the import would fail
        signal.signal = lambda number, handler: None  # type: ignore[assignment]
    try:
        import gmsh
    except (ImportError, OSError) as problem:  # OSError: a shared library of the wheel is missing
        raise MissingDependency(
            "gmsh",
            "read_mesh (.msh, .geo, .py)",
            "sudo apt-get install python3-gmsh, or pip install gmsh with sudo apt-get install libgl1 libglu1-mesa "
            f"libxcursor1 libxft2 libxinerama1 libgomp1 ({problem})",
        ) from problem
    finally:
        signal.signal = install
        if in_main_thread and handler is not None:
            signal.signal(signal.SIGINT, handler)
    if hasattr(gmsh, "oldsig"):
        gmsh.oldsig = None  # nothing to restore
    return gmsh


def _finalise(gmsh: Any) -> None:
    """Finalise gmsh; older versions set a signal handler here, which only the main thread may do."""
    handler = getattr(gmsh, "oldsig", None)
    if handler is None:
        gmsh.finalize()
        return
    gmsh.oldsig = None
    try:
        gmsh.finalize()
    finally:
        gmsh.oldsig = handler


def _is_initialised(gmsh: Any) -> bool:
    """Return whether gmsh is initialised."""
    if hasattr(gmsh, "isInitialized"):
        return bool(gmsh.isInitialized())
    # gmsh before 4.9: without a session it has no models, and writes an error to the standard error
    saved, null = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(null, 2)
        return len(gmsh.model.list()) > 0
    except Exception:  # noqa: BLE001 - gmsh raises bare Exception
        return False
    finally:
        os.dup2(saved, 2)
        os.close(saved)
        os.close(null)


def _build_function(path: Path) -> Any:
    """Return the function `build` of a Python mesh source."""
    namespace: dict[str, Any] = {"__name__": "kanefe_mesh_source", "__file__": str(path)}
    try:
        exec(compile(path.read_text(encoding="utf-8"), str(path), "exec"), namespace)
    except (SyntaxError, UnicodeDecodeError) as problem:
        raise FileError(f"{path.name} is not a Python source: {problem}") from problem
    build = namespace.get("build")
    if not callable(build):
        raise FileError(
            f"{path.name} defines no function build(gmsh). Remedy: put the gmsh calls that make the geometry and the "
            "physical groups into one (without gmsh.initialize and gmsh.finalize)"
        )
    return build


def generate(gmsh: Any, order: int | None) -> None:
    """Mesh the current model in its highest dimension, unless it is meshed already; set the order."""
    gmsh.model.occ.synchronize()
    dimension = 3 if gmsh.model.getEntities(3) else 2 if gmsh.model.getEntities(2) else 1
    if not len(gmsh.model.mesh.getElements(dimension)[0]):
        for lower in long_work("meshing lines, faces, volumes", range(1, dimension + 1)):
            gmsh.model.mesh.generate(lower)
    if order is not None:
        gmsh.model.mesh.setOrder(order)
    if _is_folded(gmsh, dimension):
        _unfold(gmsh)


def _unfold(gmsh: Any) -> None:
    """Let gmsh move the nodes of folded cells of higher order; cells that remain folded are straightened by `unfolded`.

    If gmsh does not reach its target, it reports an error from another thread, where an exception would end Python.
    """
    before = gmsh.option.getNumber("General.AbortOnError")
    gmsh.option.setNumber("General.AbortOnError", 0)
    with contextlib.suppress(Exception):  # gmsh raises bare Exception
        gmsh.model.mesh.optimize("HighOrder")
    gmsh.option.setNumber("General.AbortOnError", before)
    gmsh.logger.stop()  # discards the error of the optimisation
    gmsh.logger.start()


def _is_folded(gmsh: Any, dimension: int) -> bool:
    """Return whether a cell of higher order folds over itself, as coarse cells on curved geometry do."""
    for kind in gmsh.model.mesh.getElementTypes(dimension):
        _, _, order, count, places, _ = gmsh.model.mesh.getElementProperties(kind)
        if order > 1:
            at_nodes = np.zeros((count, 3))
            at_nodes[:, :dimension] = np.reshape(places, (count, dimension))
            _, determinants, _ = gmsh.model.mesh.getJacobians(kind, at_nodes.ravel())
            of_cells = np.reshape(determinants, (-1, count))
            if np.any(of_cells.min(axis=1) * of_cells.max(axis=1) <= 0.0):
                return True
    return False


def extract(gmsh: Any, path: Path) -> Mesh:
    """Return the current model's mesh, with dense node numbers and VTK's node order."""
    source = path.name
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    nodes = np.asarray(coordinates, dtype=float).reshape(-1, 3)
    if not len(nodes):
        raise MeshError(f"{source} has no nodes. Remedy: mesh the geometry before saving it")
    numbers = _Renumbering(np.asarray(tags, dtype=np.int64), source)
    dimension = next((d for d in (3, 2, 1) if len(gmsh.model.mesh.getElements(d)[0])), 0)
    if dimension == 0:
        raise MeshError(f"{source} has no elements. Remedy: mesh the geometry, and save all elements of its groups")
    refuse_piece(gmsh, dimension, path)
    check_all_read(path, len(nodes), sum(len(ids) for d in range(4) for _, ids in _elements(gmsh, d)))
    ghosts = ghost_count(gmsh, dimension)
    is_version_2 = path.suffix.lower() == ".msh" and msh_version(path).startswith("2")
    file = _Source(source, is_version_2, named_groups(path) if is_version_2 else {})
    groups = {d: _physical_groups(gmsh, d, d == dimension > 1, file) for d in range(4)}
    if path.suffix.lower() == ".msh":
        _warn_of_empty(groups, path)

    def blocks(d: int) -> dict[str, tuple[Cells, ...]]:
        return {
            name: tuple(_cells(gmsh, kind, numbers(ids), f"{source}: group {name!r}") for kind, ids in pieces)
            for name, pieces in groups[d].items()
        }

    points = {
        name: np.concatenate([numbers(ids).reshape(-1) for _, ids in pieces] or [np.zeros(0, dtype=np.int64)])
        for name, pieces in groups[0].items()
    }
    if dimension > 1 and groups[dimension]:
        _warn_left_out(gmsh, dimension, groups[dimension], source)
    elif dimension > 1:
        groups[dimension] = {WHOLE_BODY: _elements(gmsh, dimension)}
    return Mesh(
        nodes=nodes,
        dimension=dimension,
        cells=blocks(dimension) if dimension > 1 else {},
        facets=blocks(dimension - 1) if dimension > 1 else {},
        lines=blocks(1) or (_lines_without_group(gmsh, numbers, source) if dimension == 1 else {}),
        points=points,
        source=source,
        provenance={"reader": f"gmsh {version(gmsh)}", **({"ghost cells left out": str(ghosts)} if ghosts else {})},
    )


class _Source(NamedTuple):
    """Name of the file that is read, whether it has the mesh format 2, and then the names of its groups."""

    name: str
    is_version_2: bool
    names: Mapping[tuple[int, int], str]


class _Renumbering:
    """Function from node tags, which may be any numbers, to row numbers of the node array."""

    def __init__(self, tags: np.ndarray, source: str) -> None:
        self._order = np.argsort(tags, kind="stable")
        self._sorted = tags[self._order]
        self._source = source

    def __call__(self, tags: np.ndarray) -> np.ndarray:
        place = np.minimum(np.searchsorted(self._sorted, tags), len(self._sorted) - 1)
        missing = self._sorted[place] != tags
        if missing.any():
            raise MeshError(
                f"{self._source}: an element names node {tags[missing].flat[0]}, which is not in the file. "
                "Remedy: the file is damaged; write it again"
            )
        return self._order[place]


def _physical_groups(gmsh: Any, dimension: int, body: bool, source: _Source) -> dict[str, list[Block]]:
    """Return the elements of the entities of each group by its name; groups of the same name are merged."""
    owners: dict[int, list[str]] = {}
    for _, tag in gmsh.model.getPhysicalGroups(dimension):
        # of two groups of one name in format 2 gmsh gives the name to the first alone
        name = gmsh.model.getPhysicalName(dimension, tag) or source.names.get((dimension, int(tag))) or str(tag)
        for entity in gmsh.model.getEntitiesForPhysicalGroup(dimension, tag):
            names = owners.setdefault(int(entity), [])
            if name not in names:
                names.append(name)
    found: dict[str, list[Block]] = {}
    for entity, names in owners.items():
        if body and len(names) > 1:
            what = {2: "surface", 3: "volume"}[dimension]
            raise MeshError(
                f"{source.name}: {what} {entity} is in two groups, {names[0]!r} and {names[1]!r}. "
                f"Remedy: a cell has one material, so put each {what} in one physical {what}"
            )
        for kind, ids in _elements(gmsh, dimension, entity):
            kept = ids if body else _without_copies(ids, names, source)
            for name in names:
                found.setdefault(name, []).append((kind, kept))
        for name in names:
            found.setdefault(name, [])
    merged = {}
    for name, pieces in found.items():
        kinds = sorted({kind for kind, _ in pieces})
        merged[name] = [(kind, np.concatenate([ids for k, ids in pieces if k == kind])) for kind in kinds]
    return merged


def _elements(gmsh: Any, dimension: int, entity: int = -1) -> list[Block]:
    """Return the elements of an entity, of all entities if it is -1, without those of ghosts."""
    entities = [entity]
    if entity == -1:
        own = [tag for _, tag in own_entities(gmsh, dimension)]
        entities = own if len(own) < len(gmsh.model.getEntities(dimension)) else [-1]
    blocks: dict[int, list[np.ndarray]] = {}
    for each in entities:
        kinds, _, node_tags = gmsh.model.mesh.getElements(dimension, each)
        for kind, ids in zip(kinds, node_tags, strict=True):
            per_element = gmsh.model.mesh.getElementProperties(kind)[3]
            blocks.setdefault(int(kind), []).append(np.asarray(ids, dtype=np.int64).reshape(-1, per_element))
    return [(kind, np.concatenate(parts)) for kind, parts in blocks.items()]


def _without_copies(ids: np.ndarray, names: list[str], source: _Source) -> np.ndarray:
    """Return facets or lines without duplicates: the format 2.2 repeats an element for each of its groups."""
    _, first, counts = np.unique(row_numbers(np.sort(ids, axis=1)), return_index=True, return_counts=True)
    if source.is_version_2 and len(names) > 1 and (counts != len(names)).any():
        # gmsh has groups of entities only, but this file has different groups for elements of one entity
        raise MeshError(
            f"{source.name}: elements of one elementary entity are in different groups "
            f"({', '.join(map(repr, names))}), which gmsh cannot keep apart. Remedy: number the elementary entities "
            "(second tag of an element) apart"
        )
    return ids[np.sort(first)]


def _lines_without_group(gmsh: Any, numbers: _Renumbering, source: str) -> dict[str, tuple[Cells, ...]]:
    """Return all line elements of a mesh without line groups, under the empty name."""
    blocks = _elements(gmsh, 1)
    return {"": tuple(_cells(gmsh, kind, numbers(ids), f"{source}: lines") for kind, ids in blocks)}


def _cells(gmsh: Any, kind: int, nodes: np.ndarray, label: str) -> Cells:
    """Return a block with its nodes in VTK's order."""
    gmsh_name, dimension, _, count, reference = gmsh.model.mesh.getElementProperties(kind)[:5]
    name = _KINDS.get(kind, gmsh_name)
    refuse_shape(name, label)
    element = shape(name)
    own = np.asarray(reference, dtype=float).reshape(count, -1)[:, :dimension]
    if element.corner_kind == "wedge":
        own[:, 2] = (own[:, 2] + 1.0) / 2.0
    elif (not element.is_simplex or dimension == 1) and element.corner_kind != "pyramid":
        own = (own + 1.0) / 2.0  # gmsh's cubes and lines are [-1, 1]
    permuted = np.empty_like(nodes)
    permuted[:, element.match(own)] = nodes
    return Cells(name, permuted)


def _warn_left_out(gmsh: Any, dimension: int, groups: dict[str, list[Block]], source: str) -> None:
    """Warn of cells of the body that belong to no physical group and are left out, as in gmsh."""
    total = sum(len(ids) for _, ids in _elements(gmsh, dimension))
    kept = sum(len(ids) for pieces in groups.values() for _, ids in pieces)
    if kept < total:
        warnings.warn(
            f"{source}: {total - kept} of {total} cells belong to no physical group and are left out. "
            "Add them to a group if they are part of the body",
            MeshWarning,
            stacklevel=outside(),
        )


def _warn_of_empty(groups: dict[int, dict[str, list[Block]]], path: Path) -> None:
    """Warn of groups that a file names and no element is in."""
    empty = [name for (dimension, _), name in named_groups(path).items() if name not in groups[dimension]]
    if empty:
        them = "it" if len(empty) == 1 else "them"
        warnings.warn(
            f"{path.name} names {', '.join(map(repr, empty))}, and no element is in {them}. "
            "Remedy: write it again without Mesh.SaveAll, which leaves groups out of format 2.2",
            MeshWarning,
            stacklevel=outside(),
        )


def version(gmsh: Any) -> str:
    return str(getattr(gmsh, "GMSH_API_VERSION", None) or gmsh.__version__)


def is_before(gmsh: Any, *wanted: int) -> bool:
    """Return whether gmsh is older than a version, such as 4, 9."""
    return tuple(int(one) for one in version(gmsh).split(".")[: len(wanted)]) < wanted


def set_per_turn(gmsh: Any, count: int) -> None:
    """Let curved faces have so many cells around a full turn; zero: as the size asks."""
    if not is_before(gmsh, 4, 9):
        gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", count)
    elif count:
        gmsh.option.setNumber("Mesh.CharacteristicLengthFromCurvature", 1)
        gmsh.option.setNumber("Mesh.MinimumElementsPerTwoPi", count)
