"""A ring that NGSolve draws, meshes along its curves and assembles; in a scene it tumbles and rings.

NGSolve has geometry, curved meshes and elements in one package: `pip install ngsolve`. Its elements of order 2 have
bubbles on their edges as unknowns, which are transformed to displacements of the nodes there.
"""

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import inv

try:
    import ngsolve as ng
    from netgen.occ import Axes, Axis, OCCGeometry, WorkPlane, X, Y, Z, unit_cube
except ImportError as missing:
    raise SystemExit("this example needs NGSolve: pip install ngsolve") from missing

import kanefe as kf

E, NU, RHO = 210e9, 0.3, 7850.0  # Pa, 1, kg/m3
RADIUS, SIDE = 0.2, 0.01  # m, of the ring and of its square section


def bubble():
    """Return the value of a bubble at the middle of its edge, the same on all meshes."""
    mesh = ng.Mesh(unit_cube.GenerateMesh(maxh=1.0))
    one = ng.GridFunction(ng.H1(mesh, order=2))
    one.vec[mesh.nv] = 1.0
    ends = [mesh[v].point for v in mesh.edges[0].vertices]
    return one(mesh(*np.mean(ends, axis=0)))


def matrix(form):
    """Return the matrix of a form."""
    rows, columns, values = form.Assemble().mat.COO()
    return sp.csr_matrix((values, (rows, columns)))


class Ring:
    """What kanefe takes of finite elements, whoever made them."""

    def __init__(self):
        section = WorkPlane(Axes((RADIUS, 0, 0), n=Y, h=X)).RectangleC(SIDE, SIDE).Face()
        ring = section.Revolve(Axis((0, 0, 0), Z), 180) + section.Revolve(Axis((0, 0, 0), Z), -180)
        mesh = ng.Mesh(OCCGeometry(ring).GenerateMesh(maxh=0.03))
        mesh.Curve(2)
        space, scalar = ng.VectorH1(mesh, order=2), ng.H1(mesh, order=2)
        (u, v), count = space.TnT(), scalar.ndof
        e, e_v = ng.Sym(ng.Grad(u)), ng.Sym(ng.Grad(v))
        s = E / (1 + NU) * (e + NU / (1 - 2 * NU) * ng.Trace(e) * ng.Id(3))
        # a node at each vertex and at the middle of each edge, where u = (u_a + u_b) / 2 + bubble * unknown
        a, b = np.array([[vertex.nr for vertex in edge.vertices] for edge in mesh.edges]).T
        edges = mesh.nv + np.arange(len(a))
        ones, middle = np.ones(count), bubble()
        at_nodes = sp.csr_matrix(
            (
                np.concatenate((ones[: mesh.nv], middle * ones[edges], 0.5 * ones[edges], 0.5 * ones[edges])),
                (np.concatenate((np.arange(count), edges, edges)), np.concatenate((np.arange(count), a, b))),
            )
        )
        coordinate = ng.GridFunction(scalar)
        self.nodes = np.empty((count, 3))
        for axis, function in enumerate((ng.x, ng.y, ng.z)):
            coordinate.Set(function)
            self.nodes[:, axis] = at_nodes @ coordinate.vec.FV().NumPy()
        of_nodes = sp.kron(sp.identity(3), inv(at_nodes.tocsc())).tocsr()  # unknowns from displacements
        K = matrix(ng.BilinearForm(ng.InnerProduct(s, e_v) * ng.dx))
        M = matrix(ng.BilinearForm(RHO * ng.InnerProduct(u, v) * ng.dx))
        self.stiffness, self.mass = of_nodes.T @ K @ of_nodes, of_nodes.T @ M @ of_nodes
        self.unknowns = np.arange(3 * count).reshape(3, count).T  # all x, then all y, then all z


model = kf.model_from_elements(Ring(), expected_mass=2 * np.pi * RADIUS * SIDE**2 * RHO)
ring = kf.flexible_body(model, {}, reduction=kf.FreeInterface(modes=6))
print(f"{model.size} unknowns, {ring.mass:.4f} kg, {ring.frequencies.round(1)} Hz")

scene = kf.System()
scene.add_flexible_body("ring", ring, joint=kf.Free(angular_velocity=(20.0, 0.1, 5.0)))
result = scene.simulate((0.0, 0.2), rtol=1e-6)
energy = result.energy.total
print(f"tumbles for 0.2 s, energy {energy[0]:.4f} J, off by {np.ptp(energy) / energy[0]:.1e} of it at most")

# A thin ring that becomes an oval, in its plane (Love): the second pair of modes; the first leaves the plane.
thin = 6 / 5**0.5 / (2 * np.pi) * np.sqrt(E * SIDE**2 / 12 / (RHO * RADIUS**4))
print(f"oval in its plane: {ring.frequencies[2]:.2f} Hz, of a thin ring {thin:.2f} Hz")

# Of so few elements the ring is somewhat too stiff; shear and rotary inertia, which a thin ring has not, soften it.
checked = (ring.frequencies[2], thin, 1e-2 * thin)
