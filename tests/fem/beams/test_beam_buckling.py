"""Columns of beams: Euler's, Greenhill's and Beck's, as one body and as chains of bodies, and what is refused."""

import numpy as np
import pytest
import scipy.special

import kanefe as kf
from kanefe.errors import ModelError
from kanefe_fem import Material, Section, beam_body, straight_beam

STIFF = Material(E=1e8, nu=0.0, rho=1.0)
"""With sections of 1 m2 and 1e-8 m4: EI = 1 N m2, no strain (2e-7) and no rotary inertia (1e-8) to speak of."""

BECK = 20.0509536
"""Critical load of Beck's column in EI / L^2 (Bolotin 1963; it is known as 20.05)."""


def column_body(bodies: int, modes: int = 4, ratio: float | None = None, stiffening: str = "full") -> kf.FlexibleBody:
    """Return one of so many equal parts of a column of 1 m; planar, or with two bending stiffnesses of this ratio."""
    section = Section(A=1.0, I_y=1e-8 * (ratio or 1.0), I_z=1e-8, J=1e-8)
    options = {"theory": "euler-bernoulli", "planar": ratio is None}
    model = straight_beam(1.0 / bodies, section, STIFF, elements=6, **options)
    ends = {"root": "clamped", "tip": "rigid"}
    return beam_body(model, ends, reduction=kf.CraigBampton(modes=modes), stiffening=stiffening)


def column(bodies: int = 1, *, follows: bool = False, gravity: float = 0.0, **options) -> kf.System:
    scene = kf.System(gravity=(-gravity, 0, 0))
    part, parent = column_body(bodies, **options), None
    for i in range(bodies):
        member = scene.add_flexible_body(f"part {i}", part, parent=parent, joint=kf.Fixed())
        parent = member.interface("tip")
    if not gravity:
        scene.add_force(parent, (-1, 0, 0), follows=follows)
    return scene


@pytest.mark.parametrize(("bodies", "errors"), [(1, (2e-5, 2e-3)), (2, (2e-6, 1e-4)), (4, (1e-7, 1e-5))])
def test_clamped_columns(bodies, errors):
    """(2 k + 1)^2 pi^2 / 4; from above, as Ritz does, by the share of the shape that four modes a part leave over."""
    factors = kf.buckling(column(bodies)).factors[:2] / (np.pi**2 / 4.0 * np.array((1, 9)))
    assert np.all(factors > 1.0 - 1e-6)  # strain 2.5e-8 times two
    assert np.all(factors - 1.0 < errors)


def test_shapes_of_a_clamped_column():
    """1 - cos(pi x / 2) at the ends of the parts, and at the nodes of one of them."""
    found = kf.buckling(column(4), count=1)
    at = np.array([found.shape(f"part {i}", "tip")[0, 1] for i in range(4)])
    expected = 1.0 - np.cos(np.pi / 2.0 * np.arange(1, 5) / 4.0)
    assert at / at[-1] == pytest.approx(expected, abs=1e-5)  # the error of the factor is the square of that
    nodes = found.displacements("part 3", 0)[:, 1] / at[-1]
    assert nodes == pytest.approx(1.0 - np.cos(np.pi / 2.0 * np.linspace(0.75, 1.0, 7)), abs=1e-5)
    moved = found.shown(0, size=0.01)
    assert moved.position("part 3", "tip")[1] == pytest.approx(
        0.01 * at[-1], rel=1e-3
    )  # to first order in slopes of 0.02


def test_pinned_columns():
    """k^2 pi^2: a hinge at the root, and at the tip one on a slider, held by a loop."""
    scene = kf.System()
    part = column_body(2)
    first = scene.add_flexible_body("first", part, joint=kf.Revolute("z"))
    second = scene.add_flexible_body("second", part, parent=first.interface("tip"), joint=kf.Fixed())
    slider = scene.add_rigid_body("slider", 0.1, 0.1, at=(1, 0, 0), joint=kf.Prismatic("x"))
    scene.add_loop_joint("pin", kf.Revolute("z"), second.interface("tip"), slider)
    scene.add_force(slider, (-1, 0, 0))
    factors = kf.buckling(scene).factors[:2] / (np.pi**2 * np.array((1, 4)))
    assert np.all(factors > 1.0 - 1e-6)
    assert np.all(factors - 1.0 < (1e-5, 2e-4))  # a half wave over two parts of four modes, and over one


@pytest.mark.parametrize("ratio", [1.0, 1.02])
def test_two_planes_at_once(ratio):
    """Of a square column each factor is double; of one that is nearly square they lie beside each other."""
    found = kf.buckling(column(ratio=ratio), count=2)
    assert found.factors == pytest.approx(
        np.pi**2 / 4.0 * np.array((1.0, ratio)), rel=1e-4
    )  # two modes of four bend in each plane
    planes = np.array([found.shape("part 0", "tip")[i, 1:3] for i in range(2)])
    assert np.linalg.matrix_rank(planes, tol=1e-3 * np.abs(planes).max()) == 2
    if ratio > 1.0:
        assert abs(planes[0, 1]) < 1e-6 * abs(planes[0, 0])


def test_a_column_under_its_own_weight():
    """Greenhill (1881): q L^3 / EI = 9/4 j^2 with the first zero j of the Bessel function of order -1/3, 7.8373."""
    zero = scipy.optimize.brentq(lambda x: scipy.special.jv(-1.0 / 3.0, x), 1.5, 2.2)
    exact = 2.25 * zero**2
    assert exact == pytest.approx(7.8373, rel=1e-5)
    assert kf.buckling(column(2, gravity=1.0)).factors[0] == pytest.approx(exact, rel=1e-5)


def test_a_column_under_a_line_load():
    """As under its own weight, but for elements whose force is constant: the error falls with their square."""
    errors = []
    for elements in (6, 12):
        model = straight_beam(1.0, Section(1.0, 1e-8, 1e-8, 1e-8), STIFF, elements=elements, planar=True)
        body = beam_body(model, {"root": "clamped"}, reduction=kf.CraigBampton(modes=6), stiffening="full")
        scene = kf.System()
        member = scene.add_flexible_body("column", body, joint=kf.Fixed())
        scene.add_line_load(member, "span", (-1.0, 0, 0))
        errors.append(kf.buckling(scene).factors[0] / 7.837347 - 1.0)
    assert abs(errors[1]) < 3e-3
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.05)


@pytest.mark.parametrize(("bodies", "error"), [(1, 1e-3), (2, 5e-5), (4, 5e-6)])
def test_a_column_under_a_force_that_follows(bodies, error):
    """Beck (1952): flutter at 20.05 EI / L^2; four modes a part leave over what falls with the number of parts."""
    limit = kf.stability_limit(column(bodies, follows=True))
    assert limit.is_flutter
    assert limit.factor == pytest.approx(BECK, rel=error)
    # two frequencies meet there as the root of what is left of the factor: 1e-9 of it, round-off, is 3e-5 of them
    assert 2.0 * np.pi * limit.frequency == pytest.approx(11.0156, rel=2 * error + 1e-4)
    assert limit.displacements(f"part {bodies - 1}", 0).shape == (7, 3)


@pytest.mark.filterwarnings("ignore::kanefe.tree.stiffening_check.StiffeningWarning")
def test_inertial_stiffening_is_refused_where_a_force_acts():
    with pytest.raises(ModelError, match="'part 0' has stiffening='inertial', which leaves out what the force on"):
        kf.buckling(column(stiffening="inertial"))
    with pytest.raises(ModelError, match=r"'part 0' has no geometric stiffness.*stiffening='full'"):
        kf.buckling(column(stiffening="none"))


def test_loads_that_turn_with_a_surface_are_refused():
    scene = kf.System()
    member = scene.add_flexible_body("column", column_body(1), joint=kf.Fixed())
    scene.add_line_load(member, "span", (-1.0, 0, 0), follows=True)
    with pytest.raises(ModelError, match="not as its surface deforms"):
        kf.buckling(scene)
