"""A cantilever of two aluminium faces with a damping layer between them, whose shear takes the resonances down.

Needs dolfinx. The layer is an eighth of a millimetre thick, one element of order 2 across.
"""

from dataclasses import replace
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import kanefe as kf
from kanefe.fe_model.model import Cells
from kanefe_fem import Material, box_mesh, solid_body

length, width, face, layer = 177.8e-3, 12.7e-3, 1.524e-3, 0.127e-3  # m
aluminium = Material(E=69e9, nu=0.0, rho=2766.0)
ends = {"root": "clamped", "tip": kf.Interface(kind="average")}

mesh = box_mesh((length, width, 3.0), (24, 1, 3))
x, y, z = mesh.nodes.T
(bricks,) = mesh.cells["body"]
number = np.round(z[bricks.nodes].mean(axis=1) - 0.5)  # of the layer in which each brick is
cells = {"face": Cells(bricks.kind, bricks.nodes[number != 1]), "core": Cells(bricks.kind, bricks.nodes[number == 1])}
heights = np.interp(z, range(4), np.cumsum([0.0, face, layer, face]))
mesh = replace(mesh, nodes=np.column_stack([x, y, heights]), cells={name: (block,) for name, block in cells.items()})


def linearised(loss_factor: float) -> kf.Linearisation:
    """Return the small motions of the beam, with a force across at its tip."""
    core = Material(E=2.6 * 0.896e6, nu=0.3, rho=968.1, loss_factor=loss_factor)
    scene = kf.System()
    scene.add_flexible_body(
        "beam", solid_body(mesh, {"face": aluminium, "core": core}, ends, reduction=kf.CraigBampton(modes=8))
    )
    return kf.linearise(scene, inputs="force beam/tip z", outputs="position beam/tip z")


figure, (axes, bars) = plt.subplots(1, 2, figsize=(9, 3.8), layout="constrained", width_ratios=(2, 1))
frequencies = np.unique(np.concatenate([np.geomspace(20, 1000, 300), 66.44 + np.linspace(-4, 4, 41)]))
for loss_factor, shade in ((0.02, "0.7"), (0.1, "tab:orange"), (0.5, "tab:blue")):
    small = linearised(loss_factor)
    response = small.frequency_response(frequencies)
    axes.loglog(frequencies, 1e6 * response.magnitude[:, 0, 0], color=shade, label=f"loss factor {loss_factor:g}")
    modes = small.modes()
    bending = [i for i in range(6) if modes.loss_factors[i] > 0.05 * loss_factor][:3]
    print(f"loss factor {loss_factor:g} of the core:")
    for i in bending:
        print(f"  {modes.frequencies[i]:8.2f} Hz, loss factor {modes.loss_factors[i]:.4f}")
    if loss_factor == 0.1:
        shares = modes.loss_factors[bending] / loss_factor
axes.set(xlabel="frequency [Hz]", ylabel="tip displacement per force [µm/N]")
axes.legend()
bars.bar(["1st", "2nd", "3rd"], 100 * shares, color="tab:orange", label="solids")
bars.plot(range(3), (25.853, 26.259, 18.185), "k_", markersize=30, label="sixth-order beam")
bars.set(xlabel="bending mode", ylabel="share of the core's loss factor [%]")
bars.legend(loc="lower left")
out = Path("out")
out.mkdir(exist_ok=True)
figure.savefig(out / "constrained_layer.png", dpi=120)

# the first mode of the beam of Mead and Markus, J. Sound Vib. 10 (1969) 163, solved apart from this
checked = (shares[0], 0.25853, 0.0026)
