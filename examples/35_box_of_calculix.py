"""An arm of CalculiX: its program assembles, kanefe reads the matrices, and the arm swings with a load.

CalculiX is a free program that solves decks in the language of Abaqus: `sudo apt-get install calculix-ccx`.
"""

import re
import shutil
import subprocess
from itertools import product
from pathlib import Path

import numpy as np

import kanefe as kf
from kanefe_fem import recover

if shutil.which("ccx") is None:
    raise SystemExit("this example needs CalculiX: sudo apt-get install calculix-ccx")

SIZE, COUNTS = (0.6, 0.04, 0.03), (8, 2, 2)  # m, bricks of 20 nodes
CORNERS = [(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (0, 0, 2), (2, 0, 2), (2, 2, 2), (0, 2, 2)]
EDGES = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
BRICK = np.array(CORNERS + [tuple((np.array(CORNERS[a]) + CORNERS[b]) // 2) for a, b in EDGES])


def deck(last_step, supports=""):
    """Return a deck of the arm: nodes at half the bricks, without those in the middles of faces and bricks."""
    halves = [range(2 * n + 1) for n in COUNTS]
    label = {p: i for i, p in enumerate((p for p in product(*halves) if sum(k % 2 for k in p) < 2), start=1)}
    nodes = [f"{i}, {', '.join(f'{x:.12g}' for x in SIZE * np.array(p) / COUNTS / 2)}" for p, i in label.items()]
    bricks = []
    for e, first in enumerate(product(*map(range, COUNTS)), start=1):
        own = [str(label[tuple(2 * np.array(first) + corner)]) for corner in BRICK]
        bricks += [", ".join([str(e), *own[:10]]) + ",", ", ".join(own[10:])]
    places = (("ROOT", 0), ("TIP", 2 * COUNTS[0]))
    ends = {name: [i for p, i in label.items() if p[0] == at] for name, at in places}
    sets = [line for name, own in ends.items() for line in (f"*NSET, NSET={name}", *(f"{i}," for i in own))]
    head = ["*NODE", *nodes, "*ELEMENT, TYPE=C3D20, ELSET=ARM", *bricks, *sets]
    material = ["*MATERIAL, NAME=STEEL", "*ELASTIC", "210e9, 0.3", "*DENSITY", "7850."]
    section = ["*SOLID SECTION, ELSET=ARM, MATERIAL=STEEL"]
    return "\n".join(
        [*head, *material, *section, *supports.split("\n"), "*STEP", *last_step.split("\n"), "*END STEP", ""]
    )


out = Path("out")
out.mkdir(exist_ok=True)
(out / "arm.inp").write_text(deck("*FREQUENCY, SOLVER=MATRIXSTORAGE"))
(out / "held.inp").write_text(deck("*FREQUENCY\n6", supports="*BOUNDARY\nROOT, 1, 3"))
for job in ("arm", "held"):
    subprocess.run(["ccx", job], cwd=out, check=True, capture_output=True)

model = kf.read_calculix(out / "arm.inp", expected_mass=7850.0 * np.prod(SIZE))
arm = kf.flexible_body(model, {"ROOT": "clamped", "TIP": "rigid"}, reduction=kf.CraigBampton(modes=6))
print(arm)

scene = kf.System(gravity=(0, 0, -9.81))
member = scene.add_flexible_body("arm", arm, joint=kf.Revolute("y"))
scene.add_rigid_body("load", 5.0, 0.02, parent=member.interface("TIP"))
result = scene.simulate((0.0, 0.5), rtol=1e-6)
stress = recover(result, "arm").envelope("von_mises")
print(f"swings down with a load of 5 kg: stress up to {stress.peak / 1e6:.1f} MPa at {stress.peak_time:.3f} s")

alone = kf.flexible_body(model, {"ROOT": "clamped"}, reduction=kf.CraigBampton(modes=6))
lines = (out / "held.dat").read_text().splitlines()
of_ccx = [float(line.split()[3]) for line in lines if re.match(r"\s+[1-6]\s+\d\.\d+E", line)][:6]
for own, theirs in zip(alone.frequencies, of_ccx, strict=True):
    print(f"{own:12.6f} Hz, CalculiX {theirs:12.6f} Hz")

# CalculiX prints eight digits, and its own eigenvalue solver stops at about that.
checked = (alone.frequencies[0], of_ccx[0], 1e-6 * of_ccx[0])
