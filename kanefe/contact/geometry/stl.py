"""Meshes of STL files, binary and text: triangles with vertices of their own, which are brought together."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from kanefe.contact.geometry.stl_repair import together, without_flat
from kanefe.errors import FileError
from kanefe.frames import Matrix
from kanefe.storage.files import regular_file

HEAD, FACET = 84, 50
"""Number of bytes before the facets of a binary file, and of each facet: normal and three vertices in single precision,
and two more."""


def read_stl(path: Path) -> tuple[Matrix, np.ndarray]:
    """Return vertices (n, 3) and triangles (m, 3) of an STL file.

    Vertices that are equal to round-off are one, and triangles without area are left out.

    Raises
    ------
    FileError
        If there is no such file, or it is none of this kind.
    """
    path = regular_file(path, "of a surface")
    try:
        content = path.read_bytes()
    except OSError as error:
        raise FileError(f"{path} cannot be read: {error}. Remedy: check the file") from error
    count = int.from_bytes(content[80:HEAD], "little") if len(content) >= HEAD else -1
    if len(content) == HEAD + FACET * count:
        facets = np.frombuffer(content, np.uint8, offset=HEAD).reshape(count, FACET)
        corners = np.ascontiguousarray(facets[:, 12:48]).view("<f4").reshape(-1, 3).astype(float)
    else:
        words = content.decode("ascii", errors="replace").split()
        places = [i for i, word in enumerate(words) if word == "vertex"]
        try:
            corners = np.array([[float(word) for word in words[i + 1 : i + 4]] for i in places]).reshape(-1, 3)
        except ValueError as error:
            raise FileError(f"{path} is not an STL file: a vertex is not three numbers") from error
    if not len(corners) or len(corners) % 3:
        raise FileError(
            f"{path} is not an STL file: it has {len(corners)} vertices, which should be three per triangle"
        )
    vertices, triangles = together(corners)
    return vertices, without_flat(vertices, triangles)
