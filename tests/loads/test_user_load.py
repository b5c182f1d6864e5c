"""Loads from outside the package: what they must have, and that all routes see the same of them."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import pytest
from numba import cfunc, types

import kanefe as kf
from kanefe.loads.action import End

K, C, TAU = 400.0, 6.0, 0.05


class Magnet(kf.Load):
    """c / r^2 between two frames, from Python alone."""

    columns = ("distance [m]",)

    def __init__(self, name, ends, c):
        self.name, self.ends, self.c = name, ends, c

    def action(self, t, ends, states):
        line = ends[1].p - ends[0].p
        r = np.linalg.norm(line)
        pull = np.append(self.c / r**3 * line, np.zeros(3))
        return kf.Action(np.array((pull, -pull)), potential=-self.c / r)

    def tell(self, t, ends, states):
        return np.array((np.linalg.norm(ends[1].p - ends[0].p),))


class Maxwell(kf.Load):
    """A spring and a damper in series along z of N: its force is an internal state, df/dt = K v - f / TAU."""

    def __init__(self, name, ends, *, compiled):
        self.name, self.ends, self.compiled = name, ends, compiled

    @property
    def initial_states(self):
        return np.array((1.5,))

    def action(self, t, ends, states):
        pull = np.array((0.0, 0.0, states[0], 0.0, 0.0, 0.0))
        rate = K * (ends[1].v[2] - ends[0].v[2]) - states[0] / TAU
        potential = 0.5 * states[0] ** 2 / K
        return kf.Action(np.array((pull, -pull)), potential, taken=states[0] ** 2 / (K * TAU), rates=np.array((rate,)))

    @property
    def kernel(self):
        return kf.LoadKernel(MAXWELL.address, np.array((K, TAU))) if self.compiled else None


class OfKernelAlone(kf.Load):
    """The same by its compiled function alone."""

    def __init__(self, name, ends):
        self.name, self.ends = name, ends

    initial_states = np.array((1.5,))

    @property
    def kernel(self):
        return kf.LoadKernel(MAXWELL.address, np.array((K, TAU)), MAXWELL_COMPLEX.address)


POINTER = types.CPointer(types.float64)


@cfunc(types.void(types.float64, POINTER, POINTER, POINTER, POINTER, POINTER))
def MAXWELL(t, numbers, inputs, ends, states, out):
    f = states[0]
    out[0] = 0.5 * f * f / numbers[0]
    out[1] = f * f / (numbers[0] * numbers[1])
    out[3 + 2], out[9 + 2] = f, -f
    out[15] = numbers[0] * (ends[18 + 14] - ends[14]) - f / numbers[1]


COMPLEX = types.CPointer(types.complex128)


@cfunc(types.void(types.float64, POINTER, POINTER, COMPLEX, COMPLEX, COMPLEX))
def MAXWELL_COMPLEX(t, numbers, inputs, ends, states, out):
    f = states[0]
    out[0] = 0.5 * f * f / numbers[0]
    out[1] = f * f / (numbers[0] * numbers[1])
    out[3 + 2], out[9 + 2] = f, -f
    out[15] = numbers[0] * (ends[18 + 14] - ends[14]) - f / numbers[1]


def swing(load_of, **options):
    scene = kf.System(gravity=(0, 0, -9.81))
    arm = scene.add_rigid_body("arm", 1.0, 0.1, joint=kf.Revolute("y"), com=(0.5, 0, 0))
    scene.add(load_of(scene.ground.frame(at=(0.9, 0.2, 0.3)), arm.frame(at=(0.8, 0.0, 0.1))))
    return scene


LOADS = [
    lambda a, b: Magnet("it", (a, b), 2.0),
    lambda a, b: Maxwell("it", (a, b), compiled=False),
    lambda a, b: Maxwell("it", (a, b), compiled=True),
    lambda a, b: OfKernelAlone("it", (a, b)),
]


@pytest.mark.parametrize("load_of", LOADS, ids=["magnet", "maxwell", "maxwell-compiled", "kernel-alone"])
def test_routes_agree_to_round_off(load_of):
    model = swing(load_of).freeze()
    y = np.concatenate(([0.4], [-0.7], model.initial_states * 1.3, [0.0, 0.0]))
    np.testing.assert_allclose(model.route.evaluate(0.0, y).rates, model.literal.evaluate(0.0, y).rates, rtol=1e-12)
    assert model.route.energy(0.0, y).total == pytest.approx(model.literal.energy(0.0, y).total, rel=1e-13)


def test_a_compiled_load_needs_no_action():
    """What Python has of it is what its compiled function writes, and its tangent the derivative of that."""
    rng = np.random.default_rng(4)
    ends = [End(*rng.normal(size=(1, 3)), np.eye(3), *rng.normal(size=(2, 3))) for _ in range(2)]
    alone, written = OfKernelAlone("it", ("a", "b")), Maxwell("it", ("a", "b"), compiled=False)
    for found, wanted in zip(alone.action(0.0, ends, np.ones(1)), written.action(0.0, ends, np.ones(1)), strict=True):
        np.testing.assert_allclose(found, wanted, rtol=1e-14)
    assert alone.tangent(0.0, ends, np.ones(1)) is None  # its force is a state, which nothing moves at once


@pytest.mark.parametrize("method", ["dop853", "extrapolation", "auto"])
def test_states_of_a_load_move_with_every_method_that_serves_them(method):
    """A mass on a Maxwell element: the closed form of a linear system of three states."""
    scene = kf.System()
    ball = scene.add_point("ball", 2.0, at=(0, 0, -1), joint=kf.Prismatic("z"))
    scene.add(Maxwell("it", (scene.ground, ball), compiled=True))
    result = scene.simulate((0.0, 1.0), method=method, rtol=1e-9)
    # z'' = f / m ... with f' = K z' - f / TAU, and the pull -f on the ball
    matrix = np.array(((0.0, 1.0, 0.0), (0.0, 0.0, -0.5), (0.0, K, -1.0 / TAU)))
    from scipy.linalg import expm

    wanted = expm(matrix) @ np.array((0.0, 0.0, 1.5))
    assert result.position("ball")[-1, 2] + 1.0 == pytest.approx(wanted[0], rel=1e-6)
    assert abs(result.energy.balance_error).max() < 1e-7


def test_an_unserving_method_is_refused_for_moving_states():
    scene = swing(LOADS[2])
    with pytest.raises(kf.ModelError, match="internal states"):
        scene.simulate((0.0, 0.1), method="energy-momentum", step=1e-3)


def test_radau_follows_moving_states():
    scene = swing(LOADS[2])
    wanted = scene.copy().simulate((0.0, 0.5), method="dop853", rtol=1e-10)
    found = scene.simulate((0.0, 0.5), method="radau5", rtol=1e-8)
    np.testing.assert_allclose(found.joint_coordinates("arm"), wanted.joint_coordinates("arm"), rtol=0, atol=1e-7)


class Lacking:
    name, ends = "x", ()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"name": ""}, "needs a name"),
        ({"action": kf.Load.action}, r"load 'it' defines no forces. Remedy: action\(t, ends, states\), or a"),
        ({"ends": None}, "needs ends"),
        ({"columns": ("a [m]", "b [m]")}, "tell"),
        ({"columns": ("a [m]", "b [N]", "c [m]")}, "one unit adjacent"),
        ({"kernel": 3.0}, "kernel of load 'it'"),
        ({"kernel": kf.LoadKernel(-1, np.zeros(1))}, "address of a C function"),
        ({"initial_states": np.array((np.nan,))}, "initial_states"),
        ({"events": ("breaks",)}, "kanefe.LoadEvent"),
    ],
)
def test_what_a_load_lacks_is_named_at_add(change, message):
    kind = type("Changed", (Magnet,), {**change, "tell": kf.Load.tell})
    scene = kf.System()
    ball = scene.add_point("ball", 0.1, at=(1, 0, 0))
    load = kind("it", (scene.ground, ball), 1.0)
    for name, value in change.items():
        if name in ("name", "ends"):
            setattr(load, name, value)
    with pytest.raises(kf.ModelError, match=message):
        scene.add(load)


@pytest.mark.parametrize("thing", [Lacking(), Magnet, 3.0, None])
def test_what_is_no_load_is_refused(thing):
    with pytest.raises(kf.ModelError, match=r"is not a load between frames.*Remedy"):
        kf.System().add(thing)


@pytest.mark.parametrize(
    ("action", "message"),
    [
        (lambda self, t, ends, states: np.zeros((2, 6)), "must be a kanefe.Action"),
        (lambda self, t, ends, states: kf.Action(np.zeros((2, 3))), r"shape \(2, 6\)"),
        (lambda self, t, ends, states: kf.Action(np.full((2, 6), np.nan)), "finite"),
        (lambda self, t, ends, states: kf.Action(np.zeros((2, 6)), rates=np.zeros(1)), "rates"),
    ],
)
def test_a_wrong_action_is_named_before_the_run(action, message):
    kind = type("Changed", (Magnet,), {"action": action})
    scene = kf.System()
    ball = scene.add_point("ball", 0.1, at=(1, 0, 0))
    scene.add(kind("it", (scene.ground, ball), 1.0))
    with pytest.raises(kf.ModelError, match=message):
        scene.freeze()


def test_ends_and_names_are_checked_and_the_users_object_stays():
    scene, other = kf.System(), kf.System()
    ball = scene.add_point("ball", 0.1, at=(1, 0, 0))
    ends = scene.ground, ball
    load = Magnet("it", ends, 1.0)
    scene.add(load)
    assert load.ends is ends
    with pytest.raises(kf.ModelError, match="already has a load called 'it'"):
        scene.add_spring("it", scene.ground, ball, stiffness=1.0)
    with pytest.raises(kf.ModelError, match=r"end 0 of load 'else'.*another system"):
        scene.add(Magnet("else", (other.ground, ball), 1.0))
    assert scene.simulate((0.0, 0.1)).load("it").shape[1] == 1


@dataclass(frozen=True, eq=False)
class Begun(kf.Load):
    """A load that knows something since the start of a scene, and computes something of its ends."""

    name: str
    ends: tuple
    length: float = field(default=np.nan, init=False)

    @cached_property
    def count(self):
        return len(self.ends)


def test_a_copy_between_other_frames_keeps_what_is_known_and_computes_anew():
    load = Begun("load", ("a", "b"))
    object.__setattr__(load, "length", 2.0)
    assert load.count == 2
    other = load.with_ends(("a", "b", "c"))
    assert (other.length, other.count, other.ends) == (2.0, 3, ("a", "b", "c"))
    assert load.ends == ("a", "b")
