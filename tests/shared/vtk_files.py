"""What is in files for ParaView, read without pyevtk and VTK."""

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np

DTYPES = {"Float64": "<f8", "Int64": "<i8", "Int32": "<i4", "UInt8": "u1"}


def read_grid(path: Path) -> dict[str, np.ndarray]:
    """Read the arrays of a .vtu with raw appended data: after "_", each has its size in 8 bytes before it."""
    head, _, rest = path.read_bytes().partition(b"<AppendedData")
    data = rest[rest.index(b"_") + 1 :]
    root = ElementTree.fromstring(head + b"</VTKFile>")
    piece = next(root.iter("Piece"))
    arrays = {"sizes": np.array([int(piece.attrib["NumberOfPoints"]), int(piece.attrib["NumberOfCells"])])}
    for element in piece.iter("DataArray"):
        start = int(element.attrib["offset"])
        size = int.from_bytes(data[start : start + 8], "little")
        array = np.frombuffer(data[start + 8 : start + 8 + size], DTYPES[element.attrib["type"]])
        width = int(element.attrib["NumberOfComponents"])
        arrays[element.attrib["Name"]] = array.reshape(-1, width) if width > 1 else array
    return arrays


def read_fields(path: Path) -> dict[str, list[float] | list[str]]:
    """Read the field data of a .vtu: numbers, and texts from the codes of their bytes, each with a zero after it."""
    head, _, _ = path.read_bytes().partition(b"<AppendedData")
    fields = next(ElementTree.fromstring(head + b"</VTKFile>").iter("FieldData"))
    found: dict[str, list[float] | list[str]] = {}
    for element in fields:
        values = (element.text or "").split()
        if element.attrib["type"] == "String":
            found[element.attrib["Name"]] = bytes(map(int, values)).decode().split("\0")[:-1]
        else:
            found[element.attrib["Name"]] = [float(value) for value in values]
        assert len(found[element.attrib["Name"]]) == int(element.attrib["NumberOfTuples"])
    return found


def read_series(path: Path) -> list[tuple[float, str, Path]]:
    """Return time, name and file of every entry; the files are found from the folder of the .pvd."""
    return [
        (float(e.attrib["timestep"]), e.attrib["name"], path.parent / e.attrib["file"])
        for e in ElementTree.parse(path).iter("DataSet")
    ]
