"""Bodies without stiffening whose axial force matters say so, with the size of the error; others say nothing."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import kanefe as kf
from kanefe.equations.unstiffened import axial_forces
from kanefe.states.state import State
from kanefe_fem import Material, Rectangle, beam_body, straight_beam

LENGTH, SECTION = 1.0, Rectangle(0.02, 0.02)
ALUMINIUM = Material(E=70e9, nu=0.33, rho=2700.0)
BUCKLES = np.pi**2 * ALUMINIUM.E * SECTION.I_z / 4.0 / LENGTH**2
ENDS = {"root": "clamped", "tip": "rigid"}


@pytest.fixture(scope="module")
def body() -> kf.FlexibleBody:
    return beam_body(straight_beam(LENGTH, SECTION, ALUMINIUM, elements=8), ENDS, kf.CraigBampton(modes=4))


def column(body: kf.FlexibleBody, share: float) -> kf.System:
    scene = kf.System()
    member = scene.add_flexible_body("column", body)
    scene.add_force(member.interface("tip"), (share * BUCKLES, 0.0, 0.0))
    return scene


def spinning(body: kf.FlexibleBody, speed: float, axis: str = "z", carried: float = 0.0) -> kf.System:
    """A beam along x on a hub that spins, relative to the first frequency of the beam."""
    scene = kf.System()
    motion = kf.Motion.steady(speed * 2.0 * np.pi * body.frequencies[0])
    hub = scene.add_rigid_body("hub", 1.0, 1.0, joint=kf.Revolute(axis, motion=motion))
    beam = scene.add_flexible_body("beam", body, parent=hub)
    if carried:
        scene.add_rigid_body("tip", carried, 1e-4, parent=beam.interface("tip"))
    return scene


@pytest.mark.parametrize("share", [-0.6, -0.15, 0.5])
def test_an_axial_load_is_told_by_its_share_of_the_buckling_load(body: kf.FlexibleBody, share: float) -> None:
    word = "softer" if share < 0.0 else "stiffer"
    with pytest.warns(UserWarning, match=rf"equilibrium: .*'column' has no stiffening, but an axial load .* % {word}"):
        rest = kf.equilibrium(column(body, share))
    (found,) = axial_forces(State(rest.model, 0.0, rest.q, rest.u), [0])
    # slopes of slices that have some of eight elements each
    assert found.by_loads == pytest.approx(share, rel=0.1)
    assert found.pull == pytest.approx(share * BUCKLES, rel=1e-6)


def test_a_spin_is_told_from_a_tenth_of_the_first_frequency(body: kf.FlexibleBody) -> None:
    with pytest.warns(UserWarning, match=r"'beam' has no stiffening, but its spin pulls it .* 1\.2 % stiffer"):
        kf.equilibrium(spinning(body, 0.1))
    with pytest.warns(UserWarning, match=r"'beam' has no stiffening, but its spin pulls it .* 3[01] % stiffer"):
        spinning(body, 0.5).simulate((0.0, 0.01))


def test_what_is_carried_in_a_spin_is_an_axial_load(body: kf.FlexibleBody) -> None:
    rest = kf.equilibrium(spinning(body, 0.09, carried=1.0))
    found = axial_forces(State(rest.model, 0.0, rest.q, rest.u), [1])[0]
    pull = 1.0 * (0.09 * 2.0 * np.pi * body.frequencies[0]) ** 2 * LENGTH
    assert found.by_loads == pytest.approx(pull / BUCKLES, rel=0.1)


def test_nothing_is_said_where_nothing_matters(body: kf.FlexibleBody) -> None:
    """Of a shaft that spins about itself, of slow spins, of small loads, and of bodies that stiffen."""
    stiff = beam_body(
        straight_beam(LENGTH, SECTION, ALUMINIUM, elements=8), ENDS, kf.CraigBampton(modes=4), stiffening="full"
    )
    with warnings.catch_warnings():
        warnings.filterwarnings("error", message=".*has no stiffening")
        for scene in (spinning(body, 3.0, "x"), spinning(body, 0.05), column(body, -0.05), spinning(stiff, 0.5)):
            kf.equilibrium(scene)
