#!/usr/bin/env bash
# CalculiX 2.20 (Debian 12), *FREQUENCY, SOLVER=MATRIXSTORAGE: with GLOBAL=NO the stored stiffness is in the axes that *TRANSFORM
# gives to nodes, the stored mass in global ones, bit for bit as without it. The two do not belong together: the mass of a
# body differs between directions. Besides: a keyword with blanks before it, right behind the lines of *HEADING, is one of them.
# Seen: K turned to 1e-14, M the same in every digit; no node of a block "  *NODE" behind a heading.
set -euo pipefail
command -v ccx > /dev/null || { echo "needs CalculiX 2.20: apt install calculix-ccx python3-numpy"; exit 2; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 - <<'PYTHON'
import subprocess

import numpy as np

cube = ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))
nodes = "*NODE, NSET=ALL\n" + "".join(f"{i},{x}.,{y}.,{z}.\n" for i, (x, y, z) in enumerate(cube, 1))
body = "*ELEMENT, TYPE=C3D8, ELSET=E\n1,1,2,3,4,5,6,7,8\n*MATERIAL, NAME=S\n*ELASTIC\n2.1E11,.3\n*DENSITY\n7850.\n"
body += "*SOLID SECTION, ELSET=E, MATERIAL=S\n"
axes = "*NSET, NSET=T\n7\n*TRANSFORM, NSET=T, TYPE=R\n1.,1.,0.,-1.,1.,0.\n"


def run(deck):
    with open("job.inp", "w") as file:
        file.write(deck)
    return subprocess.run(["ccx", "job"], capture_output=True, text=True, stdin=subprocess.DEVNULL)


def stored(suffix):
    rows = np.loadtxt("job." + suffix)
    A = np.zeros((24, 24))
    i, j = rows[:, :2].astype(int).T - 1
    A[i, j] = A[j, i] = rows[:, 2]
    return A


found = {}
for option in ("", ", GLOBAL=NO"):
    run(nodes + body + axes + f"*STEP\n*FREQUENCY, SOLVER=MATRIXSTORAGE{option}\n*END STEP\n")
    found[option] = stored("sti"), stored("mas")
turn = np.eye(24)
turn[18:21, 18:21] = np.array(((1, -1, 0), (1, 1, 0), (0, 0, 2**0.5))) / 2**0.5  # columns are the axes of node 7
(K, M), (k, m) = found.values()
off = abs(k - turn.T @ K @ turn).max() / abs(K).max()
print(f"GLOBAL=NO: K turned to {off:.0e}, M {'as without it' if (m == M).all() else 'turned'}")
assert off < 1e-12 and (m == M).all(), "this has changed"
heading = "*HEADING\na cube\n  " + nodes + body + "*STEP\n*FREQUENCY, SOLVER=MATRIXSTORAGE\n*END STEP\n"
done = run(heading)
print("keyword with blanks behind a heading:", "lost" if done.returncode else "read")
assert done.returncode, "this has changed"
PYTHON
