"""Run an example as a user does, and draw it where it does not draw itself.

Called as `run_example.py SCRIPT FOLDER STEM`: what it prints, its checked number and its picture go to FOLDER.
"""

import contextlib
import io
import json
import runpy
import shutil
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from drawings import DRAWN, OWN, PLAYED
from kanefe_fem import recover

folder, stem = Path(sys.argv[2]), sys.argv[3]
printed = io.StringIO()
try:
    with contextlib.redirect_stdout(printed):
        names = runpy.run_path(str(Path("examples") / f"{stem}.py"))
except SystemExit as missing:  # a program of others that it needs is not here
    (folder / "done.json").write_text(json.dumps({"not run": str(missing)}), encoding="utf-8")
    sys.exit()
picture = folder / "picture.png"
if stem in OWN:
    shutil.copy(Path("out") / OWN[stem], picture)
else:
    DRAWN[stem](names).savefig(picture, dpi=110)
if stem in PLAYED:
    result = names["result"]
    known = [name for name in result.bodies if getattr(result.body(name).elasticity, "fibres", None) is not None]
    stress = [recover(result, name) for name in known]  # of beams: that of solids would make the page of a site large
    result.to_html(folder / "run.html", stress=stress, fps=50, title=" ".join(stem.split("_")[1:]))
value, reference, tolerance = names["checked"]
done = {"printed": printed.getvalue(), "checked": [float(value), float(reference), float(tolerance)]}
(folder / "done.json").write_text(json.dumps(done), encoding="utf-8")
