"""Shells of decks: materials, thicknesses and offsets of Nastran and Abaqus as `shell_body` takes them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import scipy.sparse.linalg as spla

import kanefe as kf
from kanefe.errors import FileError
from kanefe_fem import Laminate, Oriented, shell_body, shell_model, shell_properties

E, NU, RHO, T, OFFSET = 7e10, 0.3, 2700.0, 0.02, 0.35
LENGTH, WIDTH, CELLS = 1.0, 0.2, 4


def grid() -> tuple[np.ndarray, np.ndarray]:
    """Nodes of a strip along x, and quadrangles with normals along z."""
    x, y = np.meshgrid(np.linspace(0.0, LENGTH, CELLS + 1), (0.0, WIDTH), indexing="ij")
    nodes = np.column_stack((x.ravel(), y.ravel(), np.zeros(x.size)))
    first = 2 * np.arange(CELLS)[:, None]
    return nodes, 1 + first + np.array((0, 2, 3, 1))


def nastran(path: Path, shell: str = "PSHELL,7,1,0.02,1", last: str = "", turned: bool | None = False) -> Path:
    nodes, cells = grid()
    lines = [f"GRID,{i},,{x:.9g},{y:.9g},{z:.9g}" for i, (x, y, z) in enumerate(nodes, 1)]
    lines += [f"CQUAD4,{i},7,{a},{b},{c},{d}{last}" for i, (a, b, c, d) in enumerate(cells.tolist(), 1)]
    if turned is None:
        lines = lines[: len(nodes)] + [f"CQUAD4,{i},7,{d},{c},{b},{a}{last}" for i, (a, b, c, d) in enumerate(cells, 1)]
    if turned:
        a, b, c, d = cells[-1].tolist()
        lines[-1] = f"CQUAD4,{CELLS},7,{d},{c},{b},{a}{last}"
    lines += [f"MAT1,1,{E:g},,{NU},{RHO}", "MAT8,2,1.4E11,9.E9,0.3,5.E9,5.E9,3.5E9,1600.", *shell.split("/")]
    path.write_text("BEGIN BULK\n" + "\n".join(lines) + "\nENDDATA\n")
    return path


def abaqus(path: Path, section: str) -> Path:
    nodes, cells = grid()
    rows = [f"{i},{x:.9g},{y:.9g},{z:.9g}" for i, (x, y, z) in enumerate(nodes, 1)]
    elements = [f"{i},{a},{b},{c},{d}" for i, (a, b, c, d) in enumerate(cells.tolist(), 1)]
    path.write_text(
        "\n".join(
            [
                "*NODE",
                *rows,
                "*ELEMENT, TYPE=S4R, ELSET=STRIP",
                *elements,
                "*MATERIAL, NAME=ALU",
                "*ELASTIC",
                f"{E:g},{NU}",
                "*DENSITY",
                f"{RHO}",
                "*MATERIAL, NAME=CFRP",
                "*ELASTIC, TYPE=LAMINA",
                "1.4E11,9.E9,0.3,5.E9,5.E9,3.5E9",
                "*DENSITY",
                "1600.",
                *section.split("/"),
                "",
            ]
        )
    )
    return path


def deflection(path: Path) -> float:
    """Deflection of the tip under an axial force of 1 N/m at the nodes of the tip, root held."""
    model = shell_model(path, **shell_properties(path))
    held = np.flatnonzero(model.nodes[:, 0] < 1e-9)
    tip = np.flatnonzero(model.nodes[:, 0] > LENGTH - 1e-9)
    load = np.zeros(model.size)
    # Simpson's shares of the three nodes of the edge, by their y
    load[6 * tip] = np.where(np.abs(model.nodes[tip, 1] - WIDTH / 2) < 1e-6, 4.0, 1.0) / 6.0 * WIDTH
    free = np.setdiff1d(np.arange(model.size), (6 * held[:, None] + np.arange(6)).ravel())
    u = np.zeros(model.size)
    K = model.stiffness.tocsc()
    u[free] = spla.spsolve(K[free][:, free], load[free])
    return float(u[6 * tip + 2].mean())


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_an_eccentric_plate_bends_by_its_offset(sign: float, tmp_path: Path) -> None:
    """A strip with its middle z0 above the nodes, pulled at the nodes by N: w = N z0 L^2 / 2 E I."""
    height = sign * OFFSET * T
    of_nastran = nastran(tmp_path / "a.bdf", last=f",,{height:.9g}")
    of_abaqus = abaqus(tmp_path / "a.inp", f"*SHELL SECTION, ELSET=STRIP, MATERIAL=ALU, OFFSET={-sign * OFFSET}/{T}, 5")
    bent = [deflection(path) for path in (of_nastran, of_abaqus)]
    # pulled below its middle the strip bends up there: curvature N z0 / (E I), free at its sides
    expected = height * LENGTH**2 / 2.0 * 12.0 / (E * T**3)
    assert bent[0] == pytest.approx(bent[1], rel=1e-9)
    assert bent[0] == pytest.approx(expected, rel=0.02)  # the root is held across, too


def test_elements_from_below_have_their_offset_below(tmp_path: Path) -> None:
    """The same strip with its nodes in the other order: ZOFFS is along the normals, -z."""
    above = deflection(nastran(tmp_path / "a.bdf", last=f",,{OFFSET * T:.9g}"))
    below = deflection(nastran(tmp_path / "b.bdf", last=f",,{OFFSET * T:.9g}", turned=None))
    assert below == pytest.approx(-above, rel=1e-9)


def test_plies_keep_their_heights_and_angles(tmp_path: Path) -> None:
    """Both programs: the first ply is the bottom; 0 along x, 30 about the normal."""
    found = shell_properties(nastran(tmp_path / "a.bdf", "PCOMP,7,-0.002,,,,,,/,2,0.002,0.,,2,0.001,30.", ",0."))
    layers = "*SHELL SECTION, ELSET=STRIP, COMPOSITE, OFFSET=0.16666666666666666/0.002, 3, CFRP, 0./0.001, 3, CFRP, 30."
    other = shell_properties(abaqus(tmp_path / "a.inp", layers))
    of_nastran, of_abaqus = found["materials"]["7"], other["materials"]["STRIP"]
    assert isinstance(of_nastran, Oriented)
    np.testing.assert_allclose(of_nastran.axes, np.eye(3), atol=1e-12)
    for laminate in (of_nastran.material, of_abaqus):
        assert isinstance(laminate, Laminate)
        assert [round(float(ply.thickness), 9) for ply in laminate.plies] == [0.002, 0.001]
        assert np.degrees([ply.angle for ply in laminate.plies]) == pytest.approx([0.0, 30.0])
    assert found["offset"]["7"] == pytest.approx(0.5 - 0.002 / 0.003)
    assert other["offset"]["STRIP"] == pytest.approx(found["offset"]["7"])


def stiff_along(path: Path) -> tuple[float, np.ndarray]:
    """Force per strain of a strip of unit width stretched along x, and its first axis."""
    given = shell_properties(path)
    (material,) = given["materials"].values()
    assert isinstance(material, Oriented)
    return deflection(path), np.asarray(material.axes)


def test_axes_by_coordinate_systems_are_those_by_angles(tmp_path: Path) -> None:
    """Fibres at 30 degrees from x: by THETA, by MCID of a system turned about z, by ORIENTATION and its angle."""
    c, s = np.cos(np.radians(30.0)), np.sin(np.radians(30.0))
    # from a point on its third axis and one in the plane of the first and the third
    system = f"CORD2R,3,,0.,0.,0.,0.,0.,1./,{c:.12g},{s:.12g},0."
    offset = ",0.007"
    found = [
        stiff_along(nastran(tmp_path / "a.bdf", "PSHELL,7,2,0.02,2", ",30." + offset)),
        stiff_along(nastran(tmp_path / "b.bdf", f"PSHELL,7,2,0.02,2/{system}", ",3" + offset)),
    ]
    section = "*SHELL SECTION, ELSET=STRIP, MATERIAL=CFRP, ORIENTATION=O, OFFSET=-0.35/0.02"
    found += [
        stiff_along(abaqus(tmp_path / "a.inp", f"*ORIENTATION, NAME=O/{c},{s},0.,{-s},{c},0./3, 0./{section}")),
        stiff_along(abaqus(tmp_path / "b.inp", f"*ORIENTATION, NAME=O/1.,0.,0.,0.,1.,0./3, 30./{section}")),
    ]
    for bent, axes in found[1:3]:
        assert axes[:, 0] == pytest.approx([c, s, 0.0], abs=1e-9)
        assert bent == pytest.approx(found[0][0], rel=1e-6)
    # one ply at an angle has the shear correction of a stack
    assert found[3][0] == pytest.approx(found[0][0], rel=1e-3)
    straight = stiff_along(nastran(tmp_path / "c.bdf", "PSHELL,7,2,0.02,2", ",0." + offset))
    assert abs(straight[0]) < 0.5 * abs(found[0][0])  # fibres along the strip


def wedge(path: Path, left: float, right: float, flag: str = "", last: str = "") -> Path:
    """The strip with a thickness from left to right, by T1 to T4 of its elements."""
    nodes, _ = grid()
    deck = nastran(path, last=f",,{last}").read_text().split("\n")
    for i, line in enumerate(deck):
        if line.startswith("CQUAD4"):
            corners = [int(one) for one in line.split(",")[3:7]]
            t = [left + (right - left) * nodes[one - 1, 0] / LENGTH for one in corners]
            deck[i] = line + (",," if not last else ",") + f"\n,,{flag}," + ",".join(f"{one:.12g}" for one in t)
    path.write_text("\n".join(deck))
    return path


def test_thicknesses_of_corners_are_linear_in_between(tmp_path: Path) -> None:
    path = wedge(tmp_path / "a.bdf", 0.01, 0.03)
    model = shell_model(path, **shell_properties(path))
    weights = model.mass_field.mass @ np.ones(len(model.mass_field.points))
    # of a wedge: rho w L (a + b) / 2, and its centre at L (a + 2 b) / (3 (a + b))
    assert weights.sum() == pytest.approx(RHO * WIDTH * LENGTH * 0.02, rel=1e-9)
    assert weights @ model.mass_field.points[:, 0] / weights.sum() == pytest.approx(LENGTH * 0.07 / 0.12, rel=1e-9)
    relative = shell_properties(wedge(tmp_path / "b.bdf", 0.5, 1.5, flag="1"))["thickness"]["7"]
    x = np.array([[0.0, 0.0, 0.0], [0.25, 0.2, 0.0], [1.0, 0.0, 0.0]])
    assert relative(x) == pytest.approx([0.01, 0.015, 0.03], rel=1e-9)  # of T = 0.02
    with pytest.raises(FileError, match=r"has the thickness -?0.* at a corner"):
        shell_properties(wedge(tmp_path / "c.bdf", 0.0, 0.02))
    with pytest.raises(FileError, match=r"thicknesses of corners and an offset or plies"):
        shell_properties(wedge(tmp_path / "d.bdf", 0.01, 0.02, last="0.001"))


def test_a_body_from_a_deck(tmp_path: Path) -> None:
    path = nastran(tmp_path / "a.bdf")
    given = shell_properties(path)
    assert (given["thickness"], given["offset"]) == ({"7": T}, {"7": 0.0})
    body = shell_body(
        path,
        interfaces={"root": kf.Interface("all", at=kf.OnPlane((0, 0, 0), (1, 0, 0)))},
        reduction=kf.CraigBampton(modes=2),
        **given,
    )
    assert body.mass == pytest.approx(RHO * LENGTH * WIDTH * T)


@pytest.mark.parametrize(
    ("shell", "last", "turned", "match"),
    [
        (
            "PSHELL,7,1,0.02",
            "",
            False,
            r"PSHELL 7 \(line \d+\) bends by another material than it stretches, or by none",
        ),
        ("PSHELL,7,1,,1", "", False, r"has no thickness"),
        ("PSHELL,7,1,0.02,1,,,,3.", "", False, r"has NSM"),
        ("PSHELL,7,9,0.02,9", "", False, r"has material 9, which is no MAT1 or MAT8"),
        ("PSHELL,7,2,0.02,2", ",3", False, r"CQUAD4 1 \(line \d+\) is in coordinate system 3, which is not there"),
        (
            "PSHELL,7,2,0.02,2/CORD2C,3,,0.,0.,0.,0.,0.,1./,1.,0.,0.",
            ",3",
            False,
            r"CQUAD4 1 .* the coordinate system 3, which is not rectangular",
        ),
        (
            "PSHELL,7,2,0.02,2/CQUAD4,99,7,1,3,4,2,30.",
            ",0",
            False,
            r"CQUAD4 1 \(line \d+\) has axes by MCID 0, and other elements of its property have not",
        ),
        ("PSHELL,7,1,0.02,1", ",,0.001", True, r"the normals of \d shells are on the other side"),
        ("PSOLID,7,1", "", False, r"has no PSHELL or PCOMP"),
    ],
)
def test_what_is_not_read_is_named(shell: str, last: str, turned: bool | None, match: str, tmp_path: Path) -> None:
    with pytest.raises(FileError, match=match):
        shell_properties(nastran(tmp_path / "a.bdf", shell, last, turned))


@pytest.mark.parametrize(
    ("section", "match"),
    [
        ("*SHELL SECTION, ELSET=STRIP, MATERIAL=NONE/0.02", r"has material 'NONE', which has no \*ELASTIC"),
        ("*SHELL SECTION, ELSET=STRIP, MATERIAL=ALU/0.", r"has the thickness 0"),
        (
            "*SHELL SECTION, ELSET=STRIP, MATERIAL=ALU, NODAL THICKNESS/0.02",
            r"has NODAL THICKNESS, and the node at \(0, 0, 0\) has none",
        ),
        (
            "*NODAL THICKNESS/1, -0.01/*SHELL SECTION, ELSET=STRIP, MATERIAL=ALU, NODAL THICKNESS/0.02",
            r"\*NODALTHICKNESS \(line \d+\) has the thickness -0.01",
        ),
        ("*SHELL SECTION, ELSET=STRIP, MATERIAL=CFRP, ORIENTATION=O/0.02", r"the ORIENTATION 'O', which is not there"),
        (
            "*ORIENTATION, NAME=O/1.,0.,0.,0.,1.,0./*SHELL SECTION, ELSET=STRIP, MATERIAL=CFRP, ORIENTATION=O/0.02",
            r"\*ORIENTATION \(line \d+\) has its axis 1 across the shell, by which Abaqus and CalculiX take different",
        ),
        (
            "*ORIENTATION, NAME=O, SYSTEM=C/0.,0.,0.,0.,0.,1.",
            r"has no \*SHELL SECTION",
        ),
        (
            "*ORIENTATION, NAME=O, SYSTEM=CYLINDRICAL/0.,0.,0.,0.,0.,1./*SHELL SECTION, ELSET=STRIP, MATERIAL=CFRP,"
            " ORIENTATION=O/0.02",
            r"is not of a rectangular system",
        ),
    ],
)
def test_sections_that_are_not_read_are_named(section: str, match: str, tmp_path: Path) -> None:
    with pytest.raises(FileError, match=match):
        shell_properties(abaqus(tmp_path / "a.inp", section))


def test_thickness_at_nodes_of_abaqus_is_that_of_a_function(tmp_path: Path) -> None:
    """A strip that tapers, by labels and by sets of nodes; the middles of sides are between the corners."""
    nodes, _ = grid()
    taper = 0.03 - 0.02 * nodes[:, 0]
    rows = "/".join(f"{i}, {t:.9g}" for i, t in enumerate(taper, 1) if i > 2)
    sets = f"*NSET, NSET=ROOT/1, 2/*NODAL THICKNESS/ROOT, {taper[0]:.9g}/{rows}"
    section = f"{sets}/*SHELL SECTION, ELSET=STRIP, MATERIAL=ALU, NODAL THICKNESS, OFFSET=0.5/0.02"
    deck = abaqus(tmp_path / "a.inp", section)
    given = shell_properties(deck)
    x = np.array([[0.125, 0.0, 0.0], [0.5, 0.2, 0.0], [0.125, 0.1, 0.0]])
    np.testing.assert_allclose(given["thickness"]["STRIP"](x), 0.03 - 0.02 * x[:, 0], rtol=1e-9)
    assert given["offset"] == {"STRIP": -0.5}
    found = shell_model(deck, **given)
    same = shell_model(deck, given["materials"], lambda p: 0.03 - 0.02 * p[:, 0], offset=-0.5)
    assert abs(found.stiffness - same.stiffness).max() < 1e-9 * abs(same.stiffness).max()
