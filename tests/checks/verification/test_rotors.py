"""Small motions about a steady spin: the cases of rotors, and what their eigenvalues are picked from."""

import json
from dataclasses import replace

import numpy as np
import pytest

import kanefe as kf
from kanefe.checks.verification import rotors
from kanefe.checks.verification.references import load_references
from kanefe.checks.verification.runner import run_case


@pytest.mark.parametrize("case", rotors.CASES, ids=lambda case: case.id)
def test_case_passes(case):
    rows = list(run_case(case))
    assert rows
    assert [row for row in rows if not row.passed] == []


@pytest.mark.parametrize("digits", [("9.958931373431476", "9.968931373431476"), ("58.6316759", "58.6416759")])
def test_a_wrong_reference_is_a_miss(digits):
    """One number moved by ten tolerances: a growth and a whirl."""
    right = load_references()["D04b"]
    text = json.dumps(right.values)
    assert digits[0] in text
    checks = list(rotors.asymmetric_rotor(replace(right, values=json.loads(text.replace(*digits)))))
    assert [check.passed for check in checks] == [False, True, True]


@pytest.mark.parametrize("spin", [-70.0, 0.0, 99.9, 100.1, 115.0, 119.9, 120.1, 400.0])
def test_point_on_springs_has_the_roots_of_its_characteristic_equation(spin):
    """(s^2 + w1^2 - W^2)(s^2 + w2^2 - W^2) + 4 W^2 s^2 = 0, from Newton's law in the turning frame."""
    a, b = 100.0**2 - spin**2, 120.0**2 - spin**2
    squares = np.roots([1.0, a + b + 4.0 * spin**2, a * b])
    found = rotors.spin_eigenvalues(rotors.point_on_springs(spin))
    # next to a boundary of stability the small square is a difference of numbers a thousand times its size
    np.testing.assert_allclose(np.sort((found**2).real), np.sort(squares), rtol=1e-10)
    assert np.all((found.real >= -1e-6) & (found.imag >= -1e-6))


def test_eigenvalues_of_an_oscillator_at_rest_and_of_a_pendulum_upside_down():
    scene = kf.System()
    scene.add_point("mass", 2.0, joint=kf.Prismatic("x", forces=kf.CoordinateForce(stiffness=18.0)))
    np.testing.assert_allclose(rotors.spin_eigenvalues(scene.freeze()), [3.0j], atol=1e-12)

    scene = kf.System(gravity=(0, -9.0, 0))
    scene.add_rigid_body("rod", 2.0, com=(0, 1, 0), joint=kf.Revolute("z"))
    np.testing.assert_allclose(rotors.spin_eigenvalues(scene.freeze()), [3.0], atol=1e-12)
