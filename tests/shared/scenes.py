"""Bodies, scenes and states for the tests, from numpy alone, and finite differences along a motion.

The bodies are lattices: point masses joined by springs, every pair of them, so that K leaves exactly the rigid motions
free. They deform visibly and swing at a few hertz, which makes integration cheap and nonlinear terms large.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy.sparse as sp

import kanefe as kf
from kanefe.equations.model import Model
from kanefe.fe_model.model import MassField, NodeGroup
from kanefe.reduction import flexible_body

ROOT = np.array([[0.0, 0.2, -0.1], [0.0, -0.2, -0.1], [0.05, 0.0, 0.2]])
TIP = ROOT * [-1.0, 1.0, 1.0] + [1.0, 0.05, 0.0]


def lattice_model(
    seed: int = 0,
    *,
    planar: bool = False,
    interior: int = 3,
    spring: float = 100.0,
    mass: float = 2.0,
    nodal: bool = False,
    rotations: bool = False,
    in_fluid: bool = False,
) -> kf.FiniteElementModel:
    """Return a lattice with the groups "root", "tip" (three nodes each; two in the plane) and "middle" (one node).

    `rotations` gives every node rotations too, with springs that tie them to the rotation of the lattice. `in_fluid`
    gives it an added mass: at each node along one direction, of twice its mass.
    """
    rng = np.random.default_rng(seed)
    across = np.array([0.25, 0.25, 0.0 if planar else 0.25])
    middle = np.array([0.5, 0.0, 0.0]) + across * rng.uniform(-1, 1, (interior, 3))
    ends = [ROOT[:2] * [1, 1, 0], TIP[:2] * [1, 1, 0]] if planar else [ROOT, TIP]
    nodes = np.vstack((ends[0], middle, ends[1]))
    n, r = len(nodes), len(ends[0])
    names: tuple[str, ...] = ("x", "y") if planar else ("x", "y", "z")
    K = _springs(nodes, names, spring * rng.uniform(0.5, 1.5, (n, n)))
    # a scalar mass matrix with off-diagonal terms, as a consistent one has them
    random = rng.uniform(0.1, 1.0, (n, n))
    scalar = np.diag(rng.uniform(0.5, 1.5, n)) + 0.02 * random @ random.T
    scalar *= mass / scalar.sum()
    M = np.kron(scalar, np.eye(len(names)))
    if rotations:
        K, M, names = _with_rotations(nodes, names, K, M, spring, rng)
    field = None
    if not nodal and not rotations:
        rows = np.arange(3 * n).reshape(n, 3)[:, : len(names)].ravel()
        interpolation = sp.csr_matrix((np.ones(len(rows)), (rows, np.arange(len(rows)))), (3 * n, len(rows)))
        field = MassField(nodes, sp.csr_matrix(scalar), interpolation)
    groups = {"root": np.arange(r), "tip": np.arange(n - r, n), "middle": np.array([r])}
    return kf.FiniteElementModel(
        nodes=nodes,
        components=names,
        stiffness=sp.csr_matrix(K),
        mass=sp.csr_matrix(M),
        mass_field=field,
        added_mass=_fluid(n, names, 2.0 * mass / n) if in_fluid else None,
        groups={name: NodeGroup(g, nodes[g].mean(axis=0)) for name, g in groups.items()},
    )


def _fluid(nodes: int, names: tuple[str, ...], share: float) -> sp.csr_matrix:
    directions = np.random.default_rng(3).standard_normal((nodes, len(names)))
    return sp.csr_matrix(sp.block_diag([share * np.outer(n, n) for n in directions]))


def _springs(nodes: np.ndarray, names: tuple[str, ...], rates: np.ndarray) -> np.ndarray:
    n, width = len(nodes), len(names)
    K = np.zeros((n * width, n * width))
    for i in range(n):
        for j in range(i):
            d = (nodes[i] - nodes[j])[:width]
            row = np.zeros(n * width)
            row[width * i : width * i + width] = d / np.linalg.norm(d)
            row[width * j : width * j + width] = -d / np.linalg.norm(d)
            K += rates[i, j] * np.outer(row, row)
    return K


def _with_rotations(
    nodes: np.ndarray, names: tuple[str, ...], K: np.ndarray, M: np.ndarray, spring: float, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray, tuple[str, ...]]:
    """Add nodal rotations: each node's slope is tied to its motion against the next two nodes, and has inertia."""
    n, width = len(nodes), len(names)
    spins: tuple[str, ...] = ("rz",) if width == 2 else ("rx", "ry", "rz")
    wide = width + len(spins)
    at = (wide * np.arange(n)[:, None] + np.arange(width)).ravel()
    K_all, M_all = np.zeros((n * wide, n * wide)), np.zeros((n * wide, n * wide))
    K_all[np.ix_(at, at)], M_all[np.ix_(at, at)] = K, M
    for i in range(n):
        for step in (1, 2):
            j = (i + step) % n
            d = np.append((nodes[j] - nodes[i])[:width], [0.0] * (3 - width))
            cross = np.array([[0, -d[2], d[1]], [d[2], 0, -d[0]], [-d[1], d[0], 0]])[:width]
            cross = cross[:, 2:] if width == 2 else cross
            # the bar that a node carries points at its neighbour: u_j - u_i - theta_i x d = 0 costs nothing
            rows = np.zeros((width, n * wide))
            rows[:, wide * j : wide * j + width] = np.eye(width)
            rows[:, wide * i : wide * i + width] = -np.eye(width)
            rows[:, wide * i + width : wide * i + wide] = cross
            K_all += 0.3 * spring * rows.T @ rows
        inertia = 0.01 * (np.eye(len(spins)) + 0.2 * np.ones((len(spins), len(spins))))
        spin = slice(wide * i + width, wide * i + wide)
        M_all[spin, spin] = inertia * rng.uniform(0.5, 1.5)
    return K_all, M_all, (*names, *spins)


def lattice_body(seed: int = 0, interfaces: dict | None = None, **options: object) -> kf.FlexibleBody:
    """Return a body of a lattice; options of `flexible_body` and of `lattice_model` are told apart by name."""
    ours = {name: options.pop(name) for name in ("reduction", "damping") if name in options}
    model = lattice_model(seed, **options)  # type: ignore[arg-type]
    return flexible_body(model, {"root": "clamped", "tip": "rigid"} if interfaces is None else interfaces, **ours)


def unit_axis(rng: np.random.Generator) -> np.ndarray:
    """Return a random direction."""
    v = rng.standard_normal(3)
    return v / np.linalg.norm(v)


def random_inertia(rng: np.random.Generator, size: float = 0.1) -> np.ndarray:
    """Return the inertia of a random cloud of points: it satisfies the triangle inequality."""
    r = rng.standard_normal((6, 3))
    second = size * r.T @ r
    return np.trace(second) * np.eye(3) - second


def swing(rng: np.random.Generator) -> kf.Motion:
    """Return a smooth driven motion with all three derivatives at work."""
    a, w, p = rng.uniform(0.3, 1.0), rng.uniform(1.0, 3.0), rng.uniform(0, 6)
    return kf.Motion(
        lambda t: a * np.sin(w * t + p), lambda t: a * w * np.cos(w * t + p), lambda t: -a * w * w * np.sin(w * t + p)
    )


def _place(rng: np.random.Generator) -> dict:
    return {"at": rng.uniform(-0.3, 0.3, 3), "orientation": rng.standard_normal(4)}


def _loads(scene: kf.System, rng: np.random.Generator, *targets: object) -> None:
    for target in targets:
        force, torque = rng.standard_normal(3), rng.standard_normal(3)
        scene.add_force(
            target, lambda t, f=force: f * np.cos(t), point=rng.uniform(-0.2, 0.2, 3), follows=bool(rng.integers(2))
        )
        scene.add_torque(target, torque, follows=bool(rng.integers(2)))


def rigid_scene(seed: int, slopes: str = "rotation-vector") -> kf.System:
    """Return a rigid tree with every joint."""
    rng = np.random.default_rng(seed)
    scene = kf.System(gravity=rng.standard_normal(3), slopes=slopes)
    joints = [kf.Free(), kf.Revolute(unit_axis(rng)), kf.Prismatic(unit_axis(rng)), kf.Planar(), kf.Fixed(), kf.Free()]
    bodies: list = [None]
    for i, joint in enumerate(joints):
        parent = bodies[int(rng.integers(len(bodies)))]
        body = scene.add_rigid_body(
            f"b{i}",
            1.0 + i,
            random_inertia(rng),
            com=rng.uniform(-0.2, 0.2, 3),
            parent=parent,
            joint=joint,
            **_place(rng),
        )
        bodies.append(body)
    _loads(scene, rng, bodies[1], bodies[-1])
    scene.add_torque(bodies[2], lambda t: 0.3 + t)
    return scene


def flexible_scene(
    seed: int,
    *,
    interfaces: dict | None = None,
    joint: kf.Joint | None = None,
    slopes: str = "rotation-vector",
    loads: bool = True,
    **body: object,
) -> kf.System:
    """Return hub - flexible arm - rigid tip on the arm's interface, the hub free in space."""
    rng = np.random.default_rng(seed)
    scene = kf.System(gravity=rng.standard_normal(3), slopes=slopes)
    hub = scene.add_rigid_body("hub", 3.0, random_inertia(rng), com=rng.uniform(-0.2, 0.2, 3), joint=kf.Free())
    flexible = lattice_body(seed, interfaces, **body)
    arm = scene.add_flexible_body("arm", flexible, parent=hub, joint=joint, **_place(rng))
    tip = scene.add_rigid_body(
        "tip", 0.5, random_inertia(rng, 0.01), com=rng.uniform(-0.1, 0.1, 3), parent=arm.interface("tip"), **_place(rng)
    )
    if loads:
        _loads(scene, rng, hub, tip, arm.interface("tip"))
        scene.add_force(arm.node(3), rng.standard_normal(3))
    return scene


def chain_scene(seed: int, slopes: str = "rotation-vector", **body: object) -> kf.System:
    """Return a flexible body on the interface of a flexible body, with a driven and a free joint and a branch."""
    rng = np.random.default_rng(seed)
    scene = kf.System(gravity=rng.standard_normal(3), slopes=slopes)
    base = scene.add_rigid_body("base", 3.0, random_inertia(rng), joint=kf.Revolute(unit_axis(rng), motion=swing(rng)))
    first = scene.add_flexible_body(
        "first", lattice_body(seed, **body), parent=base, joint=kf.Revolute("y"), **_place(rng)
    )
    second = scene.add_flexible_body(
        "second",
        lattice_body(seed + 1, **body),
        parent=first.interface("tip"),
        joint=kf.Revolute("z", motion=swing(rng)),
        **_place(rng),
    )
    tip = scene.add_rigid_body(
        "tip", 0.3, random_inertia(rng, 0.01), parent=second.interface("tip"), joint=kf.Prismatic("x")
    )
    scene.add_rigid_body(
        "ball", 0.2, random_inertia(rng, 0.01), parent=first.interface("tip"), joint=kf.Free(), **_place(rng)
    )
    _loads(scene, rng, tip, first.interface("tip"), base)
    scene.add_torque(first, lambda t: 0.5 - t)
    return scene


def planar_scene(seed: int, **body: object) -> kf.System:
    """Return a scene that stays in the x-y plane: cart, flexible arm, tip."""
    rng = np.random.default_rng(seed)
    scene = kf.System(gravity=(0.3, -2.0, 0.0))
    cart = scene.add_rigid_body("cart", 3.0, 0.2, joint=kf.Planar(), com=(0.1, 0.05, 0.0))
    arm = scene.add_flexible_body(
        "arm", lattice_body(seed, planar=True, **body), parent=cart, joint=kf.Revolute("z"), at=(0.2, 0, 0)
    )
    tip = scene.add_rigid_body("tip", 0.4, 0.01, parent=arm.interface("tip"), com=(0.1, 0.0, 0.0))
    scene.add_force(tip, (*rng.standard_normal(2), 0.0))
    return scene


def floating_scene(seed: int, slopes: str = "rotation-vector", **body: object) -> kf.System:
    """Return a flexible body without a fixed interface, on a free joint, with a rigid body on its tip."""
    rng = np.random.default_rng(seed)
    scene = kf.System(gravity=rng.standard_normal(3), slopes=slopes)
    options = {"interfaces": {"tip": "rigid"}, "reduction": kf.CraigBampton(modes=4), **body}
    arm = scene.add_flexible_body("arm", lattice_body(seed, **options), joint=kf.Free(), **_place(rng))
    tip = scene.add_rigid_body(
        "tip", 0.4, random_inertia(rng, 0.01), parent=arm.interface("tip"), joint=kf.Revolute("z")
    )
    _loads(scene, rng, tip, arm.interface("tip"))
    return scene


def random_state(model: Model, seed: int, amplitude: float = 0.1, speed: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Return q and u: joints anywhere, nodes displaced by about `amplitude` m and moving by `speed` m/s and rad/s."""
    rng = np.random.default_rng(seed)
    q = np.array(model.initial_coordinates)
    u = speed * rng.standard_normal(model.free_count)
    for body in model.bodies:
        at, speeds = body.free_coordinates()
        if len(at):
            q[at] = body.joint.advance(q[at], rng.standard_normal(len(speeds)))
        if body.flexible:
            k = body.flexible.body.free_count
            for vector, at, size in ((q, body.flexible.eta, amplitude), (u, body.flexible.speeds, speed)):
                eta = rng.standard_normal(k)
                motion = abs(body.flexible.body.basis[:, :k] @ eta).max() if k else 1.0
                vector[at] = eta * size / motion
    return q, u


# Central differences of order 8: at a step of 0.02 and frequencies near 1 rad/s the truncation (0.02^8 = 3e-14) and the
# round-off (2e-16 / 0.02^2 = 6e-13 for the second derivative) balance.
STEP = 0.02
_OFFSETS = np.arange(-4, 5)
_FIRST = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
_SECOND = np.array([-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560])


def derivatives(function: Callable[[float], np.ndarray], step: float = STEP) -> tuple[np.ndarray, np.ndarray]:
    """Return the first and second derivative of an array function of one number, at zero."""
    values = np.array([function(k * step) for k in _OFFSETS])
    return np.tensordot(_FIRST, values, 1) / step, np.tensordot(_SECOND, values, 1) / step**2


def path(model: Model, q: np.ndarray, u: np.ndarray, du: np.ndarray) -> Callable[[float], np.ndarray]:
    """Return a motion s -> q(s) that passes q with speeds u and accelerations du.

    A step u s + du s^2/2 along the exponential map has these rates at s = 0: the map's own bend is of third order.
    """
    return lambda s: model.advance(q, u * s + 0.5 * du * s * s)
