"""A slider-crank from a STEP file of four parts: joints are found where faces meet, the rod is meshed and bends.

Here gmsh writes the file, as a CAD program would; it writes no names of parts, so these are put into its text.
"""

import re
from io import BytesIO
from pathlib import Path

import gmsh
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

import kanefe as kf
from kanefe.views.still import picture_of_run
from kanefe_fem import Material, read_step

CRANK, ROD, PIN = 40.0, 120.0, 6.0  # mm
NAMES = ("frame", "crank", "rod", "slider")


def bar(occ, start, length, low, bores):
    """Return a bar along x with round ends, 8 mm thick from a height on, and with bores."""
    box = (3, occ.addBox(start, -12, low, length, 24, 8))
    ends = [(3, occ.addCylinder(start + x, 0, low, 0, 0, 8, 12)) for x in (0, length)]
    whole, _ = occ.fuse([box], ends)
    if bores:
        whole, _ = occ.cut(whole, [(3, occ.addCylinder(x, 0, low - 1, 0, 0, 10, PIN)) for x in bores])
    return whole


def draw(path):
    """Write the STEP file."""
    gmsh.initialize(["crank"], readConfigFiles=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setString("Geometry.OCCTargetUnit", "MM")
    occ = gmsh.model.occ
    # the frame: a plate with a pin for the crank, and a slot for the slider
    plate = (3, occ.addBox(-30, -20, -12, 240, 40, 12))
    rails = [(3, occ.addBox(100, y, 0, 110, 5, 27)) for y in (-20, 15)]
    occ.fuse([plate], [*rails, (3, occ.addCylinder(0, 0, 0, 0, 0, 9, PIN))])
    occ.fuse(bar(occ, 0, CRANK, 1, (0,)), [(3, occ.addCylinder(CRANK, 0, 9, 0, 0, 9, PIN))])
    bar(occ, CRANK, ROD, 10, (CRANK, CRANK + ROD))
    block = (3, occ.addBox(CRANK + ROD - 18, -15, 0, 36, 30, 9))
    occ.fuse([block], [(3, occ.addCylinder(CRANK + ROD, 0, 9, 0, 0, 9, PIN))])
    occ.synchronize()
    gmsh.write(str(path))
    gmsh.finalize()
    text = path.read_text()
    unnamed = re.findall(r"PRODUCT\('(Open CASCADE STEP translator [0-9.]+ [0-9.]+)'", text)[-len(NAMES) :]
    for name, old in zip(NAMES, unnamed, strict=True):
        text = text.replace(f"'{old}'", f"'{name}'")
    path.write_text(text)


out = Path("out")
out.mkdir(exist_ok=True)
draw(out / "crank.step")

plastic = Material(E=3e9, nu=0.35, rho=1150.0)
found = read_step(out / "crank.step", {"rod": plastic, "*": 2700.0}, flexible=["rod"], size=0.012)
print(found)

# None of the joints is taken by itself. The first gets the motor that turns the crank.
SPEED = 20.0  # rad/s
taken = {
    "frame in crank": kf.Revolute("z", motion=kf.Motion.steady(SPEED)),
    "crank in rod": "revolute",
    "slider in rod": "revolute",
    "frame on slider": "prismatic",
}
scene = found.scene("frame", taken, gravity=(0.0, 0.0, 0.0), reduction=kf.CraigBampton(modes=4))
print(scene)

result = scene.simulate((0.0, np.pi / SPEED), output_step=np.pi / SPEED / 60, rtol=1e-6)
print(result)
travel = 1e3 * np.ptp(result.position("slider")[:, 0])
print(f"the slider travels {travel:.3f} mm in half a turn, twice the crank is {2 * CRANK:.3f} mm")

figure, views = plt.subplot_mosaic([["start", "turning", "late"], ["curve"] * 3], figsize=(9, 5), layout="constrained")
for name, row in (("start", 0), ("turning", 24), ("late", 48)):
    views[name].imshow(plt.imread(BytesIO(picture_of_run(result, row))))
    views[name].set_title(f"{1e3 * result.times[row]:.0f} ms")
    views[name].axis("off")
views["curve"].plot(1e3 * result.times, 1e3 * result.position("slider")[:, 0])
views["curve"].set(xlabel="time [ms]", ylabel="slider [mm]")
figure.savefig(out / "crank_from_cad.png", dpi=120)

# The rod is elastic: its inertia stretches it by less than a thousandth of a millimetre.
checked = (travel, 2 * CRANK, 2e-3)  # mm
