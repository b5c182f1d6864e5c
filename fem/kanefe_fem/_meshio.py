"""Interface to meshio, for formats other than gmsh's and decks of Abaqus and Nastran; no other file imports meshio."""

from __future__ import annotations

import contextlib
import io
import re
import shutil
import tempfile
import warnings
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from kanefe.errors import FileError, KanefeError, MissingDependency, outside
from kanefe.storage.hdf5 import h5py_for
from kanefe_fem.mesh.checks import MeshWarning
from kanefe_fem.mesh.claimed_counts import check_counts
from kanefe_fem.mesh.grouped import Group, dimension_of, grouped_mesh
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.mesh.named_files import check_named_files
from kanefe_fem.mesh.su2_markers import marker_names

GROUP_DATA = (
    "gmsh:physical",
    "medit:ref",
    "group",
    "cell_tags",
    "MaterialID",
    "CellEntityIds",
    "Label",
    "tetgen:ref",
    "netgen:index",
    "avsucd:material",
    "ugrid:ref",
)
"""Names of integer cell data with the numbers of groups, in order of precedence."""

COLOURS = ("red", "green", "blue", "alpha")
"""Names of cell data of .ply files that are no groups."""

QUADRATIC = {"wedge15": 3, "pyramid13": 3}
"""Dimensions of shapes that meshio knows but for these."""

VTK_NUMBERS = {
    "char": "int8",
    "short": "int16",
    "int": "int32",
    "long": "int64",
    **{f"unsigned_{name}": f"uint{bits}" for name, bits in (("char", 8), ("short", 16), ("int", 32), ("long", 64))},
}
"""Types of numbers in legacy files of VTK 5.1, by C's names; meshio has `int` as that of the machine, 8 bytes."""

HEAD = 1000
"""Length of the beginning of a .vtu file in which its version is looked for, bytes."""

_VTU_VERSION = re.compile(rb"<VTKFile\b[^>]*\bversion\s*=\s*[\"'](2\.\d)[\"']")

MARKERS = "su2:tag"
"""Name of the cell data with the numbers of markers of SU2."""

NAMES_OF_MARKERS = "does not support tags of string type"
"""Part of what meshio says of SU2, whose names of markers are read apart."""

READS_AT_END = 1000
"""Number of reads at the end of a file above which its reader is in an endless loop."""


def read(path: Path, names: Mapping[int, str], trusted: bool = False) -> Mesh:
    """Return the mesh of a file that meshio can read.

    Groups come from meshio's cell sets; otherwise from the families of a MED file; otherwise from the markers of SU2;
    otherwise from the first cell data among `GROUP_DATA`, named by the file's field data, by `names`, or by the number
    itself. Point
    sets (and families of points) are groups of points.

    Raises
    ------
    FileError
        If meshio does not know the format, or the file is damaged.
    """
    if path.suffix.lower() == ".wkt":  # the regular expression of its reader may take exponential time
        raise FileError(f"{path.name}: surfaces of .wkt are not read. Remedy: write it as .stl, .ply or .vtu")
    check_named_files(path, trusted)
    check_counts(path)
    raw = _read(path)
    try:
        return _mesh_of(raw, path, names)
    except KanefeError:
        raise
    except (ValueError, IndexError, KeyError, TypeError) as problem:  # from what meshio returns for a damaged file
        raise FileError(
            f"{path.name} is not a complete mesh: {type(problem).__name__}: {problem}. Remedy: check that the file is "
            "complete and its suffix right"
        ) from problem


def _mesh_of(raw: Any, path: Path, names: Mapping[int, str]) -> Mesh:
    """Return meshio's mesh as a `Mesh`."""
    blocks = [(block.type, np.asarray(block.data, dtype=np.int64)) for block in raw.cells]
    points = {name: np.asarray(ids, dtype=np.int64) for name, ids in raw.point_sets.items()}
    return grouped_mesh(
        path,
        np.asarray(raw.points, dtype=float),
        blocks,
        _groups_from_sets(raw)
        or _groups_from_families(raw)
        or _groups_from_markers(raw, path)
        or _groups_from_data(raw, names, path),
        points | _point_families(raw),
        reader=f"meshio {_import_meshio().__version__}",
    )


def _read(path: Path) -> Any:
    """Return meshio's mesh; catch the exit of the process and the output by which meshio reports errors.

    What it leaves out it tells on the terminal only: that is a warning here.
    """
    meshio = _import_meshio()
    printed = io.StringIO()
    try:
        with _readable(path) as copy, contextlib.redirect_stdout(printed), contextlib.redirect_stderr(printed):
            raw = meshio.read(copy)
    except (Exception, SystemExit) as problem:  # meshio's readers raise any exception for damaged files
        reason = str(problem) if str(problem) not in ("", "1") else " ".join(printed.getvalue().split())
        reason = f"it does not know {problem}" if isinstance(problem, KeyError) else reason
        raise FileError(
            f"meshio cannot read {path.name}: {reason or type(problem).__name__}. Remedy: check that the file is "
            "complete and its suffix right; formats are .vtu, .vtk, .xdmf, .med, ..."
        ) from problem
    told = [" ".join(line.split()) for line in printed.getvalue().split("Warning:")]
    said = "; ".join(line.rstrip(".") for line in told if line and NAMES_OF_MARKERS not in line)
    if said:
        warnings.warn(
            f"{path.name}: meshio says: {said}. Remedy: check what is missing in the mesh",
            MeshWarning,
            stacklevel=outside(),
        )
    return raw


def _import_meshio() -> Any:
    try:
        import meshio
    except ImportError as problem:
        raise MissingDependency("meshio", "read_mesh of other formats than gmsh's", "pip install meshio") from problem
    for module in (meshio._files, meshio.tetgen._tetgen):  # the modules that open files
        module.open = _open_that_ends
    meshio._mesh.topological_dimension.update(QUADRATIC)
    meshio.vtk._vtk_51.vtk_to_numpy_dtype_name.update(VTK_NUMBERS)
    return meshio


@contextlib.contextmanager
def _readable(path: Path) -> Iterator[Path]:
    """Yield the file for meshio, or a copy that it can read.

    It reads no .vtu of version 2, whose cells of order 1 and 2 are those of version 1, and no .med with families that
    are of no group, as medcoupling writes them for what is in none.
    """
    change = {".vtu": _as_version_1, ".med": _with_groups_only}.get(path.suffix.lower())
    with tempfile.TemporaryDirectory(prefix="kanefe-") as folder:
        copy = Path(folder) / path.name
        yield copy if change is not None and change(path, copy) else path


def _as_version_1(path: Path, copy: Path) -> bool:
    """Write a .vtu of version 2 as one of version 1; return whether it is one."""
    content = path.read_bytes()
    head = _VTU_VERSION.search(content[:HEAD])
    if head is None:
        return False
    copy.write_bytes(content[: head.start(1)] + b"1.0" + content[head.end(1) :])
    return True


def _with_groups_only(path: Path, copy: Path) -> bool:
    """Write a .med file without families that are of no group; return whether it has some."""
    h5py = h5py_for("read_mesh of .med")
    if not h5py.is_hdf5(path):
        return False
    with h5py.File(path) as file:
        kinds = [
            f"FAS/{mesh}/{kind}"
            for mesh in file.get("FAS", {})
            for kind in ("ELEME", "NOEUD")
            if f"FAS/{mesh}/{kind}" in file
        ]
        bare = [f"{kind}/{name}" for kind in kinds for name in file[kind] if "GRO" not in file[kind][name]]
    if bare:
        shutil.copyfile(path, copy)
        with h5py.File(copy, "r+") as file:
            for name in bare:
                del file[name]
    return bool(bare)


class _Ends(io.IOBase):
    """A file that stops readers which search for a line without end, as those of .ply, .off and .tec do."""

    _reads_at_end = 0

    def readline(self, size: int | None = -1) -> Any:
        line = super().readline(size)
        self._reads_at_end = 0 if line else self._reads_at_end + 1
        if self._reads_at_end > READS_AT_END:
            raise EOFError("it ends where more should follow")
        return line


class _BytesThatEnd(_Ends, io.BufferedReader):
    pass


class _TextThatEnds(_Ends, io.TextIOWrapper):
    pass


def _open_that_ends(path: str | Path, mode: str = "r") -> Any:
    if mode not in ("r", "rb"):
        return open(path, mode)
    file = _BytesThatEnd(io.FileIO(path))
    return file if mode == "rb" else _TextThatEnds(file)


def _groups_from_sets(raw: Any) -> list[Group]:
    """Return (name, rows of each block) from meshio's cell sets, without those that gmsh's reader adds."""
    return [(name, list(rows)) for name, rows in raw.cell_sets.items() if not name.startswith("gmsh:")]


def _groups_from_families(raw: Any) -> list[Group]:
    """Return (name, rows of each block) of a MED file, whose families are sets of cells in the same groups."""
    families = getattr(raw, "cell_tags", None)
    if not families or "cell_tags" not in raw.cell_data:
        return []
    data = [np.asarray(values).reshape(-1) for values in raw.cell_data["cell_tags"]]
    return [
        (name, [np.flatnonzero(np.isin(values, members)) for values in data])
        for name, members in _members(families).items()
    ]


def _point_families(raw: Any) -> dict[str, np.ndarray]:
    """Return the points of each group of a MED file."""
    families, numbers = getattr(raw, "point_tags", None), raw.point_data.get("point_tags")
    if not families or numbers is None:
        return {}
    return {name: np.flatnonzero(np.isin(numbers, members)) for name, members in _members(families).items()}


def _members(families: Mapping[int, list[str]]) -> dict[str, list[int]]:
    """Return the families of each group."""
    groups: dict[str, list[int]] = {}
    for number, names in families.items():
        for name in names:
            groups.setdefault(name, []).append(int(number))
    return groups


def _groups_from_markers(raw: Any, path: Path) -> list[Group]:
    """Return (name, rows of each block) of the markers of an SU2 mesh; its cells are in none."""
    if MARKERS not in raw.cell_data:
        return []
    body = max(dimension_of(block.type) for block in raw.cells)
    data = [np.asarray(values).reshape(-1) for values in raw.cell_data[MARKERS]]
    return [
        (
            name,
            [
                np.flatnonzero(values == number) if dimension_of(block.type) < body else None
                for block, values in zip(raw.cells, data, strict=True)
            ],
        )
        for number, name in marker_names(path).items()
    ]


def _groups_from_data(raw: Any, names: Mapping[int, str], path: Path) -> list[Group]:
    """Return (name, rows of each block) from integer cell data."""
    key = next((name for name in GROUP_DATA if name in raw.cell_data), None)
    if key is None:
        _warn_of_other_numbers(raw, path)
        return []
    data = [np.asarray(values).reshape(-1).astype(np.int64) for values in raw.cell_data[key]]
    known = {(int(tag), int(d)): name for name, (tag, d) in _field_data(raw)}
    groups: list[Group] = []
    for number in np.unique(np.concatenate(data)):
        if key in ("gmsh:physical", "ugrid:ref") and number == 0:
            continue  # no group there
        for dimension in sorted({dimension_of(block.type) for block in raw.cells}):
            name = known.get((int(number), dimension)) or names.get(int(number)) or str(number)
            rows = [
                np.flatnonzero(values == number) if dimension_of(block.type) == dimension else None
                for block, values in zip(raw.cells, data, strict=True)
            ]
            groups.append((name, rows))
    return groups


def _warn_of_other_numbers(raw: Any, path: Path) -> None:
    """Warn of cell data that may be the numbers of groups: whole numbers that some cells share and not all."""
    for name, data in raw.cell_data.items():
        values = np.concatenate([np.asarray(part) for part in data]) if data else np.zeros(0)
        is_whole = values.ndim == 1 and np.issubdtype(values.dtype, np.integer)
        if is_whole and name not in COLOURS and 1 < len(np.unique(values)) < len(values):
            warnings.warn(
                f"{path.name} has whole numbers {name!r} of its cells, which are not taken for groups. Remedy: none, "
                "if they are others; else 'group' as their name",
                MeshWarning,
                stacklevel=outside(),
            )


def _field_data(raw: Any) -> list[tuple[str, tuple[int, int]]]:
    """Return gmsh's physical names, (name, (tag, dimension)), if the file has them."""
    return [(name, tuple(value)) for name, value in raw.field_data.items() if len(np.atleast_1d(value)) == 2]
