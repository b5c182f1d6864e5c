"""The elastica and Beck's column by chains of beams, each bent little in its own frame."""

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

import kanefe as kf
from kanefe.errors import AccuracyWarning
from kanefe_fem import Material, Rectangle, Section, beam_body, exact_beam, straight_beam

E, WIDTH, HEIGHT = 1e7, 0.02, 0.01
EI = E * WIDTH * HEIGHT**3 / 12.0
EULER = np.pi**2 / 4.0 * EI


def column(pieces: int, follows: bool = False) -> kf.System:
    """Return a clamped column of length 1 along x, cut into pieces, under a unit force on its end."""
    material = Material(E=E, nu=0.3, rho=1000.0)
    beam = straight_beam(1.0 / pieces, Rectangle(width=WIDTH, height=HEIGHT), material, elements=4)
    held = {"root": "clamped", "tip": "rigid"}
    piece = beam_body(beam, held, kf.CraigBampton(modes=2), stiffening="full")
    scene, tip = kf.System(), None
    for i in range(pieces):
        tip = scene.add_flexible_body(f"piece {i}", piece, **({"parent": tip} if tip else {})).interface("tip")
    scene.add_force(tip, (-1, 0, 0), follows=follows)
    return scene


def test_the_post_buckling_branch_is_the_elastica():
    """K(k) = pi/2 sqrt(P / P_E); the tip is at 2 E(k) / K(k) - 1 along and 2 k / K(k) across (Timoshenko and Gere)."""
    load = 1.15
    m = brentq(lambda m: ellipk(m) - np.pi / 2.0 * np.sqrt(load), 1e-3, 0.9)
    exact = np.array((2.0 * ellipe(m) / ellipk(m) - 1.0, 2.0 * np.sqrt(m) / ellipk(m)))
    errors = []
    for pieces in (4, 8):
        scene = column(pieces)
        branch = kf.equilibrium_path(scene, to=1.2 * EULER, longest=0.1, branch=kf.buckling(scene))
        assert branch.factors[0] == pytest.approx(EULER, rel=1e-4)  # shear and shortening before it buckles
        tip = branch.at(load * EULER).position(f"piece {pieces - 1}", "tip")
        errors.append(float(np.linalg.norm((tip[0], np.hypot(*tip[1:])) - exact)))
    assert errors[1] < 1.5e-3
    assert errors[0] > 4.0 * errors[1]  # of the second order in the length of a piece, and more while they are long


def test_a_column_under_a_following_force_flutters_as_becks():
    """20.05 E I / l^2 (Beck 1952), and no branch."""
    path = kf.equilibrium_path(column(4, follows=True), to=25.0 * EI, longest=0.2)
    assert [point.kind for point in path.critical_points] == ["flutter"]
    assert path.flutter_points[0].factor / EI == pytest.approx(20.05, rel=2e-3)


def pulled_across(functions):
    """Return a clamped beam with a tip force P across it, P L^2 / EI = 10."""
    scene = kf.System()
    section = Section.from_stiffness(EA=1.0, EI_z=1.0, rho_A=1.0)
    beam = exact_beam(1.0, section, planar=True, basis=functions)
    scene.add_force(scene.add_flexible_body("beam", beam).interface("tip"), (0, 10.0, 0))
    return scene


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(("functions", "is_coarse"), [(3, True), (10, False)])
def test_a_rest_tells_how_well_the_functions_of_an_exact_beam_show_it(functions, is_coarse):
    """Under P L^2 / EI = 10 the curvature falls from its largest value to zero: three functions are too few."""
    scene = pulled_across(functions)
    if is_coarse:
        with pytest.warns(
            AccuracyWarning, match="equilibrium: strains of 'beam': the last functions, and errors .*basis="
        ):
            found = kf.equilibrium(scene)
    else:
        found = kf.equilibrium(scene)
    assert found.resolution.body == "beam"
    assert found.resolution.is_coarse == is_coarse
    assert f"strains {found.resolution}" in str(found)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(("functions", "is_coarse"), [(3, True), (10, False)])
def test_a_path_is_warned_once_of_too_few_functions_at_its_worst_point(functions, is_coarse):
    """Under P L^2 / EI = 10, as the rest above."""
    scene = pulled_across(functions)
    if not is_coarse:
        assert kf.equilibrium_path(scene, longest=0.3).is_whole
        return
    with pytest.warns(AccuracyWarning) as told:
        path = kf.equilibrium_path(scene, longest=0.3)
    assert path.is_whole
    (one,) = told
    assert "equilibrium_path, at 1 times the loads: strains of 'beam': the last functions" in str(one.message)
