#!/usr/bin/env bash
# MuJoCo 4.0.0 takes a keyframe whose qpos, qvel or ctrl has fewer numbers than the model, by any way of loading: the rest is that
# of the initial pose, or zero, without an error or a warning. mpos and mquat that are too short are dropped as a whole. What is
# too long is an error. A keyframe written before a joint was added thus goes on loading, with the joints behind it moved.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv own
own/bin/pip install -q --disable-pip-version-check mujoco==4.0.0
own/bin/python - <<'PYTHON'
import mujoco

MODEL = """<mujoco><worldbody><body name="m" mocap="true" pos="5 6 7"/><body><joint name="a"/><geom size=".1"/><body>
<joint name="b" ref="30"/><geom size=".1"/></body></body></worldbody><actuator><motor joint="a"/><motor joint="b"/></actuator>
<keyframe><key {}="{}"/></keyframe></mujoco>"""
for what, given, expected in (
    ("qpos", "1", [1.0, 0.5235987755982988]),
    ("qvel", "1", [1.0, 0.0]),
    ("mpos", "1 2", [5.0, 6.0, 7.0]),
    ("qpos", "1 2 3", None),
    ("ctrl", "1", [1.0, 0.0]),
):
    try:
        found = getattr(mujoco.MjModel.from_xml_string(MODEL.format(what, given)), f"key_{what}")[0].tolist()
    except ValueError as error:
        found = None
        print(f"{what} of {len(given.split())}: {str(error).splitlines()[0]}")
    else:
        print(f"{what} of {len(given.split())}: taken as {found}")
    assert found == expected, "this has changed"
PYTHON
