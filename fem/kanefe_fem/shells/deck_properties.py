"""Materials, thickness and offset of the shells of a deck of Nastran, Abaqus or CalculiX, for `shell_body`.

Heights are told in three ways: Nastran's ZOFFS is that of the middle above the grid points, in m, its Z0 of a PCOMP
that of the bottom; OFFSET of Abaqus is that of the nodes above the middle, as a fraction of the thickness. All are
along the normal by the order of the nodes of an element. Plies are at angles from the axes of
`kanefe_fem.shells.deck_axes`.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple, TypedDict

import numpy as np

from kanefe.arguments import checked
from kanefe.errors import FileError
from kanefe.fe_model.shapes import shape
from kanefe.imports.abaqus_input import Keyword, deck_keywords
from kanefe.imports.abaqus_sets import key_of
from kanefe.imports.bulk_data import bulk_cards
from kanefe.imports.card import Card
from kanefe.imports.grid_points import GridPoints, grid_points
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.materials.laminate import Laminate, Ply
from kanefe_fem.materials.oriented import Oriented, SolidMaterial
from kanefe_fem.materials.orthotropic import Orthotropic
from kanefe_fem.mesh.abaqus_deck import read_abaqus_mesh
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.mesh.nastran_deck import read_nastran_mesh
from kanefe_fem.mesh_files import NASTRAN
from kanefe_fem.shells.deck_axes import axes_of_elements, oriented_by
from kanefe_fem.shells.deck_thickness import ThicknessOfNodes, thickness_of_corners, thickness_of_nodes
from kanefe_fem.shells.of_groups import Thickness
from kanefe_fem.shells.orientation import consistent

OFFSETS = {"SPOS": 0.5, "SNEG": -0.5}
"""Names of the offset of nodes above the middle, as fractions of the thickness."""


class ShellProperties(TypedDict):
    """Keywords of `shell_body` by group of cells."""

    materials: dict[str, SolidMaterial]
    thickness: dict[str, Thickness]
    offset: dict[str, float]


class _Shell(NamedTuple):
    """Of one group: a material, thickness in m, and the height of the middle as a fraction of it."""

    material: SolidMaterial
    thickness: Any
    offset: float


@checked
def shell_properties(
    path: str | Path, *, names: Mapping[int, str] | None = None, trusted: bool = False
) -> ShellProperties:
    """Return materials, thicknesses and offsets of the shells of a deck, as `shell_body` takes them.

    Parameters
    ----------
    path : str or Path
        Deck of Nastran (PSHELL, PCOMP with MAT1, MAT8; ZOFFS, Z0) or of Abaqus and CalculiX (``*SHELL SECTION``, also
        COMPOSITE, with OFFSET, or with NODAL THICKNESS; ``*ELASTIC`` of type ISOTROPIC, LAMINA or ENGINEERING
        CONSTANTS), in m, kg, s.
    names : dict of int to str, optional
        Names of properties of Nastran, as for `kanefe_fem.read_mesh`.
    trusted : bool
        Whether it may include files outside its folder.

    Returns
    -------
    dict
        "materials", "thickness" in m, a function of places where corners of elements have their own, and "offset" as a
        fraction of the thickness, each a dict by group.

    Raises
    ------
    FileError
        If a card is not as it should be or of a kind that is not read, or elements of one property differ in their
        offset or in the side of their normals; the message has the line.

    Examples
    --------
    >>> given = shell_properties("panel.bdf")                              # doctest: +SKIP
    >>> panel = shell_body("panel.bdf", interfaces={"root": "clamped"}, **given)  # doctest: +SKIP
    """
    path = Path(path)
    is_nastran = path.suffix.lower() in NASTRAN
    shells = _of_nastran(path, names or {}, trusted) if is_nastran else _of_abaqus(path, trusted)
    if not shells:
        what = "PSHELL or PCOMP" if is_nastran else "*SHELL SECTION"
        raise FileError(f"{path} has no {what}. Remedy: the deck with its properties, or materials= and thickness=")
    if any(shell.offset or not isinstance(shell.material, Material) for shell in shells.values()):
        mesh = read_nastran_mesh(path, names or {}, trusted) if is_nastran else read_abaqus_mesh(path, trusted)
        _check_sides(mesh, path)
    return {
        "materials": {name: shell.material for name, shell in shells.items()},
        "thickness": {name: shell.thickness for name, shell in shells.items()},
        "offset": {name: shell.offset for name, shell in shells.items()},
    }


def _check_sides(mesh: Mesh, path: Path) -> None:
    """Refuse normals by which offsets and plies would not go, since a shell's are made consistent."""
    blocks = tuple(block for own in mesh.cells.values() for block in own if shape(block.kind).dimension == 2)
    turned = consistent(blocks, path.name)[1]
    if turned:
        raise FileError(
            f"{path}: the normals of {turned} shells are on the other side of their neighbours', and offsets or plies "
            "go by them. Remedy: turn them in the deck"
        )


def _of_nastran(path: Path, names: Mapping[int, str], trusted: bool) -> dict[str, _Shell]:
    cards = bulk_cards(path, trusted=trusted, reader="shell_properties")
    materials = {card.whole(2): card for card in cards if card.name in ("MAT1", "MAT8")}
    elements = [card for card in cards if card.name in _FIELDS]
    heights, grids = _heights(elements), grid_points(cards)
    found: dict[str, _Shell] = {}
    for card in cards:
        if card.name not in ("PSHELL", "PCOMP"):
            continue
        number = card.whole(2)
        name = names.get(number) or str(number)
        height = heights.get(number, 0.0)
        shell = (_pshell if card.name == "PSHELL" else _pcomp)(card, materials, height)
        of = [one for one in elements if _property_of(one) == number]
        shell = shell._replace(thickness=_at_corners(of, shell, grids))
        if not isinstance(shell.material, Material):
            places = [_FIELDS[one.name][0] for one in of]
            shell = shell._replace(material=Oriented(shell.material, axes_of_elements(of, places, grids, cards)))
        found[name] = shell
    return found


_FIELDS = {"CTRIA3": (7, 8, (12, 13, 14), 11), "CQUAD4": (8, 9, (12, 13, 14, 15), 11)}
_FIELDS |= {"CTRIA6": (10, 11, (12, 13, 14), 15), "CQUAD8": (16, 17, (12, 13, 14, 15), 18)}
"""Fields of THETA, of ZOFFS, of the thicknesses of corners and of TFLAG, of Nastran's shells."""


def _at_corners(elements: list[Card], shell: _Shell, grids: GridPoints) -> float | ThicknessOfNodes:
    """Return the thickness of elements; one that varies has its middle at the nodes, and no plies."""
    places, flags = [_FIELDS[one.name][2] for one in elements], [_FIELDS[one.name][3] for one in elements]
    thickness = thickness_of_corners(elements, places, flags, shell.thickness, grids)
    if callable(thickness) and (shell.offset or isinstance(shell.material, Laminate)):
        raise elements[0].refused(
            "is of a property with thicknesses of corners and an offset or plies, which are not read together. Remedy: "
            "without ZOFFS, and thickness= as a function of places"
        )
    return thickness


def _property_of(card: Card) -> int:
    return card.whole(3) if card.field(3) else card.whole(2)


def _heights(elements: list[Card]) -> dict[int, float]:
    """Return ZOFFS of the elements of each property, m."""
    found: dict[int, float] = {}
    for card in elements:
        number, height = _property_of(card), card.number(_FIELDS[card.name][1])
        if found.setdefault(number, height) != height:
            raise card.refused(
                f"has ZOFFS {height:g}, and another element of property {number} {found[number]:g}. Remedy: a property "
                "for each offset"
            )
    return found


def _pshell(card: Card, materials: Mapping[int, Card], height: float) -> _Shell:
    thickness = card.number(4)
    if card.field(5) != card.field(3):
        raise card.refused("bends by another material than it stretches, or by none. Remedy: MID2 as MID1, or PCOMP")
    if card.number(9) or (card.field(8) and abs(card.number(8) - 5.0 / 6.0) > 1e-4):
        raise card.refused("has NSM or another TS/T than 5/6, which are not read. Remedy: rho, and shear_factor=")
    if card.number(6) not in (0.0, 1.0):
        raise card.refused(f"has 12 I/T^3 of {card.number(6):g}, which is not read. Remedy: 1, or PCOMP")
    if thickness <= 0.0:
        raise card.refused("has no thickness. Remedy: T in field 4")
    return _Shell(_material(card, card.whole(3), materials), thickness, height / thickness)


def _pcomp(card: Card, materials: Mapping[int, Card], height: float) -> _Shell:
    plies, last = [], (0, 0.0)
    for place in range(10, card.count + 2, 4):
        if not any(card.field(place + i) for i in range(3)):
            continue
        last = (card.whole(place) if card.field(place) else last[0], card.number(place + 1) or last[1])
        plies.append(Ply(_material(card, last[0], materials), last[1], np.radians(card.number(place + 2))))
    if card.number(4):
        raise card.refused("has NSM, which is not read. Remedy: rho of its plies")
    layup = card.field(9).upper()
    if layup not in ("", "SYM"):
        raise card.refused(f"has LAM {layup}, which is not read. Remedy: all plies, or SYM")
    laminate = Laminate(plies + plies[::-1] if layup == "SYM" else plies)
    thickness = laminate.thickness
    bottom = card.number(3) if card.field(3) else -0.5 * thickness
    return _Shell(laminate, thickness, 0.5 + (bottom + height) / thickness)


def _material(card: Card, number: int, materials: Mapping[int, Card]) -> SolidMaterial:
    """Return a material of MAT1 or MAT8."""
    of = materials.get(number)
    if of is None:
        raise card.refused(f"has material {number}, which is no MAT1 or MAT8 of the deck. Remedy: one of these")
    if of.name == "MAT1":
        E, G, nu = of.numbers(3, 3)
        nu = nu if of.field(5) else E / (2.0 * G) - 1.0
        E = E if of.field(3) else 2.0 * G * (1.0 + nu)
        return Material(E=E, nu=nu, rho=of.number(6), name=str(number))
    E1, E2, nu12, G12, G1z, G2z, rho = of.numbers(3, 7)
    return _sheet((E1, E2, nu12, G12, G1z or G12, G2z or G12), rho, str(number))


def _sheet(values: tuple[float, ...], rho: float, name: str) -> Orthotropic:
    """Return a material of which only what acts in a sheet is known: E1, E2, nu12, G12, G13, G23."""
    E1, E2, nu12, G12, G13, G23 = values
    # a shell has no stress across itself: E3 and its ratios do nothing
    return Orthotropic(
        E1=E1, E2=E2, E3=E2, nu12=nu12, nu13=0.0, nu23=0.0, G12=G12, G13=G13, G23=G23, rho=rho, name=name
    )


def _of_abaqus(path: Path, trusted: bool) -> dict[str, _Shell]:
    blocks = deck_keywords(path, trusted=trusted, reader="shell_properties")
    materials = _materials(blocks)
    found: dict[str, _Shell] = {}
    for block in blocks:
        if block.name != "SHELLSECTION":
            continue
        options = {name.replace(" ", "") for name in block.options}
        for option in ("SHELLTHICKNESS", "STACKDIRECTION"):
            if option in options:
                raise block.refused(f"has {option}, which is not read. Remedy: thickness= as a function of places")
        material, thickness = _stack(block, materials)
        if block.options.get("ORIENTATION") and not isinstance(material, Material):
            material = oriented_by(block, blocks, material, thickness)
        varies: Any = thickness
        if "NODALTHICKNESS" in options:
            if isinstance(material, Laminate | Oriented):
                raise block.refused("has NODAL THICKNESS of plies, which is not read. Remedy: plies, or one material")
            varies = thickness_of_nodes(block, blocks)
        given = block.options.get("OFFSET", "").strip().upper()
        above = OFFSETS[given] if given in OFFSETS else block.number(given, block.at)
        found[block.option("ELSET").strip("\"'")] = _Shell(material, varies, -above if above else 0.0)
    return found


def _stack(block: Keyword, materials: Mapping[str, SolidMaterial]) -> tuple[SolidMaterial, float]:
    """Return the material of a section and its thickness, m."""

    def of(name: str, at: int) -> SolidMaterial:
        material = materials.get(key_of(name))
        if material is None:
            raise block.refused(f"has material {name!r}, which has no *ELASTIC that is read. Remedy: write it", at)
        return material

    rows = list(block.rows())
    if "COMPOSITE" not in {name.upper() for name in block.options}:
        if not rows:
            raise block.refused("has no thickness. Remedy: a line with it")
        thickness = block.number(rows[0][1][0], rows[0][0])
        if thickness <= 0.0:
            raise block.refused(f"has the thickness {thickness:g}. Remedy: a positive one", rows[0][0])
        return of(block.option("MATERIAL"), block.at), thickness
    plies = []
    for at, fields in rows:
        fields = [*fields, "", "", "", ""]
        plies.append(Ply(of(fields[2], at), block.number(fields[0], at), np.radians(block.number(fields[3], at))))
    laminate = Laminate(plies)
    return laminate, laminate.thickness


def _materials(blocks: list[Keyword]) -> dict[str, SolidMaterial]:
    """Return the linear elastic materials of a deck."""
    elastic: dict[str, Keyword] = {}
    density: dict[str, float] = {}
    name = ""
    for block in blocks:
        if block.name == "MATERIAL":
            name = key_of(block.option("NAME"))
        elif block.name == "ELASTIC":
            elastic[name] = block
        elif block.name == "DENSITY":
            at, fields = next(iter(block.rows()))
            density[name] = block.number(fields[0], at)
    found: dict[str, SolidMaterial] = {}
    for of, block in elastic.items():
        kind = block.options.get("TYPE", "ISOTROPIC").upper().replace(" ", "")
        values = [block.number(text, at) for at, fields in block.rows() for text in fields]
        made = _elastic(kind, values, density.get(of, 0.0), of)
        if made is not None:
            found[of] = made
    return found


def _elastic(kind: str, values: list[float], rho: float, name: str) -> SolidMaterial | None:
    """Return a material; None of a kind that is not read."""
    if kind in ("ISOTROPIC", "ISO"):
        return Material(E=values[0], nu=values[1], rho=rho, name=name)
    if kind == "LAMINA":
        E1, E2, nu12, G12, G13, G23 = values[:6]
        return _sheet((E1, E2, nu12, G12, G13, G23), rho, name)
    if kind == "ENGINEERINGCONSTANTS":
        E1, E2, E3, nu12, nu13, nu23, G12, G13, G23 = values[:9]
        return Orthotropic(
            E1=E1, E2=E2, E3=E3, nu12=nu12, nu13=nu13, nu23=nu23, G12=G12, G13=G13, G23=G23, rho=rho, name=name
        )
    return None
