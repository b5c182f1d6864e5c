"""The table of methods: names, options, which row serves which scene, and the list for users."""

from __future__ import annotations

import pytest

import kanefe as kf
from kanefe.bodies.unreduced import UnreducedBody
from kanefe.equations.model import Model
from kanefe.integrate.dynamics import Dynamics
from kanefe.integrate.methods.generalised_alpha_unreduced import UnreducedStepper
from kanefe.integrate.methods.kernel_stepper import KernelStepper
from kanefe.integrate.methods.table import METHODS, ROWS, own_methods, row_for
from kanefe.integrate.stepper import StepControl
from kanefe.reduction.build import flexible_body
from kanefe_fem.beams.body import straight_beam
from kanefe_fem.beams.sections import Tube
from kanefe_fem.materials.isotropic import Material


def pendulum() -> Model:
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    scene.add_rigid_body("rod", 1.0, 0.1, com=(0.5, 0, 0), joint=kf.Revolute("y"))
    return scene.freeze()


@pytest.fixture
def unreduced(monkeypatch: pytest.MonkeyPatch) -> kf.System:
    """Return a beam that keeps all degrees of freedom of its mesh, on a hinge."""
    monkeypatch.setattr("kanefe.reduction.build.LARGEST_DENSE", 0)
    beam = straight_beam(1.0, Tube(0.04, 0.002), Material(E=70e9, nu=0.33, rho=2700.0), elements=3)
    body = flexible_body(beam, {"root": "clamped", "tip": "rigid"})
    assert isinstance(body, UnreducedBody)
    scene = kf.System()
    scene.add_flexible_body("beam", body, joint=kf.Revolute("y"))
    return scene


OF_UNREDUCED = "generalised-alpha", "hht"


def test_every_method_can_be_run_in_some_way() -> None:
    for row in ROWS:
        assert row.has_error_control or row.has_fixed_steps, row.name
        assert 0.0 <= row.least_rtol < 1e-6, row.name


def test_one_name_stands_for_the_row_that_serves_the_scene(unreduced: kf.System) -> None:
    rigid, whole = pendulum(), unreduced.freeze()
    control = StepControl(1e-6, 1e-7, None)
    for name in OF_UNREDUCED:
        small, large = row_for(rigid, name), row_for(whole, name)
        assert small is METHODS[name] is not large
        assert large in ROWS
        for row, model, kind in ((small, rigid, KernelStepper), (large, whole, UnreducedStepper)):
            stepper = row.make(Dynamics(model), 0.0, 1.0, control)
            assert isinstance(stepper, kind)
            assert stepper.name == name


@pytest.mark.parametrize("name", [name for name in METHODS if name not in OF_UNREDUCED])
def test_an_unreduced_body_is_refused_by_all_others_with_the_reason(name: str, unreduced: kf.System) -> None:
    with pytest.raises(kf.ModelError, match=f"method '{name}' would need a step for the highest mode of the mesh"):
        row_for(unreduced.freeze(), name)


def test_an_unreduced_body_takes_given_steps(unreduced: kf.System) -> None:
    done = unreduced.simulate((0.0, 0.1), step=0.01, output_step=0.05).statistics
    assert (done["method"], done["steps"], done["factorisations"]) == ("generalised-alpha", 10, 1)


def test_the_list_has_a_line_for_every_row() -> None:
    lines = kf.methods().splitlines()
    assert [line.split()[0] for line in lines] == ["auto", *(row.name for row in ROWS)]
    assert max(map(len, lines)) <= 120
    by_name = dict(zip([line.split()[0] for line in lines], lines, strict=True))
    assert "rtol, atol or step" in by_name["dop853"]
    assert "(order 8)" in by_name["dop853"]
    assert "rtol" not in by_name["rk4"]
    assert set(own_methods()) < set(by_name)
