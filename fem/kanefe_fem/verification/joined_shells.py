"""Shells with stiffeners and with solids, SH20 to SH22, against beams in closed form.

Without contraction (nu = 0) a strip bends as a beam: tips are exact, and the reference has no error of its own.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from kanefe.bodies.flexible import FlexibleBody
from kanefe.checks.verification import Case, Check, Reference
from kanefe.fe_model.interface import Interface
from kanefe.fe_model.model import Cells
from kanefe.reduction.craig_bampton import CraigBampton
from kanefe_fem.beams.sections import Rectangle
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.mesh.simple import box_mesh
from kanefe_fem.mesh.surface_grid import surface_mesh
from kanefe_fem.shells.body import shell_body
from kanefe_fem.shells.stiffener import Stiffener

PLAIN = Material(E=210e9, nu=0.0, rho=7850.0)

TIP = 2e-3
"""Largest relative error of compliances and of frequencies: the solid half has cells of 42 mm."""


def compliance(body: FlexibleBody, name: str) -> np.ndarray:
    """Return the motion of an interface under unit forces and moments on it, shape (6, 6), m/N to rad/(N m)."""
    frame = next(one for one in body.interfaces if one.name == name)
    k = body.free_count
    motion = frame.motion[:, :k]
    return np.asarray(motion @ np.linalg.solve(body.stiffness[:k, :k], motion.T))


def with_side(mesh: Mesh, name: str, where: np.ndarray) -> Mesh:
    """Return a mesh of nine-node quadrangles with a group of the sides whose nodes are all in a mask."""
    table = np.concatenate([mesh.connectivity[:, [i, (i + 1) % 4, 4 + i]] for i in range(4)])
    chosen = table[where[table].all(axis=1)]
    once = np.unique(np.sort(chosen, axis=1), axis=0, return_index=True)[1]
    lines = (Cells("line3", chosen[once]),)
    return Mesh(mesh.nodes, 2, mesh.cells, facets={**mesh.facets, name: lines}, source=mesh.source)


def on_box(box: Mesh, sheets: Mapping[str, Mesh]) -> Mesh:
    """Return a box, the group "block", and surfaces, groups of facets, as one mesh; lines are "surface.line"."""
    nodes, facets = [np.asarray(box.nodes)], dict(box.facets)
    lines: dict[str, tuple[Cells, ...]] = {}
    for name, sheet in sheets.items():
        start = sum(len(one) for one in nodes)
        nodes.append(np.asarray(sheet.nodes))
        facets[name] = tuple(Cells(one.kind, one.nodes + start) for one in sheet.cell_blocks)
        lines |= {f"{name}.{k}": (Cells("line3", one[0].nodes + start),) for k, one in sheet.facets.items()}
    return Mesh(np.concatenate(nodes), 3, {"block": box.cells["body"]}, facets=facets, lines=lines, source="parts")


def half_and_half(reference: Reference) -> Iterator[Check]:
    """SH20: a cantilever, half of it a solid and half a shell whose cells do not fit those of the solid."""
    length, width, t = 1.0, 0.1, 0.02
    box = box_mesh((length / 2, width, t), (12, 2, 1), start=(0.0, -width / 2, -t / 2))
    sheet = surface_mesh(lambda s, r: (length * (1.0 + s) / 2, width * (r - 0.5), 0.0 * s), (8, 3))
    mesh, materials = on_box(box, {"sheet": sheet}), {"block": PLAIN, "sheet": PLAIN}
    held: dict[str, str | Interface] = {"root": "clamped"}
    statics = shell_body(mesh, materials, held | {"sheet.tip": "average"}, {"sheet": t}, CraigBampton(modes=0))
    found = np.diag(compliance(statics, "sheet.tip"))
    for axis, name in enumerate(("u_x", "u_y", "u_z")):
        yield Check.relative(f"{name} per force at the tip [m/N]", found[axis], reference.values[name], TIP)
    body = shell_body(mesh, materials, held, {"sheet": t}, CraigBampton(modes=5))
    bent = [f for f in body.frequencies if np.isclose(reference.values["frequencies"], f, rtol=0.05).any()]
    for n, (f, expected) in enumerate(zip(bent, reference.values["frequencies"], strict=True), start=1):
        yield Check.relative(f"f{n} of bending [Hz]", f, expected, TIP)


def t_beam(reference: Reference) -> Iterator[Check]:
    """SH21: a strip with a rib beside it, under a moment and a force at its end."""
    width, t, thick, height = 0.06, 4e-3, 5e-3, 30e-3
    mesh = surface_mesh(lambda s, r: (s, width * (r - 0.5), 0.0 * s), (8, 2))
    mesh = with_side(mesh, "rib", np.abs(mesh.nodes[:, 1]) < 1e-9)
    for offset in ("below", (0.0, 0.0, -(t + height) / 2.0)):
        rib = Stiffener(Rectangle(thick, height), PLAIN, offset)
        body = shell_body(
            mesh, PLAIN, {"root": "clamped", "tip": "rigid"}, t, CraigBampton(modes=0), beams={"rib": rib}
        )
        C = compliance(body, "tip")
        told = "by the section" if isinstance(offset, str) else "by a vector"
        for name, value in (("phi/M", C[4, 4]), ("w/M", -C[2, 4]), ("u/N", C[0, 0]), ("phi/N", abs(C[4, 0]))):
            yield Check.relative(f"{name}, offset {told} [SI]", value, reference.values[name], 1e-3)


def clad(reference: Reference) -> Iterator[Check]:
    """SH22: a bar with sheets on two faces, of which each cell lies on the solid."""
    length, width, core, t = 1.0, 0.05, 0.04, 1e-3
    box = box_mesh((length, width, core), (8, 1, 2), start=(0.0, -width / 2, -core / 2))

    def sheet(z: float) -> Mesh:
        return surface_mesh(lambda s, r: (length * s, width * (r - 0.5), z + 0.0 * s), (8, 1))

    sheets = {"upper": sheet(core / 2), "lower": sheet(-core / 2)}
    foam = Material(E=2.1e9, nu=0.0, rho=100.0)
    materials = {"block": foam, "upper": PLAIN, "lower": PLAIN}
    thickness, offset = {"upper": t, "lower": t}, {"upper": 0.5, "lower": -0.5}
    body = shell_body(
        on_box(box, sheets),
        materials,
        {"root": "clamped", "tip": "rigid"},
        thickness,
        CraigBampton(modes=0),
        offset=offset,
    )
    C = compliance(body, "tip")
    yield Check.relative("phi/M [rad/(N m)]", C[4, 4], reference.values["phi/M"], 5e-3)
    yield Check.relative("u/N [m/N]", C[0, 0], reference.values["u/N"], 5e-3)


CASES = (Case("SH20", half_and_half), Case("SH21", t_beam), Case("SH22", clad))
