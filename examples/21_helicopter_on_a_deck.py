"""A helicopter on compliant skids on a rolling deck, in the plane (SRAMSS-2D): slip, and the effect of lashings.

The structure is that of section V of Schock & Langlois; all parameters are assumed (`kanefe_fem.sramss.parameters`).
The deck rolls by 8 degrees. With a friction coefficient of 0.3 the skids never slide; on a wet deck with 0.15 they
slide down in every half roll, one after the other; two lashings of 2 kN hold them.
"""

import math
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from kanefe_fem.sramss import Deck, from_level, lashing_length, level_rest, planar_scene

roll = Deck(amplitude=math.radians(8.0))
length = lashing_length()
cases = {
    "dry, mu 0.3": {"mu": 0.3},
    "wet, mu 0.15": {"mu": 0.15},
    "wet, lashed": {"mu": 0.15, "lashed": length},
}
figure, axes = plt.subplots(3, 1, figsize=(8.0, 8.0), sharex=True, layout="constrained")
slips = {}
for name, options in cases.items():
    rest, _ = level_rest(lashed=options.get("lashed", 0.0))
    scene = planar_scene(roll, skids="rough", **options)
    result = scene.simulate((0.0, 30.0), start=from_level(scene, rest), output_step=0.02)
    port = result.contact("port skid")
    slips[name] = port.slip[-1]
    first = result.events["port skid slip"]
    said = f"slips first at {first[0]:.3f} s, by {1e3 * port.slip[-1]:.1f} mm in 30 s" if len(first) else "never slips"
    print(f"{name}: the port skid {said}; {result.statistics['seconds']:.1f} s")
    axes[1].plot(result.times, port.tangential / np.maximum(port.normal, 1.0), label=name, linewidth=1.0)
    axes[2].plot(result.times, port.slip, label=name)
axes[0].plot(result.times, np.degrees(roll.angle(result.times)), color="0.3")
for ax, label in zip(axes, ("roll of the deck [deg]", "T / N of the port skid", "its slip [m]"), strict=True):
    ax.set_ylabel(label)
    ax.grid(color="0.9")
axes[1].legend(loc="lower right", ncols=3, fontsize="small")
axes[2].set_xlabel("time [s]")
out = Path("out")
out.mkdir(exist_ok=True)
figure.savefig(out / "helicopter_on_a_deck.png", dpi=120)

# sticking friction has exactly zero slip
checked = (float(slips["dry, mu 0.3"]), 0.0, 1e-12)
print(f"dry: slip {checked[0]:g} m")
