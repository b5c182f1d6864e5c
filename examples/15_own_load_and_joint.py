"""A load and a joint of your own, in one file outside the package: a bead on a parabolic wire above a magnet.

Both are written in Python first, which is enough for a scene on the literal route. With C functions, here compiled by
numba, the same scene runs on the compiled route.
"""

import numpy as np
from numba import cfunc, types
from scipy.integrate import quad

import kanefe as kf

MASS, CURVATURE, START = 0.05, 0.8, 0.5  # kg, 1/m, m
PULL, DEPTH = 0.02, 0.3  # of the magnet, N m2; below the wire, m


class Wire(kf.Joint):
    """A bead slides on z = c x^2; the coordinate is x."""

    coordinate_names, speed_names = ("x [m]",), ("rate [m/s]",)

    def __init__(self, c, x):
        self.c, self.x = c, x

    def initial_coordinates(self):
        """Return q at the start."""
        return np.array((self.x,))

    def initial_speeds(self):
        """Return u at the start: at rest."""
        return np.zeros(1)

    def pose(self, q):
        """Return where the bead is seen from the wire, and its axes."""
        return np.array((q[0], 0.0, self.c * q[0] ** 2)), np.eye(3)

    def partial_velocities(self, q):
        """Return V and W: velocity and angular velocity for a unit of the speed."""
        return np.array(((1.0,), (0.0,), (2.0 * self.c * q[0],))), np.zeros((3, 1))

    def remainders(self, q, u):
        """Return Z and Y: what is left of the acceleration without du."""
        return np.array((0.0, 0.0, 2.0 * self.c * u[0] ** 2)), np.zeros(3)


class Magnet(kf.Load):
    """Two frames attract each other by k / distance^2."""

    columns = ("pull [N]",)

    def __init__(self, name, a, b, k):
        self.name, self.ends, self.k = name, (a, b), k

    def action(self, t, ends, states):
        """Return force and moment on both ends, and the potential."""
        line = ends[1].p - ends[0].p
        r = np.linalg.norm(line)
        pull = np.append(self.k / r**3 * line, np.zeros(3))
        return kf.Action(np.array((pull, -pull)), potential=-self.k / r)

    def tell(self, t, ends, states):
        """Return what `result.load` shows."""
        return np.array((self.k / np.sum((ends[1].p - ends[0].p) ** 2),))


POINTER = types.CPointer(types.float64)


@cfunc(types.void(POINTER, POINTER, POINTER))
def wire(numbers, q, out):
    """Write p, A, V, W, dV/dq and dW/dq; `out` comes as zeros."""
    c, x = numbers[0], q[0]
    out[0], out[2] = x, c * x * x
    out[3], out[7], out[11] = 1.0, 1.0, 1.0
    out[12], out[14] = 1.0, 2.0 * c * x
    out[20] = 2.0 * c


@cfunc(types.void(types.float64, POINTER, POINTER, POINTER, POINTER, POINTER))
def magnet(t, numbers, inputs, ends, states, out):
    """Write the potential, and from place 3 on force and moment of each end; an end is 18 numbers, its place first."""
    x, y, z = ends[18] - ends[0], ends[19] - ends[1], ends[20] - ends[2]
    r = np.sqrt(x * x + y * y + z * z)
    pull = numbers[0] / r**3
    out[0] = -numbers[0] / r
    out[3], out[4], out[5] = pull * x, pull * y, pull * z
    out[9], out[10], out[11] = -pull * x, -pull * y, -pull * z


class CompiledWire(Wire):
    """The same for the compiled route."""

    def links(self):
        """Return the chain of links: one that a function of C moves."""
        return (kf.Link.given(kf.LinkKernel(wire.address, np.array((self.c,)))),)


class CompiledMagnet(Magnet):
    """The same for the compiled route."""

    @property
    def kernel(self):
        """The function of C, with its numbers."""
        return kf.LoadKernel(magnet.address, np.array((self.k,)))


def run(joint, load):
    """Return the result of some swings from rest, and their period."""
    scene = kf.System(gravity=(0, 0, -9.81))
    bead = scene.add_point("bead", MASS, joint=joint(CURVATURE, START))
    scene.add(load("magnet", scene.ground.frame(at=(0, 0, -DEPTH)), bead, PULL))
    bottom = kf.Event("bottom", lambda t, state: state.joint_coordinates("bead")[0], direction=1)
    result = scene.simulate((0.0, 4.0), rtol=1e-10, events=[bottom])
    return result, float(np.diff(result.events["bottom"]).mean())


def exact_period():
    """Return the period from the energy alone: a quarter is the integral of dx over the rate."""

    def potential(x):
        z = CURVATURE * x * x
        return MASS * 9.81 * z - PULL / np.hypot(x, z + DEPTH)

    def time(angle):  # x = START sin(angle) takes the pole at the turn away
        x = START * np.sin(angle)
        inertia = MASS * (1.0 + 4.0 * CURVATURE**2 * x * x)
        rate = np.sqrt(2.0 * (potential(START) - potential(x)) / inertia)
        return START * np.cos(angle) / rate

    return 4.0 * quad(time, 0.0, np.pi / 2, epsrel=1e-11)[0]


exact = exact_period()
for joint, load in ((Wire, Magnet), (CompiledWire, CompiledMagnet)):
    result, period = run(joint, load)
    statistics, pull = result.statistics, result.load("magnet")[:, 0]
    print(f"{joint.__name__} and {load.__name__}: route {statistics['route']} ({statistics['route_reason']})")
    print(f"  period {period:.9f} s, from the energy {exact:.9f} s; the magnet pulls by up to {pull.max():.4f} N")
    error, seconds = abs(result.energy.balance_error).max(), statistics["seconds"]
    print(f"  the energy is conserved to {error:.0e} J; {seconds:.3f} s of computing")

checked = (period, exact, 1e-8)  # s: some hundred steps with errors of 1e-10
