"""Bad meshes: slivers, and cells a thousand times as long as thick."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from kanefe.bodies.flexible import FlexibleBody
from kanefe.checks.robustness.case import Effort, Finding, StressCase
from kanefe.errors import KanefeError, ModelError, UnitWarning
from kanefe.fe_model.model import Cells
from kanefe.reduction import CraigBampton
from kanefe.report.mesh_quality import mesh_quality
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.mesh.mesh import Mesh
from kanefe_fem.mesh.simple import box_mesh
from kanefe_fem.solids.body import solid_body

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
BAR = Material(E=210e9, nu=0.0, rho=7850.0)
BLOCK, COUNTS = (1.0, 0.2, 0.1), (8, 4, 2)
MODES = 6

GAPS = (1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8, 1e-10)
"""Heights of the slivers relative to those of good cells."""

ALWAYS = 1e-6
"""Relative height down to which no mesh may be refused."""


def flattened(mesh: Mesh, gap: float, seed: int) -> Mesh:
    """Return the mesh with a tenth of its inner nodes moved until a cell is left with a share `gap` of its height."""
    rng = np.random.default_rng(seed)
    block = next(iter(mesh.cells.values()))[0]
    nodes, cells = mesh.nodes.copy(), block.nodes
    low, high = nodes.min(axis=0), nodes.max(axis=0)
    inner = np.flatnonzero(np.all((nodes > low + 1e-9) & (nodes < high - 1e-9), axis=1))
    for node in rng.choice(inner, max(1, len(inner) // 10), replace=False):
        around = cells[np.any(cells == node, axis=1)]
        direction = rng.standard_normal(3)
        before = _volumes(nodes, around)
        nodes[node] += direction
        rates = _volumes(nodes, around) - before  # volumes are linear in the place of one node
        nodes[node] -= direction
        reach = np.min(np.where(rates < 0.0, -before / np.minimum(rates, -1e-300), np.inf))
        nodes[node] += (1.0 - gap) * reach * direction
    return replace(mesh, nodes=nodes)


def _volumes(nodes: np.ndarray, cells: np.ndarray) -> np.ndarray:
    x = nodes[cells]
    return np.asarray(np.linalg.det(x[:, 1:4] - x[:, :1]) / 6.0)


def slivers(effort: Effort) -> Iterator[Finding]:
    """Frequencies and mass of a free block whose mesh has slivers, against those of the good mesh."""
    mesh = box_mesh(BLOCK, COUNTS, "tetra")
    good = solid_body(mesh, STEEL, {}, reduction=CraigBampton(modes=MODES), cache=False)
    errors, masses, aspects, refused, early = [], [], [], 0, 0
    tries = [(gap, seed) for gap in GAPS for seed in range(effort.count(3, 1))]
    for gap, seed in tries:
        bad = flattened(mesh, gap, seed)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                body = solid_body(bad, STEEL, {}, reduction=CraigBampton(modes=MODES), cache=False)
        except KanefeError:
            refused += 1
            early += gap >= ALWAYS
            continue
        aspects.append(float(mesh_quality(bad.nodes, _blocks(bad)).aspect_ratio.max()))
        errors.append(float(np.abs(body.frequencies / good.frequencies - 1.0).max()))
        masses.append(abs(body.mass / good.mass - 1.0))
    note = f"aspect ratios up to {max(aspects):.0e}, {refused} of {len(tries)} refused by name"
    what = f"free block of {mesh.cell_count} tetrahedra with slivers of 1e-1 ... 1e-10 of a good height"
    reason = "the mesh is another one, and its own error is of this size"
    yield Finding.of(what, errors, "frequencies 1-6, relative", 0.02, reason, note)
    yield Finding.of(what, masses, "mass, relative", 1e-12, "round-off", note)
    yield Finding(
        what,
        len(tries),
        f"refused though not flatter than {ALWAYS:g}",
        float(early),
        0.0,
        "known limit: from aspect ratios of 1e8 on K is round-off, which the check of its rigid motions finds",
        note,
    )


def _blocks(mesh: Mesh) -> tuple[Cells, ...]:
    return tuple(block for blocks in mesh.cells.values() for block in blocks)


LAYERS = (1e-1, 1e-2, 1e-3, 1e-4, 1e-6)
"""Thickness of thin layers of cells relative to their neighbours."""

SLENDER = (30.0, 100.0, 300.0, 1000.0)
TOO_SLENDER = (3000.0, 1e4, 1e5)
"""Ratios of length to thickness of bars with one or a few cells."""


def aspect_ratios(effort: Effort) -> Iterator[Finding]:
    """Cells up to a million times as long as thick in a compact body, and bars and plates of slender cells."""
    reference = _clamped(_layered(0.5)).frequencies
    errors = [float(np.abs(_clamped(_layered(share)).frequencies / reference - 1.0).max()) for share in LAYERS]
    yield Finding.of(
        "clamped block with two layers of cells, 10 ... 1e6 times as long as thick",
        errors,
        "frequencies 1-8, relative",
        0.01,
        "its meshes differ by half a percent",
    )
    bends, twins, count = [], [], 2
    for slender in SLENDER:
        found = _clamped(_bar(slender, count), BAR).frequencies
        # Bernoulli's; two quadratic cells, whose moments are constant in each, are 5 % above
        bends.append(abs(found[0] / (_bernoulli(slender) * 1.0508) - 1.0))
        twins.append(abs(found[1] / found[0] - 1.0))
    what = f"square bar of {count} cells, {SLENDER[0]:g} ... {SLENDER[-1]:g} times as long as thick"
    yield Finding.of(what, bends, "first frequency, relative", 0.02, "shear in the thickest")
    yield Finding.of(
        what,
        twins,
        "two bending modes of one frequency, relative",
        1e-3,
        "round-off of K over its condition, the fourth power of the slenderness",
    )
    silent = 0
    for slender in TOO_SLENDER:
        try:
            body = _clamped(_bar(slender, count), BAR)
        except ModelError as problem:
            silent += "Remedy" not in str(problem)
        else:
            silent += abs(body.frequencies[0] / (_bernoulli(slender) * 1.0508) - 1.0) > 0.02
    yield Finding(
        f"square bar of {count} cells, {TOO_SLENDER[0]:g} ... {TOO_SLENDER[-1]:g} times as long as thick",
        len(TOO_SLENDER),
        "wrong without a word",
        float(silent),
        0.0,
        "known limit: the condition of K passes 1e16, and the body is refused; beams do it",
    )


def _clamped(mesh: Mesh, material: Material = STEEL) -> FlexibleBody:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UnitWarning)
        return solid_body(mesh, material, {"root": "clamped"}, reduction=CraigBampton(modes=8), cache=False)


def _layered(share: float) -> Mesh:
    """Return a block of 4 x 4 x 2 cells whose first and last layer along y have a share of the usual thickness."""
    mesh = box_mesh((1.0, 1.0, 0.5), (4, 4, 2), "hexahedron", start=(0.0, -0.5, -0.25))
    nodes = mesh.nodes.copy()
    thin = 0.25 * share
    nodes[:, 1] = np.interp(nodes[:, 1], (-0.5, -0.25, 0.0, 0.25, 0.5), (-0.25, thin - 0.25, 0.0, 0.25 - thin, 0.25))
    return replace(mesh, nodes=nodes)


def _bar(slender: float, count: int) -> Mesh:
    side = 1.0 / slender
    return box_mesh((1.0, side, side), (count, 1, 1), "hexahedron", start=(0.0, -side / 2, -side / 2))


def _bernoulli(slender: float) -> float:
    """Return the first frequency of a clamped bar of 1 m in Hz."""
    return 1.8751040687**2 * math.sqrt(STEEL.E / STEEL.rho / 12.0) / slender / (2.0 * math.pi)


CASES = (
    StressCase("slivers", "sliver meshes", slivers),
    StressCase("aspect-ratio", "cells of aspect ratio 1e3", aspect_ratios),
)
