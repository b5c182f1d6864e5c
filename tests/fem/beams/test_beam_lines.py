"""Lines of beams that carry loads: resultants, exact deflections, and names that are not there."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from fem_meshes import STEEL, shown
from kanefe.errors import ModelError
from kanefe.fe_model.model import Cells
from kanefe.frames import skew
from kanefe_fem.beams.body import beam_body, beam_model, straight_beam
from kanefe_fem.beams.from_mesh import beam_model_from_mesh
from kanefe_fem.beams.sections import Rectangle, Tube
from kanefe_fem.mesh.mesh import Mesh

LENGTH = 2.0
NODES = np.array([[0.0, 0, 0], [1, 0.2, 0], [1.5, 1, 0], [0.5, 1, 0.7]])
ELEMENTS = np.array([[0, 1], [1, 2], [2, 3]])


def tip_deflection(model, load):
    """Return the static motion (6,) of the tip, in G, under a load along "span", in N/m."""
    body = beam_body(model, {"root": "clamped", "tip": "rigid"}, lines=["span"])
    k = body.free_count
    _, _, elastic = body.load_pattern("span").of_traction(np.asarray(load, dtype=float), np.zeros(k))
    return body.interface("tip").motion[:, :k] @ np.linalg.solve(body.stiffness[:k, :k], elastic)


@pytest.mark.parametrize("theory", ["euler-bernoulli", "timoshenko"])
@pytest.mark.parametrize("elements", [1, 3])
@pytest.mark.parametrize("direction", [(1, 0, 0), (1, 2, -0.5)])
def test_a_cantilever_under_its_load_has_the_deflection_of_the_books(theory, elements, direction):
    section = Rectangle(0.04, 0.06)
    model = straight_beam(LENGTH, section, STEEL, elements=elements, direction=direction, theory=theory)
    along = np.array(direction) / np.linalg.norm(direction)
    y = np.cross((0, 0, 1), along)
    y /= np.linalg.norm(y)
    z, w = np.cross(along, y), 300.0
    E, GA = STEEL.E, STEEL.shear_modulus * section.A
    for across, inertia, kappa in ((y, section.I_z, section.shear_y), (z, section.I_y, section.shear_z)):
        shear = 0.0 if theory == "euler-bernoulli" else w * LENGTH**2 / (2 * kappa * GA)
        motion = tip_deflection(model, w * across)
        # consistent loads make nodal deflections exact: the tolerance is the round-off of the solve
        np.testing.assert_allclose(
            motion[:3], (w * LENGTH**4 / (8 * E * inertia) + shear) * across, rtol=1e-9, atol=1e-12
        )
        slope = np.cross(along, across) * w * LENGTH**3 / (6 * E * inertia)
        np.testing.assert_allclose(motion[3:], slope, rtol=1e-9, atol=1e-12)
    stretch = w * LENGTH**2 / (2 * E * section.A)
    np.testing.assert_allclose(tip_deflection(model, w * along)[:3], stretch * along, rtol=1e-9, atol=1e-15)


def test_a_planar_cantilever_has_it_too():
    section, w = Rectangle(0.04, 0.06), 300.0
    model = straight_beam(LENGTH, section, STEEL, elements=2, planar=True, theory="euler-bernoulli")
    motion = tip_deflection(model, (0.0, -w, 0.0))
    assert motion[1] == pytest.approx(-w * LENGTH**4 / (8 * STEEL.E * section.I_z), rel=1e-9)
    assert motion[5] == pytest.approx(-w * LENGTH**3 / (6 * STEEL.E * section.I_z), rel=1e-9)
    # across the plane the body cannot deform, but it is pushed
    assert abs(tip_deflection(model, (0.0, 0.0, w))).max() == 0.0
    assert model.load_patterns["span"].measure == pytest.approx(LENGTH)


def test_the_forces_of_a_frame_do_the_work_of_their_resultants():
    model = beam_model(NODES, ELEMENTS, Tube(0.05, 0.003), STEEL, lines={"legs": [0, -1], "beam": 1})
    length = np.linalg.norm(np.diff(NODES, axis=0), axis=1)
    middle = 0.5 * (NODES[1:] + NODES[:-1])
    for name, chosen in (("legs", [0, 2]), ("beam", [1])):
        pattern = model.load_patterns[name]
        first = length[chosen] @ middle[chosen]
        assert pattern.kind == "line"
        assert pattern.measure == pytest.approx(length[chosen].sum(), rel=1e-14)
        np.testing.assert_allclose(pattern.first, first, rtol=1e-14)
        expected = np.vstack((pattern.measure * np.eye(3), skew(first)))
        np.testing.assert_allclose(model.rigid_modes().T @ pattern.traction, expected, rtol=0, atol=1e-14)


def test_all_elements_are_the_span_unless_lines_are_named():
    assert sorted(beam_model(NODES, ELEMENTS, Tube(0.05, 0.003), STEEL).load_patterns) == ["span"]
    assert sorted(beam_model(NODES, ELEMENTS, Tube(0.05, 0.003), STEEL, lines={}).load_patterns) == []


def test_the_lines_of_a_mesh_are_its_groups_with_a_section():
    lines = {"legs": (Cells("line", ELEMENTS[[0, 2]]),), "beam": (Cells("line", ELEMENTS[[1]]),)}
    mesh = Mesh(NODES, 1, {}, lines=lines, points={"root": np.array([0]), "tip": np.array([3])})
    section = Tube(0.05, 0.003)
    patterns = beam_model_from_mesh(mesh, {"legs": section, "beam": section}, STEEL).load_patterns
    wanted = beam_model(NODES, ELEMENTS, section, STEEL, lines={"legs": [0, 2], "beam": [1]}).load_patterns
    assert list(patterns) == ["legs", "beam"]
    for name, pattern in patterns.items():
        np.testing.assert_allclose(pattern.traction, wanted[name].traction, rtol=0, atol=1e-15)


def test_a_body_keeps_the_lines_it_is_told_to():
    model = beam_model(NODES, ELEMENTS, Tube(0.05, 0.003), STEEL, lines={"legs": [0, 2], "beam": 1})
    held = {"root": "clamped"}
    assert [p.name for p in beam_body(model, held).load_patterns] == ["legs", "beam"]
    assert [p.name for p in beam_body(model, held, lines=["beam"]).load_patterns] == ["beam"]
    reduced = beam_body(model, held, reduction=kf.CraigBampton(modes=3))
    assert reduced.load_pattern("beam").shape_first.shape == (3, reduced.count)


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        (["roof"], ["no line called 'roof'", "legs, beam"]),
        ("legs", ["lines='legs'", "['legs']"]),
    ],
)
def test_a_line_the_model_does_not_have_is_named(lines, words):
    model = beam_model(NODES, ELEMENTS, Tube(0.05, 0.003), STEEL, lines={"legs": [0, 2], "beam": 1})
    with pytest.raises(ModelError) as refusal:
        beam_body(model, {"root": "clamped"}, lines=lines)
    shown(refusal, *words)


@pytest.mark.parametrize("elements", [[3], [-4], [0.5], [], [[0]]])
def test_a_line_of_unknown_elements_is_named(elements):
    with pytest.raises(ModelError) as refusal:
        beam_model(NODES, ELEMENTS, Tube(0.05, 0.003), STEEL, lines={"legs": elements})
    shown(refusal, "line 'legs'", "0 to 2")
