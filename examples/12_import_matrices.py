"""A bar from matrices of another program: checked on input, simulated, and exported as SID."""

from pathlib import Path

import numpy as np

import kanefe as kf

E, rho, length, width, elements = 210e9, 7850.0, 1.0, 0.02, 16
nodes = np.column_stack((np.linspace(0.0, length, elements + 1), np.zeros((elements + 1, 2))))
h, area, inertia = length / elements, width**2, width**4 / 12

# What an exporting program would write: a plane bar of Hermite elements with lumped masses, lower triangles by node
# label, in mm, t, s.
beam = np.array([[12, 6 * h, -12, 6 * h], [6 * h, 4 * h**2, -6 * h, 2 * h**2], [-12, -6 * h, 12, -6 * h],
                 [6 * h, 2 * h**2, -6 * h, 4 * h**2]]) * E * inertia / h**3  # fmt: skip
axial = np.array([[1, -1], [-1, 1]]) * E * area / h
K, M = np.zeros((2, 3 * (elements + 1), 3 * (elements + 1)))
for first in range(0, 3 * elements, 3):
    along, across = [first, first + 3], [first + 1, first + 2, first + 4, first + 5]
    K[np.ix_(along, along)] += axial
    K[np.ix_(across, across)] += beam
    M[(places := [first, first + 1, first + 3, first + 4]), places] += rho * area * h / 2
labels = 10 * np.arange(1, elements + 2)
freedoms = [(label, number) for label in labels for number in (1, 2, 6)]
unit = np.tile([1e-3, 1e-3, 1.0], elements + 1)  # their unit motions in m and rad
for name, matrix in (("bar_STIF1.mtx", K), ("bar_MASS1.mtx", M)):
    theirs = matrix * np.outer(unit, unit) / (1e3 * 1e-6)
    lines = [
        f"{freedoms[i][0]},{freedoms[i][1]}, {freedoms[j][0]},{freedoms[j][1]}, {theirs[i, j]:.16e}"
        for i, j in zip(*np.nonzero(np.tril(theirs)), strict=True)
    ]
    Path(name).write_text("\n".join(lines) + "\n")
text = [f"{label}, {1e3 * x}, {1e3 * y}, {1e3 * z}" for label, (x, y, z) in zip(labels, nodes, strict=True)]
sets = ["*NSET, NSET=ROOT", str(labels[0]), "*NSET, NSET=TIP", str(labels[-1])]
Path("bar.inp").write_text("\n".join(["*NODE", *text, *sets, ""]))

model = kf.read_abaqus("bar.inp", "bar_STIF1.mtx", "bar_MASS1.mtx", units="mm, t, s", expected_mass=rho * area * length)
found = model.provenance["self_check"]
print(f"{found['rigid_motions']} rigid motions, mass {found['mass']:.4f} kg, centre {found['center_of_mass'][0]:.3f} m")

bar = kf.flexible_body(model, {"ROOT": "clamped", "TIP": "rigid"}, reduction=kf.CraigBampton(modes=4))
frames = kf.write_sid(bar, "bar.SID_FEM")
same = kf.read_sid("bar.SID_FEM", names=frames)

tips = []
for body in (bar, same):
    scene = kf.System(gravity=(0, -9.81, 0))
    scene.add_flexible_body("bar", body, joint=kf.Revolute("z"))
    result = scene.simulate((0.0, 0.5), rtol=1e-6)
    tips.append(result.position("bar", "TIP")[-1])
print(f"tip after 0.5 s: {tips[0].round(6)} m, of the body read back from SID {tips[1].round(6)} m")

exact = 1.8751040687**2 / (2 * np.pi) * np.sqrt(E * inertia / (rho * area * length**4))
print(f"first frequency {same.frequencies[0]:.4f} Hz, of a clamped bar {exact:.4f} Hz")

# Lumped masses at 16 elements shift the first frequency by some 1e-3.
checked = (same.frequencies[0], exact, 2e-3 * exact)
