"""Tractions, pressures and line loads: equal to the nodal forces they stand for, their power booked, names checked."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp

import kanefe as kf
from kanefe.errors import FileError, ModelError
from kanefe.fe_model.load_pattern import NodalPattern
from kanefe.fe_model.model import NodeGroup
from kanefe.imports.from_matrices import model_from_matrices
from kanefe.kane.assemble import accelerations, assemble
from kanefe.kane.coupling import accelerations_and_coupling_forces, recovered_forces
from kanefe.kane.energy import elastic_energy, gravity_energy, kinetic_energy, load_power
from kanefe.kane.reactions import joint_reactions
from kanefe.reduction import flexible_body
from kanefe.states.state import State
from random_scenes import any_change
from scenes import derivatives, lattice_model, path, random_inertia, random_state, unit_axis

T = 0.2
EDGE = {2: 0.2, 3: 0.5, 4: 0.3}  # metres of the edge that belong to each node


def patterned(seed: int = 0, interfaces: dict | None = None, reduction: Any = None, **options: Any) -> kf.FlexibleBody:
    """Return a lattice whose nodes share a "side" with a random outside, and an "edge" of three nodes."""
    model = lattice_model(seed, **options)
    shares, normals = side_forces(model.nodes, model.components)
    edge = np.zeros(len(model.nodes))
    edge[list(EDGE)] = list(EDGE.values())
    patterns = {
        "side": NodalPattern.of_nodes(
            model.nodes, model.components, shares, normals, pressure_change=any_change(model.size)
        ),
        "edge": NodalPattern.of_nodes(model.nodes, model.components, edge, kind="line"),
    }
    held = {"root": "clamped", "tip": "rigid"} if interfaces is None else interfaces
    return flexible_body(replace(model, load_patterns=patterns), held, reduction=reduction)


def side_forces(nodes: np.ndarray, components: tuple[str, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Return the area of each node and the force on it of a unit pressure: any numbers will do."""
    rng = np.random.default_rng(4)
    shares, normals = rng.uniform(0.1, 1.0, len(nodes)), rng.standard_normal((len(nodes), 3))
    if "z" not in components:
        normals[:, 2] = 0.0
    return shares, normals


def scene_of(seed: int, body: kf.FlexibleBody) -> tuple[kf.System, Any]:
    """Return hub - flexible arm - tip, without loads but gravity."""
    rng = np.random.default_rng(seed)
    scene = kf.System(gravity=rng.standard_normal(3))
    hub = scene.add_rigid_body("hub", 3.0, random_inertia(rng), joint=kf.Free())
    joint = kf.Free() if body.is_floating else kf.Revolute(unit_axis(rng))
    arm = scene.add_flexible_body("arm", body, parent=hub, joint=joint, at=(0.2, -0.1, 0.3))
    scene.add_rigid_body("tip", 0.5, random_inertia(rng, 0.01), parent=arm.interface("tip"), at=(0.1, 0, 0))
    return scene, arm


BODIES = {
    "unreduced": lambda: patterned(0),
    "reduced": lambda: patterned(1, reduction=kf.CraigBampton(modes=3)),
    "floating": lambda: patterned(2, {"tip": "rigid"}, reduction=kf.CraigBampton(modes=4)),
    "planar mesh": lambda: patterned(3, planar=True),
    "nodes that rotate": lambda: patterned(4, rotations=True),
}


# a following force on a node that rotates follows the node, a following traction follows G: those differ
FOLLOWING = [(body, False) for body in BODIES] + [(body, True) for body in BODIES if body != "nodes that rotate"]


@pytest.mark.parametrize(("body_name", "follows"), FOLLOWING)
@pytest.mark.parametrize("name", ["side", "edge"])
def test_a_uniform_load_is_the_sum_of_its_nodal_forces(body_name: str, follows: bool, name: str) -> None:
    body = BODIES[body_name]()

    def load(t: float) -> np.ndarray:
        return np.array([0.3 - t, 0.5, -0.7])

    scene, arm = scene_of(5, body)
    (scene.add_traction if name == "side" else scene.add_line_load)(arm, name, load, follows=follows)
    nodal, other = scene_of(5, body)
    shares = dict(enumerate(side_forces(body.nodes, body.components)[0])) if name == "side" else EDGE
    for node, share in shares.items():
        nodal.add_force(other.node(node), lambda t, s=share: s * load(t), follows=follows)
    ours, theirs = scene.freeze(), nodal.freeze()
    q, u = random_state(ours, 3)
    for is_wide in (False, True):
        _, F = assemble(State(ours, 0.2, q, u, is_wide=is_wide))
        _, expected = assemble(State(theirs, 0.2, q, u, is_wide=is_wide))
        np.testing.assert_allclose(F, expected, rtol=0, atol=1e-12 * abs(expected).max())
    assert load_power(State(ours, 0.2, q, u)) == pytest.approx(load_power(State(theirs, 0.2, q, u)), rel=1e-12)
    du = accelerations(State(ours, 0.2, q, u))
    wrenches, expected = (np.array(joint_reactions(State(model, 0.2, q, u), du)) for model in (ours, theirs))
    np.testing.assert_allclose(wrenches, expected, rtol=0, atol=1e-12 * abs(expected).max())


@pytest.mark.parametrize("make", BODIES.values(), ids=BODIES)
def test_a_pressure_is_the_sum_of_following_nodal_forces_on_the_undeformed_body(make: Any) -> None:
    body = make()
    scene, arm = scene_of(6, body)
    scene.add_pressure(arm, "side", lambda t: 2.0 + t)
    nodal, other = scene_of(6, body)
    _, normals = side_forces(body.nodes, body.components)
    for node, normal in enumerate(normals):
        nodal.add_force(other.node(node), lambda t, n=normal: (2.0 + t) * n, follows=True)
    ours, theirs = scene.freeze(), nodal.freeze()
    q, u = random_state(ours, 3)
    deformed = q.copy()
    q[ours.bodies[1].flexible.eta] = 0.0
    _, F = assemble(State(ours, 0.2, q, u))
    _, expected = assemble(State(theirs, 0.2, q, u))
    np.testing.assert_allclose(F, expected, rtol=0, atol=1e-12 * abs(expected).max())
    # and it stays so when the body deforms: the load itself does not depend on eta
    bare = scene_of(6, body)[0].freeze()
    still = np.zeros_like(u)
    with_load, without = (joint_reactions(State(model, 0.2, deformed, u), still)[1] for model in (ours, bare))
    pattern = body.load_pattern("side")
    resultant = 2.2 * np.concatenate((pattern.pressure_force, pattern.pressure_moment))
    np.testing.assert_allclose(without - with_load, resultant, rtol=0, atol=1e-12 * abs(without).max())


@pytest.mark.parametrize("make", BODIES.values(), ids=BODIES)
def test_a_pressure_that_follows_its_surface_changes_with_the_coordinates(make: Any) -> None:
    body = make()
    model, size = body.load_pattern("side"), len(body.nodes) * len(body.components)
    scene, arm = scene_of(6, body)
    scene.add_pressure(arm, "side", 2.0, follows=True)
    fixed, other = scene_of(6, body)
    fixed.add_pressure(other, "side", 2.0)
    ours, theirs = scene.freeze(), fixed.freeze()
    q, u = random_state(ours, 3)
    terms = ours.bodies[1].flexible
    eta = q[terms.eta]
    change = any_change(size).over(np.eye(size))
    moved = 2.0 * (change @ (body.basis[:, : body.free_count] @ eta))
    states = [State(one, T, q, u) for one in (ours, theirs)]
    (_, with_change), (_, without) = (assemble(state) for state in states)
    G = states[0].motions[1]
    expected = G.V.T @ moved[:3] + G.W.T @ moved[3:6]
    expected[terms.speeds] += body.basis[:, : body.free_count].T @ moved[6:]
    np.testing.assert_allclose(with_change - without, expected, rtol=0, atol=1e-12 * abs(with_change).max())
    rates = [joint_reactions(state, np.zeros_like(u))[1] for state in states]
    np.testing.assert_allclose(rates[1] - rates[0], moved[:6], rtol=0, atol=1e-12 * abs(rates[0]).max())
    wanted = np.vstack((change[:6] @ body.basis, body.basis.T @ (change[6:] @ body.basis)))
    np.testing.assert_allclose(model.pressure_change, wanted, atol=1e-13 * abs(wanted).max())


def loaded(seed: int, body: kf.FlexibleBody) -> kf.System:
    scene, arm = scene_of(seed, body)
    scene.add_traction(arm, "side", lambda t: np.array([0.3, 0.1 + t, -0.2]))
    scene.add_traction(arm, "side", (0.2, -0.3, 0.1), follows=True)
    scene.add_line_load(arm, "edge", (0.2, 0.3, -0.1))
    scene.add_pressure(arm, "side", lambda t: 0.4 * np.cos(t))
    scene.add_pressure(arm, "side", lambda t: 0.1 * np.sin(t), follows=True)
    return scene


EXACT = [name for name in BODIES if name != "nodes that rotate"]  # the nodal form of inertia does not keep energy


@pytest.mark.parametrize("make", [BODIES[name] for name in EXACT], ids=EXACT)
def test_energy_changes_by_the_power_of_the_loads(make: Any) -> None:
    model = loaded(7, make()).freeze()
    assert model.has_power
    q, u = random_state(model, 8, amplitude=0.01)
    t = 0.3
    du = accelerations(State(model, t, q, u))
    along = path(model, q, u, du)

    def energy(s: float) -> np.ndarray:
        at = along(s)
        total = (
            kinetic_energy(State(model, t, at, u + du * s))
            + elastic_energy(State(model, t, at))
            + gravity_energy(State(model, t, at))
        )
        return np.array(total)

    rate, _ = derivatives(energy, 0.001)
    # round-off 2e-16 of the energy over a step of 0.001 s; the truncation of order 8 is below it at this amplitude
    assert float(rate) == pytest.approx(load_power(State(model, t, q, u)), abs=1e-11 * (1 + abs(energy(0.0))))


def test_a_run_keeps_its_balance_of_energy() -> None:
    result = loaded(7, patterned(1, reduction=kf.CraigBampton(modes=3))).simulate((0.0, 2.0), rtol=1e-9)
    energy = result.energy
    total = energy.kinetic + energy.elastic + energy.gravity
    change = total - total[0] - (energy.work - energy.work[0])
    assert np.ptp(energy.work) > 0.1
    # the error per unit of the run at rtol = 1e-9
    assert abs(change).max() < 1e-6 * np.ptp(energy.work)


@pytest.mark.parametrize("name", ["unreduced", "reduced"])
def test_coupling_forces_by_both_routes_carry_the_loads(name: str) -> None:
    model = loaded(3, BODIES[name]()).freeze()
    q, u = random_state(model, 2)
    du, forces = accelerations_and_coupling_forces(State(model, 0.1, q, u))
    _, recovered = recovered_forces(State(model, 0.1, q, u), accelerations(State(model, 0.1, q, u)))
    # as in test_coupling: two factorisations of matrices with condition numbers up to some 1e4
    assert forces == pytest.approx(recovered, abs=1e-12 * abs(forces).max())
    bare = scene_of(3, BODIES[name]())[0].freeze()
    assert abs(forces - recovered_forces(State(bare, 0.1, q, u), du)[1]).max() > 1e-3 * abs(forces).max()


def test_a_load_may_depend_on_the_state() -> None:
    """A function of (t, state) acts as the constant that it gives at this state, in forces, power and reactions."""
    scene, arm = scene_of(4, patterned(1))
    scene.add_traction(arm, "side", lambda t, state: -0.5 * state.velocity("tip") + t)
    scene.add_line_load(arm, "edge", lambda t, state: 0.1 * state.position("arm", "tip"), follows=True)
    scene.add_pressure(arm, "side", lambda t, state: float(state.modal_coordinates("arm")[0]))
    model = scene.freeze()
    q, u = random_state(model, 2)
    state = State(model, T, q, u)
    fixed, other = scene_of(4, patterned(1))
    fixed.add_traction(other, "side", -0.5 * state.velocity("tip") + T)
    fixed.add_line_load(other, "edge", 0.1 * state.position("arm", "tip"), follows=True)
    fixed.add_pressure(other, "side", float(state.modal_coordinates("arm")[0]))
    same = fixed.freeze()
    du = accelerations(State(model, T, q, u))
    assert du == pytest.approx(accelerations(State(same, T, q, u)), abs=1e-13 * abs(du).max())
    assert load_power(State(model, T, q, u)) == pytest.approx(load_power(State(same, T, q, u)), rel=1e-13)
    wrenches = np.array(joint_reactions(State(model, T, q, u), du))
    assert wrenches == pytest.approx(
        np.array(joint_reactions(State(same, T, q, u), du)), abs=1e-12 * abs(wrenches).max()
    )


class TestBadInput:
    def test_loads_need_a_flexible_body_of_this_scene(self) -> None:
        scene, arm = scene_of(0, patterned(0))
        hub = scene.add_rigid_body("block", 1.0, 0.1, joint=kf.Free())
        with pytest.raises(
            ModelError, match=r"the traction on 'side' of 'block': 'block' is not a flexible body.*Remedy"
        ):
            scene.add_traction(hub, "side", (0, 0, 1))  # type: ignore[arg-type]
        with pytest.raises(ModelError, match=r"'tip' of 'arm' is not a flexible body.*Remedy"):
            scene.add_pressure(arm.interface("tip"), "side", 1.0)
        with pytest.raises(ModelError, match="another system"):
            kf.System().add_pressure(arm, "side", 1.0)
        with pytest.raises(ModelError, match=r"the pressure on 'side' of 3"):
            scene.add_pressure(3, "side", 1.0)  # type: ignore[arg-type]

    def test_an_unknown_surface_is_named_with_those_there_are(self) -> None:
        scene, arm = scene_of(0, patterned(0))
        with pytest.raises(ModelError, match=r"the pressure on 'top' of 'arm'.*It has: side, edge\. Remedy"):
            scene.add_pressure(arm, "top", 1.0)
        bare, other = scene_of(0, flexible_body(lattice_model(0), {"root": "clamped", "tip": "rigid"}))
        with pytest.raises(ModelError, match=r"It has: none\. Remedy.*surfaces="):
            bare.add_traction(other, "top", (0, 0, 1))

    def test_a_pressure_follows_no_surface_whose_change_is_not_known(self) -> None:
        scene, arm = scene_of(0, patterned(0))
        with pytest.raises(ModelError, match="a line without an outside has no pressure"):
            scene.add_pressure(arm, "edge", 1.0, follows=True)
        with pytest.raises(ModelError, match="follows= of add_pressure must be True or False"):
            scene.add_pressure(arm, "side", 1.0, follows=1)  # type: ignore[arg-type]
        model = lattice_model(0)
        bare = NodalPattern.of_nodes(model.nodes, model.components, *side_forces(model.nodes, model.components))
        body = flexible_body(replace(model, load_patterns={"side": bare}), {"root": "clamped", "tip": "rigid"})
        scene, arm = scene_of(0, body)
        with pytest.raises(ModelError, match=r"the pressure on 'side' of 'arm' cannot follow its surface.*Remedy"):
            scene.add_pressure(arm, "side", 1.0, follows=True)

    def test_a_line_is_no_surface(self) -> None:
        scene, arm = scene_of(0, patterned(0))
        with pytest.raises(ModelError, match="Remedy: add_line_load"):
            scene.add_traction(arm, "edge", (0, 0, 1))
        with pytest.raises(ModelError, match="Remedy: add_traction"):
            scene.add_line_load(arm, "side", (0, 0, 1))
        with pytest.raises(ModelError, match="a line without an outside has no pressure"):
            scene.add_pressure(arm, "edge", 1.0)

    @pytest.mark.parametrize("value", [(1, 2), 3.0, "x", (1, 2, np.nan)])
    def test_a_traction_is_three_numbers(self, value: Any) -> None:
        scene, arm = scene_of(0, patterned(0))
        with pytest.raises(ModelError, match="the traction on 'side' of 'arm' must be three finite numbers"):
            scene.add_traction(arm, "side", value)

    @pytest.mark.parametrize("value", [(1, 2, 3), "x", np.inf, None])
    def test_a_pressure_is_one_number(self, value: Any) -> None:
        scene, arm = scene_of(0, patterned(0))
        with pytest.raises(ModelError, match="the pressure on 'side' of 'arm' must be one finite number"):
            scene.add_pressure(arm, "side", value)

    @pytest.mark.parametrize("value", [np.nan, (1.0, 2.0)])
    def test_a_function_that_fails_is_named_with_the_time(self, value: Any) -> None:
        for add in ("add_traction", "add_pressure"):
            scene, arm = scene_of(0, patterned(0))
            getattr(scene, add)(arm, "side", lambda t: value)
            model = scene.freeze()
            with pytest.raises(ModelError, match=r"on 'side' of 'arm' must give .* at t = 0\.25 s"):
                assemble(State(model, 0.25, model.initial_coordinates, model.initial_speeds))

    def test_a_function_of_other_things_is_refused(self) -> None:
        scene, arm = scene_of(0, patterned(0))
        with pytest.raises(ModelError, match=r"the pressure on 'side' of 'arm' must be a function of time"):
            scene.add_pressure(arm, "side", lambda a, b, c: 0.0)

    def test_a_frozen_scene_takes_no_loads(self) -> None:
        scene, arm = scene_of(0, patterned(0))
        scene.freeze()
        with pytest.raises(ModelError, match="the scene was frozen"):
            scene.add_pressure(arm, "side", 1.0)


class TestGivenMatrices:
    def given(self, pattern: Any) -> kf.FiniteElementModel:
        model = lattice_model(0)
        return model_from_matrices(model.mass, model.stiffness, model.nodes, load_patterns={"side": pattern})

    def test_a_pattern_comes_through_to_the_body(self) -> None:
        model = lattice_model(0)
        shares, normals = side_forces(model.nodes, model.components)
        pattern = NodalPattern.of_nodes(model.nodes, model.components, shares, normals)
        given = replace(self.given(pattern), groups={"root": NodeGroup(np.arange(3), model.nodes[:3].mean(axis=0))})
        found = flexible_body(given, {"root": "clamped"}).load_pattern("side")
        np.testing.assert_allclose(
            found.shape_first, pattern.traction.T @ flexible_body(given, {"root": "clamped"}).basis
        )
        assert found.measure == pytest.approx(shares.sum())

    def test_a_pattern_of_other_nodes_is_refused(self) -> None:
        model = lattice_model(0)
        shares, normals = side_forces(model.nodes, model.components)
        pattern = NodalPattern.of_nodes(model.nodes, model.components, shares, normals)
        with pytest.raises(ModelError, match="load pattern 'side' have another resultant"):
            self.given(replace(pattern, traction=np.roll(pattern.traction, 3, axis=0)))
        with pytest.raises(ModelError, match="load pattern 'side' have another resultant"):
            self.given(replace(pattern, pressure=-pattern.pressure))
        with pytest.raises(ModelError, match=r"forces of shape \(27, 3\) and \(3,\)"):
            self.given(replace(pattern, pressure=np.zeros(3)))
        with pytest.raises(ModelError, match="must have finite forces"):
            self.given(replace(pattern, traction=np.full((27, 3), np.nan)))
        with pytest.raises(ModelError, match="must be a NodalPattern"):
            self.given(shares)
        with pytest.raises(ModelError, match="pressure_change of load pattern 'side' must be a PressureChange"):
            self.given(replace(pattern, pressure_change=sp.csr_matrix((27, 27))))
        with pytest.raises(ModelError, match=r"pressure_change .* shapes .*\(12, 24\).*, of 27 components"):
            self.given(replace(pattern, pressure_change=any_change(24)))
        with pytest.raises(ModelError, match="does not turn the resultant of load pattern 'side' with the body"):
            self.given(replace(pattern, pressure_change=any_change(27)))


def test_a_file_of_the_version_before_is_refused(tmp_path: Any) -> None:
    path = tmp_path / "arm.npz"
    patterned(0).save(str(path))
    with np.load(path) as file:
        arrays = dict(file)
    header = json.loads(str(arrays.pop("header"))) | {"version": 2}
    np.savez(path, header=np.array(json.dumps(header)), **arrays)
    with pytest.raises(FileError, match=r"has format version 2, this kanefe reads version 4\. Remedy: make the body"):
        kf.FlexibleBody.load(str(path))
