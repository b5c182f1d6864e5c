#!/usr/bin/env bash
# yourdfpy 0.0.60 refuses a whole URDF file for a shape that it does not know or that is empty, also where no shape is wanted
# (build_scene_graph=False, load_meshes=False): ValueError "Unknown tag: capsule", IndexError for an empty <geometry/>,
# TypeError for a <visual> without one. Files of bullet3 have <capsule> and <plane>; readers of pybullet and Drake take them.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv own
own/bin/pip install -q --disable-pip-version-check yourdfpy==0.0.60 numpy==1.26.4
own/bin/python - <<'PYTHON'
import io, logging
import yourdfpy

logging.disable(logging.CRITICAL)
ROBOT = "<robot name='r'><link name='base'/><link name='a'>{}</link><joint name='j' type='continuous'><parent link='base'/><child link='a'/></joint></robot>"
SHAPES = {
    "sphere": ("<collision><geometry><sphere radius='.1'/></geometry></collision>", None),
    "capsule": ("<collision><geometry><capsule radius='.1' length='.2'/></geometry></collision>", ValueError),
    "empty geometry": ("<visual><geometry/></visual>", IndexError),
    "visual without geometry": ("<visual><origin xyz='0 0 0'/></visual>", TypeError),
}
for name, (shape, expected) in SHAPES.items():
    raised = None
    try:
        yourdfpy.URDF.load(io.BytesIO(ROBOT.format(shape).encode()), build_scene_graph=False, load_meshes=False, mesh_dir="")
    except Exception as error:
        raised = error
    print(f"{name}: {type(raised).__name__}: {raised}" if raised else f"{name}: read")
    assert (None if raised is None else type(raised)) is expected, "this has changed"
PYTHON
