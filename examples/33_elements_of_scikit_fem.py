"""A spinning blade of scikit-fem's elements: mass, stiffness, geometric stiffness and stresses come from there.

scikit-fem is a finite-element library of a few thousand lines of Python: `pip install scikit-fem`.
"""

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import splu

try:
    import skfem
except ImportError as missing:
    raise SystemExit("this example needs scikit-fem: pip install scikit-fem") from missing
from skfem.helpers import ddot, dot, eye, grad, mul, sym_grad, trace

import kanefe as kf
from kanefe_fem import recover

E, NU, RHO = 70e9, 0.0, 2700.0  # Pa, 1, kg/m3
LENGTH, WIDTH, HEIGHT = 1.0, 0.04, 0.01  # m


def stress(e):
    """Return Hooke's stress of a strain."""
    return E / (1 + NU) * (e + eye(NU / (1 - 2 * NU) * trace(e), 3))


product = skfem.BilinearForm(lambda p, q, w: p * q)


class Blade:
    """What kanefe takes of finite elements, whoever made them."""

    def __init__(self):
        across = [np.array([-0.5, 0.5]) * size for size in (WIDTH, HEIGHT)]
        mesh = skfem.MeshHex.init_tensor(np.linspace(0.0, LENGTH, 13), *across)
        element = skfem.ElementHex2()
        self.basis = skfem.Basis(mesh, skfem.ElementVector(element), intorder=4)
        self.scalar = self.basis.with_element(element)
        # scikit-fem numbers the three components of a node one after the other, as kanefe does
        self.nodes = self.basis.doflocs[:, ::3].T
        self.stiffness = skfem.BilinearForm(lambda u, v, w: ddot(stress(sym_grad(u)), sym_grad(v))).assemble(self.basis)
        self.mass = sp.kron(RHO * product.assemble(self.scalar), sp.identity(3))
        x = self.nodes[:, 0]
        self.groups = {"root": np.flatnonzero(x < 1e-9), "tip": np.flatnonzero(x > LENGTH - 1e-9)}

    def stress_stiffness(self, displacement, load=None):
        """Return int grad(u) s : grad(v) with the stress s of a static displacement: the same for each component."""
        s = stress(sym_grad(self.basis.interpolate(displacement)))
        form = skfem.BilinearForm(lambda p, q, w: dot(grad(p), mul(w["s"], grad(q))))
        return sp.kron(form.assemble(self.scalar, s=s), sp.identity(3))

    def stresses(self, displacements):
        """Return xx, yy, zz, yz, xz, xy at the nodes of each displacement: the projection on the shape functions."""
        solve = splu(product.assemble(self.scalar).tocsc()).solve
        load = skfem.LinearForm(lambda q, w: w["s"] * q)
        found = np.empty((len(self.nodes), 6, displacements.shape[1]))
        for column, u in enumerate(displacements.T):
            s = stress(sym_grad(self.basis.interpolate(u)))
            for row, (a, b) in enumerate(((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))):
                found[:, row, column] = solve(load.assemble(self.scalar, s=s[a, b]))
        return found


blade = Blade()
model = kf.model_from_elements(blade, expected_mass=RHO * LENGTH * WIDTH * HEIGHT)
body = kf.flexible_body(
    model, {"root": "clamped"}, reduction=kf.CraigBampton(modes=6, loads=("centrifugal",)), stiffening="inertial"
)
print(f"{model.size} unknowns, {body.mass:.3f} kg, first frequency {body.frequencies[0]:.3f} Hz")

# The speeds of a table, as multiples of sqrt(E I / (rho A L^4)): a blade on a hub of no radius flaps at 3.5160 of it at
# rest and at 5.5850 at the speed 4 (Wright et al., Journal of Applied Mechanics 49, 1982).
unit = 2.0 * np.pi * body.frequencies[0] / 3.5160  # rad/s
speeds = unit * np.array([0.0, 2.0, 4.0])
flaps = []
for speed in speeds:
    scene = kf.System()
    scene.add_flexible_body("blade", body, joint=kf.Revolute("z", motion=kf.Motion.steady(speed)))
    steady = kf.equilibrium(scene)
    flaps.append(steady.linearise().modes().frequencies[0])
    peak = recover(steady, "blade").envelope("von_mises").peak
    pull = 0.5 * RHO * (speed * LENGTH) ** 2
    print(
        f"{speed * 30.0 / np.pi:6.1f} rev/min: flap at {flaps[-1]:.3f} Hz, stress at the root {peak / 1e6:.3f} MPa",
        end="",
    )
    print(f", rho (speed length)^2 / 2 = {pull / 1e6:.3f} MPa")

# Six modes, and a section of a hundredth of the length.
checked = (flaps[2] / flaps[0], 5.5850 / 3.5160, 5e-3)
