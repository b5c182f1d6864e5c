"""Door to yourdfpy: the parser of URDF. The only file that imports yourdfpy."""

from __future__ import annotations

import logging
from copy import deepcopy
from io import BytesIO
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from kanefe.errors import FileError, MissingDependency

_DAMAGE = (ValueError, KeyError, IndexError, TypeError, AttributeError, OSError)
"""Exceptions that yourdfpy raises on elements with missing parts."""


def parsed(root: ElementTree.Element, path: Path) -> Any:
    """Return yourdfpy's ``Robot`` of the root element of a file, without its shapes, which may be of any kind.

    Raises
    ------
    FileError
        If an element lacks a required part.
    MissingDependency
        Without yourdfpy.
    """
    urdf, mechanism = _import_yourdfpy(), deepcopy(root)
    for link in mechanism.findall("link"):
        for shape in (*link.findall("visual"), *link.findall("collision")):
            link.remove(shape)
    file = BytesIO(ElementTree.tostring(mechanism))
    try:
        return urdf.URDF.load(file, build_scene_graph=False, load_meshes=False, mesh_dir="").robot
    except _DAMAGE as error:
        raise FileError(
            f"{path} is not a complete URDF file ({type(error).__name__}: {error}). Remedy: check that robot, links "
            "and joints have names, joints a parent and a child, and that numbers are numbers"
        ) from error


def _import_yourdfpy() -> Any:
    try:
        import yourdfpy
    except ImportError as problem:  # yourdfpy itself, or what it needs in turn
        missing = (problem.name or "yourdfpy").partition(".")[0]
        raise MissingDependency(missing, "read_urdf", "pip install 'kanefe[robots]'") from problem
    # it logs missing shapes and damaged files, which are handled here
    logging.getLogger("yourdfpy.urdf").setLevel(logging.CRITICAL)
    return yourdfpy
