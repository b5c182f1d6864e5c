"""A good call of each public function; `bad_input` spoils its arguments one by one."""

from __future__ import annotations

import re
from importlib import import_module

from good_call import CALLS

for part in ("scenes", "joints", "laws", "seas", "bodies", "results", "studies", "elements", "others"):
    import_module(f"good_{part}")

QUICK = {
    name: made
    for name, made in CALLS.items()
    if re.match(
        r"kanefe\.(System\.add_(?!pressure|traction)|Interface|Near|InBox|InCylinder|OnPlane|Krylov|FreeInterface|Event)",
        name,
    )
    or re.match(r"kanefe_fem\.(?!solid|recover|beam|attach|straight|read|Assembly|ProposedJoint|UserEnergy|Mesh)", name)
    or re.match(r"kanefe\.(Result|Instant|Modes|Buckling)\.(?!plot|save|to_|view)", name)
}
"""Those that take some milliseconds."""
