"""What is worth knowing of a shell: thickness over radius and over size, rotary inertia, folds; told, and warned of."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from kanefe.errors import AccuracyWarning, outside
from kanefe.fe_model.model import MassField
from kanefe.fe_model.shapes import measures, shape
from kanefe_fem.materials.laminate import Laminate
from kanefe_fem.shells.checks import turn_within
from kanefe_fem.shells.directors import Directors
from kanefe_fem.shells.mass import masses_of_sections
from kanefe_fem.shells.of_groups import ShellGroup
from kanefe_fem.shells.problem import ShellCells
from kanefe_fem.shells.sections import ShellSection

THICK = 0.1
"""Thickness, relative to radius, size or wave, from which a shell is not thin enough to be one."""

FLAT = 1e-9
"""Thickness relative to a radius of curvature up to which cells are told to be flat: places in files have round-off."""

SHEARED = 0.2
"""Share of shear in the deflection of a laminate over which first-order theory is off by more than 2 to 4 %."""


def shell_measures(
    nodes: np.ndarray, found: Directors, cells: Sequence[ShellCells], groups: Sequence[ShellGroup], field: MassField
) -> dict[str, Any]:
    """Return the measures of a shell, json-able, and warn where it is none.

    Parameters
    ----------
    nodes : ndarray, shape (n, 3)
        m.
    found : Directors
    cells : sequence of ShellCells
    groups : sequence of ShellGroup
        In the order of the sections.
    field : MassField

    Returns
    -------
    dict
        "thickness_m" of each group, least and largest, and its "mass_kg"; "t/R" and "t/L", the worst, with their places
        and groups; "turn in a cell", the largest angle between its normals, rad; "rotary inertia", the part of the
        inertia about the centre of mass that the thickness makes; "bending" of each group: see `of_bending`.
    """
    curved = [_curvature(nodes, found, one) for one in cells]
    area, thinnest, thickest = (np.zeros(len(groups)) for _ in range(3))
    thinnest += np.inf
    worst, place, where = 0.0, np.zeros(3), 0
    for one, (size, curvature) in zip(cells, curved, strict=True):
        np.add.at(area, one.of_cell, size)
        np.minimum.at(thinnest, one.of_cell, one.thickness.min(axis=1))
        np.maximum.at(thickest, one.of_cell, one.thickness.max(axis=1))
        ratio = one.thickness.max(axis=1) * curvature
        if ratio.max(initial=0.0) > worst:
            at = int(ratio.argmax())
            worst, place, where = float(ratio[at]), nodes[one.cells.nodes[at]].mean(axis=0), int(one.of_cell[at])
    by_size = thickest / np.sqrt(area)
    stubby = int(by_size.argmax())
    names = [group.name for group in groups]
    result = {
        "thickness_m": {name: [float(a), float(b)] for name, a, b in zip(names, thinnest, thickest, strict=True)},
        "mass_kg": dict(zip(names, masses_of_sections(nodes, found, cells).tolist(), strict=True)),
        "t/R": {"value": worst, "group": names[where], "at": place.round(9).tolist()},
        "t/L": {"value": float(by_size[stubby]), "group": names[stubby]},
        "rotary inertia": _rotary(field),
        "turn in a cell": float(max(turn_within(nodes, one.cells).max() for one in cells)),
        "bending": {name: of_bending(one.section, t) for name, one, t in zip(names, groups, thickest, strict=True)},
    }
    _warn(result)
    for group, t, size in zip(groups, thickest, np.sqrt(area), strict=True):
        _warn_of_layers(group, float(t), float(size))
    return result


def _curvature(nodes: np.ndarray, found: Directors, one: ShellCells) -> tuple[np.ndarray, np.ndarray]:
    """Return area (m2) and largest curvature (1/m) of cells, at their middles."""
    element = shape(one.cells.kind)
    slope = element.gradients(element.nodes[: element.corners].mean(axis=0)[None])[0]
    x = nodes[one.cells.nodes]
    J, turn = (np.einsum("na,mni->mia", slope, of) for of in (x, found.normal[one.sides]))
    first, second = J.swapaxes(1, 2) @ J, J.swapaxes(1, 2) @ turn
    values = np.linalg.eigvals(np.linalg.solve(first, 0.5 * (second + second.swapaxes(1, 2))))
    return measures(one.cells.kind, x)[0], np.abs(values).max(axis=1)


def _rotary(field: MassField) -> float:
    """Return the part of the moments of mass about the centre that comes from points beside the surface."""
    arms = np.asarray(field.arms)
    weights = field.mass @ np.ones(len(arms))
    away = field.points - weights @ field.points / weights.sum()
    whole, own = (float(np.einsum("pi,pi->", v, field.mass @ v)) for v in (away, arms))
    return own / whole


def _warn(found: Mapping[str, Any]) -> None:
    curved, size = found["t/R"], found["t/L"]
    for what, text in (
        (curved, f"a radius of curvature at {curved['at']} m"),
        (size, "the root of its area"),
    ):
        if what["value"] > THICK:
            warnings.warn(
                f"the thickness of group {what['group']!r} is {what['value']:.2g} of {text}, more than a tenth: a "
                "shell of straight directors is the wrong model there. Remedy: mesh that part as a solid (solid_body, "
                "or volumes and surfaces in one mesh)",
                AccuracyWarning,
                stacklevel=outside(),
            )


def _warn_of_layers(group: ShellGroup, thickness: float, size: float) -> None:
    """Warn of a laminate whose layers shear so much that their directors do not stay straight."""
    if not isinstance(group.plain, Laminate) or len({(ply.material, ply.angle) for ply in group.plain.plies}) == 1:
        return
    share = shear_share(group.section, thickness, size)
    if share > SHEARED:
        warnings.warn(
            f"laminate of group {group.name!r}: bent over {size:.3g} m it shears by {share:.2g} of its deflection, "
            "where first-order theory is off by some per cent (12 % of a cross ply with t/L 1/4). Remedy: mesh it as "
            "a solid, a layer of cells for each ply or two",
            AccuracyWarning,
            stacklevel=outside(),
        )


def shear_share(section: ShellSection, thickness: float, length: float) -> float:
    """Return deflection by shear over that by bending, in half a wave of a length (m), in the softest direction."""
    bending, shear = np.diag(section.stiffness(2))[:2], np.diag(section.shear)
    return float(((np.pi * thickness / length) ** 2 * bending / shear).max())


def shortest_wave(bending: Mapping[str, Sequence[float]], frequency: float) -> tuple[float, float, str]:
    """Return the length of bending waves at a frequency in Hz, m, and the thickness over it, of the worst group.

    ``k^4 = m w^2 / D`` with the numbers of `of_bending`.
    """
    w = 2.0 * np.pi * frequency
    waves = [(2.0 * np.pi * (D / (m * w**2)) ** 0.25, t, name) for name, (D, m, t) in bending.items()]
    length, t, name = max(waves, key=lambda wave: wave[1] / wave[0])
    return float(length), float(t / length), name


def of_bending(section: ShellSection, thickness: float) -> list[float]:
    """Return D in N m, in the softest direction without twist, mass in kg/m2 and thickness in m."""
    stiffness = np.linalg.eigvalsh(section.stiffness(2)[:2, :2])[0]
    return [float(thickness**3 * stiffness), float(thickness * section.mass(0)), float(thickness)]


def told_of_waves(provenance: Mapping[str, Any]) -> list[str]:
    """Return the line on the waves of the fastest mode that a body of this record prints; warn if they are short."""
    modes = [one["frequency"] for one in provenance["reduction"].get("modes", ()) if one.get("kept", True)]
    if not modes or not max(modes) > 0.0:
        return []
    length, ratio, name = shortest_wave(provenance["shell"]["bending"], max(modes))
    if ratio > THICK:
        warnings.warn(
            f"the thickness of group {name!r} is {ratio:.2g} of the bending waves of about {length:.3g} m of the "
            f"fastest mode ({max(modes):.4g} Hz), more than a tenth: a shell is the wrong model for it. Remedy: fewer "
            "modes, or mesh that part as a solid",
            AccuracyWarning,
            stacklevel=outside(),
        )
    return [f"fastest mode {max(modes):.4g} Hz, waves of about {length:.3g} m, t/wave {ratio:.2g}"]


def told(provenance: Mapping[str, Any]) -> list[str]:
    """Return the lines that a body of this record prints."""
    found = provenance["shell"]
    thickness = "; ".join(
        f"{name} {1e3 * low:.4g}{f' to {1e3 * high:.4g}' if high > low * (1.0 + 1e-9) else ''} mm, "
        f"{found['mass_kg'][name]:.4g} kg"
        for name, (low, high) in found["thickness_m"].items()
    )
    curved = found["t/R"]
    bent = f"t/R up to {curved['value']:.2g} ({curved['group']})" if curved["value"] > FLAT else "flat cells"
    lines = [
        f"shell: thickness {thickness}",
        f"{bent}, t/L up to {found['t/L']['value']:.2g} "
        f"({found['t/L']['group']}), rotary inertia {100 * found['rotary inertia']:.2g} % of the inertia",
        f"{provenance['nodes on folds']} nodes on folds, {provenance['cells turned']} cells turned; the normal turns "
        f"by up to {np.degrees(found['turn in a cell']):.2g} degrees in a cell",
    ]
    by_section: dict[str, list[str]] = {}
    for name, section in provenance.get("stiffeners", {}).items():
        by_section.setdefault(section, []).append(name)
    for section, names in by_section.items():
        masses = [provenance["stiffener_masses_kg"][name] for name in names]
        lines.append(f"stiffener {', '.join(names)}: {section}, {sum(masses):.4g} kg")
    if "seams" in provenance:
        seams, solids = provenance["seams"], provenance["solids"]
        lines.append(
            f"solid {', '.join(solids['materials'])}: {solids['mass_kg']:.4g} kg; on it {seams['edges']} edges and "
            f"{seams['cells']} cells of the shell"
        )
    return lines
