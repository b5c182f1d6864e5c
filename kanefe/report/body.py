"""The sections of the report of a flexible body."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

import numpy as np

from kanefe.bodies.flexible import FlexibleBody
from kanefe.documents.blocks import Block, Heading, Histogram, Paragraph, Picture, Table
from kanefe.documents.document import Report
from kanefe.documents.record_tables import record_tables
from kanefe.fe_model.model import COMPONENTS, ROTATIONS, TRANSLATIONS, Cells
from kanefe.report.mesh_quality import MeshQuality, mesh_quality
from kanefe.report.modes import BodyModes, body_modes, compliance_shares, interface_masses

MOST_MODES = 30
"""Largest number of modes in tables."""

PICTURES = 12
"""Largest number of modes that are drawn."""

WORST = 5
"""Largest number of cells that are listed."""

DENSE = 400
"""Number of free coordinates up to which the modes of a body are computed for the report."""

FLAT, LONG, BENT = 0.1, 10.0, 0.25
"""Quality limits of poor cells: scaled Jacobian below the first, aspect ratio and bend of sides above the others."""

SHAPES = "Frequencies and mode shapes"


def body_report(body: FlexibleBody) -> Report:
    """Return the report of a flexible body; `FlexibleBody.report` is the usual way."""
    modes = body_modes(body) if body.free_count <= DENSE else None
    blocks = (
        *_summary(body, modes),
        *_mesh(body),
        *_mass(body),
        *_frequencies(body, modes),
        *(_effective_masses(body, modes) if modes is not None else ()),
        *_interfaces(body, modes),
        *_reduction(body),
        *_numbers(body, modes),
        *_skipped(body),
        *_provenance(body),
    )
    source = body.provenance.get("source")
    title = f"Flexible body from {source}" if source else "Flexible body"
    return Report(title, blocks, cache(lambda: _pictures(body, modes)))  # drawn once for all formats


def _summary(body: FlexibleBody, modes: BodyModes | None) -> list[Block]:
    held = "floats" if body.is_floating else f"is held in G by {body.fixed_count} components of its interfaces"
    if body.bends_far:
        held = "bends and turns as far as it likes from its root section, which is fixed in G"
    first = "" if modes is None or not body.free_count else f" from {modes.frequencies[0]:.5g} Hz"
    return [
        Paragraph(
            f"{len(body.nodes)} nodes, {len(body.nodes) * len(body.components)} degrees of freedom, "
            f"{body.free_count} free coordinates{first}. Mass {body.mass:.6g} kg. The body {held}. "
            f"Units: {body.units}; components in the mesh frame G.{_losses(body)}"
        )
    ]


def _losses(body: FlexibleBody) -> str:
    """Return sentences on what relaxes in a body, and on its structural damping."""
    found, relaxation = "", body.relaxation
    if relaxation is not None:
        least, most = relaxation.times.min(), relaxation.times.max()
        times = f"{least:.3g} s" if least == most else f"{least:.3g} to {most:.3g} s"
        found += (
            f" Viscoelastic: {len(relaxation.times)} internal states, relaxation times {times}; frequencies are those "
            "of the long-term stiffness."
        )
    if body.structural is not None:
        found += " Structural damping acts in frequency responses and modes only."
    return found


def _mesh(body: FlexibleBody) -> list[Block]:
    quality = mesh_quality(body.nodes, body.cells)
    blocks: list[Block] = [Heading("Mesh quality")]
    if not quality.kinds:
        return [*blocks, Paragraph("The body has no cells (given matrices): its mesh is not known.")]
    size = np.ptp(body.nodes, axis=0)
    counts = ", ".join(f"{count} {kind}" for kind, count in quality.kinds.items())
    shortest, longest = quality.edges[:, 0].min(), quality.edges[:, 1].max()
    blocks.append(
        Paragraph(
            f"{counts}; extent {size[0]:.4g} x {size[1]:.4g} x {size[2]:.4g} m; sides of {shortest:.3g} to "
            f"{longest:.3g} m."
        )
    )
    return blocks + _shapes_of_cells(quality)


def _shapes_of_cells(quality: MeshQuality) -> list[Block]:
    known = np.isfinite(quality.scaled_jacobian)
    if not known.any():
        return []
    jacobian, aspect, bend = quality.scaled_jacobian[known], quality.aspect_ratio[known], quality.bend[known]
    rows = [
        [title, f"{values.min():.3f}", f"{values.mean():.3f}", f"{values.max():.3f}"]
        for title, values in (
            ("scaled Jacobian (1 is best)", jacobian),
            ("aspect ratio (1 is best)", aspect),
            ("bend of sides (0 is straight)", bend),
        )
    ]
    blocks: list[Block] = [Table(("", "least", "mean", "greatest"), rows)]
    low = min(0.0, float(np.floor(10.0 * jacobian.min()) / 10.0))
    edges = np.round(np.arange(low, 1.0 + 1e-9, 0.1), 10)
    counted = np.histogram(np.clip(jacobian, low, 1.0), bins=edges)[0]
    blocks.append(Histogram("Cells by scaled Jacobian:", edges.tolist(), counted.tolist()))
    blocks += _worst_cells(quality)
    poor = int(np.count_nonzero((jacobian < FLAT) | (aspect > LONG)))
    bent = int(np.count_nonzero(bend > BENT))
    if poor or bent:
        blocks.append(
            Paragraph(
                f"{poor} cells are flat or long (scaled Jacobian below {FLAT:g} or aspect ratio above {LONG:g}), "
                f"{bent} bend by more than {BENT:g} of a side: stresses there are poor. Refine or smooth the mesh.",
                warning=True,
            )
        )
    return blocks


def _worst_cells(quality: MeshQuality) -> list[Block]:
    jacobian = np.where(np.isfinite(quality.scaled_jacobian), quality.scaled_jacobian, np.inf)
    worst = np.argsort(jacobian, kind="stable")[:WORST]
    rows = [
        [
            str(number),
            f"{jacobian[number]:.3f}",
            f"{quality.aspect_ratio[number]:.3f}",
            ", ".join(f"{x:.4g}" for x in quality.centres[number]),
        ]
        for number in worst
    ]
    return [Paragraph("The worst cells:"), Table(("cell", "scaled Jacobian", "aspect ratio", "centre in G [m]"), rows)]


def _mass(body: FlexibleBody) -> list[Block]:
    c = body.center_of_mass
    inertia = body.inertia - body.mass * (c @ c * np.eye(3) - np.outer(c, c))
    moments, axes = np.linalg.eigh(inertia)
    rows = [
        ["mass", f"{body.mass:.8g}", "kg"],
        ["centre of mass", ", ".join(f"{_clean(x, _size(body)):.6g}" for x in c), "m"],
        ["inertia about it: xx, yy, zz", ", ".join(f"{x:.6g}" for x in np.diag(inertia)), "kg m2"],
        [
            "xy, xz, yz",
            ", ".join(f"{_clean(inertia[i, j], moments[2]):.6g}" for i, j in ((0, 1), (0, 2), (1, 2))),
            "kg m2",
        ],
        ["principal moments", ", ".join(f"{x:.6g}" for x in moments), "kg m2"],
    ]
    rows += [[f"principal axis {number + 1}", _direction(axes[:, number]), ""] for number in range(3)]
    form = (
        "The inertia is exact for the displacement field of the elements."
        if body.is_exact
        else "The inertia is the nodal form of Eq. 38, an approximation where nodes rotate."
    )
    if body.bends_far:
        form = "The inertia is that of rigid sections along the beam, exact however it bends."
    return [Heading("Mass properties (undeformed)"), Table(("", "", ""), rows, align_left=True), Paragraph(form)]


def _frequencies(body: FlexibleBody, modes: BodyModes | None) -> list[Block]:
    blocks: list[Block] = [Heading(SHAPES)]
    if body.free_count == 0:
        return [*blocks, Paragraph("The body has no free coordinates.")]
    if modes is None:
        return [
            *blocks,
            Paragraph(f"The body has {body.free_count} free coordinates; modes are listed up to {DENSE} of them."),
        ]
    how = "the body free in space" if body.is_floating else "the fixed interfaces held"
    if body.bends_far:
        how = "the root section held, for small motions about the undeformed body"
    rows = [
        [str(i + 1), f"{modes.frequencies[i]:.6g}", f"{100 * modes.damping_ratios[i]:.3g}"]
        for i in range(min(body.free_count, MOST_MODES))
    ]
    blocks += [Paragraph(f"With {how}."), Table(("mode", "frequency [Hz]", "damping [%]"), rows)]
    return blocks + _more(body.free_count)


def _more(count: int) -> list[Block]:
    return [Paragraph(f"... and {count - MOST_MODES} more modes.")] if count > MOST_MODES else []


def _effective_masses(body: FlexibleBody, modes: BodyModes) -> list[Block]:
    blocks: list[Block] = [Heading("Effective masses")]
    if body.is_floating:
        text = "The body floats: its modes carry no momentum, so that their effective masses are zero."
        return [*blocks, Paragraph(text)]
    shares = modes.effective_shares
    count = min(body.free_count, MOST_MODES)
    rows = [[str(i + 1), *(_percent(s) for s in shares[:, i])] for i in range(count)]
    rows.append(["sum of all", *(_percent(s) for s in shares.sum(axis=1))])
    blocks += [
        Paragraph(
            "Effective mass of each mode along x, y and z in percent of the mass, and about the axes of G through "
            "its origin in percent of the inertia. The rest to 100 belongs to the fixed interfaces and dropped modes."
        ),
        Table(("mode", *(f"{c} [%]" for c in COMPONENTS)), rows),
    ]
    held = [frame for frame in body.interfaces if frame.fixed_components]
    if len(held) < 2:
        return blocks
    masses = interface_masses(body, modes)
    for frame in held:
        numbers = [column - body.free_count for column in frame.fixed_columns]
        names = [COMPONENTS[c] for c in frame.fixed_components]
        header = ("mode", *(f"{n} [{'kg' if n in TRANSLATIONS else 'kg m2'}]" for n in names))
        rows = [[str(i + 1), *(f"{m:.4g}" for m in masses[numbers, i])] for i in range(count)]
        rows.append(["sum of all", *(f"{m:.4g}" for m in masses[numbers].sum(axis=1))])
        blocks += [Paragraph(f"Effective masses when only the interface {frame.name!r} moves:"), Table(header, rows)]
    return blocks


def _interfaces(body: FlexibleBody, modes: BodyModes | None) -> list[Block]:
    blocks: list[Block] = [Heading("Interfaces")]
    if not body.interfaces:
        return [*blocks, Paragraph("The body has no interfaces.")]
    rows = []
    for frame in body.interfaces:
        of = range(6) if frame.is_held and body.bends_far else frame.fixed_components
        fixed = ", ".join(COMPONENTS[c] for c in of) or "none"
        rows.append([frame.name, ", ".join(f"{_clean(x, _size(body)):.6g}" for x in frame.position), fixed])
    blocks.append(Table(("interface", "position in G [m]", "fixed in G"), rows, align_left=True))
    if modes is None or body.free_count == 0:
        return blocks
    for frame in body.interfaces:
        shares = compliance_shares(frame.motion[:, : body.free_count], modes)
        moving = [c for c in range(6) if shares[c].any()]
        if not moving:
            continue
        largest = np.argsort(-shares[moving].max(axis=0), kind="stable")[:8]
        table = [[str(i + 1), *(_percent(shares[c, i]) for c in moving)] for i in np.sort(largest)]
        blocks += [
            Paragraph(f"Static compliance of {frame.name!r}: share of each mode in percent."),
            Table(("mode", *(f"{COMPONENTS[c]} [%]" for c in moving)), table),
        ]
    return blocks


def _reduction(body: FlexibleBody) -> list[Block]:
    if body.bends_far:
        return []
    record = body.provenance.get("reduction")
    blocks: list[Block] = [Heading("Reduction")]
    if record is None:
        return [*blocks, Paragraph("Nothing is recorded.")]
    if isinstance(record, Mapping):  # effective masses have a section of their own
        record = {key: value for key, value in record.items() if key != "effective_mass"}
    return blocks + record_tables(record)


def _numbers(body: FlexibleBody, modes: BodyModes | None) -> list[Block]:
    if modes is None or body.free_count == 0:
        return []
    k = body.free_count
    mass = body.moments.elastic_mass[:k, :k]
    off = float(abs(mass - np.eye(k)).max())
    rows = [
        ["condition number of the mass matrix", f"{modes.mass_condition:.3g}"],
        ["condition number of the stiffness matrix", f"{modes.stiffness_condition:.3g}"],
        ["highest frequency", f"{modes.frequencies[-1]:.5g} Hz"],
        [
            "its period (an explicit method needs steps of about a tenth)",
            f"{1.0 / max(modes.frequencies[-1], 1e-300):.3g} s",
        ],
    ]
    if off < 0.1:
        rows.append(["largest departure of the modal mass from the identity", f"{off:.1e}"])
    blocks: list[Block] = [Heading("Conditioning"), Table(("", ""), rows)]
    if modes.mass_condition > 1e10:
        blocks.append(
            Paragraph("The mass matrix is badly conditioned: coordinates are nearly dependent.", warning=True)
        )
    return blocks


def _skipped(body: FlexibleBody) -> list[Block]:
    skipped = []
    damped = body.damping.any() if isinstance(body.damping, np.ndarray) else body.damping.nnz > 0
    if not damped and body.structural is None and body.relaxation is None:
        skipped.append("damping: the body has none")
    if body.provenance.get("stiffening", "none") == "none" and not body.bends_far:
        skipped.append("motion-induced stiffening: the stiffness does not change with speed or load")
    if body.elasticity is None:
        skipped.append("stresses: the moduli of the cells are not known")
    if not body.load_patterns and not body.bends_far:
        skipped.append("distributed loads: no surface or line of the body can carry one")
    if "z" not in body.components:
        skipped.append("motion out of the plane: the mesh has none")
    if body.is_floating:
        skipped.append("rigid modes of the mesh: G takes their place")
    if not body.interfaces:
        skipped.append("interfaces: nothing can be joined to the body but by its frame G and its nodes")
    if not skipped:
        return []
    return [Heading("What was skipped"), Table(("", ""), [entry.split(": ", 1) for entry in skipped], align_left=True)]


def _provenance(body: FlexibleBody) -> list[Block]:
    record: dict[str, Any] = {key: value for key, value in body.provenance.items() if key != "reduction"}
    return [Heading("Origin"), *record_tables(record)] if record else []


def _pictures(body: FlexibleBody, modes: BodyModes | None) -> dict[str, list[Picture]]:
    """Return thumbnails of the mode shapes under their heading, of shells and beams thick; they need pyvista."""
    if modes is None or body.free_count == 0:
        return {}
    from kanefe.views.pictures import drawn, shape_drawing
    from kanefe.views.player.skins import skin_of

    numbers = range(min(body.free_count, PICTURES))
    rest = np.zeros(body.free_count)
    points, cells, skin = body.nodes, body.cells, None if body.bends_far else skin_of(body)
    moved = [body.node_velocities(rest, modes.shapes[:, number]) for number in numbers]
    if skin is not None and skin.arms is not None:
        turned = [_turns_of_nodes(body, modes.shapes[:, number]) for number in numbers]
        pairs = zip(moved, turned, strict=True)
        moved = [shape[skin.nodes] + np.cross(turn[skin.nodes], skin.arms) for shape, turn in pairs]
        points, cells = skin.points, (Cells("triangle", skin.triangles),)
    images = drawn([shape_drawing(points, cells, shape) for shape in moved])
    captions = [f"mode {number + 1}: {modes.frequencies[number]:.5g} Hz" for number in numbers]
    return {SHAPES: [Picture(*pair) for pair in zip(captions, images, strict=True)]}


def _turns_of_nodes(body: FlexibleBody, eta: np.ndarray) -> np.ndarray:
    """Return the rotations of all nodes, (n, 3) in rad, of coordinates (k,)."""
    found = np.zeros((len(body.nodes), 3))
    for axis, name in enumerate(ROTATIONS):
        if name in body.components:
            found[:, axis] = body.basis[body.components.index(name) :: len(body.components), : len(eta)] @ eta
    return found


def _percent(share: float) -> str:
    return f"{100 * share:.2f}" if share >= 5e-5 else "-"


def _clean(value: float, scale: float) -> float:
    """Return zero for round-off, also that of the mesh's coordinates."""
    return 0.0 if abs(value) < 1e-8 * scale else float(value)


def _direction(axis: np.ndarray) -> str:
    """Return a unit vector as text, with its sign chosen so that the largest component is positive."""
    turned = axis * np.sign(axis[np.argmax(abs(axis))])
    return ", ".join(f"{x + 0.0:.5f}" for x in turned.round(5))


def _size(body: FlexibleBody) -> float:
    return float(np.ptp(body.nodes, axis=0).max()) or 1.0
