"""Frames of beams: inertia, rigid motions, static and modal accuracy, bad input, meshes of lines."""

from __future__ import annotations

import itertools
import json

import numpy as np
import pytest
import scipy.linalg
from scipy.spatial.transform import Rotation

from kanefe.errors import MeshError, ModelError
from kanefe.fe_model.model import Cells, rigid_motion
from kanefe_fem.beams import elements as be
from kanefe_fem.beams.body import beam_body, beam_model, straight_beam
from kanefe_fem.beams.from_mesh import beam_model_from_mesh
from kanefe_fem.beams.sections import Box, Rectangle, Section, SolidCircle, Tube
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.mesh.mesh import Mesh

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
ALUMINIUM = Material(E=70e9, nu=0.33, rho=2700.0)
UNIT = Material(E=1.0, nu=0.3, rho=1.0)
UNIT_SECTION = Section(A=1.0, I_y=1.0, I_z=1.0, J=1.0)
THEORIES = ["timoshenko", "euler-bernoulli"]


def frequencies(model, fixed=(), keep=None, count=5, added_mass=None):
    """Angular frequencies in rad/s without the zero ones; `fixed` are dofs, `keep` the components that may move."""
    K, M = model.stiffness.toarray(), model.mass.toarray()
    if added_mass is not None:
        M = M + added_mass
    width = len(model.components)
    moving = [model.components.index(c) for c in keep or model.components]
    free = [d for d in range(model.size) if d not in set(fixed) and d % width in moving]
    values = scipy.linalg.eigh(K[np.ix_(free, free)], M[np.ix_(free, free)], eigvals_only=True)
    omega = np.sqrt(values[values > 1e-7 * values[count + 1]])
    return omega[:count]


# ---------------------------------------------------------------------------------------------- inertia


FRAME_NODES = np.array([[0, 0, 0], [1, 0, 0], [1, 0.8, 0], [1, 0.8, 0.6], [0.2, 0.3, 0.9], [0, 0, 0.5]], dtype=float)
FRAME_ELEMENTS = np.array([[0, 1], [1, 2], [3, 2], [3, 4], [4, 5], [5, 0], [1, 4]])
FRAME_SECTIONS = [
    Tube(0.05, 0.004),
    Rectangle(0.06, 0.03),
    Box(0.05, 0.08, 0.005),
    SolidCircle(0.04),
    Rectangle(0.02, 0.05),
    Tube(0.08, 0.002),
    Box(0.04, 0.04, 0.003),
]
FRAME_MATERIALS = [STEEL, ALUMINIUM, STEEL, ALUMINIUM, ALUMINIUM, STEEL, STEEL]
FRAME_ORIENTATION = np.array(
    [[0, 0.3, 1], [0.2, 0, 1], [1, 0.4, 0], [0, 1, 0.2], [1, 0, 0], [0.3, -1, 0], [0, 0, 1]], dtype=float
)


def space_frame(Q=None, shift=(0.0, 0.0, 0.0), **options):
    Q = np.eye(3) if Q is None else Q
    return beam_model(
        FRAME_NODES @ Q.T + shift,
        FRAME_ELEMENTS,
        FRAME_SECTIONS,
        FRAME_MATERIALS,
        orientation=FRAME_ORIENTATION @ Q.T,
        **options,
    )


def rigid_body(nodes, elements, sections, materials, orientation):
    """Mass, first moment and inertia about the origin of uniform straight prismatic bars, from textbook formulas."""
    mass, first, inertia = 0.0, np.zeros(3), np.zeros((3, 3))
    for (i, j), s, material, towards in zip(elements, sections, materials, orientation, strict=True):
        x = nodes[j] - nodes[i]
        length = np.linalg.norm(x)
        x = x / length
        z = towards - x * (x @ towards)
        z = z / np.linalg.norm(z)
        axes = np.column_stack([x, np.cross(z, x), z])
        rho, m, c = material.rho, material.rho * s.A * length, 0.5 * (nodes[i] + nodes[j])
        own = np.diag([s.I_y + s.I_z, s.I_y + s.A * length**2 / 12, s.I_z + s.A * length**2 / 12]) * rho * length
        mass += m
        first += m * c
        inertia += axes @ own @ axes.T + m * (c @ c * np.eye(3) - np.outer(c, c))
    return mass, first, inertia


def rigid_mass_matrix(mass, first, inertia):
    x, y, z = first
    skew = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.block([[mass * np.eye(3), -skew], [skew, inertia]])


TURNS = [np.eye(3), Rotation.from_rotvec([0.3, -1.1, 0.7]).as_matrix(), Rotation.from_rotvec([2.0, 0.4, 1]).as_matrix()]


@pytest.mark.parametrize("theory", THEORIES)
@pytest.mark.parametrize("turn", range(len(TURNS)))
def test_mass_first_moment_and_inertia_of_a_space_frame_are_exact(theory, turn):
    Q, shift = TURNS[turn], np.array([0.4, -0.2, 1.1])
    model = space_frame(Q, shift, theory=theory)
    exact = rigid_mass_matrix(
        *rigid_body(model.nodes, FRAME_ELEMENTS, FRAME_SECTIONS, FRAME_MATERIALS, FRAME_ORIENTATION @ Q.T)
    )
    R = model.rigid_modes()
    assert abs(R.T @ (model.mass @ R) - exact).max() < 1e-12 * abs(exact).max()
    field = model.mass_field
    moments = rigid_motion(field.points, (0, 0, 0))
    from_points = moments.T @ (np.repeat(field.mass.diagonal(), 3)[:, None] * moments)
    assert abs(from_points - exact).max() < 1e-12 * abs(exact).max()


@pytest.mark.parametrize("theory", THEORIES)
@pytest.mark.parametrize("angle", [0.0, 0.7, 2.0])
def test_mass_first_moment_and_inertia_of_a_planar_frame_are_exact(theory, angle):
    Q = Rotation.from_rotvec([0, 0, angle]).as_matrix()
    nodes = np.array([[0, 0, 0], [1, 0, 0], [1, 0.8, 0], [0.2, 0.9, 0]]) @ Q.T + [0.3, -0.5, 0]
    elements, sections = [[0, 1], [1, 2], [3, 2]], [Rectangle(0.06, 0.03), Tube(0.05, 0.003), Box(0.04, 0.06, 0.004)]
    materials = [STEEL, ALUMINIUM, STEEL]
    model = beam_model(nodes[:, :2], elements, sections, materials, theory=theory, planar=True)
    assert model.components == ("x", "y", "rz")
    exact = rigid_mass_matrix(*rigid_body(nodes, elements, sections, materials, [np.array([0, 0, 1.0])] * 3))
    plane = np.ix_([0, 1, 5], [0, 1, 5])
    R = model.rigid_modes()[:, [0, 1, 5]]
    assert abs(R.T @ (model.mass @ R) - exact[plane]).max() < 1e-12 * abs(exact).max()
    moments = rigid_motion(model.mass_field.points, (0, 0, 0))
    from_points = moments.T @ (np.repeat(model.mass_field.mass.diagonal(), 3)[:, None] * moments)
    assert abs(from_points[plane] - exact[plane]).max() < 1e-12 * abs(exact).max()


@pytest.mark.parametrize("theory", THEORIES)
def test_the_mass_field_follows_every_rigid_motion(theory):
    model = space_frame(TURNS[1], theory=theory)
    moved = model.mass_field.interpolation @ model.rigid_modes()
    assert abs(moved - rigid_motion(model.mass_field.points, (0, 0, 0))).max() < 1e-14


@pytest.mark.parametrize("theta", [0.0, 0.6, 2.5])
def test_the_planar_mass_without_rotary_inertia_is_eq_41(theta):
    length = 0.7
    nodes = length * np.array([[0, 0], [np.cos(theta), np.sin(theta)]])
    section = Rectangle(0.02, 0.03)
    model = beam_model(nodes, [[0, 1]], section, STEEL, theory="euler-bernoulli", planar=True, rotary_inertia=False)
    T = be.planar_transformation(theta)
    mass = be.rotate_element_matrix(be.planar_mass(length, STEEL.rho * section.A), T)
    stiffness = be.rotate_element_matrix(be.planar_stiffness(length, STEEL.E * section.A, STEEL.E * section.I_z), T)
    # round-off of sums of products of the size of the largest entries
    assert abs(model.mass.toarray() - mass).max() < 1e-14 * abs(mass).max()
    assert abs(model.stiffness.toarray() - stiffness).max() < 1e-14 * abs(stiffness).max()


def test_rotary_inertia_of_the_hermite_element_is_przemienieckis():
    a, section = 0.3, Rectangle(0.1, 0.05)
    both = [
        straight_beam(
            a, section, STEEL, elements=1, theory="euler-bernoulli", planar=True, rotary_inertia=rotary
        ).mass.toarray()
        for rotary in (True, False)
    ]
    block = np.array(
        [
            [36, 3 * a, -36, 3 * a],
            [3 * a, 4 * a**2, -3 * a, -(a**2)],
            [-36, -3 * a, 36, -3 * a],
            [3 * a, -(a**2), -3 * a, 4 * a**2],
        ]
    )
    exact = STEEL.rho * section.I_z / (30 * a) * block
    bending = np.ix_([1, 2, 4, 5], [1, 2, 4, 5])
    assert abs((both[0] - both[1])[bending] - exact).max() < 1e-13 * abs(both[0]).max()


def test_torsion_carries_the_polar_inertia_with_or_without_rotary_inertia():
    section = Rectangle(0.1, 0.05)
    polar = STEEL.rho * (section.I_y + section.I_z)
    for rotary in (True, False):
        mass = straight_beam(0.6, section, STEEL, elements=1, rotary_inertia=rotary).mass.toarray()
        assert mass[np.ix_([3, 9], [3, 9])] == pytest.approx(polar * 0.6 / 6 * np.array([[2, 1], [1, 2]]), rel=1e-13)


# ---------------------------------------------------------------------------------------------- gyroscopic wrench


def field_wrench(model, w, alpha):
    """Inertia force and moment about the origin of the mass field of a frame that moves as one rigid body."""
    field = model.mass_field
    r = field.points
    a = np.cross(alpha, r) + np.cross(w, np.cross(w, r))
    force = field.mass @ a
    return np.concatenate([force.sum(axis=0), np.cross(r, force).sum(axis=0)])


@pytest.mark.parametrize("theory", THEORIES)
@pytest.mark.parametrize("turn", range(len(TURNS)))
def test_a_stiff_space_frame_spun_about_any_axis_has_the_wrench_of_the_rigid_body(theory, turn):
    Q, shift = TURNS[turn], np.array([0.4, -0.2, 1.1])
    model = space_frame(Q, shift, theory=theory)
    _, first, J = rigid_body(model.nodes, FRAME_ELEMENTS, FRAME_SECTIONS, FRAME_MATERIALS, FRAME_ORIENTATION @ Q.T)
    axes = [np.array(a, dtype=float) for a in itertools.product((-1, 0, 1), repeat=3) if any(a)]
    for w in axes:
        w = 7.0 * w
        alpha = np.array([1.0, -2.0, 0.5]) * w[::-1]
        exact = np.concatenate(
            [np.cross(alpha, first) + np.cross(w, np.cross(w, first)), J @ alpha + np.cross(w, J @ w)]
        )
        assert abs(field_wrench(model, w, alpha) - exact).max() < 1e-10 * abs(exact).max()


def nodal_wrench(model, w):
    """The printed form: M times nodal accelerations, with alpha (here zero) as the angular ones; about the origin."""
    a = np.zeros((len(model.nodes), 6))
    a[:, :3] = np.cross(w, np.cross(w, model.nodes))
    return model.rigid_modes().T @ (model.mass @ a.ravel())


def test_nodal_angular_accelerations_give_a_wrong_gyroscopic_torque():
    """One Hermite element spun with (wx, wy, 0) about its end: 0.35 m l^2 wx wy instead of m l^2/3 wx wy."""
    length, section, w = 1.5, SolidCircle(1e-4), np.array([3.0, 2.0, 0.0])
    unit = STEEL.rho * section.A * length * length**2 * w[0] * w[1]
    torque = []
    for count in (1, 2, 4):
        model = straight_beam(length, section, STEEL, elements=count, theory="euler-bernoulli", rotary_inertia=False)
        torque.append(nodal_wrench(model, w)[5] / unit)
        # 1e-8: the section's own inertia, (d/l)^2
        assert field_wrench(model, w, np.zeros(3))[5] / unit == pytest.approx(1 / 3, rel=1e-8)
    assert torque[0] == pytest.approx(0.35, rel=1e-12)
    error = np.array(torque) - 1 / 3
    assert error[:-1] / error[1:] == pytest.approx([4.0, 4.0], rel=1e-6)  # falls as h^2


# ---------------------------------------------------------------------------------------------- stiffness


@pytest.mark.parametrize("theory", THEORIES)
def test_rigid_motions_need_no_force_and_there_are_six(theory):
    model = space_frame(TURNS[1], theory=theory)
    K = model.stiffness.toarray()
    assert abs(K @ model.rigid_modes((0.3, 0.1, -0.4))).max() < 1e-14 * abs(K).max()
    values = np.linalg.eigvalsh(K)
    assert values[6] > 1e-9 * values[-1] > 1e3 * abs(values[:6]).max()
    assert abs(K - K.T).max() == 0.0
    assert abs(model.mass - model.mass.T).max() == 0.0


@pytest.mark.parametrize("turn", [1, 2])
def test_matrices_turn_with_the_frame(turn):
    Q = TURNS[turn]
    here, there = space_frame(), space_frame(Q, (1.0, 2.0, 3.0))
    T = np.kron(np.eye(2 * len(FRAME_NODES)), Q)
    for name in ("stiffness", "mass"):
        expected = T @ getattr(here, name).toarray() @ T.T
        # 1e-13: lengths of elements are differences of coordinates that the shift made larger
        assert abs(getattr(there, name).toarray() - expected).max() < 1e-13 * abs(expected).max()


@pytest.mark.parametrize("theory", THEORIES)
@pytest.mark.parametrize("turn", range(len(TURNS)))
def test_tip_deflections_of_one_element_are_exact(theory, turn):
    Q, length, force = TURNS[turn], 0.8, 1000.0
    s = Rectangle(0.06, 0.1)
    model = straight_beam(length, s, STEEL, elements=1, direction=Q[:, 0], orientation=Q[:, 2], theory=theory)
    K = model.stiffness.toarray()[6:, 6:]
    E, G = STEEL.E, STEEL.shear_modulus
    shear = theory == "timoshenko"
    for axis, inertia, kappa in ((1, s.I_z, s.shear_y), (2, s.I_y, s.shear_z)):
        load = np.concatenate([force * Q[:, axis], np.zeros(3)])
        deflection = np.linalg.solve(K, load)[:3] @ Q[:, axis]
        exact = force * length**3 / (3 * E * inertia) + shear * force * length / (kappa * G * s.A)
        assert deflection == pytest.approx(exact, rel=1e-12)
    pull = np.linalg.solve(K, np.concatenate([force * Q[:, 0], np.zeros(3)]))
    assert pull[:3] @ Q[:, 0] == pytest.approx(force * length / (E * s.A), rel=1e-12)
    twist = np.linalg.solve(K, np.concatenate([np.zeros(3), force * Q[:, 0]]))
    assert twist[3:] @ Q[:, 0] == pytest.approx(force * length / (G * s.J), rel=1e-12)


def test_the_planar_model_is_the_spatial_one_in_its_plane():
    s = Rectangle(0.06, 0.1)
    nodes, elements = np.array([[0, 0, 0], [1, 0.2, 0], [1.2, 1, 0]]), [[0, 1], [1, 2]]
    space, plane = (beam_model(nodes, elements, s, STEEL, planar=planar) for planar in (False, True))
    kept = [6 * node + c for node in range(3) for c in be.PLANAR_ROWS]
    for name in ("stiffness", "mass"):
        expected = getattr(space, name).toarray()[np.ix_(kept, kept)]
        assert abs(getattr(plane, name).toarray() - expected).max() < 1e-14 * abs(expected).max()


def test_orientation_says_where_local_z_points():
    s = Rectangle(0.02, 0.1)
    soft = {"y": (0, 0, 1), "z": (0, 1, 0)}
    for direction, orientation in soft.items():
        model = straight_beam(1.0, s, STEEL, elements=1, orientation=orientation, theory="euler-bernoulli")
        K = model.stiffness.toarray()
        row = 6 + "xyz".index(direction)
        assert K[row, row] == pytest.approx(12 * STEEL.E * s.I_z, rel=1e-13)


# ---------------------------------------------------------------------------------------------- frequencies

B01 = {
    "clamped-free": (["root"], [], [1.875104068711961, 4.694091132974175, 7.854757438237613]),
    "free-free": ([], [], [4.730040744862704, 7.853204624095838, 10.99560783800167]),
    "clamped-clamped": (["root", "tip"], [], [4.730040744862704, 7.853204624095838, 10.99560783800167]),
    "clamped-pinned": (["root"], ["tip"], [3.926602312047919, 7.068582745628732, 10.21017612281303]),
    "free-pinned": ([], ["tip"], [3.926602312047919, 7.068582745628732, 10.21017612281303]),
}


def supports(model, clamped, pinned):
    width = len(model.components)
    fixed = [width * node + c for name in clamped for node in model.groups[name].nodes for c in range(width)]
    y = model.components.index("y")
    return fixed + [width * node + y for name in pinned for node in model.groups[name].nodes]


def euler_bernoulli(elements):
    return straight_beam(
        1.0, UNIT_SECTION, UNIT, elements=elements, theory="euler-bernoulli", planar=True, rotary_inertia=False
    )


@pytest.mark.parametrize("case", sorted(B01))
def test_euler_bernoulli_frequencies(case):
    """B01 of the open cases: the roots bL of the frequency equations."""
    clamped, pinned, roots = B01[case]
    # 20 elements give the first three roots of the clamped-free beam to 1e-5; the higher ones of the other cases need
    # 30, because the error of a root is (bL/n)^4/2880 (next test).
    model = euler_bernoulli(20 if case == "clamped-free" else 30)
    omega = frequencies(model, supports(model, clamped, pinned), keep=("y", "rz"), count=3)
    assert np.sqrt(omega) == pytest.approx(roots, rel=1e-5)


@pytest.mark.parametrize("case", sorted(B01))
def test_the_error_of_hermite_frequencies_is_that_of_the_theory(case):
    """omega_h / omega - 1 = (k h)^4 / 1440 + O((k h)^6), k = bL / L: no accuracy is lost to the implementation."""
    clamped, pinned, roots = B01[case]
    model = euler_bernoulli(20)
    omega = frequencies(model, supports(model, clamped, pinned), keep=("y", "rz"), count=3)
    # 3 %: the next term of the series, largest (2.4 %) for the third free-free mode, where k h = 0.55
    error = omega / np.array(roots) ** 2 - 1
    assert error == pytest.approx((np.array(roots) / 20) ** 4 / 1440, rel=0.03)


B02 = {
    "clamped-free": (["root"], [], [82.8943626933, 496.814531609, 1306.69807298, 2370.30840574, 3608.25503355]),
    "free-free": ([], [], [513.486056059, 1335.67592773, 2436.33263598, 3717.53232567]),
    "clamped-clamped": (["root", "tip"], [], [498.367105181, 1277.19339173, 2308.42451607, 3505.29555478]),
    "pinned-pinned": ([], ["root", "tip"], [230.680406669, 881.522232997, 1857.2040824, 3057.51178875, 4403.74943852]),
}


TIMOSHENKO_ELEMENTS = 200
"""Order 2: the fifth mode, at 4.4 kHz, needs so many for 1e-4; the first mode has 1e-4 with 10."""


@pytest.mark.parametrize("case", sorted(B02))
@pytest.mark.parametrize("plane", ["planar", "xy", "xz"])
def test_timoshenko_frequencies(case, plane):
    """B02a and B02b of the open cases: a 0.05 x 0.1 m bar of 1 m, bending across the 0.1 m."""
    clamped, pinned, exact = B02[case]
    section = Rectangle(0.05, 0.1) if plane == "xz" else Rectangle(0.1, 0.05)
    model = straight_beam(1.0, section, STEEL, elements=TIMOSHENKO_ELEMENTS, planar=plane == "planar")
    keep = ("z", "ry") if plane == "xz" else ("y", "rz")
    fixed = supports(model, clamped, pinned)
    if plane == "xz":
        fixed += [6 * node + 2 for name in pinned for node in model.groups[name].nodes]
    hertz = frequencies(model, fixed, keep=keep, count=len(exact)) / (2 * np.pi)
    assert hertz == pytest.approx(exact, rel=1e-4)


B03A = {
    (1.0, 0.0): [1.5572978611989, 16.250085158239, 50.895842831216, 105.19827584975],
    (0.5, 0.05): [1.8785850319265, 8.2017841559207, 26.483869125369, 65.395349214793],
}


@pytest.mark.parametrize("tip", sorted(B03A))
def test_cantilever_with_a_tip_body(tip):
    """B03a of the open cases."""
    model = euler_bernoulli(40)  # (k h)^4/1440 is 3e-6 for the fourth mode, and 5e-5 with 20
    added = np.zeros((model.size, model.size))
    added[-2, -2], added[-1, -1] = tip
    omega = frequencies(model, supports(model, ["root"], []), keep=("y", "rz"), count=4, added_mass=added)
    assert omega == pytest.approx(B03A[tip], rel=1e-5)


BAR = SolidCircle(0.02)
BAR_ELEMENTS = 240
"""Stretch and twist are linear in an element: the error is (k h)^2/24, 6.5e-5 for the third mode, 3 pi, at 240."""


def test_axial_and_torsional_frequencies():
    """B06 of the open cases."""
    model = straight_beam(1.0, BAR, STEEL, elements=BAR_ELEMENTS)
    c, tau = np.sqrt(STEEL.E / STEEL.rho), 2 * np.pi
    clamped, odd = supports(model, ["root"], []), np.array([1, 3, 5])
    along = frequencies(model, clamped, keep=("x",), count=3) / tau
    assert along == pytest.approx([1293.0485382587128, 3879.1456147761382, 6465.242691293564], rel=1e-4)
    free = frequencies(model, keep=("x",), count=3) / tau
    assert free == pytest.approx(np.array([1, 2, 3]) * c / 2, rel=1e-4)
    added = np.zeros((model.size, model.size))
    added[-6, -6] = STEEL.rho * BAR.A
    loaded = frequencies(model, clamped, keep=("x",), count=3, added_mass=added) / tau
    assert loaded == pytest.approx([708.2096327321227, 2819.90151498698, 5299.056828008877], rel=1e-4)
    twist = frequencies(model, clamped, keep=("rx",), count=3) / tau
    assert twist == pytest.approx(odd * np.sqrt(STEEL.shear_modulus / STEEL.rho) / 4, rel=1e-4)


def rates(errors):
    return np.log2(np.array(errors[:-1]) / np.array(errors[1:]))


def test_hermite_frequencies_converge_with_order_four():
    errors = []
    for count in (6, 12, 24):
        model = euler_bernoulli(count)
        omega = frequencies(model, supports(model, ["root"], []), keep=("y", "rz"), count=2)
        errors.append(omega[1] / 4.694091132974175**2 - 1)
    assert errors[0] > 0  # a Rayleigh quotient: from above
    assert rates(errors) == pytest.approx([4.0, 4.0], abs=0.1)


def test_axial_frequencies_converge_with_order_two():
    errors = []
    for count in (10, 20, 40):
        model = straight_beam(1.0, BAR, STEEL, elements=count)
        omega = frequencies(model, supports(model, ["root"], []), keep=("x",), count=1)
        errors.append(omega[0] / (2 * np.pi * 1293.0485382587128) - 1)
    assert rates(errors) == pytest.approx([2.0, 2.0], abs=0.05)


def test_timoshenko_frequencies_converge_with_order_two():
    errors = []
    for count in (10, 20, 40):
        model = straight_beam(1.0, Rectangle(0.1, 0.05), STEEL, elements=count, planar=True)
        omega = frequencies(model, supports(model, ["root"], []), keep=("y", "rz"), count=1)
        errors.append(omega[0] / (2 * np.pi * 82.8943626933) - 1)
    assert errors[0] < 2e-5
    assert rates(errors) == pytest.approx([2.0, 2.0], abs=0.1)


@pytest.mark.parametrize("theory", THEORIES)
def test_slender_beams_of_both_theories_agree(theory):
    model = straight_beam(1.0, Rectangle(1e-3, 1e-3), STEEL, elements=40, theory=theory, planar=True)
    omega = frequencies(model, supports(model, ["root"], []), keep=("y", "rz"), count=1)
    exact = 1.875104068711961**2 * np.sqrt(STEEL.E * 1e-6 / 12 / STEEL.rho)
    assert omega[0] == pytest.approx(exact, rel=1e-5)  # shear and rotary inertia: of the size of (depth/length)^2


# ---------------------------------------------------------------------------------------------- models and bodies


def test_groups_cells_and_provenance():
    model = beam_model(FRAME_NODES, FRAME_ELEMENTS, BAR, STEEL, groups={"root": 0, "tip": -1, "feet": [1, 2]})
    assert model.groups["tip"].nodes.tolist() == [5]
    assert model.groups["tip"].position == pytest.approx(FRAME_NODES[5])
    assert model.groups["feet"].nodes.tolist() == [1, 2]
    assert model.groups["feet"].position == pytest.approx([1, 0.4, 0])
    assert [cells.kind for cells in model.cells] == ["line"]
    assert model.cells[0].nodes.tolist() == FRAME_ELEMENTS.tolist()
    assert json.loads(json.dumps(dict(model.provenance)))["dofs"] == model.size == 36
    assert sorted(beam_model(FRAME_NODES, FRAME_ELEMENTS, BAR, STEEL).groups) == ["root", "tip"]


def test_straight_beam_runs_from_start_in_its_direction():
    model = straight_beam(2.0, BAR, STEEL, elements=4, direction=(0, 0, 3), start=(1, 2, 3))
    assert model.groups["root"].position == pytest.approx([1, 2, 3])
    assert model.groups["tip"].position == pytest.approx([1, 2, 5])


def test_a_beam_body_keeps_mass_inertia_and_first_frequency():
    model = straight_beam(1.0, Rectangle(0.05, 0.1), STEEL, elements=10)
    body = beam_body(model, {"root": "clamped"})
    exact = rigid_body(
        model.nodes, model.cells[0].nodes, [Rectangle(0.05, 0.1)] * 10, [STEEL] * 10, [np.array([0, 0, 1.0])] * 10
    )
    assert body.is_exact
    assert body.mass == pytest.approx(exact[0], rel=1e-12)
    assert body.center_of_mass == pytest.approx(exact[1] / exact[0], abs=1e-12)
    # the softer plane is x-y, with half the depth
    omega = frequencies(model, supports(model, ["root"], []), keep=("y", "rz"), count=1)
    assert body.frequencies[0] * 2 * np.pi == pytest.approx(omega[0], rel=1e-9)


# ---------------------------------------------------------------------------------------------- bad input

TWO = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0]], dtype=float)


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        ({"nodes": [[0, 0, 0], [1, 0, 0], [1, 0, 0]]}, r"element 1 \(nodes \[1, 2\]\) has no length"),
        ({"nodes": [[0, 0, 0], [1, 0, np.nan], [1, 1, 0]]}, "node 1 has the position"),
        ({"nodes": [[0, 0], [1, 0], [1, 1]]}, r"shape \(3, 2\)"),
        ({"nodes": [0, 1, 2]}, r"nodes has shape \(3,\)"),
        ({"nodes": [[0, 0, 0], [1, 0, 0], [1, 1, 0.2]], "planar": True}, "node 2 has z = 0.2"),
        ({"elements": [[0, 1], [1, 3]]}, r"element 1 has the nodes \[1, 3\]"),
        ({"elements": [[0, 1], [-1, 2]]}, "element 1 has the nodes"),
        ({"elements": [[0, 1, 2]]}, r"elements has shape \(1, 3\)"),
        ({"elements": [[0.0, 1.0], [1.0, 2.0]]}, "elements has numbers of type float"),
        ({"elements": np.zeros((0, 2), dtype=int)}, "elements has shape"),
        ({"elements": [[0, 1], [1, 0], [1, 2]]}, r"between nodes \[.*\] is given twice"),
        ({"elements": [[0, 1]]}, "node 2 .* belongs to no element"),
        ({"nodes": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]], "elements": [[0, 1], [2, 3]]}, "2 unconnected parts"),
        ({"section": [BAR]}, "1 sections for 2 elements"),
        ({"section": 0.05}, "section of element 0 is 0.05"),
        ({"material": [STEEL, "steel"]}, "material of element 1 is 'steel'"),
        ({"theory": "bernoulli"}, "unknown beam theory 'bernoulli'"),
        ({"orientation": (0, 1, 0)}, r"element 1 \(nodes \[1, 2\]\) is zero or parallel"),
        ({"orientation": (0, 0, 0)}, "element 0"),
        ({"orientation": (0, 1)}, r"orientation has shape \(2,\)"),
        ({"orientation": (0, 1, 0), "planar": True}, "normal of the plane"),
        ({"groups": {"tip": 3}}, "group 'tip'"),
        ({"groups": {"tip": []}}, "group 'tip'"),
        ({"groups": {"tip": "last"}}, "group 'tip'"),
    ],
)
def test_bad_frames_are_named(arguments, named):
    good = {"nodes": TWO, "elements": [[0, 1], [1, 2]], "section": Rectangle(0.05, 0.1), "material": STEEL}
    beam_model(**good)
    with pytest.raises(ModelError, match=named) as caught:
        beam_model(**{**good, **arguments})
    assert "Remedy" in str(caught.value)


def test_an_upright_beam_needs_an_orientation_only_if_its_section_does():
    upright = {"direction": (0, 0, 1), "elements": 2}
    with pytest.raises(ModelError, match=r"orientation .* of element 0"):
        straight_beam(1.0, Rectangle(0.05, 0.1), STEEL, **upright)
    straight_beam(1.0, Rectangle(0.05, 0.1), STEEL, orientation=(1, 0, 0), **upright)
    for section in (BAR, Tube(0.05, 0.002), Rectangle(0.05, 0.05)):
        straight_beam(1.0, section, STEEL, **upright)


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        ({"length": 0.0}, "length = 0.0"),
        ({"length": "one"}, "length = 'one'"),
        ({"elements": 0}, "elements = 0"),
        ({"elements": 2.5}, "elements = 2.5"),
        ({"direction": (0, 0, 0)}, "direction"),
    ],
)
def test_bad_straight_beams_are_named(arguments, named):
    with pytest.raises(ModelError, match=named):
        straight_beam(**{"length": 1.0, "section": BAR, "material": STEEL, **arguments})


# ---------------------------------------------------------------------------------------------- meshes of lines


def line_mesh(**changes):
    """A portal with a node that no line uses (number 1)."""
    nodes = np.array([[0, 0, 0], [9, 9, 9], [0, 0, 1], [1, 0, 1], [1, 0, 0]], dtype=float)
    given = {
        "nodes": nodes,
        "dimension": 1,
        "cells": {},
        "lines": {"legs": (Cells("line", np.array([[0, 2], [3, 4]])),), "beam": (Cells("line", np.array([[2, 3]])),)},
        "points": {"foot": np.array([4]), "stray": np.array([1])},
        "source": "portal",
    }
    return Mesh(**{**given, **changes})


def test_a_frame_from_the_lines_of_a_mesh():
    tube, box = Tube(0.05, 0.003), Box(0.04, 0.08, 0.003)
    model = beam_model_from_mesh(
        line_mesh(),
        {"legs": tube, "beam": box},
        {"legs": STEEL, "beam": ALUMINIUM},
        orientation={"legs": (1, 0, 0), "beam": (0, 0, 1)},
    )
    expected = beam_model(
        [[0, 0, 0], [0, 0, 1], [1, 0, 1], [1, 0, 0]],
        [[0, 1], [2, 3], [1, 2]],
        [tube, tube, box],
        [STEEL, STEEL, ALUMINIUM],
        orientation=[[1, 0, 0], [1, 0, 0], [0, 0, 1]],
    )
    assert abs(model.stiffness - expected.stiffness).max() == 0.0
    assert abs(model.mass - expected.mass).max() == 0.0
    assert {name: group.nodes.tolist() for name, group in model.groups.items()} == {
        "foot": [3],
        "legs": [0, 1, 2, 3],
        "beam": [1, 2],
    }
    assert model.provenance["mesh"] == "portal"


@pytest.mark.parametrize(
    ("changes", "sections", "options", "error", "named"),
    [
        ({}, {"legs": BAR}, {}, ModelError, "'beam' .* has no section"),
        ({}, {"legs": BAR, "beam": BAR, "roof": BAR}, {}, MeshError, "'roof'.*beam, legs"),
        ({}, {}, {}, ModelError, "no sections"),
        ({}, {"legs": BAR, "beam": BAR}, {"materials": {"legs": STEEL}}, ModelError, "'beam' has no material"),
        ({}, {"legs": BAR, "beam": BAR}, {"orientation": {"legs": (1, 0, 0)}}, ModelError, "'beam' has no orientation"),
        ({"lines": {"legs": (Cells("line3", np.array([[0, 2, 3]])),)}}, {"legs": BAR}, {}, MeshError, "'line3'"),
        (
            {"lines": {n: (Cells("line", np.array([[0, 2], [2, 3]])),) for n in ("legs", "beam")}},
            {"legs": BAR, "beam": BAR},
            {},
            MeshError,
            "in the groups 'legs' and 'beam'",
        ),
    ],
)
def test_bad_line_meshes_are_named(changes, sections, options, error, named):
    with pytest.raises(error, match=named):
        beam_model_from_mesh(line_mesh(**changes), sections, **{"materials": STEEL, **options})


@pytest.mark.gmsh
def test_a_frame_from_a_gmsh_source(tmp_path):
    pytest.importorskip("gmsh")
    source = tmp_path / "portal.geo"
    source.write_text(
        "Point(1) = {0, 0, 0, 0.25}; Point(2) = {0, 0, 1, 0.25};\n"
        "Point(3) = {1, 0, 1, 0.25}; Point(4) = {1, 0, 0, 0.25};\n"
        "Line(1) = {1, 2}; Line(2) = {2, 3}; Line(3) = {4, 3};\n"
        'Physical Curve("legs") = {1, 3}; Physical Curve("beam") = {2};\n'
        'Physical Point("left") = {1}; Physical Point("right") = {4};\n'
    )
    tube = Tube(0.05, 0.003)
    model = beam_model_from_mesh(source, {"legs": tube, "beam": tube}, STEEL)
    assert sorted(model.groups) == ["beam", "left", "legs", "right"]
    assert model.groups["right"].position == pytest.approx([1, 0, 0])
    assert len(model.nodes) == 13
    mass = model.rigid_modes()[:, 0] @ (model.mass @ model.rigid_modes()[:, 0])
    assert mass == pytest.approx(3.0 * STEEL.rho * tube.A, rel=1e-12)
