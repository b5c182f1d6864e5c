"""How far bodies are bent is always told, and warned of where it is beyond the reach of their kinematics."""

from __future__ import annotations

import warnings
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import kanefe as kf
from kanefe.bodies.inner_rotations import inner_rotations
from kanefe.tree.bending import Bending, worst_bending
from kanefe_fem import Material, Rectangle, beam_body, straight_beam

SECTION = Rectangle(0.01, 0.01)
ALUMINIUM = Material(E=70e9, nu=0.33, rho=2700.0)
ENDS = {"root": "clamped", "tip": "rigid"}


def cantilever(
    load: float, stiffening: str = "none", modes: int = 2, *, planar: bool = False, damping: float = 0.7
) -> kf.System:
    """A cantilever of 1 m under a force at its tip: `load` is P L^2 / E I."""
    beam = straight_beam(1.0, SECTION, ALUMINIUM, elements=8, planar=planar)
    body = beam_body(beam, ENDS, kf.CraigBampton(modes=modes), kf.ModalDamping(damping), stiffening=stiffening)
    scene = kf.System()
    beam_in_scene = scene.add_flexible_body("beam", body, joint=kf.Fixed())
    scene.add_force(beam_in_scene.interface("tip"), (0.0, load * ALUMINIUM.E * SECTION.I_z, 0.0))
    return scene


@pytest.mark.parametrize("load", [1.2, 2.4, 3.3])
def test_a_cantilever_bent_far_is_told(load: float) -> None:
    with pytest.warns(
        kf.SimulationWarning, match=r"bent beyond its valid range, 'beam' by .* rad at .*tip.*about 0\.2 rad"
    ):
        result = cantilever(load).simulate((0.0, 0.5))
    assert "bending 'beam' by" in str(result)
    assert "beyond its valid range" in str(result)
    _, rotation, reach, place, time, displacement, _ = result.statistics["bending"]
    tip = result.deflection("beam", "tip")
    row = int(np.argmin(np.abs(result.times - time)))
    largest = np.linalg.norm(tip[:, 3:], axis=1).max()
    assert rotation >= largest * (1.0 - 1e-12)
    # it may be at a step, within 0.5 ms of an output: there a vibration of 52 rad/s has lost (52 * 5e-4)^2 / 2
    assert rotation == pytest.approx(largest, rel=4e-4)
    assert (reach, place) == (0.2, "interface 'tip'")
    assert displacement == pytest.approx(np.linalg.norm(tip[row, :3]), rel=4e-4)
    with pytest.warns(kf.AccuracyWarning, match="beyond its valid range"):
        found = kf.equilibrium(cantilever(load))
    assert found.bending is not None
    # of the linear beam: P L^2 / 2 E I, and P L^3 / 3 E I; its shear is 1e-4 of it
    assert found.bending.rotation == pytest.approx(load / 2.0, rel=1e-3)
    assert found.bending.displacement == pytest.approx(load / 3.0, rel=1e-3)


@pytest.mark.parametrize(
    "options",
    [{}, {"method": "dop853"}, {"method": "generalised-alpha"}, {"method": "generalised-alpha", "step": 1e-3}],
)
def test_a_body_bent_far_between_outputs_is_told(options: dict[str, Any]) -> None:
    scene = cantilever(1.2, damping=0.0)
    period = 1.0 / scene.freeze().flexible_terms("beam").body.frequencies[0]
    with pytest.warns(kf.SimulationWarning, match="bent beyond its valid range"):
        result = scene.simulate((0.0, period), output_step=period, **options)
    assert np.linalg.norm(result.deflection("beam", "tip")[:, 3:], axis=1).max() < 0.1
    bending = Bending(*result.statistics["bending"])
    # twice that at rest, half a period on, but for further modes and what is left between two steps
    assert bending.rotation == pytest.approx(1.2, rel=0.1)
    assert bending.time == pytest.approx(period / 2, rel=0.15)
    assert bending.displacement == pytest.approx(0.8, rel=0.1)


@pytest.mark.parametrize("method", ["radau5", "generalised-alpha"])
def test_what_was_bent_far_before_a_checkpoint_is_told_after_it(method: str, tmp_path) -> None:
    scene = cantilever(1.2, damping=0.0)
    span, fixed = (0.0, 0.12), {"step": 2e-3} if method == "generalised-alpha" else {}
    whole = scene.simulate(span, method=method, output_step=0.12, **fixed)
    path = tmp_path / "run.h5"
    most = whole.statistics["steps"] - 5
    scene.simulate(span, method=method, output_step=0.12, checkpoint=path, most_steps=most, **fixed)
    resumed = scene.simulate(span, method=method, output_step=0.12, resume=path, **fixed)
    assert resumed.statistics["bending"] == whole.statistics["bending"]
    assert 0.0 < whole.statistics["bending"][4] < 0.1


def test_what_a_step_went_past_an_event_has_not_been() -> None:
    """A step that ends far behind an event is bent as no body ever was."""
    scene = cantilever(0.1, damping=0.0)
    first = kf.Event("first", lambda t, state: t - 0.011, terminal=True)
    result = scene.simulate((0.0, 1.0), method="generalised-alpha", step=0.01, events=first, output_step=1.0)
    assert result.times[-1] == pytest.approx(0.011)
    assert result.statistics["bending"][4] <= result.times[-1]


def test_a_scene_that_is_stepped_tells_how_far_its_bodies_were_bent() -> None:
    sim = cantilever(1.2).start(outputs="deflection beam/tip y")
    sim.step(0.5)
    assert 0.6 < sim.statistics["bending"][1] < 0.7  # at rest, and what it swings beyond


def test_a_body_within_its_reach_is_told_in_print_alone() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        result = cantilever(0.1).simulate((0.0, 0.5))
        assert kf.equilibrium(cantilever(0.35)).bending.rotation < 0.2
    assert "bending 'beam' by 0.05" in str(result)
    assert "beyond" not in str(result)


@pytest.mark.parametrize("modes", [1, 8])
def test_the_reach_of_what_stiffens_is_that_of_its_own_shape(modes: int) -> None:
    """By the inertia that it loses as it bends on, not by that of high modes that nothing moves."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = kf.equilibrium(cantilever(0.15, "full", modes, planar=True))
    assert found.bending.rotation == pytest.approx(0.075, rel=1e-3)
    assert found.bending.reach == pytest.approx(0.10, rel=0.05)
    # of an elastica to second order: P L^3 / 3 E I (1 - 4 (P L^2 / E I)^2 / 35 ...), its shear is 1e-4 of it
    assert found.deflection("beam", "tip")[1] == pytest.approx(0.05, rel=2e-3)


@pytest.mark.parametrize("known", ["rotations", "cells", "nodes alone"])
def test_rotations_are_those_of_nodes_or_else_of_cells(known: str) -> None:
    body = cantilever(0.3).freeze().flexible_terms("beam").body
    if known != "rotations":
        rows = np.reshape(np.arange(6 * len(body.nodes)), (-1, 6))[:, :3].ravel()
        cells = body.cells if known == "cells" else ()
        frames = tuple(
            replace(frame, motion=np.vstack((frame.motion[:3], 0 * frame.motion[3:]))) for frame in body.interfaces
        )
        body = replace(body, components=("x", "y", "z"), basis=body.basis[rows], cells=cells, interfaces=frames)
    k = body.free_count
    force = body.node_frame(len(body.nodes) - 1).motion[1, :k]
    eta = np.linalg.solve(body.stiffness[:k, :k], force)
    eta /= force @ eta
    inner = inner_rotations(body)
    assert inner is not None
    size = np.linalg.norm(inner.largest(eta)[1])
    # deflected by 1 m in 1 m: 3/2 at the tip, nearly so in the last of eight cells, one of its length
    expected = {"rotations": 1.5, "cells": 1.5 * (1.0 - 1.0 / 16.0**2), "nodes alone": 1.0}[known]
    assert size == pytest.approx(expected, rel=2e-3)
    assert inner.of_displacements == (known == "nodes alone")


def test_unreduced_bodies_are_told_of_too() -> None:
    beam = straight_beam(1.0, SECTION, ALUMINIUM, elements=60)  # too many to be dense
    scene = kf.System()
    body = scene.add_flexible_body("beam", beam_body(beam, ENDS), joint=kf.Fixed())
    scene.add_force(body.interface("tip"), (0.0, 1.2 * ALUMINIUM.E * SECTION.I_z, 0.0))
    model = scene.freeze()
    terms = model.flexible_terms("beam")
    q = model.initial_coordinates.copy()
    k, tip = terms.body.free_count, terms.body.interface("tip")
    q[terms.eta] = terms.body.held_factors.solve(tip.motion[1, :k] * 1.2 * ALUMINIUM.E * SECTION.I_z)
    found = worst_bending(model, np.zeros(1), q[None])
    assert found is not None
    assert found.rotation == pytest.approx(0.6, rel=1e-3)


def test_a_planar_beam_is_hinged_by_the_word() -> None:
    beam = straight_beam(1.0, SECTION, ALUMINIUM, elements=8, planar=True)
    guide = kf.Interface(fixed=("y",))
    by_word, by_components = (
        beam_body(beam, {"root": root, "tip": guide}, kf.CraigBampton(modes=2))
        for root in ("hinged", kf.Interface(fixed=("x", "y")))
    )
    np.testing.assert_array_equal(by_word.stiffness, by_components.stiffness)
