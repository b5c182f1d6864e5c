"""Viscoelastic bodies in scenes: roots and runs against closed forms, routes against each other, rest and start."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from kanefe.equations.body_relaxations import with_relaxed_bodies
from kanefe.integrate.methods.generalised_alpha import CompiledAlpha
from kanefe_fem import Material, Rectangle, beam_body, straight_beam

E, RHO, ARMS = 210e9, 7850.0, [(1.0 / 3.0, 0.02), (0.1, 0.003)]
ROUTES = 1e-11
"""Of two routes that solve for accelerations of stiff modes: 1e-16 times their frequencies over the slowest."""


def beam(prony=ARMS, modes: int = 2, **interfaces) -> kf.FlexibleBody:
    material = Material(E=E, nu=0.3, rho=RHO, prony=prony)
    model = straight_beam(1.0, Rectangle(0.05, 0.01), material, elements=6)
    return beam_body(model, interfaces or {"root": "clamped", "tip": "rigid"}, kf.CraigBampton(modes=modes))


def arm_and_tool(body: kf.FlexibleBody | None = None, speed: float = 0.5) -> kf.System:
    scene = kf.System(gravity=(0, 0, -9.81))
    arm = scene.add_flexible_body("arm", body or beam(), joint=kf.Revolute("y", speed=speed))
    scene.add_rigid_body("tool", 1.0, 0.01, parent=arm.interface("tip"))
    return scene


def disturbed(model, seed: int = 0) -> np.ndarray:
    y = model.initial_state
    return y + 1e-2 * np.random.default_rng(seed).standard_normal(len(y))


class TestRoutes:
    def test_the_compiled_route_has_the_rates_of_the_literal_one(self):
        model = arm_and_tool().freeze()
        y = disturbed(model)
        literal = model.literal.evaluate(0.0, np.concatenate((y, np.zeros(2)))).rates
        rates = model.rhs(0.0, y)
        assert np.abs(rates - literal[: len(y)]).max() < ROUTES * np.abs(rates).max()

    def test_also_of_a_body_whose_coordinates_are_no_modes_of_unit_mass(self):
        material = Material(E=E, nu=0.3, rho=RHO, prony=ARMS)
        whole = beam_body(straight_beam(1.0, Rectangle(0.05, 0.01), material, elements=2), {"root": "clamped"})
        assert not np.allclose(whole.moments.elastic_mass[: whole.free_count, : whole.free_count], np.eye(12))
        scene = kf.System()
        scene.add_flexible_body("arm", whole)
        model = scene.freeze()
        y = 1e-3 * disturbed(model)
        literal = model.literal.evaluate(0.0, np.concatenate((y, np.zeros(2)))).rates
        rates = model.rhs(0.0, y)
        assert np.abs(rates - literal[: len(y)]).max() < 1e-9 * np.abs(rates).max()

    def test_runs_of_all_methods_end_alike_and_keep_their_books(self):
        scene = arm_and_tool(beam(modes=1), speed=0.2)
        exact = scene.simulate((0.0, 0.2), method="dop853", rtol=1e-10)
        size = np.abs(exact.position("tool")).max()
        assert exact.energy.dissipated[-1] > 1e-4
        # some thousand steps at 1e-10 of 0.1 J
        assert np.abs(exact.energy.balance_error).max() < 1e-8
        for method, rtol, error in (("radau5", 1e-8, 1e-8), ("generalised-alpha", 1e-5, 1e-4)):
            run = scene.simulate((0.0, 0.2), method=method, rtol=rtol)
            assert np.abs(run.position("tool")[-1] - exact.position("tool")[-1]).max() < error * size
            assert run.energy.dissipated[-1] == pytest.approx(exact.energy.dissipated[-1], rel=100 * error)


@pytest.mark.parametrize("sprung", [False, True])
@pytest.mark.parametrize("options", [{"step": 1e-3}, {"rtol": 1e-5}])
def test_arms_in_the_sweeps_are_those_of_the_matrix_over_all_unknowns(sprung, options, monkeypatch):
    def run() -> kf.Result:
        scene = arm_and_tool()
        if sprung:
            scene.add_spring("spring", scene.ground, scene.body("tool"), stiffness=1e4, damping=10.0)
        return scene.simulate((0.0, 0.05), method="generalised-alpha", output_step=0.01, **options)

    swept = run()
    assert (swept.statistics["jacobians"] > 0) == sprung
    monkeypatch.setattr(CompiledAlpha, "kernels_for", lambda makes, model: makes.with_jacobian(0))
    dense = run()
    assert dense.statistics["jacobians"] > 0
    size = np.abs(dense.load("relaxation of arm")[:, 0]).max()
    # both iterate to 1e-3 of the tolerance, 1e-7 with fixed steps; free steps differ by what theirs allow
    tolerance = 1e-8 if "step" in options else 1e-4
    np.testing.assert_allclose(swept.position("tool"), dense.position("tool"), rtol=0, atol=tolerance)
    np.testing.assert_allclose(
        swept.load("relaxation of arm")[:, 0],
        dense.load("relaxation of arm")[:, 0],
        rtol=0,
        atol=100 * tolerance * size,
    )


class TestFiles:
    def test_a_saved_body_has_its_arms(self, tmp_path):
        body = beam()
        body.save(tmp_path / "beam.npz")
        found = kf.FlexibleBody.load(tmp_path / "beam.npz").relaxation
        np.testing.assert_array_equal(found.factors, body.relaxation.factors)
        np.testing.assert_array_equal(found.times, body.relaxation.times)

    def test_the_report_of_a_body_tells_of_them(self):
        text = str(beam().report()).replace("\n", " ")
        assert "16 internal states, relaxation times 0.003 to 0.02 s" in text

    def test_a_run_goes_on_from_its_checkpoint_with_the_states_of_arms(self, tmp_path):
        scene, kept = on_wall(beam(modes=1)), tmp_path / "run.h5"
        whole = scene.simulate((0.0, 0.1), method="radau5")
        stopped = scene.simulate((0.0, 0.1), method="radau5", checkpoint=kept, most_steps=5)
        assert stopped.status.kind == "stopped"
        rest = scene.simulate((0.0, 0.1), method="radau5", resume=kept)
        np.testing.assert_array_equal(rest.load("relaxation of arm")[-1], whole.load("relaxation of arm")[-1])


def on_wall(body: kf.FlexibleBody, gravity: float = 9.81) -> kf.System:
    scene = kf.System(gravity=(0, 0, -gravity))
    arm = scene.add_flexible_body("arm", body)
    scene.add_rigid_body("tool", 0.2, 1e-3, parent=arm.interface("tip"))
    return scene


def depth(state) -> float:
    return float(state.position("tool")[2])


class TestRest:
    def test_at_rest_arms_have_relaxed_and_the_long_term_stiffness_is_left(self):
        soft = Material(E=E * (1.0 - sum(w for w, _ in ARMS)), nu=0.3, rho=RHO)
        model = straight_beam(1.0, Rectangle(0.05, 0.01), soft, elements=6)
        elastic = beam_body(model, {"root": "clamped", "tip": "rigid"}, kf.CraigBampton(modes=2))
        rest = kf.equilibrium(on_wall(beam()))
        assert depth(rest) == pytest.approx(depth(kf.equilibrium(on_wall(elastic))), rel=1e-9)
        run = on_wall(beam()).simulate((0.0, 0.5), start=rest)
        assert run.position("tool")[-1, 2] == pytest.approx(depth(rest), rel=1e-9)

    def test_a_run_begins_with_relaxed_arms_also_from_given_coordinates(self):
        scene = on_wall(beam(), gravity=0.0)
        model = scene.freeze()
        y = model.initial_state[: model.coordinate_count + model.free_count]
        y[0] = 1e-3
        run = scene.simulate((0.0, 1e-3), start=y, method="dop853")
        assert run.load("relaxation of arm")[0] == pytest.approx((0.0, 0.0), abs=1e-20)

    def test_a_stretch_held_for_long_relaxes(self):
        """A rod pulled slowly has its long-term stiffness, and pulled at once the instantaneous one."""
        body = beam(modes=0)
        load = kf.System()
        load.add_flexible_body("arm", body)
        model = load.freeze()
        own, k = model.loads[0], body.free_count
        eta = np.linspace(1.0, 2.0, k) * 1e-3
        y = np.concatenate((eta, np.zeros(k), np.zeros(len(own.initial_states))))
        state = model.literal.view(0.0, y)
        at_once = own.action(0.0, state.load_ends(0), state.load_states(0)).wrenches[:, 0]
        np.testing.assert_allclose(at_once, -body.relaxation.factors @ (body.relaxation.factors.T @ eta), rtol=1e-12)
        whole = body.stiffness[:k, :k] @ eta - at_once
        share = 1.0 - sum(w for w, _ in ARMS)
        np.testing.assert_allclose(whole, body.stiffness[:k, :k] @ eta / share, rtol=1e-9)


class TestSmallMotions:
    def test_roots_of_a_simply_supported_beam_are_those_of_its_characteristic_equation(self):
        """One arm, e = 0.5 of the long-term modulus, tau = 0.02 s, 20 pi rad/s."""
        held = {"root": kf.Interface(("x", "y")), "tip": kf.Interface(("y",))}

        def supported(E: float, prony=()) -> kf.FlexibleBody:
            material = Material(E=E, nu=0.3, rho=RHO, prony=prony)
            options = {"planar": True, "theory": "euler-bernoulli", "rotary_inertia": False}
            model = straight_beam(1.0, Rectangle(0.05, 0.01), material, elements=20, **options)
            return beam_body(model, held, kf.CraigBampton(modes=2))

        long_term = 1e9 * (10.0 / supported(1e9).frequencies[0]) ** 2
        scene = kf.System()
        scene.add_flexible_body("beam", supported(1.5 * long_term, [(1.0 / 3.0, 0.02)]))
        found = kf.linearise(scene).modes().eigenvalues
        for root in (-6.81123973 + 73.34724008j, -36.37752053):
            assert np.abs(found - root).min() < 1e-8 * abs(root)
        model = scene.freeze()
        of_equations = np.linalg.eigvals(model.jacobian(0.0, model.initial_state))
        assert np.abs(of_equations[:, None] - found).min(axis=0).max() < 1e-9 * np.abs(found).max()

    @pytest.mark.filterwarnings("ignore::kanefe.linear.unsettled.UnsettledWarning")
    def test_about_a_moving_state_with_relaxed_arms_A_is_the_jacobian_of_the_equations(self):
        model = arm_and_tool().freeze()
        y = disturbed(model, 2)
        y = np.concatenate((*model.parts(y)[:2], with_relaxed_bodies(model, model.literal.view(0.0, y), y[-16:])))
        small = kf.linearise(model, t=0.0, start=y)
        np.testing.assert_allclose(small.A, model.jacobian(0.0, y), rtol=0, atol=1e-9 * np.abs(small.A).max())
        x = np.arange(1.0, len(small.A) + 1.0)
        np.testing.assert_allclose(small.moved(x), y + x, rtol=1e-12)

    def test_the_frequency_response_is_that_of_the_complex_modulus(self):
        scene = on_wall(beam(modes=4), gravity=0.0)
        elastic = on_wall(beam(prony=[], modes=4), gravity=0.0)
        what = {"inputs": "force tool z", "outputs": "position tool z"}
        for f in (1.0, 7.0, 60.0):
            s = 2j * np.pi * f
            modulus = 1.0 - sum(w for w, _ in ARMS) + sum(w * s * t / (1.0 + s * t) for w, t in ARMS)
            found = kf.linearise(scene, **what).frequency_response([f]).response[0, 0, 0]
            small = kf.linearise(elastic, **what)
            n = small.position_count
            A = small.A.astype(complex)
            A[n:, :n] *= modulus
            expected = (small.C @ np.linalg.solve(s * np.eye(len(A)) - A, small.B))[0, 0]
            assert abs(found - expected) < 1e-9 * abs(expected)

    def test_free_bodies_have_their_rigid_motions_and_second_order_matrices_are_long_term(self):
        body = beam(tip="rigid")
        scene = kf.System()
        scene.add_flexible_body("arm", body, joint=kf.Free())
        small = kf.linearise(scene)
        modes = small.modes()
        assert np.count_nonzero(modes.is_rigid) == 6
        assert modes.is_stable
        k = body.free_count
        np.testing.assert_allclose(small.stiffness[6:, 6:], body.stiffness[:k, :k], atol=1e-8 * body.stiffness.max())
        assert np.abs(small.damping).max() < 1e-8 * np.sqrt(body.stiffness.max())
        assert len(small.undamped().A) == small.moving_count
        elastic = modes.eigenvalues[~modes.is_rigid & (modes.eigenvalues.imag > 0.0)]
        assert len(elastic) == k
        assert np.all(elastic.real < 0.0)

    def test_accelerations_as_outputs(self):
        scene = on_wall(beam(), gravity=0.0)
        names = ["position tool z", "acceleration tool z"]
        response = kf.linearise(scene, inputs="force tool z", outputs=names).frequency_response([5.0, 50.0])
        place, acceleration = response.response[:, 0, 0], response.response[:, 1, 0]
        np.testing.assert_allclose(acceleration, -((2.0 * np.pi * np.array((5.0, 50.0))) ** 2) * place, rtol=1e-7)
