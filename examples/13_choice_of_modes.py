"""How wrong a run is: error by source over refinement, until an accuracy is met; and the choice of modes="auto"."""

import warnings
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import kanefe as kf
from kanefe_fem import Material, Rectangle, beam_body, straight_beam

aluminium = Material(E=70e9, nu=0.3, rho=2700.0)
model = straight_beam(1.0, Rectangle(width=0.02, height=0.02), aluminium, elements=4, planar=True)
INTERFACES = {"root": "clamped", "tip": "rigid"}
TIP = "deflection beam/tip translation_y"


def scene_of(reduction: kf.CraigBampton) -> kf.System:
    """Return an arm that its own weight and that of a tool at its tip begin to bend."""
    body = beam_body(model, INTERFACES, reduction, kf.RayleighDamping(stiffness=2e-4))
    scene = kf.System(gravity=(0, -9.81, 0))
    beam = scene.add_flexible_body("beam", body)
    scene.add_rigid_body("tool", 0.5, 1e-3, parent=beam.interface("tip"))
    return scene


# 1. Ask for an accuracy: runs with smaller tolerances, more modes, stiffening and split cells, one at a time.
scene = scene_of(kf.CraigBampton(modes=4))
result = scene.simulate((0.0, 0.2), accuracy=1e-5, of=[TIP])
found = result.accuracy
print(found)

# 2. The true error, against far more of everything.
fine = {"reduction": kf.CraigBampton(modes=16, loads=("gravity", "angular acceleration")), "stiffening": "full"}
with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    best = scene.with_bodies({"beam": scene.body("beam").body.rebuilt(**fine, refined=2)})
    exact = best.simulate((0.0, 0.2), rtol=1e-11, output_times=result.times)
true = float(np.abs(result.deflection("beam", "tip")[:, 1] - exact.deflection("beam", "tip")[:, 1]).max())
print(f"\nbound {found.bounds[0]:.2e} m, true error {true:.2e} m, allowed {found.allowed[0]:.2e} m")

# 3. Modes chosen by the loads that they have to represent.
loads = ("gravity", "angular acceleration")
auto = kf.CraigBampton(modes="auto", up_to_frequency=20.0, tol=1e-3, loads=loads)
report = scene_of(auto).body("beam").body.provenance["reduction"]
print(f"\nauto, tol = 1e-3: error of the body alone {report['error_estimate']['value']:.1e}")
for mode in report["modes"][:6]:
    print(f"{mode['frequency']:9.1f} Hz  {'kept   ' if mode['kept'] else 'dropped'}  {mode['why']}")

figure, axes = plt.subplots(figsize=(9.0, 4.2), layout="constrained")
for source in found.sources:
    if len(source.apart):
        apart = source.apart[:, 0]
        (line,) = axes.semilogy(np.arange(1, len(apart) + 1), apart, "o-", label=source.name)
        for i, label in enumerate(source.levels[1:][: len(apart)]):
            axes.annotate(
                label, (i + 1, apart[i]), (6, 4), textcoords="offset points", fontsize=8, color=line.get_color()
            )
axes.axhline(found.allowed[0], color="black", lw=1.0, label="allowed")
axes.axhline(found.bounds[0], color="black", ls="--", lw=1.0, label="bound of the answer")
axes.axhline(true, color="black", ls=":", lw=1.0, label="its true error")
most = max(len(source.apart) for source in found.sources)
axes.set(xlabel="pair", ylabel="difference of two levels, m", xticks=range(1, most + 1), xlim=(0.8, most + 0.8))
axes.grid(alpha=0.3)
figure.legend(fontsize=8, loc="outside right upper")
out = Path("out")
out.mkdir(exist_ok=True)
figure.savefig(out / "choice_of_modes.png", dpi=150)
print(f"\nwrote {out / 'choice_of_modes.png'}")

# The true error is below the bound, and not far: what is allowed is met.
checked = (true / float(found.bounds[0]), 0.5, 0.5)
