"""The door to pyevtk: the motion of a scene as files for ParaView."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple
from xml.sax.saxutils import escape

import numpy as np

from kanefe.errors import FileError, MissingDependency, ModelError
from kanefe.fe_model.drawn_shell import drawn_shell
from kanefe.fe_model.model import CELL_TYPES
from kanefe.fe_model.shapes import shape as element
from kanefe.fe_model.thick_shell import ThickShell, layered
from kanefe.frames import numbers, rotation_matrix
from kanefe.results.body_shape import BodyShape
from kanefe.results.contact_history import STATUS, ContactHistory
from kanefe.results.load_lines import GONE, SLACK, LoadLine
from kanefe.results.selection import spread_frames
from kanefe.results.wholes import parts_of_cells
from kanefe.storage.files import ready_path
from kanefe.storage.watched import long_work
from kanefe.views.cuboids import CORNERS, equivalent_cuboid

try:
    from pyevtk.vtk import VtkFile, VtkGroup, VtkUnstructuredGrid
except ImportError as _error:
    raise MissingDependency("pyevtk", "Result.to_vtk", "pip install pyevtk") from _error

if TYPE_CHECKING:
    from kanefe.results.reader import Reader

MOST_FRAMES = 200
"""Default number of frames written."""

SMALLEST_SIDE = 0.02
"""Side of the box that represents a point, relative to the scene's size."""

WRITTEN_TYPES = CELL_TYPES | {"wedge": 73, "wedge18": 73}
"""VTK's number of each shape of cell in files. VTK turned its wedge, 13, inside out between 9.6 and 9.7, and the volume
of its 18 nodes, 32, is a sixth of the true one to 9.6; both are right as Lagrange's wedges in either."""

_FRAME = re.compile(r"(body\d+|rigid|contacts|lines)_\d{4,}\.vtu")

_QUOTES = {'"': "&quot;"}

FieldData = Callable[[int], tuple[dict[str, np.ndarray], dict[str, np.ndarray]]]
"""Scalars at the nodes (n,) and at the cells (cells,) of a body, by name, at an output time given by number; of a shell
at the points of its layers, and of what is beside it (`kanefe.fe_model.drawn_shell`)."""


def write_series(
    result: Reader,
    path: str | Path,
    *,
    fps: float | None = None,
    every: int | None = None,
    frames: np.ndarray | None = None,
    scale: float = 1.0,
    fields: Mapping[str, FieldData] | None = None,
) -> Path:
    """Write the series that `Result.to_vtk` describes, optionally of chosen output times and with fields on bodies.

    Each flexible body has one .vtu per frame: its deformed mesh in N (of a shell with its thickness, and with fields
    its layers), with the elastic displacement in the axes of N
    as point data. The rigid bodies share one: boxes of their mass and inertia; bodies without mass are not shown.
    Contacts share one: points with force, normal force, slip and status. Springs, ropes and other loads along a line
    share one: lines, and whether they are slack. The number of a body, contact or load is cell data ("body", "contact",
    "load"), and its place in the names that each file has as field data ("bodies", "contacts", "loads").
    """
    target = Path(path)
    if not target.name or target.suffix.lower() not in ("", ".pvd"):
        raise ModelError(f"cannot write a series to the file {target}: its name must end in .pvd")
    if numbers(scale).shape != () or not math.isfinite(numbers(scale)):
        raise ModelError(f"scale of the displacements must be finite, not {scale!r}")
    for name in result.bodies:
        for block in result.body(name).cells:
            if block.kind not in WRITTEN_TYPES:
                raise ModelError(
                    f"the mesh of {name!r} has cells of kind {block.kind!r}. VTK files hold: {', '.join(WRITTEN_TYPES)}"
                )
    if frames is None:
        frames = spread_frames(result.times, fps, every, MOST_FRAMES)
    target = ready_path(target.with_suffix(".pvd"))
    folder = target.with_name(f"{target.stem}_frames")
    parts = [*_parts_of_bodies(result, float(scale), fields or {}), *_parts_of_loads(result, frames)]
    try:
        folder.mkdir(exist_ok=True)
        listed: list[tuple[Path, float, int, str]] = []
        for number, frame in enumerate(long_work(f"writing {target.name}", frames)):
            time = float(result.times[frame])
            for place, part in enumerate(parts):
                about = _time_field(time) + part.names
                file = part.write and part.write(folder / f"{part.stem}_{number:04d}", int(frame), about)
                if file is not None:
                    listed.append((file, time, place, part.title))
        _write_collection(target, listed)
        _remove_other_frames(folder, {file for file, _, _, _ in listed})
    except OSError as error:
        raise FileError(
            f"cannot write {target}: {error.strerror or error}. Remedy: free some space or choose another folder"
        ) from error
    return target


class _Part(NamedTuple):
    """One file of each time.

    Attributes
    ----------
    title, stem : str
        Its name in the collection, and the beginning of those of its files.
    names : str
        Field data that lists what its cells are parts of.
    write : callable, or None
        Writes the file of a path, an output time by number and field data; returns its path, or None if nothing is
        there then. None: nothing ever is.
    """

    title: str
    stem: str
    names: str
    write: Callable[[Path, int, str], Path | None] | None


def _parts_of_bodies(result: Reader, scale: float, fields: Mapping[str, FieldData]) -> Iterator[_Part]:
    """Yield a part for each body, of which only flexible ones write, and that of the boxes of rigid ones."""
    shapes, names = [result.body(name) for name in _drawn(result, fields)], _texts("bodies", result.bodies)
    for i, shape in enumerate(shapes):
        write = None
        if shape.is_flexible:
            data, number = fields.get(shape.name), _number_of(result, shape)
            thick = _thick(shape, plies=data is not None)
            grid = _mesh_grid(shape if thick is None else thick, number)
            write = partial(_write_mesh, result, (shape, thick), grid, scale, data)
        yield _Part(shape.name, f"body{i}", names, write)
    boxes = _boxes(result, [shape for shape in shapes if not shape.is_flexible and shape.mass > 0.0])
    cubes = _grid(
        [("hexahedron", np.arange(8 * len(boxes)).reshape(-1, 8))],
        {"body": np.array([number for number, _, _ in boxes])},
    )
    yield _Part("rigid bodies", "rigid", names, partial(_write_boxes, result, boxes, cubes) if boxes else None)


def _parts_of_loads(result: Reader, frames: np.ndarray) -> Iterator[_Part]:
    """Yield the parts of contacts and of loads along lines."""
    contacts = [result.contact(name) for name in result.contacts]
    spots = _grid([("vertex", np.arange(len(contacts))[:, None])], {"contact": np.arange(len(contacts))})
    write = partial(_write_contacts, contacts, spots) if contacts else None
    yield _Part("contacts", "contacts", _texts("contacts", result.contacts), write)
    lines = result.load_lines(frames)
    rows = {int(frame): row for row, frame in enumerate(frames)}
    names = _texts("loads", [line.name for line in lines])
    yield _Part("loads along lines", "lines", names, partial(_write_lines, lines, rows))


def _drawn(result: Reader, fields: Mapping[str, FieldData]) -> list[str]:
    """Return the names of the bodies that are written: a segmented one as a whole, unless segments have fields."""
    wholes = {whole: parts for whole, parts in result.segmented.items() if not any(name in fields for name in parts)}
    of = {name: whole for whole, parts in wholes.items() for name in parts}
    return list(dict.fromkeys(of.get(name, name) for name in result.bodies))


def _boxes(result: Reader, shapes: list[BodyShape]) -> list[tuple[int, BodyShape, np.ndarray]]:
    """Return number, shape and corners (8, 3) in the body's frame of the box of each rigid body."""
    points = [result.position(name) for name in result.bodies]
    points += [result.nodal_positions(n, frames=[0])[0] for n in result.bodies if result.body(n).is_flexible]
    sizes = [equivalent_cuboid(shape.mass, shape.inertia) for shape in shapes]
    everything = np.vstack(points)
    extent = float(np.linalg.norm(np.ptp(everything, axis=0)))
    # the origin of a single body that spins about a fixed point has no extent
    extent = max([extent, *(float(sides.max()) for sides, _ in sizes)]) or 1.0
    boxes = []
    for shape, (sides, axes) in zip(shapes, sizes, strict=True):
        shown = np.maximum(sides, SMALLEST_SIDE * extent)
        boxes.append((result.bodies.index(shape.name), shape, shape.com + 0.5 * (CORNERS * shown) @ axes.T))
    return boxes


class _Grid(NamedTuple):
    """Cells of a .vtu file, which are the same at all times.

    Attributes
    ----------
    connectivity, offsets : ndarray of int
        Nodes of all cells one after the other, and the end of each cell.
    types : ndarray of uint8
        VTK's numbers of the types.
    numbers : dict of str to ndarray of int32
        What each cell is a part of: number of its body, contact or load.
    """

    connectivity: np.ndarray
    offsets: np.ndarray
    types: np.ndarray
    numbers: dict[str, np.ndarray]


def _grid(blocks: Sequence[tuple[str, np.ndarray]], numbers: Mapping[str, np.ndarray | int]) -> _Grid:
    sizes = np.concatenate([np.full(len(nodes), nodes.shape[1]) for _, nodes in blocks])
    return _Grid(
        connectivity=np.concatenate([nodes.ravel() for _, nodes in blocks]).astype(np.int64),
        offsets=np.cumsum(sizes, dtype=np.int64),
        types=np.concatenate([np.full(len(nodes), WRITTEN_TYPES[kind], dtype=np.uint8) for kind, nodes in blocks]),
        numbers={name: np.array(np.broadcast_to(of, len(sizes)), dtype=np.int32) for name, of in numbers.items()},
    )


def _thick(shape: BodyShape, *, plies: bool) -> ThickShell | None:
    """Return a shell with its thickness, and with what is in one mesh with it; None for other bodies."""
    known = shape.elasticity
    if known is None or known.shell is None:
        return None
    thick = layered(shape.cells, known.shell, plies=plies)
    solids = [block for block in shape.cells if element(block.kind).dimension == 3]
    drawn = drawn_shell(shape.nodes, shape.cells, known.ribs, thick, solids)
    return ThickShell(drawn.nodes, drawn.arms, drawn.all_cells)


def _mesh_grid(shape: BodyShape | ThickShell, number: np.ndarray | int) -> _Grid:
    blocks = [(block.kind, block.nodes) for block in shape.cells]
    return _grid(blocks or [("vertex", np.arange(len(shape.nodes))[:, None])], {"body": number})


def _number_of(result: Reader, shape: BodyShape) -> np.ndarray | int:
    """Return the place of a body among those of the result; of a segmented one that of the segment of each cell."""
    names = result.segmented.get(shape.name)
    if names is None:
        return result.bodies.index(shape.name)
    places = np.array([result.bodies.index(name) for name in names])
    return np.asarray(places[parts_of_cells([result.body(name) for name in names])])


def _write_mesh(
    result: Reader,
    body: tuple[BodyShape, ThickShell | None],
    grid: _Grid,
    scale: float,
    data: FieldData | None,
    path: Path,
    frame: int,
    about: str,
) -> Path:
    shape, thick = body
    A_NG = rotation_matrix(result.rotation(shape.name)[frame])
    nodes = np.arange(len(shape.nodes)) if thick is None else thick.nodes
    displacement, rest = result.nodal_displacements(shape.name, frame, nodes), shape.nodes[nodes]
    if thick is not None:
        turned = shape.rotations(result.modal_coordinates(shape.name)[[frame]], nodes)[0]
        displacement, rest = displacement + np.cross(turned, thick.arms), rest + thick.arms
    displacement = displacement @ A_NG.T
    points = rest @ A_NG.T + result.position(shape.name)[frame] + scale * displacement
    at_nodes, at_cells = data(frame) if data is not None else ({}, {})
    return _write_grid(path, points, grid, {"displacement [m]": displacement, **at_nodes}, at_cells, about)


def _write_boxes(
    result: Reader, boxes: list[tuple[int, BodyShape, np.ndarray]], grid: _Grid, path: Path, frame: int, about: str
) -> Path:
    corners = []
    for _, shape, local in boxes:
        A_NR = rotation_matrix(result.rotation(shape.name)[frame])
        corners.append(local @ A_NR.T + result.position(shape.name)[frame])
    return _write_grid(path, np.vstack(corners), grid, {}, {}, about)


def _write_contacts(contacts: Sequence[ContactHistory], grid: _Grid, path: Path, frame: int, about: str) -> Path:
    fields = {
        "force [N]": np.array([contact.force[frame] for contact in contacts]),
        "normal [N]": np.array([contact.normal[frame] for contact in contacts]),
        "slip [m]": np.array([contact.slip[frame] for contact in contacts]),
        "status": np.array([STATUS.index(contact.status[frame]) for contact in contacts], dtype=np.int32),
    }
    return _write_grid(path, np.array([contact.point[frame] for contact in contacts]), grid, fields, {}, about)


def _write_lines(lines: Sequence[LoadLine], rows: Mapping[int, int], path: Path, frame: int, about: str) -> Path | None:
    """Write the lines at one of the times shown, except broken ones."""
    row = rows[frame]
    shown = [(i, line) for i, line in enumerate(lines) if line.states[row] != GONE]
    if not shown:
        return None
    points = np.vstack([line.points[row] for _, line in shown])
    starts = np.cumsum([0, *(len(line.points[row]) for _, line in shown)])
    cells = [start + np.arange(len(line.points[row]) - 1) for start, (_, line) in zip(starts, shown, strict=False)]
    first = np.concatenate(cells)
    counts = [len(own) for own in cells]
    slack = np.repeat(np.array([line.states[row] == SLACK for _, line in shown], dtype=np.int32), counts)
    number = np.repeat([i for i, _ in shown], counts)
    grid = _grid([("line", np.column_stack((first, first + 1)))], {"load": number})
    return _write_grid(path, points, grid, {}, {"slack": slack}, about)


def _write_grid(
    path: Path,
    points: np.ndarray,
    grid: _Grid,
    at_nodes: Mapping[str, np.ndarray],
    at_cells: Mapping[str, np.ndarray],
    about: str,
) -> Path:
    """Write one .vtu; return its path. Fields are (n,) or (n, 3); `about` is field data as it is in the file.

    Arrays are written directly as bytes, because pyevtk packs them number by number.
    """
    file = VtkFile(str(path.absolute()), VtkUnstructuredGrid)
    arrays: list[np.ndarray] = []

    def add(name: str, array: np.ndarray) -> None:
        array = np.ascontiguousarray(array)
        file.addHeader(name, array.dtype.name, len(array), array.size // max(len(array), 1))
        arrays.append(array)

    file.openGrid()
    file.xml.openElement("FieldData").addText(about)
    file.xml.closeElement("FieldData")
    file.openPiece(ncells=len(grid.types), npoints=len(points))
    file.openElement("Points")
    add("points", points)
    file.closeElement("Points")
    file.openElement("Cells")
    add("connectivity", grid.connectivity)
    add("offsets", grid.offsets)
    add("types", grid.types)
    file.closeElement("Cells")
    for kind, fields in (("Point", at_nodes), ("Cell", {**grid.numbers, **at_cells})):
        if not fields:
            continue
        scalars = next((name for name, values in fields.items() if values.ndim == 1), None)
        vectors = next((name for name, values in fields.items() if values.ndim == 2), None)
        file.openData(kind, scalars=scalars, vectors=vectors)
        for name, values in fields.items():
            add(name, values if values.dtype == np.int32 else values.astype(float))
        file.closeData(kind)
    file.closePiece()
    file.closeGrid()
    for array in arrays:
        file.appendHeader(array.dtype.name, len(array), array.size // max(len(array), 1))
        file.xml.stream.write(array.data)
    file.save()
    return Path(file.getFileName())


def _time_field(time: float) -> str:
    """Return the time of a file where VTK looks for it, as field data."""
    return f'<DataArray type="Float64" Name="TimeValue" NumberOfTuples="1" format="ascii">{time!r}</DataArray>'


def _texts(name: str, texts: Sequence[str]) -> str:
    """Return texts as field data: the bytes of each, and a zero."""
    codes = " ".join(f"{code}" for text in texts for code in (*text.encode(), 0))
    return f'<DataArray type="String" Name="{name}" NumberOfTuples="{len(texts)}" format="ascii">{codes}</DataArray>'


def _remove_other_frames(folder: Path, written: set[Path]) -> None:
    """Remove the files that an earlier and longer series of this name has left in its folder."""
    kept = {file.name for file in written}
    for file in folder.glob("*.vtu"):
        if _FRAME.fullmatch(file.name) and file.name not in kept:
            file.unlink()


def _write_collection(target: Path, listed: list[tuple[Path, float, int, str]]) -> None:
    """Write the .pvd file, with relative paths. pyevtk does not escape special characters of XML."""
    folder = target.absolute().parent
    group = VtkGroup(str(folder / target.stem))
    for file, time, part, name in listed:
        relative = escape(file.relative_to(folder).as_posix(), _QUOTES)
        group.addFile(str(folder / relative), sim_time=repr(time), part=str(part), name=escape(name, _QUOTES))
    group.save()
