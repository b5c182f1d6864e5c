"""Damping: Rayleigh given and fitted, ratios per mode, matrices; and that rigid motion never feels it (Eq. 27, 28)."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse as sp

import kanefe as kf
from kanefe.errors import ModelError
from kanefe.kane.active import elastic_forces
from kanefe.kane.energy import dissipated_power
from kanefe.reduction import flexible_body
from kanefe.states.state import State
from scenes import flexible_scene, lattice_body, lattice_model, random_state

CB = kf.CraigBampton(modes=3)


def ratios(body: kf.FlexibleBody) -> tuple[np.ndarray, np.ndarray]:
    """Return frequencies in Hz and damping ratios of the undamped modes, and check that they are uncoupled by C."""
    k = body.free_count
    K, M = body.stiffness[:k, :k], body.moments.elastic_mass[:k, :k]
    squares, shapes = scipy.linalg.eigh(K, M)
    C = shapes.T @ body.damping @ shapes
    assert pytest.approx(np.diag(np.diag(C)), abs=1e-10 * abs(C).max()) == C
    return np.sqrt(squares) / (2 * np.pi), np.diag(C) / (2 * np.sqrt(squares))


@pytest.mark.parametrize("reduction", [None, CB], ids=str)
def test_rayleigh_ratios_appear(reduction: Any) -> None:
    damping = kf.RayleighDamping(mass=0.3, stiffness=0.002)
    frequencies, found = ratios(lattice_body(0, reduction=reduction, damping=damping))
    # eigenvectors of small matrices
    assert found == pytest.approx([damping.ratio(f) for f in frequencies], rel=1e-9)


def test_rayleigh_is_fitted_to_two_ratios() -> None:
    frequencies = lattice_body(0, reduction=CB).frequencies[[0, 4]]
    damping = kf.RayleighDamping.fit(frequencies, (0.03, 0.05))
    _, found = ratios(lattice_body(0, reduction=CB, damping=damping))
    assert found[[0, 4]] == pytest.approx([0.03, 0.05], rel=1e-9)


@pytest.mark.parametrize("reduction", [None, CB], ids=str)
def test_modal_ratios_appear_and_the_last_goes_on(reduction: Any) -> None:
    _, found = ratios(lattice_body(0, reduction=reduction, damping=kf.ModalDamping((0.01, 0.04, 0.02))))
    assert found == pytest.approx([0.01, 0.04, *[0.02] * (len(found) - 2)], rel=1e-9)
    _, found = ratios(lattice_body(0, reduction=reduction, damping=kf.ModalDamping(0.01)))
    assert found == pytest.approx(np.full(len(found), 0.01), rel=1e-9)


def test_a_damped_mode_decays_at_its_ratio() -> None:
    scene = kf.System()
    scene.add_flexible_body(
        "arm", lattice_body(0, reduction=CB, damping=kf.ModalDamping(0.05)), modal_coordinates=[0.01] + [0] * 8
    )
    f = scene.freeze().flexible_terms("arm").body.frequencies[0]
    w, z = 2 * np.pi * f, 0.05
    result = scene.simulate((0.0, 2.0 / f), rtol=1e-10, method="dop853")
    wd = w * np.sqrt(1 - z * z)
    t = result.times
    expected = 0.01 * np.exp(-z * w * t) * (np.cos(wd * t) + z * w / wd * np.sin(wd * t))
    # the integrator's tolerance, absolute 1e-13 beside relative 1e-10
    assert result.modal_coordinates("arm")[:, 0] == pytest.approx(expected, abs=1e-10)


@pytest.mark.parametrize("kind", ["sparse", "dense"])
def test_a_given_matrix_is_projected(kind: str) -> None:
    model = lattice_model(0)
    random = np.random.default_rng(0).standard_normal((model.size, 4))
    C = random @ random.T  # dampers between a few combinations: singular, symmetric
    body = lattice_body(0, damping=sp.csr_matrix(C) if kind == "sparse" else C)
    psi = body.basis[:, : body.free_count]
    assert body.damping == pytest.approx(psi.T @ C @ psi, abs=1e-12 * abs(C).max())


def test_the_model_s_own_damping_is_taken_by_default() -> None:
    model = lattice_model(0)
    C = 0.01 * model.stiffness
    body = flexible_body(replace(model, damping=C), {"root": "clamped"})
    k = body.free_count
    assert body.damping == pytest.approx(0.01 * body.stiffness[:k, :k], abs=1e-12)
    assert (
        np.any(flexible_body(replace(model, damping=C), {"root": "clamped"}, damping=kf.ModalDamping(0.0)).damping) == 0
    )


def test_undamped_scenes_run_no_damping_code() -> None:
    model = flexible_scene(0).freeze()
    assert model.flexible_terms("arm").damping is None
    assert flexible_scene(0, damping=kf.ModalDamping(0.0)).freeze().flexible_terms("arm").damping is None


@pytest.mark.parametrize("damping", [kf.RayleighDamping(0.5, 0.01), kf.ModalDamping(0.1)], ids=repr)
def test_power_is_never_positive_and_none_without_deformation(damping: Any) -> None:
    model = flexible_scene(0, damping=damping).freeze()
    for seed in range(5):
        q, u = random_state(model, seed)
        assert dissipated_power(State(model, 0.0, q, u)) > 0
        u[model.flexible_terms("arm").speeds] = 0.0
        assert dissipated_power(State(model, 0.0, q, u)) == 0.0


def test_damping_is_internal_its_forces_have_no_resultant() -> None:
    # What damping takes from the motion it hands on through the structure: the supports of a body that only deforms at
    # a steady rate, without mass, feel C and K alike; with zero elastic force they feel the damping of the shape.
    model = flexible_scene(0, damping=kf.RayleighDamping(stiffness=0.01)).freeze()
    terms = model.flexible_terms("arm")
    rng = np.random.default_rng(0)
    shape = np.concatenate((rng.standard_normal(terms.body.free_count), np.zeros(6)))
    still = np.zeros_like(shape)
    # for C = b K the force of a rate is b times the force of the same displacement, on every row
    elastic, damped = elastic_forces(terms, shape, still), elastic_forces(terms, still, shape)
    assert damped == pytest.approx(0.01 * elastic, abs=1e-11)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: kf.RayleighDamping(mass=-1.0), r"the mass factor must be finite and >= 0, not -1\.0"),
        (lambda: kf.RayleighDamping(stiffness=np.nan), "the stiffness factor must be finite and >= 0, not nan"),
        (
            lambda: kf.RayleighDamping.fit((10.0, 10.0), (0.1, 0.1)),
            "two ratios at two different frequencies above zero",
        ),
        (lambda: kf.RayleighDamping.fit((0.0, 10.0), (0.1, 0.1)), "two ratios at two different frequencies above zero"),
        (lambda: kf.RayleighDamping.fit((1.0, 10.0, 20.0), (0.1, 0.1, 0.1)), "two ratios at two different frequencies"),
        (
            lambda: kf.RayleighDamping.fit((10.0, 100.0), (0.5, 0.001)),
            "negative Rayleigh factor .* Remedy: closer ratios",
        ),
        (lambda: kf.ModalDamping(-0.1), r"modal damping ratios must be finite and >= 0, not -0\.1"),
        (lambda: kf.ModalDamping(()), "modal damping ratios must be finite and >= 0"),
        (lambda: kf.ModalDamping(np.nan), "modal damping ratios must be finite and >= 0, not nan"),
        (
            lambda: lattice_body(0, reduction=kf.CraigBampton(modes=0), damping=kf.ModalDamping([0.1] * 7)),
            "7 damping ratios were given for 6 elastic modes. Remedy: leave some out",
        ),
        (lambda: lattice_body(0, damping=0.02), r"damping=0\.02 is not a damping\. Remedy: ModalDamping\(0\.02\)"),
        (lambda: lattice_body(0, damping=np.eye(3)), r"damping matrix has shape \(3, 3\), the model has 27 degrees"),
        (lambda: lattice_body(0, damping=-np.eye(27)), "feeds energy in .* Remedy: check its signs"),
        (
            lambda: lattice_body(0, damping=np.triu(np.ones((27, 27)))),
            "not symmetric or not finite. Remedy: pass its symmetric",
        ),
        (lambda: lattice_body(0, damping=np.diag([np.nan] * 27)), "not symmetric or not finite"),
    ],
)
def test_bad_input_is_named(make: Any, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        make()


def test_modal_damping_above_critical_has_to_be_meant() -> None:
    with pytest.raises(kf.ModelError, match=r"ratio of 5 is above 1.*Remedy: 0\.05 for 5 %, or overdamped=True"):
        kf.ModalDamping(5.0)
    with pytest.raises(kf.ModelError, match="ratio of 2 is above 1"):
        kf.ModalDamping((0.01, 2.0))
    assert kf.ModalDamping(5.0, overdamped=True).ratios(2).tolist() == [5.0, 5.0]
    assert kf.ModalDamping(1.0).ratios(1).tolist() == [1.0]
