"""Sections by stiffness: the beam that a material makes, and couplings against the integrated equations of a beam."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from kanefe.errors import ModelError, UnitWarning
from kanefe_fem import Material, Rectangle, Section, beam_model, straight_beam
from kanefe_fem.beams import elements as be
from kanefe_fem.beams.coupled import coupled_polynomials
from kanefe_fem.beams.properties import of_matrices, properties_of

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
SHAPE = Rectangle(0.05, 0.1)
NUMBERS = {
    "EA": STEEL.E * SHAPE.A,
    "EI_y": STEEL.E * SHAPE.I_y,
    "EI_z": STEEL.E * SHAPE.I_z,
    "GJ": STEEL.shear_modulus * SHAPE.J,
    "GA_y": STEEL.shear_modulus * SHAPE.A * SHAPE.shear_y,
    "GA_z": STEEL.shear_modulus * SHAPE.A * SHAPE.shear_z,
}
MASS = {"rho_A": STEEL.rho * SHAPE.A, "rho_I": (STEEL.rho * SHAPE.I_y, STEEL.rho * SHAPE.I_z)}


def coupled_stiffness() -> np.ndarray:
    """A stiffness with every coupling there is, of a blade's size."""
    size = np.sqrt([1e9, 2e8, 1e8, 1e6, 2e6, 8e6])
    noise = np.random.default_rng(7).uniform(-0.15, 0.15, (6, 6))
    return np.outer(size, size) * (np.eye(6) + 0.5 * (noise + noise.T) * (1 - np.eye(6)))


@pytest.mark.parametrize("planar", [False, True])
def test_a_section_by_its_numbers_is_the_same_beam(planar):
    by_material = straight_beam(1.3, SHAPE, STEEL, elements=3, planar=planar, direction=(1.0, 0.4, 0.0))
    kept = {name: value for name, value in NUMBERS.items() if not planar or name in ("EA", "EI_z", "GA_y")}
    section = Section.from_stiffness(**kept, **MASS)
    by_numbers = straight_beam(1.3, section, elements=3, planar=planar, direction=(1.0, 0.4, 0.0))
    u, f = np.random.default_rng(1).standard_normal((2, by_material.size))
    load = np.random.default_rng(2).standard_normal(3 * len(by_material.mass_field.points))
    for one, other in (
        (by_material.stiffness @ u, by_numbers.stiffness @ u),
        (by_material.mass @ f, by_numbers.mass @ f),
        (by_material.stress_stiffness(u, load) @ f, by_numbers.stress_stiffness(u, load) @ f),
    ):
        assert other == pytest.approx(one, abs=1e-12 * abs(one).max())


def test_without_numbers_of_inertia_the_section_is_of_one_material():
    section = Section.from_stiffness(**NUMBERS, rho_A=MASS["rho_A"])
    assert section.mass_of(None).second == pytest.approx(np.diag(MASS["rho_I"][::-1]), rel=1e-14)


@pytest.mark.parametrize("rigid_in_shear", [False, True])
def test_coupled_interpolation_is_the_closed_form_without_coupling(rigid_in_shear):
    diagonals = np.array([[2e6, 3e5, 2e5, 700.0, 2e3, 3e3], [1e6, 1e5, 4e5, 900.0, 5e3, 4e3]])
    if rigid_in_shear:
        diagonals[:, 1:3] = np.inf
    properties = of_matrices(np.array([0.4, 1.3]), np.array([np.diag(d) for d in diagonals]))
    general = coupled_polynomials(properties.length, properties.matrices)
    assert general == pytest.approx(be.interpolation_polynomials(properties), abs=1e-13)


def test_one_element_with_all_couplings_bends_as_the_equations_of_the_beam_say():
    length, D, wrench = 2.0, coupled_stiffness(), np.array([3e3, -2e3, 1e3, 400.0, -300.0, 500.0])
    model = straight_beam(length, Section.from_stiffness(stiffness=D, rho_A=40.0), elements=1)
    K = model.stiffness.toarray()[6:, 6:]

    def rates(x, motion):
        n = wrench[:3]
        m = wrench[3:] + np.cross([length - x, 0.0, 0.0], n)  # the moment of the tip's force about the section
        strains = np.linalg.solve(D, np.concatenate((n, m)))
        return np.concatenate((strains[:3] - np.cross([1.0, 0.0, 0.0], motion[3:]), strains[3:]))

    tip = solve_ivp(rates, (0.0, length), np.zeros(6), rtol=1e-12, atol=1e-16).y[:, -1]
    assert np.linalg.solve(K, wrench) == pytest.approx(tip, rel=1e-9)

    split = straight_beam(length, Section.from_stiffness(stiffness=D, rho_A=40.0), elements=5)
    fine = np.linalg.solve(split.stiffness.toarray()[6:, 6:], np.concatenate((np.zeros(24), wrench)))
    assert fine[-6:] == pytest.approx(tip, rel=1e-9)
    assert properties_of(model.elasticity, np.array([length])).matrices[0] == pytest.approx(D, rel=1e-14)


def test_a_mass_off_the_axis_moves_as_a_rigid_section_does():
    rho_A, y, z = 40.0, 0.02, -0.03
    about_centre = np.array([[0.5, 0.05], [0.05, 0.2]])  # int rho (y^2, yz; yz, z^2)
    second = about_centre + rho_A * np.outer((y, z), (y, z))
    cross = np.array([[0.0, z, -y], [-z, 0.0, 0.0], [y, 0.0, 0.0]])
    J = np.zeros((3, 3))
    J[0, 0], J[1, 1], J[2, 2] = np.trace(second), second[1, 1], second[0, 0]
    J[1, 2] = J[2, 1] = -second[0, 1]
    matrix = np.block([[rho_A * np.eye(3), rho_A * cross], [rho_A * cross.T, J]])
    section = Section.from_stiffness(stiffness=coupled_stiffness(), mass=matrix)
    length = 2.0
    model = straight_beam(length, section, elements=4)
    assert model.mass_field.mass.sum() == pytest.approx(rho_A * length, rel=1e-14)
    # kinetic energy of a turn about the axis, and of one about y through the root, per unit rate squared
    R = model.rigid_modes()
    inertia = R.T @ model.mass @ R
    assert inertia[3, 3] == pytest.approx(length * J[0, 0], rel=1e-12)
    assert inertia[4, 4] == pytest.approx(length * J[1, 1] + rho_A * length**3 / 3.0, rel=1e-12)
    assert inertia[4, 5] == pytest.approx(length * J[1, 2], rel=1e-12)
    assert inertia[0, 4] == pytest.approx(rho_A * length * z, rel=1e-12)


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"rho_A": 1.0, "EI_y": 1.0}, "EA = None is not a number"),
        ({"EA": 1.0, "rho_A": 1.0}, "no bending stiffness"),
        ({"EA": 1.0, "EI_y": -1.0, "rho_A": 1.0}, "EI_y = -1 must be positive"),
        ({"EA": 1.0, "EI_z": 1.0}, "rho_A = None is not a number"),
        ({"EA": 1.0, "EI_z": 1.0, "rho_A": 1.0, "rho_I": -1.0}, "rho_I=-1.0"),
        ({"stiffness": np.eye(6), "EA": 1.0, "rho_A": 1.0}, "both stiffness and EA"),
        ({"stiffness": np.eye(6) - np.eye(6, k=1), "rho_A": 1.0}, "not symmetric"),
        ({"stiffness": -np.eye(6), "rho_A": 1.0}, "not positive"),
        ({"stiffness": np.eye(6), "mass": np.eye(6)}, "no rigid section"),
        ({"stiffness": np.eye(6), "mass": np.eye(6), "rho_A": 1.0}, "mass is given beside"),
        ({"EA": 1.0, "EI_z": 1.0, "rho_A": 1.0, "centre_of_mass": (0.0, 0.0, 0.0)}, "centre_of_mass"),
    ],
)
def test_what_is_no_section_is_refused(given, says):
    with pytest.raises(ModelError, match=says):
        Section.from_stiffness(**given)


def test_what_does_not_fit_the_beam_is_refused():
    planar = Section.from_stiffness(EA=1e6, EI_z=1e3, rho_A=1.0)
    with pytest.raises(ModelError, match="no GJ and no EI_y"):
        straight_beam(1.0, planar)
    with pytest.raises(ModelError, match="couples motions in the plane"):
        straight_beam(1.0, Section.from_stiffness(stiffness=coupled_stiffness(), rho_A=1.0), planar=True)
    with pytest.raises(ModelError, match="stiffness and mass of its own"):
        straight_beam(1.0, planar, STEEL, planar=True)
    with pytest.raises(ModelError, match="has no E"):
        straight_beam(1.0, SHAPE)
    off = Section.from_stiffness(EA=1e6, EI_z=1e3, rho_A=1.0, centre_of_mass=(0.1, 0.0))
    with pytest.raises(ModelError, match="rotary_inertia=True"):
        straight_beam(1.0, off, planar=True, rotary_inertia=False)
    out = Section.from_stiffness(EA=1e6, EI_z=1e3, rho_A=1.0, centre_of_mass=(0.0, 0.1))
    with pytest.raises(ModelError, match="out of the plane"):
        straight_beam(1.0, out, planar=True)


@pytest.mark.parametrize(
    ("section", "material", "says"),
    [
        (SHAPE, Material(E=210.0, nu=0.3, rho=7850.0), "wave speed"),
        (SHAPE, Material(E=210e3, nu=0.3, rho=7.85e-9), "density"),
        (Rectangle(50.0, 100.0), STEEL, "mass is"),
        (Section.from_stiffness(EA=1.0, EI_y=1.0, EI_z=1.0, GJ=1.0, rho_A=40.0), None, "speed of waves"),
    ],
)
def test_beams_that_are_hardly_in_si_units_are_told(section, material, says):
    nodes = [[0.0, 0.0, 0.0], [1000.0, 0.0, 0.0]]
    with pytest.warns(UnitWarning, match=says):
        beam_model(nodes, [[0, 1]], section, material)
