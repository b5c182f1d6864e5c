"""Meshes of solids cut into segments: against beams and the uncut body, centre lines, bad input."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import kanefe as kf
import kanefe_fem
from kanefe_fem import Material, Rectangle, box_mesh, segmented, straight_beam
from kanefe_fem.segments.centre_line import arc_lengths, found_line, stations

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
ENDS = {"root": "clamped", "tip": "rigid"}


def bar(length=1.0, counts=(48, 2, 2), side=0.02):
    """Return the mesh of a bar along x about its axis."""
    return box_mesh((length, side, side), counts, start=(0, -side / 2, -side / 2))


def bent(radius, pitch=0.0):
    """Return the mesh of a bar of 2 m, bent about z on a radius."""
    mesh = bar(2.0, (60, 2, 2), 0.1)
    x, y, z = mesh.nodes.T
    turn, r = x / radius, radius - y
    return replace(mesh, nodes=np.column_stack([r * np.sin(turn), radius - r * np.cos(turn), z + pitch * turn]))


def rest_of(body, force, gravity=(0.0, 0.0, 0.0)):
    """Return the rest of a segmented or flexible body under a force at its tip."""
    scene = kf.System(gravity=gravity)
    add = scene.add_flexible_body if isinstance(body, kf.FlexibleBody) else scene.add_segmented_body
    scene.add_force(add("b", body).interface("tip"), force)
    return kf.equilibrium(scene)


@pytest.mark.fenicsx
@pytest.mark.filterwarnings("ignore::kanefe.AccuracyWarning")
@pytest.mark.parametrize(
    ("cuts", "worst", "count"),
    [
        ("average", 2.5e-3, 8),
        ("rigid", 2.5e-2, 8),
        pytest.param("average", 2.5e-3, 16, marks=pytest.mark.slow),
        pytest.param("rigid", 2.5e-2, 16, marks=pytest.mark.slow),
    ],
)
def test_a_bar_bends_as_the_beam(cuts, worst, count):
    """By 0.7 m of 1 m; faces that stay plane stiffen it by the contraction that they hinder, at each cut."""
    mesh, force = bar(), (0, 0, 5000.0)
    beam = straight_beam(1.0, Rectangle(0.02, 0.02), STEEL, elements=48)
    solid = rest_of(segmented(mesh, ENDS, STEEL, segments=count, cuts=cuts), force)
    line = rest_of(segmented(beam, ENDS, segments=count), force)
    found, expected = solid.deflection("b", "tip"), line.deflection("b", "tip")
    np.testing.assert_allclose(found, expected, atol=worst * abs(expected).max())
    frequencies = [r.linearise().modes().frequencies[:3] for r in (solid, line)]
    np.testing.assert_allclose(*frequencies, rtol=1.5 * worst)


@pytest.mark.fenicsx
def test_a_curved_bar_is_the_uncut_one():
    """Mass and inertia to round-off; small deflections and stresses as of one body, within the softness of the cuts."""
    mesh = bent(1.0)
    chain = segmented(mesh, ENDS, STEEL, segments=8, surfaces=["top"])
    body = kanefe_fem.solid_body(mesh, STEEL, ENDS, kf.CraigBampton(modes=0), cache=False)
    assert chain.mass == pytest.approx(body.mass, rel=1e-14)
    np.testing.assert_allclose(chain.center_of_mass, body.center_of_mass, atol=1e-14)
    np.testing.assert_allclose(chain.inertia, body.inertia, atol=1e-14 * body.inertia.max())
    own, other = rest_of(chain, (0, 0, 3e3)), rest_of(body, (0, 0, 3e3))
    deflection = other.deflection("b", "tip")
    np.testing.assert_allclose(own.deflection("b", "tip"), deflection, atol=1e-2 * abs(deflection).max())
    fields, expected = kanefe_fem.recover(own, "b"), kanefe_fem.recover(other, "b")
    assert fields.stress_at_cells().shape == expected.stress_at_cells().shape
    assert fields.envelope().peak == pytest.approx(expected.envelope().peak, rel=0.01)
    one = [np.median(f.stress_at_cells()[0], axis=0) for f in (fields, expected)]
    np.testing.assert_allclose(*one, atol=0.02 * abs(one[1]).max())
    assert own.nodal_positions("b").shape == chain.nodes.shape


def small(body):
    """Return the deflection of the tip under a force of 1 N, and frequencies."""
    rest = rest_of(body, (0, 0.4, 1.0))
    return rest.deflection("b", "tip")[[1, 2, 4, 5]], rest.linearise().modes().frequencies[:3]


@pytest.mark.fenicsx
@pytest.mark.parametrize(("kind", "count"), [("hexahedron", 7), ("tetra", 7), ("tetra", 10)])
def test_cuts_run_between_layers_of_cells(kind, count):
    """Where the mesh has layers, whatever the number; nodes that are denser to one side move no face."""
    mesh = box_mesh((1.0, 0.02, 0.02), (50, 2, 2), kind, start=(0, -0.01, -0.01))
    x, y, z = mesh.nodes.T
    mesh = replace(mesh, nodes=np.column_stack([x, y + 15 * (y**2 - 1e-4), z]))
    body = kanefe_fem.solid_body(mesh, STEEL, ENDS, kf.CraigBampton(modes=6), cache=False)
    for found, expected in zip(small(segmented(mesh, ENDS, STEEL, segments=count)), small(body), strict=True):
        np.testing.assert_allclose(found, expected, rtol=2e-3)


@pytest.mark.fenicsx
def test_cuts_that_are_not_flat_are_told():
    """The softness that the message tells is not exceeded, and not told in vain."""
    mesh = box_mesh((1.0, 0.02, 0.02), (50, 2, 2), "tetra", start=(0, -0.01, -0.01))
    x, y, z = mesh.nodes.T
    bowed = np.where((x > 0.1) & (x < 0.9), 60.0 * (y**2 + z * 0.01), 0.0)
    mesh = replace(mesh, nodes=np.column_stack([x + bowed, y, z]))
    body = kanefe_fem.solid_body(mesh, STEEL, ENDS, kf.CraigBampton(modes=6), cache=False)
    with pytest.warns(kf.AccuracyWarning, match="follow cells up to") as told:
        chain = segmented(mesh, ENDS, STEEL, segments=8)
    share = float(str(told[0].message).partition("may be ")[2].partition(" %")[0]) / 100
    excess = small(chain)[0] / small(body)[0] - 1
    assert 1e-3 < excess.max() < share


@pytest.mark.fenicsx
def test_loads_on_the_whole():
    """A traction on a surface has its resultant at the root, whatever the cuts."""
    scene = kf.System()
    member = scene.add_segmented_body("b", segmented(bar(), ENDS, STEEL, segments=5, surfaces=["top"]))
    scene.add_traction(member, "top", (0.0, 0.0, -1e3))
    held = kf.equilibrium(scene).coupling_force("b", "root")
    np.testing.assert_allclose(held[[2, 4]], (20.0, -10.0), rtol=1e-3)


@pytest.mark.parametrize(("radius", "pitch"), [(1.0, 0.0), (0.6, 0.0), (0.4, 0.15)])
def test_a_centre_line_is_found(radius, pitch):
    """Of an arc and of a coil: on its axis within a tenth of the side, as long as it, with sections across."""
    mesh = bent(radius, pitch)
    line = found_line(mesh.nodes, mesh.cell_blocks)
    assert abs(np.hypot(line[:, 0], line[:, 1] - radius) - radius).max() < 0.01
    assert arc_lengths(line)[-1] == pytest.approx(2.0 * np.hypot(1.0, pitch / radius), rel=0.03)
    at, _ = stations(mesh.nodes, line)
    arc = bar(2.0, (60, 2, 2), 0.1).nodes[:, 0]
    share = (at - at.min()) / np.ptp(at) if at[arc.argmin()] < at[arc.argmax()] else 1 - (at - at.min()) / np.ptp(at)
    assert abs(share - arc / 2.0).max() < 0.03  # sections of the coil are sheared by its pitch


@pytest.mark.fenicsx
def test_bad_solids():
    mesh = bar(1.0, (24, 2, 2))
    for call, message in (
        (lambda: segmented(mesh, ENDS, segments=4), "needs materials="),
        (lambda: segmented(mesh, ENDS, STEEL, segments=60), "shorter than the width"),
        (lambda: segmented(bar(0.08), ENDS, STEEL, segments=2), "too stout to be cut"),
        (lambda: segmented(bent(0.3), ENDS, STEEL, segments=4, line=bent(0.3).nodes[[0, 9, 5]]), "too stout|crosses"),
        (lambda: segmented(mesh, {"root": "clamped", "top": "average"}, STEEL, segments=4), "share node|at the cut"),
        (lambda: segmented(mesh, {"root": "clamped", "tip": "clamped"}, STEEL, segments=4), "fixed in G, but belong"),
        (lambda: segmented(mesh, ENDS, STEEL, segments=4, line=[[0, 0, 0]]), "at least two points"),
        (lambda: segmented(mesh, ENDS, STEEL, segments=4, line=[[0, 0, 0], [0, 0, 0]]), "same point twice"),
        (lambda: segmented(mesh, ENDS, STEEL, segments=4, lumped=[kanefe_fem.LumpedMass("tip", mass=1.0)]), "lumped="),
        (lambda: segmented(mesh, ENDS, STEEL, segments=4, forms=kanefe_fem.Forms(mass=lambda f: f.mass)), "forms="),
        (lambda: segmented(mesh, ENDS, replace(STEEL, damping=kf.RayleighDamping(1.0, 0.0)), segments=4), "mass=1 1/s"),
    ):
        with pytest.raises(kf.ModelError, match=message):
            call()
