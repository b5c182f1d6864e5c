"""Geometric stiffness and the second-order displacement of beams and solids, against closed forms and rigid turns."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg

from kanefe.checks.verification.rotors import spin_eigenvalues
from kanefe.errors import ModelError
from kanefe.fe_model.factorise import splu_factorise
from kanefe.fe_model.interface import Interface
from kanefe.fe_model.model import COMPONENTS
from kanefe.fe_model.shapes import quadrature, shape
from kanefe.fe_model.statics import StaticProblem
from kanefe.fe_model.ties import tie_interfaces
from kanefe.frames import skew
from kanefe.imports.from_matrices import model_from_matrices
from kanefe.joints import Free, Motion, Revolute
from kanefe.reduction import CraigBampton, flexible_body
from kanefe.reduction.build import unrestrained_motions
from kanefe.reduction.stiffening import INERTIAL_LOADS
from kanefe.system import System
from kanefe_fem.beams.body import beam_body, beam_model, straight_beam
from kanefe_fem.beams.sections import Rectangle, Section
from kanefe_fem.lumped.parts import LumpedMass, attach
from kanefe_fem.materials.isotropic import Material
from kanefe_fem.mesh.simple import box_mesh
from static_loads import held, static

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
SOFT = Material(E=210e9, nu=0.0, rho=7850.0)

SKEW_FRAME = ([[0, 0, 0], [0.3, 0.1, -0.2], [0.5, 0.4, 0.1], [0.2, 0.7, 0.3]], [[0, 1], [1, 2], [2, 3]])
"""Nodes and elements of a chain of beams that bends and twists in space."""


def rigid_turn_errors(body, model):
    """Return errors of the second-order displacement when a body, held at `root`, turns rigidly about it.

    A turned body has u2 = 1/2 theta x (theta x r); one that is bent and turned has theta x u beside, and its frames
    have the rotation vector 1/2 theta x theta_u (Baker, Campbell, Hausdorff).
    """
    k, root = body.free_count, body.interface("root").position
    moments = body.moments
    shifted = moments.second - np.outer(moments.first, root)
    rows = []
    for W in (skew(axis) for axis in np.eye(3)):
        turn = rigid_turn(model, W)
        R = np.linalg.lstsq(body.basis, turn, rcond=None)[0]
        assert np.abs(body.basis @ R - turn).max() < 1e-8
        pairs = [
            (moments.quadratic_first @ R @ R, W @ W @ (moments.first - moments.mass * root)),
            (moments.quadratic_second @ R @ R, shifted @ (W @ W).T),
            ((moments.quadratic_first @ R)[:, :k], W @ moments.shape_first[:, :k]),
            ((moments.quadratic_second @ R)[..., :k], np.einsum("abi,cb->aci", moments.shape_second[..., :k], W)),
        ]
        for frame in body.interfaces[1:]:
            if not frame.motion.any(axis=1).all():
                continue  # a released component is not seen by the frame
            motion = frame.motion[:, :k]
            pairs += [
                ((frame.quadratic @ R @ R)[:3], W @ W @ (frame.position - root)),
                ((frame.quadratic @ R)[:3, :k], W @ motion[:3]),
                ((frame.quadratic @ R)[3:, :k], 0.5 * W @ motion[3:]),
            ]
        rows.append(pairs)
    errors = []
    for of_one in zip(*rows, strict=True):
        found, exact = (np.array(side) for side in zip(*of_one, strict=True))
        errors.append(np.abs(found - exact).max() / np.abs(exact).max())
    return max(errors)


def rigid_turn(model, W):
    root = model.groups["root"].position
    turn = np.zeros((len(model.nodes), 6))
    turn[:, :3] = (model.nodes - root) @ W.T
    turn[:, 3:] = (W[2, 1], W[0, 2], W[1, 0])
    kept = [COMPONENTS.index(c) for c in model.components]
    return turn[:, kept].reshape(-1)


@pytest.mark.parametrize("theory", ["timoshenko", "euler-bernoulli"])
@pytest.mark.parametrize("tip", [{}, {"tip": "rigid"}])
def test_rigid_turns_of_beams_are_not_stiffened(theory, tip):
    """To round-off, whatever the number of elements: one for each of the three bars here."""
    model = beam_model(*SKEW_FRAME, Rectangle(0.02, 0.05), STEEL, theory=theory, groups={"root": 0, "tip": -1})
    body = beam_body(model, {"root": "clamped", **tip}, reduction=CraigBampton(modes=5), stiffening="full")
    assert rigid_turn_errors(body, model) < 1e-9  # condition number of K: 1e5


def test_interfaces_with_axes_of_their_own_obey_the_same():
    """Between two clamped or rigid ones."""
    model = beam_model(*SKEW_FRAME, Rectangle(0.02, 0.05), STEEL, groups={"root": 0, "middle": 2, "tip": -1})
    axes = scipy.linalg.expm(skew((0.3, 0.2, -0.5)))
    interfaces = {"root": "clamped", "middle": Interface(axes=axes), "tip": "rigid"}
    body = beam_body(model, interfaces, reduction=CraigBampton(modes=2), stiffening="full")
    assert rigid_turn_errors(body, model) < 1e-9


def test_lumped_inertia_turns_with_its_node():
    """A rigid body on the tip, off its node, is not stiffened either; its points are no part of any element."""
    frame = beam_model(*SKEW_FRAME, Rectangle(0.02, 0.05), STEEL, groups={"root": 0, "tip": -1})
    weight = LumpedMass("tip", 3.0, inertia=np.diag((0.02, 0.03, 0.04)), position=(0.3, 0.9, 0.2))
    model = attach(frame, [weight])
    body = beam_body(model, {"root": "clamped"}, reduction=CraigBampton(modes=5), stiffening="full")
    assert rigid_turn_errors(body, model) < 1e-9


def solid(counts=(5, 1, 1), size=(1.0, 0.1, 0.05), material=STEEL):
    from kanefe_fem.solids.model import solid_model

    return solid_model(box_mesh(size, counts, "hexahedron", start=(0.2, -0.1, 0.3)), material)


@pytest.mark.fenicsx
@pytest.mark.parametrize("tip", [None, "rigid", Interface(kind="average"), Interface(released=("x",))], ids=str)
def test_rigid_turns_of_solids_are_not_stiffened(tip):
    """A rigid patch must not be stiffened by the dipole of the forces that hold it (the sign of D is seen here)."""
    model = solid()
    interfaces = {"root": "clamped", **({} if tip is None else {"tip": tip})}
    body = flexible_body(model, interfaces, reduction=CraigBampton(modes=5), stiffening="full")
    assert rigid_turn_errors(body, model) < 1e-7  # K has 1e9 between its eigenvalues


@pytest.mark.fenicsx
@pytest.mark.parametrize(
    "interfaces", [{"root": "clamped"}, {"root": "clamped", "tip": "rigid"}, {}, {"tip": "rigid"}], ids=str
)
def test_solid_moves_by_its_second_order_displacement(interfaces):
    """u2 from its own equation, K u2 = -1/2 int C (grad u^T grad u) : grad v, without any geometric stiffness."""
    model = solid((3, 1, 1))
    body = flexible_body(model, interfaces, reduction=CraigBampton(modes=4), stiffening="full")
    ties = tie_interfaces(model, interfaces)
    problem = StaticProblem(model, ties, unrestrained_motions(model, ties), splu_factorise)
    eta = np.zeros(body.count)
    eta[: body.free_count] = np.random.default_rng(3).standard_normal(body.free_count)
    u = body.basis @ eta
    known = np.zeros((len(model.nodes), 3))  # of patches that turn rigidly
    for tie, frame in zip(ties.ties, body.interfaces, strict=True):
        W = skew((frame.motion @ eta)[3:])
        known[tie.nodes] = 0.5 * (model.nodes[tie.nodes] - tie.position) @ (W @ W).T
    w = known.ravel()
    T = ties.transformation
    forces = -nonlinear_forces(model, u) - model.stiffness @ w
    u2 = T @ problem.solve((T.T @ forces)[:, None])[:, 0] + w
    if problem.rigid_count:
        R = model.rigid_modes()
        u2 -= R @ np.linalg.solve(R.T @ (model.mass @ R), R.T @ (model.mass @ u2))
    weighted = model.mass_field.mass @ u2.reshape(-1, 3)
    first = 0.5 * body.moments.quadratic_first @ eta @ eta
    second = 0.5 * body.moments.quadratic_second @ eta @ eta
    scale = np.abs(weighted).sum()
    np.testing.assert_allclose(first, weighted.sum(axis=0), rtol=0, atol=1e-9 * scale)
    np.testing.assert_allclose(second, model.nodes.T @ weighted, rtol=0, atol=1e-9 * scale)
    if "tip" in interfaces:
        tip = body.interface("tip")
        centre = model.groups["tip"].position
        node = np.linalg.norm(model.nodes - centre, axis=1).argmin()  # hexahedra of order 2 have one there
        moved = 0.5 * tip.quadratic @ eta @ eta
        np.testing.assert_allclose(moved[:3], u2.reshape(-1, 3)[node], rtol=0, atol=1e-9 * np.abs(u2).max())


def nonlinear_forces(model, u):
    """Return ``1/2 int C (grad u^T grad u) : grad v`` for unit displacements v, assembled cell by cell in numpy."""
    f = np.zeros((len(model.nodes), 3))
    lame, mu = STEEL.lame, STEEL.shear_modulus
    for block in model.cells:
        element = shape(block.kind)
        points, weights = quadrature(block.kind, 4)  # as the stiffness
        for cell in block.nodes:
            X, displacement = model.nodes[cell], u.reshape(-1, 3)[cell]
            for gradient, weight in zip(element.gradients(points), weights, strict=True):
                J = X.T @ gradient
                dN = gradient @ np.linalg.inv(J)
                grad = displacement.T @ dN
                E = 0.5 * grad.T @ grad
                S = lame * np.trace(E) * np.eye(3) + 2.0 * mu * E
                f[cell] += weight * abs(np.linalg.det(J)) * dN @ S
    return f.ravel()


def test_floating_body_keeps_its_mean_place():
    """Of a floating body int rho u2 and int rho X x u2 vanish, as with linear coordinates."""
    model = beam_model(*SKEW_FRAME, Rectangle(0.02, 0.05), STEEL)
    moments = beam_body(model, {}, reduction=CraigBampton(modes=6), stiffening="inertial").moments
    second = moments.quadratic_second
    scale = np.abs(second).max()
    assert np.abs(moments.quadratic_first).max() < 1e-9 * scale
    assert np.abs(second - second.transpose(1, 0, 2, 3)).max() < 1e-9 * scale


@pytest.mark.parametrize("interfaces", [{"tip": "clamped"}, {}], ids=str)
def test_spun_body_is_the_same_wherever_G_is(interfaces):
    """A bar spun about its middle and about z: the same frequencies with G at its root, at its tip, or floating."""
    section, material = Section(A=1.0, I_y=1e-6, I_z=1e-6, J=1e-6), Material(E=1e6, nu=0.0, rho=1.0)
    model = straight_beam(1.0, section, material, elements=10, theory="euler-bernoulli")

    def found(interfaces, stiffening="inertial"):
        body = beam_body(model, interfaces, reduction=CraigBampton(modes=12), stiffening=stiffening)
        scene = System()
        spin = 8.0
        velocity = np.cross((0.0, 0.0, spin), -body.center_of_mass)
        scene.add_flexible_body("bar", body, joint=Free(velocity=tuple(velocity), angular_velocity=(0.0, 0.0, spin)))
        values = np.abs(spin_eigenvalues(scene.freeze()).imag)
        return values[values > 15.0][:4]

    # the bar stretches by 5e-6, and its Coriolis forces by some 1e-5 (axial modes at 3000 rad/s and 8 rad/s)
    np.testing.assert_allclose(found(interfaces), found({"root": "clamped"}), rtol=1e-3)
    # at this speed stiffening is not small
    assert np.abs(found(interfaces) / found(interfaces, "none") - 1.0).max() > 1e-2


def test_twist_of_a_spun_strip():
    """Spin stiffens twist by the inertia of turned sections and by the pull on helices: Rayleigh's quotient of both."""
    section, spin = Rectangle(width=0.05, height=0.002), 30.0
    model = straight_beam(1.0, section, SOFT, elements=24, theory="euler-bernoulli")
    body = beam_body(model, {"root": "clamped"}, reduction=CraigBampton(modes=24), stiffening="inertial")

    def slowest_twist(rate):
        scene = System()
        scene.add_flexible_body("strip", body, joint=Revolute("z", motion=Motion.steady(rate)))
        expected = np.pi / 2.0 * np.sqrt(SOFT.shear_modulus * section.J / (SOFT.rho * (section.I_y + section.I_z)))
        values = spin_eigenvalues(scene.freeze()).imag
        return values[np.abs(values - expected).argmin()]

    # phi = sin(pi x / 2), N = rho A spin^2 (1 - x^2) / 2
    x, w = np.polynomial.legendre.leggauss(20)
    x, w = 0.5 * (x + 1.0), 0.5 * w
    phi, slope = np.sin(np.pi * x / 2.0), np.pi / 2.0 * np.cos(np.pi * x / 2.0)
    helices = (w * 0.5 * (1.0 - x**2) * slope**2).sum() / (w * phi**2).sum()
    sections = (section.I_z - section.I_y) / (section.I_z + section.I_y)
    gained = slowest_twist(spin) ** 2 - slowest_twist(0.0) ** 2
    assert gained == pytest.approx(spin**2 * (helices + sections), rel=1e-3)  # Rayleigh: to first order in spin^2


@pytest.mark.fenicsx
def test_bar_of_solids_shortens_as_a_bar_of_beams():
    """G of the first bending modes, tip foreshortening and moment about z agree within what the theories differ."""
    interfaces = {"root": "clamped", "tip": "rigid"}
    found = []
    beams = straight_beam(1.0, Rectangle(0.05, 0.02), SOFT, elements=20, start=(0.2, 0.0, 0.0))
    for model in (beams, solid((20, 1, 1), (1.0, 0.05, 0.02), SOFT)):
        body = flexible_body(model, interfaces, reduction=CraigBampton(modes=8), stiffening="full")
        tip = body.interface("tip")
        bend = body.stiffness[: body.free_count, : body.free_count]
        eta = np.zeros((2, body.count))  # deflected by forces at the tip along y and z
        eta[:, : body.free_count] = np.linalg.solve(bend, tip.motion[1:3, : body.free_count].T).T
        found.append([[q @ e @ e for e in eta] for q in (tip.quadratic[0], body.moments.quadratic_first[0])])
    np.testing.assert_allclose(found[0], found[1], rtol=1e-2)


def test_nothing_is_computed_when_it_is_off():
    def fail(*_):
        raise AssertionError("geometric stiffness of a body without stiffening")

    model = replace(straight_beam(1.0, Rectangle(0.02, 0.05), STEEL, elements=4), stress_stiffness=fail)
    body = beam_body(model, {"root": "clamped"}, reduction=CraigBampton(modes=4))
    assert body.moments.quadratic_first is None
    assert body.moments.quadratic_second is None
    assert all(frame.quadratic is None for frame in body.interfaces)
    assert all(pattern.quadratic_first is None for pattern in body.load_patterns)


def test_inertial_leaves_interfaces_and_patterns_linear():
    model = straight_beam(1.0, Rectangle(0.02, 0.05), STEEL, elements=4)
    body = beam_body(model, {"root": "clamped"}, reduction=CraigBampton(modes=4), stiffening="inertial")
    full = beam_body(model, {"root": "clamped"}, reduction=CraigBampton(modes=4), stiffening="full")
    assert body.interface("root").quadratic is None
    assert body.load_pattern("span").quadratic_first is None
    np.testing.assert_array_equal(body.moments.quadratic_second, full.moments.quadratic_second)
    # of uniform rho A the load of inertia is that of the line; only inside the elements is it known more exactly
    line = full.load_pattern("span").quadratic_first * STEEL.rho * 0.02 * 0.05
    assert np.abs(line - full.moments.quadratic_first).max() < 0.1 * np.abs(line).max()


@pytest.mark.filterwarnings("ignore::kanefe.imports.nodal_inertia.NodalFormWarning")
def test_given_matrices_stiffen_as_the_beams_they_come_from():
    """K_g of unit loads made beforehand; the inertia of the nodal form is that of the field in the plane."""
    beams = straight_beam(1.0, Rectangle(0.02, 0.01), STEEL, elements=6, planar=True)
    free = held(beams, [0])
    field = beams.mass_field
    fields = np.column_stack([np.ones(len(field.points)), field.points])
    geometric = {}
    for name in INERTIAL_LOADS:
        direction = np.eye(3)["xyz".index(name[-1])]
        share = fields[:, 0 if len(name) == 1 else 1 + "xyz".index(name[0])]
        load = np.kron(field.mass @ share, direction)
        geometric[name] = beams.stress_stiffness(static(beams, free, field.interpolation.T @ load), load)
    given = model_from_matrices(
        beams.mass,
        beams.stiffness,
        beams.nodes,
        components=beams.components,
        groups={"root": [0], "tip": [6]},
        geometric_stiffness=geometric,
    )
    options = {"reduction": CraigBampton(modes=3), "stiffening": "inertial"}
    ours, theirs = (flexible_body(m, {"root": "clamped"}, **options).moments for m in (beams, given))
    k = 3
    first, second = ours.quadratic_first[:, :k, :k], ours.quadratic_second[:, :, :k, :k]
    signs = np.sign(np.diag(ours.shape_product[0, 0][:k, :k]))
    assert signs.shape == (k,)
    np.testing.assert_allclose(theirs.quadratic_first[:, :k, :k], first, rtol=0, atol=1e-9 * np.abs(first).max())
    # the turned sections (rotary inertia) are beyond the nodal form: (0.02 m)^2 / 12 against 1 m^2
    np.testing.assert_allclose(theirs.quadratic_second[:, :, :k, :k], second, rtol=0, atol=5e-3 * np.abs(second).max())

    missing = {name: matrix for name, matrix in geometric.items() if name != "xx"}
    with pytest.raises(ModelError, match="unit inertia load 'xx'"):
        flexible_body(replace(given, geometric_stiffness=missing), {"root": "clamped"}, **options)
    with pytest.raises(ModelError, match="inertia loads only"):
        flexible_body(given, {"root": "clamped"}, reduction=CraigBampton(modes=3), stiffening="full")


def test_stiffening_asked_where_there_is_none():
    beams = straight_beam(1.0, Rectangle(0.02, 0.01), STEEL, elements=4, planar=True)
    bare = replace(beams, stress_stiffness=None)
    with pytest.raises(ModelError, match="no geometric stiffness"):
        flexible_body(bare, {"root": "clamped"}, reduction=CraigBampton(modes=2), stiffening="inertial")
    with pytest.raises(ModelError, match="'none', 'inertial', 'full'"):
        flexible_body(beams, {"root": "clamped"}, reduction=CraigBampton(modes=2), stiffening="yes")
    long = straight_beam(1.0, Rectangle(0.02, 0.01), STEEL, elements=120, planar=True)
    with pytest.raises(ModelError, match="unreduced body of 363"):
        flexible_body(long, {"root": "clamped"}, stiffening="full")
