"""Unreduced bodies in sparse matrices against the same bodies in dense ones, which the literal route treats."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp

import kanefe as kf
import kanefe.reduction.build as reduction_body
from kanefe.bodies.inertia_field import Selection
from kanefe.bodies.unreduced import UnreducedBody
from kanefe.equations.model import Model
from kanefe.errors import FileError, ModelError, SimulationError, SimulationWarning
from kanefe.fe_model.factorise import splu_factorise
from kanefe.fe_model.model import FiniteElementModel
from kanefe.integrate.trajectory import Trajectory
from kanefe.kane.assemble import accelerations
from kanefe.reduction import flexible_body
from kanefe.result import Result
from kanefe.scene.scene import FlexibleMember
from kanefe.states.state import State
from kanefe.tree.tangents import constant_tangents
from kanefe.unreduced.bordered import Bordered
from kanefe.unreduced.mass_solver import MassSolver
from kanefe.unreduced.route import UnreducedRoute
from kanefe_fem.beams.body import straight_beam
from kanefe_fem.beams.sections import Tube
from kanefe_fem.materials.isotropic import Material

ALUMINIUM = Material(E=70e9, nu=0.33, rho=2700.0)
TUBE = Tube(0.04, 0.002)
HELD = {"root": "clamped", "tip": "rigid"}


def beam(elements: int = 3, length: float = 1.0) -> FiniteElementModel:
    return straight_beam(length, TUBE, ALUMINIUM, elements=elements)


def body_of(model: FiniteElementModel, interfaces: dict, is_sparse: bool, monkeypatch, **options) -> kf.FlexibleBody:
    monkeypatch.setattr(reduction_body, "LARGEST_DENSE", 0 if is_sparse else 10**6)
    body = flexible_body(model, interfaces, **options)
    assert isinstance(body, UnreducedBody) == is_sparse
    return body


def carrying(make: Callable[..., kf.FlexibleBody]) -> kf.System:
    """Return a hub with an arm, whose tip carries a body and which a spring and a force hold at a node."""
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    hub = scene.add_rigid_body("hub", 1.0, 0.02, joint=kf.Revolute("z"))
    arm = scene.add_flexible_body("arm", make(beam(), HELD), parent=hub, at=(0.1, 0, 0), joint=kf.Revolute("y"))
    scene.add_rigid_body("tip", 0.5, (0.01, 0.02, 0.03), parent=arm.interface("tip"), com=(0.1, 0.05, 0.0))
    scene.add_spring("spring", arm.node(2), scene.ground, stiffness=100.0, damping=3.0, rest_length=0.2)
    scene.add_force(arm.interface("tip"), lambda t, state: (1.0, 2.0, state.position("arm", "tip")[0]))
    return scene


def two_in_a_chain(make: Callable[..., kf.FlexibleBody]) -> kf.System:
    """Return a floating arm that carries another one, with Rayleigh damping in both, and a motor between."""
    scene = kf.System(gravity=(1.0, 0.0, -9.81))
    damping = kf.RayleighDamping(0.3, 1e-4)
    one = scene.add_flexible_body(
        "one", make(beam(), {"tip": "rigid"}, damping=damping), joint=kf.Free(angular_velocity=(1.0, 2.0, 0.5))
    )
    two = scene.add_flexible_body(
        "two", make(beam(2, 0.7), HELD, damping=damping), parent=one.interface("tip"), joint=kf.Revolute("z")
    )
    scene.add_motor(two, lambda t: 3.0 * np.cos(t))
    return scene


def driven_bridge(make: Callable[..., kf.FlexibleBody]) -> kf.System:
    """Return an arm held at both ends, once in part, on a driven joint: coupling forces are not statically known."""
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    swing = kf.Motion(
        lambda t: 0.3 * np.sin(2.0 * t), lambda t: 0.6 * np.cos(2.0 * t), lambda t: -1.2 * np.sin(2.0 * t)
    )
    hub = scene.add_rigid_body("hub", 1.0, 0.1, joint=kf.Revolute("z", motion=swing))
    ends = {"root": "clamped", "tip": kf.Interface(fixed=("y", "z", "rx"))}
    scene.add_flexible_body("arm", make(beam(), ends, damping=kf.RayleighDamping(0.2, 1e-4)), parent=hub)
    return scene


def loop(make: Callable[..., kf.FlexibleBody]) -> kf.System:
    """Return a four-bar mechanism whose coupler is an unreduced body, closed at its tip."""
    scene = kf.System(gravity=(0.0, -9.81, 0.0))
    crank = scene.add_rigid_body(
        "crank", 0.5, 0.01, com=(0.1, 0, 0), joint=kf.Revolute("z", position=np.pi / 2, speed=4.0)
    )
    coupler = scene.add_flexible_body(
        "coupler", make(beam(), HELD), parent=crank, at=(0.2, 0, 0), joint=kf.Revolute("z", position=-np.pi / 2)
    )
    rocker = scene.add_rigid_body(
        "rocker", 0.5, 0.01, at=(1.0, 0, 0), com=(0.1, 0, 0), joint=kf.Revolute("z", position=np.pi / 2)
    )
    scene.add_loop_joint("pin", kf.Revolute("z"), coupler.interface("tip"), rocker.frame(at=(0.2, 0, 0)))
    return scene


SCENES = (carrying, two_in_a_chain, driven_bridge, loop)


def pair(build: Callable, monkeypatch) -> tuple[Model, Model]:
    """Return the models of a scene with sparse and with dense bodies."""
    return tuple(  # type: ignore[return-value]
        build(lambda m, i, s=is_sparse, **o: body_of(m, i, s, monkeypatch, **o)).freeze() for is_sparse in (True, False)
    )


def same_states(sparse: Model, dense: Model, count: int = 3) -> list[tuple[np.ndarray, ...]]:
    """Return random states (q, u) of both models that are the same motion; loops are opened a little."""
    rng = np.random.default_rng(5)
    states = []
    for _ in range(count):
        q, u = sparse.initial_coordinates.copy(), sparse.initial_speeds + 0.0
        q_dense, u_dense = dense.initial_coordinates.copy(), dense.initial_speeds + 0.0
        for own, other in zip(sparse.bodies, dense.bodies, strict=True):
            at, speeds = own.free_coordinates()
            at_dense, speeds_dense = other.free_coordinates()
            move = 0.3 * rng.standard_normal(len(speeds))
            if not sparse.constraints and len(at):
                q[at] = q_dense[at_dense] = own.joint.advance(q[at], move)
                u[speeds] = u_dense[speeds_dense] = rng.standard_normal(len(speeds))
            if own.flexible and other.flexible:
                body = own.flexible.body
                if sparse.constraints:
                    continue
                eta, deta = (body.centred(s * rng.standard_normal(body.free_count)) for s in (1e-2, 1.0))
                q[own.flexible.eta], u[own.flexible.speeds] = eta, deta
                basis, k = other.flexible.body.basis, other.flexible.body.free_count
                nodal = body.basis[:, : body.free_count]
                q_dense[other.flexible.eta] = np.linalg.lstsq(basis[:, :k], nodal @ eta, rcond=None)[0]
                u_dense[other.flexible.speeds] = np.linalg.lstsq(basis[:, :k], nodal @ deta, rcond=None)[0]
        states.append((q, u, q_dense, u_dense))
    return states


def nodal_rates(model: Model, du: np.ndarray) -> list[np.ndarray]:
    """Return joint rates, and the nodal rates of flexible bodies, whatever their coordinates."""
    found = []
    for body in model.bodies:
        found.append(du[body.free_coordinates()[1]])
        if body.flexible:
            k = body.flexible.body.free_count
            found.append(np.asarray(body.flexible.body.basis[:, :k] @ du[body.flexible.speeds]))
    return found


@pytest.mark.parametrize("build", SCENES)
def test_accelerations_are_those_of_the_dense_body(build, monkeypatch):
    sparse, dense = pair(build, monkeypatch)
    scene = UnreducedRoute(sparse)
    for q, u, q_dense, u_dense in same_states(sparse, dense):
        found = nodal_rates(sparse, scene.accelerations(0.7, q, u))
        wanted = nodal_rates(dense, accelerations(State(dense, 0.7, q_dense, u_dense)))
        for own, other in zip(found, wanted, strict=True):
            # K eta of 1e-2 m is 1e9 N/kg: round-off of the dense solve in the highest modes
            assert abs(own - other).max(initial=0.0) <= 1e-8 * max(abs(other).max(initial=0.0), 1.0)


CHANNELS = (
    ("position", "velocity", "acceleration", "rotation", "angular_velocity", "angular_acceleration"),
    ("center_of_mass", "joint_reaction", "coupling_force", "driving_force", "loop_force", "deflection"),
    ("kinetic_energy", "elastic_energy", "gravity_energy", "linear_momentum", "angular_momentum"),
)


@pytest.mark.parametrize("build", SCENES)
def test_results_are_those_of_the_dense_body(build, monkeypatch):
    sparse, dense = pair(build, monkeypatch)
    scene = UnreducedRoute(sparse)
    states = same_states(sparse, dense)
    times = np.full(len(states), 0.7 if not sparse.constraints else 0.0)
    zero = np.zeros(len(times))
    own_q, own_u, q, u = (np.array(values) for values in zip(*states, strict=True))
    own_du = np.array([scene.accelerations(t, *state[:2]) for t, state in zip(times, states, strict=True)])
    own = Result(sparse, Trajectory(times, own_q, own_u, zero, zero, {}, own_du))
    other = Result(dense, Trajectory(times, q, u, zero, zero, {}))
    for quantity in (name for names in CHANNELS for name in names):
        for name, interface in places(own, quantity):
            found, wanted = (r.read(quantity, name, interface) for r in (own, other))
            size = max(abs(other.read(quantity, *place)).max() for place in places(own, quantity))
            # K eta of 1e-2 m is 1e9 N/kg: round-off of the dense solve in the highest modes
            assert abs(found - wanted).max() <= 1e-7 * max(size, 1e-9), (quantity, name, interface)
    for name in own.bodies:
        if own.body(name).is_flexible:
            moved = [r.nodal_displacements(name) for r in (own, other)]
            assert abs(moved[0] - moved[1]).max() < 1e-12


def places(result: Result, quantity: str) -> list[tuple[str, str | None]]:
    """Return what a quantity is of: bodies, interfaces, loops, or the scene."""
    if quantity.endswith(("energy", "momentum")):
        return [("", None)]
    if quantity == "loop_force":
        return [(name, None) for name in result.loops]
    if quantity == "driving_force":
        return [(name, None) for name in result.bodies if result.body(name).is_driven]
    own = [(name, None) for name in result.bodies]
    seen = [(name, interface) for name in result.bodies for interface in result.interfaces(name)]
    if quantity in ("joint_reaction", "center_of_mass"):
        return own
    return seen if quantity in ("coupling_force", "deflection") else own + seen


def hinged(body: kf.FlexibleBody, **start: float) -> kf.System:
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    scene.add_flexible_body("arm", body, joint=kf.Revolute("y", **start))
    return scene


class Counted:
    """A factorisation that counts."""

    def __init__(self) -> None:
        self.made, self.solves, self.columns = 0, 0, 0

    def __call__(self, matrix):
        self.made += 1
        inner = splu_factorise(matrix)
        counter = self

        class Factors:
            def solve(self, b: np.ndarray) -> np.ndarray:
                counter.solves += b.ndim == 1
                counter.columns += b.shape[1] if b.ndim == 2 else 0
                return inner.solve(b)

        return Factors()


def test_matrices_are_factored_once_per_step_size_and_solved_once_per_iteration(monkeypatch):
    counted = Counted()
    body = body_of(beam(), HELD, True, monkeypatch, factorise=counted)
    result = hinged(body, speed=1.0).simulate((0.0, 1.0), rtol=1e-4, output_step=0.01)
    done = result.statistics
    assert counted.made == done["factorisations"] < 0.1 * done["steps"]
    # one solve for each iteration and for each error estimate; a border of six columns for each factorisation
    assert counted.solves <= done["iterations"] + done["steps"] + done["rejected"] + 2
    assert counted.columns == 6 * counted.made
    assert done["iterations"] < 2.2 * done["steps"]


@pytest.mark.parametrize("method", ["generalised-alpha", "hht"])
def test_motion_converges_to_that_of_the_dense_body(method, monkeypatch):
    """An arm swings with a body at its tip: the same method, with the dense body and its own step control."""
    soft = straight_beam(1.0, TUBE, Material(E=1e9, nu=0.33, rho=2700.0), elements=1)
    ends = []
    for is_sparse, rtol in ((False, 1e-7), (True, 1e-4), (True, 1e-7)):
        body = body_of(soft, HELD, is_sparse, monkeypatch)
        scene = hinged(body, speed=1.0)
        tip = FlexibleMember(scene, 0, "arm", body=body).interface("tip")
        scene.add_rigid_body("load", 0.5, 1e-3, parent=tip, com=(0.1, 0.05, 0.0))
        options: dict[str, Any] = {"method": method, "output_step": 0.05, "rtol": rtol}
        result = scene.simulate((0.0, 0.2), **options)
        ends.append(result.position("load"))
        assert result.statistics["method"] == method
    errors = [abs(end - ends[0]).max() for end in ends[1:]]
    assert errors[0] < 1e-3  # m, of a swing of 0.3 m: the tolerance is that of one step
    assert errors[1] < 1e-5


@pytest.mark.parametrize("method", ["generalised-alpha", "hht"])
def test_fixed_steps_are_those_of_the_dense_body(method, monkeypatch):
    """The same formula in compiled code, with the dense body: both iterate to a thousandth of 1e-7 of the size."""
    soft = straight_beam(1.0, TUBE, Material(E=1e9, nu=0.33, rho=2700.0), elements=1)
    ends = []
    for is_sparse in (False, True):
        body = body_of(soft, HELD, is_sparse, monkeypatch)
        scene = hinged(body, speed=1.0)
        tip = FlexibleMember(scene, 0, "arm", body=body).interface("tip")
        scene.add_rigid_body("load", 0.5, 1e-3, parent=tip, com=(0.1, 0.05, 0.0))
        result = scene.simulate((0.0, 0.2005), method=method, step=1e-3, output_step=0.05)
        ends.append(result.position("load"))
        assert result.statistics["steps"] == 201  # the last one is half as long
    # the dense body begins with a delay of the accelerations, which the other one has not: of order 2, as the method is
    assert abs(ends[1] - ends[0]).max() < 2e-5


def test_a_fixed_step_that_is_too_long_is_told(monkeypatch):
    body = body_of(beam(), HELD, True, monkeypatch)
    with pytest.warns(SimulationWarning, match=r"does not converge with steps of 5 s.*a smaller step, or rtol instead"):
        hinged(body, speed=50.0).simulate((0.0, 20.0), method="generalised-alpha", step=5.0, output_step=5.0)


def test_free_flight_keeps_energy_and_momenta(monkeypatch):
    body = body_of(beam(), {"tip": "rigid"}, True, monkeypatch)
    scene = kf.System()
    scene.add_flexible_body("arm", body, joint=kf.Free(velocity=(1, 0, 0), angular_velocity=(3.0, 2.0, 1.0)))
    result = scene.simulate((0.0, 0.5), rtol=1e-7, output_step=0.05)
    total = result.energy.kinetic + result.energy.elastic
    # steps of 2 ms and turns of 4 rad/s: the method of order 2 keeps them to h^2 w^2
    assert abs(total / total[0] - 1).max() < 2e-5
    angular = result.momentum.angular
    assert abs(angular - angular[0]).max() < 5e-5 * abs(angular).max()
    linear = result.momentum.linear
    assert abs(linear - linear[0]).max() < 2e-5 * abs(linear).max()
    # G follows the mean motion: its coordinates keep out of the rigid ones
    eta = result.modal_coordinates("arm")
    assert abs(eta @ body.mean_motions.T).max() < 1e-9 * abs(body.mean_motions).max()


def test_energy_balance_with_loads_and_damping(monkeypatch):
    scene = carrying(lambda m, i, **o: body_of(m, i, True, monkeypatch, damping=kf.RayleighDamping(0.1, 1e-5), **o))
    result = scene.simulate((0.0, 0.3), rtol=1e-6, output_step=0.03)
    energy = result.energy
    given = energy.work - energy.work[0]
    assert abs(energy.balance_error).max() < 2e-4 * max(abs(given).max(), np.ptp(energy.kinetic))


def test_loop_stays_closed(monkeypatch):
    scene = loop(lambda m, i, **o: body_of(m, i, True, monkeypatch, **o))
    report = scene.start_report()
    assert [(one.body, one.value) for one in report.speeds if one.origin == "given"] == [("crank", 4.0)]
    assert (report.mended, report.bodies[0].largest_speed, report.elastic_energy) == ((), 0.0, 0.0)
    assert max(abs(row.rate) for row in report.rows) < 1e-12
    assert max(abs(row.acceleration) for row in report.rows) < 1e-9  # of 16 1/s2, by stiff modes
    result = scene.simulate((0.0, 0.2), rtol=1e-5, output_step=0.02)
    angle = result.joint_coordinates("rocker")[:, 0]
    end = np.column_stack((1.0 + 0.2 * np.cos(angle), 0.2 * np.sin(angle), 0 * angle))
    assert abs(result.position("coupler", "tip") - end).max() < 1e-9
    energy = result.energy
    assert abs(energy.balance_error).max() < 1e-3 * np.ptp(energy.kinetic)


def test_matrices_of_nodes_that_rotate(monkeypatch):
    """The nodal form, of which only M at the nodes is known, as the literal route has it."""
    from dataclasses import replace

    nodal = replace(beam(), mass_field=None)
    sparse, dense = (hinged(body_of(nodal, HELD, is_sparse, monkeypatch)).freeze() for is_sparse in (True, False))
    for q, u, q_dense, u_dense in same_states(sparse, dense):
        found = sparse.rhs(0.0, np.concatenate((q, u)))[len(q) :]
        wanted = accelerations(State(dense, 0.0, q_dense, u_dense))
        assert abs(found - wanted).max() < 1e-8 * abs(wanted).max()


def test_what_a_model_offers(monkeypatch):
    sparse, dense = pair(two_in_a_chain, monkeypatch)
    q, u, q_dense, u_dense = same_states(sparse, dense, 1)[0]
    y, y_dense = np.concatenate((q, u)), np.concatenate((q_dense, u_dense))
    for own, other in zip(sparse.energy(0.0, y), dense.energy(0.0, y_dense), strict=True):
        assert abs(own - other) < 1e-9 * max(abs(other), 1.0)
    for name, wrench in dense.joint_reactions(0.0, y_dense).items():
        assert abs(sparse.joint_reactions(0.0, y)[name] - wrench).max() < 1e-6 * abs(wrench).max() + 1e-6
    own, other = sparse.kinematics("two", 0.0, y, "tip"), dense.kinematics("two", 0.0, y_dense, "tip")
    assert abs(own.position - other.position).max() < 1e-12
    assert abs(own.partial_velocities @ u - own.velocity).max() < 1e-12 * abs(own.velocity).max()
    for refused in (lambda: sparse.mass_matrix(0.0, y), lambda: sparse.forces(0.0, y), lambda: sparse.jacobian(0.0, y)):
        with pytest.raises(ModelError, match="Remedy"):
            refused()


def test_mass_properties_and_frequencies(monkeypatch):
    for ends in (HELD, {"tip": "rigid"}, {}):
        sparse, dense = (body_of(beam(6), ends, is_sparse, monkeypatch) for is_sparse in (True, False))
        assert sparse.mass == pytest.approx(dense.mass, rel=1e-12)
        assert abs(sparse.center_of_mass - dense.center_of_mass).max() < 1e-12
        assert abs(sparse.inertia - dense.inertia).max() < 1e-12
        count = len(sparse.frequencies)
        # the shift and the inverse of eigsh leave some 1e-9
        assert abs(sparse.frequencies / dense.frequencies[:count] - 1).max() < 1e-7


def test_bad_input(monkeypatch, tmp_path):
    body = body_of(beam(), HELD, True, monkeypatch)
    for method in ("dop853", "rk4"):
        with pytest.raises(ModelError, match="generalised-alpha"):
            hinged(body).simulate((0.0, 1.0), method=method, **({"step": 0.1} if method == "rk4" else {}))
    with pytest.raises(ModelError, match="RayleighDamping"):
        body_of(beam(), HELD, True, monkeypatch, damping=kf.ModalDamping(0.01))
    with pytest.raises(FileError, match="Remedy"):
        body.save(str(tmp_path / "arm.npz"))
    monkeypatch.setattr("kanefe.unreduced.route.LARGEST_STORE", 10_000)
    with pytest.raises(ModelError, match="output_step"):
        hinged(body).simulate((0.0, 1.0))
    monkeypatch.undo()
    body = body_of(beam(), HELD, True, monkeypatch)
    scene = hinged(body)
    scene.add_motor(FlexibleMember(scene, 0, "arm", body=body), lambda t, state: state.modal_coordinates("arm")[0])
    with pytest.raises(ModelError, match=r"state\.position"):
        scene.simulate((0.0, 0.1))


def test_result_file_and_views(monkeypatch, tmp_path):
    pytest.importorskip("h5py")
    body = body_of(beam(), HELD, True, monkeypatch)
    result = hinged(body).simulate((0.0, 0.01), rtol=1e-4, output_step=0.005)
    result.save(tmp_path / "swing.h5")
    again = kf.load_result(tmp_path / "swing.h5")
    assert abs(again.nodal_displacements("arm") - result.nodal_displacements("arm")).max() < 1e-15
    assert result.to_vtk(tmp_path / "swing.pvd").is_file()
    monkeypatch.setattr("kanefe.results.saved_shapes.LARGEST_BASIS", 100)
    with pytest.raises(ModelError, match="Remedy"):
        result.save(tmp_path / "large.h5")
    assert not (tmp_path / "large.h5").exists()


def test_selection_is_the_matrix_it_is_made_of():
    rng = np.random.default_rng(2)
    dense = np.eye(6)[[3, 0, 0, 5, 1, 2, 4]]  # a column that two rows pick
    dense[1], dense[6] = rng.standard_normal(6), 0.0
    A = Selection(sp.csr_matrix(dense))
    x, y = rng.standard_normal(6), rng.standard_normal(7)
    assert abs(A.times(x) - dense @ x).max() < 1e-15
    assert abs(A.transposed_times(y) - dense.T @ y).max() < 1e-15


def test_border_is_the_solution_of_the_whole_system(monkeypatch):
    """The bordered equations against one dense matrix, at a step size with stiffness and damping."""
    for build in (carrying, two_in_a_chain):
        sparse, dense = pair(build, monkeypatch)
        scene = UnreducedRoute(sparse)
        q, u, q_dense, _ = same_states(sparse, dense, 1)[0]
        damping, stiffness = 1e-3, 1e-6
        at = scene.residual(0.0, q, u, 0 * u)
        n = scene.small.free_count
        bordered = Bordered(
            scene.condensed, scene.borders(q, scene.factored(damping, stiffness)), at.mass[:n, :n], at.state.motions
        )
        rng = np.random.default_rng(1)
        right = [rng.standard_normal(m.body.free_count) for m in scene.condensed.substructures]
        z = rng.standard_normal(n)
        for member in scene.condensed.substructures:
            z[member.rates] = 0.0
        solution = bordered.solve(z, right)
        found = nodal_rates(sparse, scene.condensed.joined(solution.z, solution.parts))
        M = dense.mass_matrix(0.0, np.concatenate((q_dense, np.zeros(dense.free_count))))
        K, C = constant_tangents(dense)
        for body in dense.bodies:  # of the bodies alone: the border has no joint springs here
            if body.flexible is None:
                continue
            s = body.flexible.speeds
            M[s, s] += damping * C[s, s] + stiffness * K[s, s]
        forces = np.zeros(dense.free_count)
        members = {member.number: f for member, f in zip(scene.condensed.substructures, right, strict=True)}
        for number, (own, other) in enumerate(zip(sparse.bodies, dense.bodies, strict=True)):
            at_own, at_other = own.free_coordinates()[1], other.free_coordinates()[1]
            forces[at_other] = scene.condensed.joined(z, right)[at_own]
            if other.flexible:
                basis, k = other.flexible.body.basis, other.flexible.body.free_count
                nodal = own.flexible.body.basis[:, : own.flexible.body.free_count]
                to_own = np.linalg.lstsq(nodal.toarray(), basis[:, :k], rcond=None)[0]
                forces[other.flexible.speeds] = to_own.T @ members[number]
        wanted = nodal_rates(dense, np.linalg.solve(M, forces))
        for own, other in zip(found, wanted, strict=True):
            assert abs(own - other).max(initial=0.0) <= 1e-8 * max(abs(other).max(initial=0.0), 1e-3)


def test_a_mass_matrix_without_inverse_is_refused():
    with pytest.raises(SimulationError, match="no mass"):
        MassSolver(sp.csr_matrix(np.array([[1.0, 1.0], [1.0, 1.0]]))).solve(np.array([1.0, -1.0]))
    M = sp.csr_matrix(np.array([[2.0, 0.5, 0.0], [0.5, 1.0, 0.3], [0.0, 0.3, 4.0]]))
    b = np.arange(6.0).reshape(3, 2)
    assert abs(MassSolver(M).solve(b) - np.linalg.solve(M.toarray(), b)).max() < 1e-13


def test_steps_over_vibrations_converge_where_far_corrections_are_slow(monkeypatch):
    # steps of a tenth of the run, whose first corrections are 1e4 of what is allowed
    arm = body_of(beam(), {"root": "clamped"}, True, monkeypatch, damping=kf.RayleighDamping(0.0, 3e-4))
    scene = kf.System()
    root = scene.add_flexible_body("arm", arm, joint=kf.Revolute("z", speed=1.0))
    scene.add_torque(root.interface("root"), (0.0, 0.0, -0.2))
    rough, fine = (scene.copy().simulate((0.0, 1.5), rtol=rtol) for rtol in (1e-4, 1e-6))
    assert rough.statistics["steps"] < 30
    difference = rough.joint_coordinates("arm")[-1] - fine.joint_coordinates("arm")[-1]
    assert abs(difference) < 1e-3  # rad: ten steps' tolerance
