"""Ties: averages, axes, released components, virtual nodes, against dense linear algebra."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse as sp

import kanefe as kf
from kanefe.errors import ModelError
from kanefe.fe_model.averaging import moment_free_columns
from kanefe.fe_model.model import FiniteElementModel, NodeGroup, rigid_motion
from kanefe.fe_model.ties import tie_interfaces
from kanefe.frames import euler_parameters_from_matrix, rotation_matrix
from kanefe.kane.assemble import accelerations
from kanefe.reduction import flexible_body
from kanefe.states.state import State
from kanefe.tree.scene_state import SceneState
from scenes import lattice_body, lattice_model, random_state

TURN = rotation_matrix(np.array([0.8, 0.3, -0.4, 0.33]))
ABOUT_Z = rotation_matrix(np.array([0.9, 0.0, 0.0, 0.3]))
POSITION = (1.3, -0.2, 0.4)
SPECS = {
    "rigid": kf.Interface(),
    "rigid, off the mesh": kf.Interface(position=POSITION, axes=TURN),
    "average": kf.Interface(kind="average"),
    "average by mass": kf.Interface(kind="average", weights="mass", axes=TURN),
    "average by numbers, off the mesh": kf.Interface(kind="average", weights=(1, 2, 3, 1), position=POSITION),
    "rigid across z": kf.Interface(released=("x", "y"), axes=TURN),
    "average across z": kf.Interface(kind="average", released=("x", "y"), axes=TURN),
}


def four_node_tip(**options: object) -> FiniteElementModel:
    """Return a lattice whose group "end" has four nodes, and "pair" two others."""
    model = lattice_model(3, interior=4, **options)
    n = len(model.nodes)
    groups = {"end": np.array([n - 4, n - 3, n - 2, n - 1]), "pair": np.array([3, 4])}
    return replace(
        model,
        groups={**model.groups, **{name: NodeGroup(g, model.nodes[g].mean(axis=0)) for name, g in groups.items()}},
    )


def weights_of(model: FiniteElementModel, spec: kf.Interface, nodes: np.ndarray) -> np.ndarray:
    """Return the dense weight matrix of an average over the components of its nodes in G."""
    dofs = (nodes[:, None] * 3 + np.arange(3)).ravel()
    if spec.weights == "mass":
        return model.mass.toarray()[np.ix_(dofs, dofs)]
    return np.kron(np.diag(np.ones(len(nodes)) if spec.weights is None else spec.weights), np.eye(3))


@pytest.mark.parametrize("spec", SPECS.values(), ids=SPECS)
def test_rigid_motions_obey_every_tie(spec: kf.Interface) -> None:
    model = four_node_tip()
    ties = tie_interfaces(model, {"root": "rigid", "end": spec})
    rigid = model.rigid_modes(about=(0.3, -0.1, 0.2))
    tied = ties.coordinates(rigid)
    assert ties.transformation @ tied == pytest.approx(rigid, abs=1e-12)
    end = ties.ties[1]
    # the frame moves as a point of the rigid body does, seen along its own axes
    moved = rigid_motion(end.position[None], (0.3, -0.1, 0.2), ("x", "y", "z", "rx", "ry", "rz"))
    along = np.kron(np.eye(2), spec.rotation.T) @ moved
    assert tied[end.rows] == pytest.approx(along[list(end.components)], abs=1e-12)


@pytest.mark.parametrize("spec", SPECS.values(), ids=SPECS)
def test_tied_coordinates_are_read_back(spec: kf.Interface) -> None:
    ties = tie_interfaces(four_node_tip(), {"root": "rigid", "end": spec})
    x = np.random.default_rng(1).standard_normal((ties.transformation.shape[1], 3))
    assert ties.coordinates(ties.transformation @ x) == pytest.approx(x, abs=1e-12)


@pytest.mark.parametrize("name", [name for name in SPECS if name.startswith("average") and "across" not in name])
def test_an_average_is_the_rigid_motion_closest_to_the_nodes(name: str) -> None:
    model, spec = four_node_tip(), SPECS[name]
    ties = tie_interfaces(model, {"root": "rigid", "end": spec})
    end = ties.ties[1]
    x = np.random.default_rng(2).standard_normal(ties.transformation.shape[1])
    moved = (ties.transformation @ x).reshape(-1, 3)[end.nodes].ravel()
    half = scipy.linalg.cholesky(weights_of(model, spec, end.nodes))
    R = rigid_motion(model.nodes[end.nodes], end.position)
    closest = np.linalg.lstsq(half @ R, half @ moved, rcond=None)[0]
    # the conditioning of the fit of a patch 0.5 m wide about a point 0.6 m off it is below 100
    assert end.directions @ x[end.rows] == pytest.approx(closest, abs=1e-12)


def test_an_average_by_mass_counts_the_rotations_of_nodes() -> None:
    model = four_node_tip(rotations=True)
    ties = tie_interfaces(model, {"end": kf.Interface(kind="average", weights="mass", axes=TURN)})
    end = ties.ties[0]
    dofs = (end.nodes[:, None] * 6 + np.arange(6)).ravel()
    M, R = (
        model.mass.toarray()[np.ix_(dofs, dofs)],
        rigid_motion(model.nodes[end.nodes], end.position, model.components),
    )
    x = np.random.default_rng(4).standard_normal(model.size)
    mean = np.linalg.solve(R.T @ M @ R, R.T @ M @ (ties.transformation @ x)[dofs])
    assert end.directions @ x[end.rows] == pytest.approx(mean, abs=1e-12)


def test_unit_motion_of_each_fixed_component_is_along_its_axis() -> None:
    support = {"root": kf.Interface(("x", "y", "rx"), axes=TURN), "tip": kf.Interface(("x", "z", "ry"), axes=TURN.T)}
    scene = kf.System()
    scene.add_flexible_body("arm", lattice_body(2, support))
    terms = scene.freeze().flexible_terms("arm")
    for frame in terms.body.interfaces:
        rigid = rigid_motion(frame.position[None], (0.0, 0.0, 0.0), ("x", "y", "z", "rx", "ry", "rz"))
        moved = np.kron(np.eye(2), frame.axes.T) @ (rigid @ terms.fixed_rigid + frame.motion @ terms.fixed_elastic)
        columns = [column - terms.body.free_count for column in frame.fixed_columns]
        expected = np.eye(terms.body.fixed_count)[columns]
        assert moved[list(frame.fixed_components)] == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("weights", [None, "mass", (1.0, 0.5, 2.0, 0.0)])
def test_an_average_adds_no_stiffness_and_no_mass(weights: object) -> None:
    model = four_node_tip()
    ties = tie_interfaces(model, {"end": kf.Interface(kind="average", weights=weights, position=POSITION, axes=TURN)})
    T = ties.transformation.toarray()
    assert T.shape == (model.size, model.size)
    K, M = ties.project(model.stiffness).toarray(), ties.project(model.mass).toarray()
    expected = scipy.linalg.eigvalsh(model.stiffness.toarray(), model.mass.toarray())
    # T of a frame 0.6 m off a patch 0.5 m wide has a condition number of about 10
    assert scipy.linalg.eigvalsh(K, M) == pytest.approx(expected, abs=1e-11 * expected[-1])


def test_clamped_average_is_what_multipliers_give() -> None:
    model = four_node_tip()
    spec = kf.Interface("all", kind="average", weights="mass")
    body = flexible_body(model, {"end": spec})
    nodes = model.groups["end"].nodes
    R = rigid_motion(model.nodes[nodes], model.groups["end"].position)
    held = np.zeros((6, model.size))
    held[:, (nodes[:, None] * 3 + np.arange(3)).ravel()] = R.T @ weights_of(model, spec, nodes)
    Z = scipy.linalg.null_space(held)
    squares = scipy.linalg.eigvalsh(Z.T @ model.stiffness @ Z, Z.T @ model.mass @ Z)
    assert body.frequencies == pytest.approx(np.sqrt(squares) / (2 * np.pi), rel=1e-9)
    rigid = flexible_body(model, {"end": "clamped"})
    assert np.all(rigid.frequencies[:3] > body.frequencies[:3])  # a rigid patch is stiffer


def test_forces_on_an_average_frame_spread_to_the_nodes_with_their_resultant() -> None:
    model = four_node_tip()
    ties = tie_interfaces(model, {"root": "rigid", "end": kf.Interface(kind="average", axes=TURN, position=POSITION)})
    end, N = ties.ties[1], model.size
    wrench = np.random.default_rng(0).standard_normal(6)
    force = np.zeros(N)
    force += ties.frame_reading[end.rows - ties.interior_count].T @ wrench
    assert ties.transformation.T @ force == pytest.approx(
        np.eye(len(ties.transformation.T @ force))[end.rows].T @ wrench
    )
    resultant = model.rigid_modes(about=POSITION).T @ force
    assert np.kron(np.eye(2), TURN.T) @ resultant == pytest.approx(wrench, abs=1e-12)


def test_averages_of_three_nodes_without_room_to_deform_are_rigid() -> None:
    # a beam's node is six coordinates: nothing deviates from its mean motion
    model = lattice_model(0, rotations=True)
    ones = [
        flexible_body(model, {"root": "clamped", "middle": kf.Interface(kind=kind)}) for kind in ("rigid", "average")
    ]
    assert ones[0].frequencies == pytest.approx(ones[1].frequencies, rel=1e-12)
    assert ones[0].interface("middle").motion.shape == ones[1].interface("middle").motion.shape


@pytest.mark.parametrize("seed", range(3))
def test_a_line_of_nodes_with_rotations_has_all_six_components(seed: int) -> None:
    # two nodes do not show the turn about their line by translations: their rotations do
    model = four_node_tip(rotations=True)
    ties = tie_interfaces(model, {"pair": kf.Interface(kind="average")})
    assert ties.ties[0].components == tuple(range(6))
    rigid = model.rigid_modes(about=ties.ties[0].position)
    assert ties.coordinates(rigid)[ties.ties[0].rows] == pytest.approx(np.eye(6), abs=1e-12)


@pytest.mark.parametrize("count", [2, 5, 40, 150])
def test_deviations_are_orthonormal_without_moments_and_sparse(count: int) -> None:
    points = np.random.default_rng(count).uniform(size=(count, 3)) * [1.0, 0.3, 0.0]
    P = rigid_motion(points, (0.4, 0.1, 0.0)).T[: 5 if count == 2 else 6]
    Z = moment_free_columns(P, np.repeat(points, 3, axis=0))
    assert Z.shape == (3 * count, 3 * count - len(P))
    assert abs(P @ Z).max(initial=0.0) < 1e-13 * count
    assert (Z.T @ Z).toarray() == pytest.approx(np.eye(Z.shape[1]), abs=1e-13)
    levels = max(1.0, np.log2(3 * count / 6.0))
    assert Z.nnz <= 3 * count * 12 * levels  # a dense basis would have 9 count^2


def test_virtual_node_is_the_rigid_shift_of_the_patch() -> None:
    model = lattice_model(1)
    here, there = (
        flexible_body(model, {"root": "clamped", "tip": kf.Interface(position=place)}) for place in (None, POSITION)
    )
    tip, virtual = here.interface("tip"), there.interface("tip")
    shift = rigid_motion(np.array(POSITION)[None], tip.position, ("x", "y", "z", "rx", "ry", "rz"))
    assert there.frequencies == pytest.approx(here.frequencies, rel=1e-10)
    eta = np.linalg.lstsq(here.basis, there.basis, rcond=None)[0]  # the coordinates of one body from the other's
    assert virtual.motion == pytest.approx(shift @ tip.motion @ eta, abs=1e-10)
    assert virtual.position == pytest.approx(POSITION)


@pytest.mark.parametrize("kind", ["rigid", "average"])
@pytest.mark.parametrize("axes", [TURN, euler_parameters_from_matrix(TURN)], ids=["matrix", "Euler parameters"])
def test_components_are_fixed_along_the_axes_of_the_interface(kind: str, axes: np.ndarray) -> None:
    model = four_node_tip()
    given = {"fixed": ("x", "y", "z", "rx", "ry"), "kind": kind}
    turned = replace(
        model,
        nodes=model.nodes @ TURN,  # the same body seen from the axes of the interface
        stiffness=_turned(model.stiffness, TURN),
        mass_field=replace(model.mass_field, points=model.nodes @ TURN),
        groups={name: NodeGroup(g.nodes, g.position @ TURN) for name, g in model.groups.items()},
    )
    support = {"root": kf.Interface(("x", "y", "z"))}
    skew = flexible_body(model, {**support, "end": kf.Interface(**given, axes=axes)})
    straight = flexible_body(turned, {**support, "end": kf.Interface(**given)})
    assert skew.frequencies == pytest.approx(straight.frequencies, rel=1e-9)
    frame = skew.interface("end")
    assert frame.axes == pytest.approx(TURN, abs=1e-14)
    along = np.kron(np.eye(2), TURN.T) @ frame.motion
    assert abs(along[:5, : skew.free_count]).max() < 1e-12 * abs(along).max()
    assert abs(along[5, : skew.free_count]).max() > 1e-3 * abs(along).max()


def _turned(matrix: sp.csr_matrix, A: np.ndarray) -> sp.csr_matrix:
    turn = sp.kron(sp.identity(matrix.shape[0] // 3), A, format="csr")
    return (turn.T @ matrix @ turn).tocsr()


def test_released_components_of_the_nodes_stay_free() -> None:
    model = four_node_tip()
    spec = kf.Interface(("z", "rx", "ry"), released=("x", "y"), axes=TURN)
    body = flexible_body(model, {"root": "clamped", "end": spec})
    # by hand: the nodes of "end" keep their place along the third axis
    nodes = model.groups["end"].nodes
    held = np.zeros((4, model.size))
    for row, node in enumerate(nodes):
        held[row, 3 * node : 3 * node + 3] = TURN[:, 2]
    root = model.groups["root"].nodes
    others = np.setdiff1d(np.arange(model.size), (root[:, None] * 3 + np.arange(3)).ravel())
    Z = np.eye(model.size)[:, others] @ scipy.linalg.null_space(held[:, others])
    squares = scipy.linalg.eigvalsh(Z.T @ model.stiffness @ Z, Z.T @ model.mass @ Z)
    assert body.frequencies == pytest.approx(np.sqrt(squares) / (2 * np.pi), rel=1e-9)


def test_axes_of_a_planar_body_turn_about_z_only() -> None:
    model = lattice_model(0, planar=True)
    body = flexible_body(model, {"root": "clamped", "tip": kf.Interface(axes=ABOUT_Z)})
    assert body.interface("tip").axes == pytest.approx(ABOUT_Z)
    with pytest.raises(ModelError, match=r"axes of interface 'tip' lead out of the components x, y .* about z only"):
        flexible_body(model, {"root": "clamped", "tip": kf.Interface(axes=TURN)})


def carrying_scene(axes: np.ndarray) -> kf.System:
    """Return an arm with a rod, a force and a spring at its tip; the same scene whatever the axes of the interface."""
    body = lattice_body(2, {"root": "clamped", "tip": kf.Interface(axes=axes)})
    scene = kf.System(gravity=(0.3, -9.81, 1.0))
    arm = scene.add_flexible_body("arm", body, joint=kf.Revolute("z"))
    tip, at = arm.interface("tip"), axes.T @ [0.1, -0.05, 0.2]
    seen = euler_parameters_from_matrix(axes.T)
    rod = scene.add_rigid_body(
        "rod", 0.5, (0.1, 0.2, 0.25), parent=tip, joint=kf.Revolute("y"), com=(0.3, 0, 0.1), at=at, orientation=seen
    )
    scene.add_force(tip, axes.T @ [1.0, 2.0, 3.0], point=at, follows=True)
    scene.add_torque(tip.frame(at=at), axes.T @ [0.3, -0.2, 0.1], follows=True)
    scene.add_spring("spring", tip.frame(at=2 * at), rod.frame(at=(0.2, 0.1, 0.0)), stiffness=40.0)
    return scene


def test_what_an_interface_carries_is_placed_in_its_axes() -> None:
    plain, turned = carrying_scene(np.eye(3)).freeze(), carrying_scene(TURN).freeze()
    q, u = random_state(plain, 7)
    terms, k = plain.flexible_terms("arm"), plain.flexible_terms("arm").body.free_count
    bases = [model.flexible_terms("arm").body.basis[:, :k] for model in (plain, turned)]
    change = np.linalg.lstsq(bases[1], bases[0], rcond=None)[0]  # components of the tip are coordinates of the body

    def seen(x: np.ndarray, at: slice) -> np.ndarray:
        x = x.copy()
        x[at] = change @ x[at]
        return x

    q_turned, u_turned = seen(q, terms.eta), seen(u, terms.speeds)
    expected = seen(accelerations(State(plain, 0.3, q, u)), terms.speeds)
    # the same equations but for round-off of the turned places, times the conditioning of M (1e2)
    assert accelerations(State(turned, 0.3, q_turned, u_turned)) == pytest.approx(
        expected, abs=1e-12 * abs(expected).max()
    )
    y, y_turned = np.concatenate((q, u)), np.concatenate((q_turned, u_turned))
    assert turned.rhs(0.3, y_turned)[len(q) :] == pytest.approx(expected, abs=1e-11 * abs(expected).max())
    one, two = plain.kinematics("arm", 0.3, y, "tip"), turned.kinematics("arm", 0.3, y_turned, "tip")
    assert two.position == pytest.approx(one.position, abs=1e-13)
    assert two.rotation == pytest.approx(one.rotation @ TURN, abs=1e-13)
    assert two.velocity == pytest.approx(TURN.T @ one.velocity, abs=1e-12)
    assert two.angular_velocity == pytest.approx(TURN.T @ one.angular_velocity, abs=1e-12)


def test_results_turn_interfaces_with_their_axes_and_give_forces_in_G() -> None:
    runs = []
    for axes in (np.eye(3), TURN):
        body = lattice_body(
            2, {"root": kf.Interface(("x", "y", "z", "rx", "ry", "rz"), axes=axes), "tip": kf.Interface(axes=axes)}
        )
        scene = kf.System(gravity=(0.3, -9.81, 1.0))
        arm = scene.add_flexible_body("arm", body, joint=kf.Revolute("z"))
        back = axes.T @ [0.1, 0.2, 0.3]  # the same point, whatever the axes

        def drag(t: float, state: SceneState, axes: np.ndarray = axes, back: np.ndarray = back) -> np.ndarray:
            thrust = state.rotation("arm", "tip") @ axes.T @ [0.5, 0.2, -0.1]
            return thrust - 0.2 * state.velocity("arm", "tip", back)

        scene.add_force(arm.interface("tip"), drag)
        runs.append(scene.simulate((0.0, 0.05), rtol=1e-9, atol=1e-11))
    plain, turned = runs
    A, B = (rotation_matrix(run.rotation("arm", "tip")[-1]) for run in runs)
    assert B == pytest.approx(A @ TURN, abs=1e-9)
    assert turned.position("arm", "tip") == pytest.approx(plain.position("arm", "tip"), abs=1e-9)
    assert turned.velocity("arm", "tip") == pytest.approx(plain.velocity("arm", "tip"), abs=1e-8)
    forces = plain.coupling_force("arm", "root")
    # two runs within 1e-9 of each other; springs of 100 N/m and accelerations of the same digits
    assert turned.coupling_force("arm", "root") == pytest.approx(forces, abs=1e-6 * abs(forces).max())


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        ({"kind": "stiff"}, r"of kind 'stiff'\. Remedy: one of rigid, average, node"),
        ({"weights": "area"}, r"weights='area' are for averages"),
        ({"kind": "average", "weights": "volume"}, r"weights='volume' .* area, mass, uniform"),
        ({"kind": "average", "weights": (1, -1, 1)}, r"weights of an interface must be finite numbers >= 0"),
        ({"kind": "average", "weights": (0, 0, 0)}, r"not all zero"),
        ({"axes": np.diag([1.0, 1.0, -1.0])}, r"(?s)axes of an interface must be a rotation, .* a right-handed matrix"),
        ({"axes": 2 * np.eye(3)}, "must be a rotation"),
        ({"axes": (0, 0, 0, 0)}, "must be a rotation"),
        ({"position": (1, 2)}, r"position of an interface must be three finite numbers in m, not \(1, 2\)"),
        ({"position": (1, 2, np.nan)}, "three finite numbers"),
        ({"released": ("x", "spin")}, r"an interface releases components among x, y"),
        ({"released": ("x", "y", "z", "rx", "ry", "rz")}, "releases all components follows nothing"),
        ({"groups": ()}, "names of groups of the mesh"),
        ({"groups": (1, 2)}, "names of groups of the mesh"),
    ],
)
def test_interfaces_that_make_no_sense_are_refused_at_once(spec: dict, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        kf.Interface(**spec)


@pytest.mark.parametrize(
    ("interfaces", "message"),
    [
        (
            {"end": kf.Interface(kind="average", weights="area")},
            r"interface 'end' has no facets or lines to be weighted",
        ),
        ({"end": kf.Interface(kind="average", weights=(1, 2, 3))}, r"interface 'end' has 4 nodes and 3 weights"),
        ({"end": kf.Interface(kind="average", weights=(1, 1, 0, 0))}, r"weights of interface 'end' leave a component"),
        ({"end": kf.Interface(kind="node")}, r"interface 'end' is of kind 'node', but its group has 4 nodes"),
        (
            {"peg": kf.Interface(kind="node", position=(5, 5, 5))},
            r"interface 'peg': there is no node at \(5.0, 5.0, 5.0\) m; the nearest is node \d at .* Remedy: give",
        ),
        (
            {"middle": kf.Interface(position=(0, 0, 0))},
            r"interface 'middle' is a single node without rotations, so its frame cannot be away from it",
        ),
        ({"pair": "rigid"}, r"lie on a line.* Remedy: .* such as Interface\(\.\.\., axes="),
        ({"pair": kf.Interface(position=(0, 0, 0))}, r"lie on a line, and its frame, at .*, does not"),
        ({"middle": kf.Interface(released=("x", "y", "z"))}, r"'middle' releases all that its nodes could follow"),
        ({"end": kf.Interface(groups=("end", "pear"))}, r"no group of facets or nodes called 'pear'"),
        ({"all": kf.Interface(groups=("end", "tip")), "tip": "rigid"}, r"interfaces 'all' and 'tip' share node"),
        ({"middle": "rigid"}, r"the body floats, and its interfaces \(middle\) follow only 3 of its 6 rigid motions"),
        ({"end": 3}, r"interface 'end' cannot be 3\. Remedy: one of clamped, rigid, hinged, average, node"),
    ],
)
def test_patches_that_cannot_follow_are_named(interfaces: dict, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        flexible_body(four_node_tip(), interfaces, reduction=kf.CraigBampton(modes=2))


def test_a_line_follows_all_but_the_turn_about_itself_and_carries_no_body() -> None:
    model = four_node_tip()
    try:
        tie_interfaces(model, {"pair": "rigid"})
    except ModelError as error:
        axes = np.array(eval(str(error).split("axes=")[1].split("): then")[0]))
    body = flexible_body(model, {"root": "clamped", "pair": kf.Interface(axes=axes)})
    frame = body.interface("pair")
    assert frame.loose_rotations(model.components) == ("rx",)
    scene = kf.System()
    arm = scene.add_flexible_body("arm", body)
    with pytest.raises(ModelError, match=r"interface 'pair' of 'arm' has no rotation rx of its own .* add_loop_joint"):
        scene.add_rigid_body("rod", 1.0, 0.1, parent=arm.interface("pair"))


def test_node_found_by_its_place_and_several_groups_make_one_patch() -> None:
    model = four_node_tip()
    node = int(model.groups["middle"].nodes[0])
    body = flexible_body(
        model, {"root": "clamped", "peg": kf.Interface(kind="node", position=model.nodes[node] + 1e-8)}
    )
    assert body.interface("peg").position == pytest.approx(model.nodes[node], abs=1e-15)
    assert body.interface("peg").motion[:3] == pytest.approx(body.basis[3 * node : 3 * node + 3], abs=1e-15)
    ties = tie_interfaces(model, {"both": kf.Interface(groups=("root", "pair"))})
    assert ties.ties[0].nodes.tolist() == [0, 1, 2, 3, 4]
    assert ties.ties[0].position == pytest.approx(model.nodes[:5].mean(axis=0))
    assert kf.Interface(groups="root") == kf.Interface(groups=("root",))
