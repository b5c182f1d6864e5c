"""A project from an assembly: the script that reads it, with the joints that were found, for `kanefe new --step`."""

from __future__ import annotations

import shutil
import warnings
from pathlib import Path

from kanefe_fem.assemblies.assembly import Assembly
from kanefe_fem.assemblies.proposals import KINDS, ProposedJoint
from kanefe_fem.assemblies.reading import read_step

SCRIPT = '''"""{name}: the assembly {file}. Units: SI.

Found in the file, on its first reading:

{found}
"""

from pathlib import Path

from kanefe_fem import read_step

HERE = Path(__file__).parent

# Densities in kg/m3, or Material(E=..., nu=..., rho=...) of kanefe_fem, by name of part, product or
# colour; "*": all others. The file has no materials: steel is a guess.
MATERIALS = {{"*": 7850.0}}

GROUND = {ground!r}  # the part that stands still: the largest, until you choose

# Joints that may be, as the faces of two parts propose them. NONE IS TAKEN YET: remove the # before those that are
# joints, and choose their kind: "fixed", "revolute", "cylindrical" or "prismatic".
JOINTS = {{
{joints}
}}

assembly = read_step(HERE / {file!r}, MATERIALS, overlaps=False)
left_out = assembly.unreached(GROUND, JOINTS)
scene = assembly.scene(GROUND, JOINTS, without=left_out)
print(scene)
if left_out:
    print("left out, because no joint that is taken reaches them:", ", ".join(left_out))

if JOINTS:
    result = scene.simulate((0.0, 1.0))
    print(result)
    print("written:", result.to_html(HERE / "run.html"))
else:
    print("nothing moves: take joints in JOINTS")
'''


def step_project(folder: Path, step: str) -> list[Path]:
    """Write the files of a project for an assembly to a folder that is there, and return them.

    Parameters
    ----------
    folder : Path
    step : str
        A STEP file, which is copied.

    Raises
    ------
    FileError, MeshError, ModelError
        As `kanefe_fem.read_step`.
    """
    source = Path(step)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        assembly = read_step(source)
    notes = [f"Note: {one.message}" for one in told if issubclass(one.category, Warning)]
    copy = folder / source.name
    shutil.copyfile(source, copy)
    script = folder / "run.py"
    script.write_text(script_of(assembly, folder.name, notes), encoding="utf-8")
    return [copy, script]


def script_of(assembly: Assembly, name: str, notes: list[str]) -> str:
    """Return the script of an assembly."""
    largest = max(assembly.parts.values(), key=lambda part: part.volume)
    joints = [_line(joint) for joint in assembly.joints.values()]
    found = "\n".join([str(assembly), *notes]).replace("\\", "/").replace('"""', "'''")
    return SCRIPT.format(
        name=name,
        file=assembly.source,
        found=found,
        ground=largest.name,
        joints="\n".join(joints) or "    # no shaft in a hole and no planes face to face were found",
    )


def _line(joint: ProposedJoint) -> str:
    kind = "revolute" if joint.kind == "cylindrical" else joint.kind if joint.kind in KINDS else "fixed"
    return f"    # {joint.name!r}: {kind!r},  # {joint.certainty}: {joint.reason}"
