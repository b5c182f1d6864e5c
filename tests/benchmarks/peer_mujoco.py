"""Chains by MuJoCo, in joint coordinates, without contacts and constraints."""

from __future__ import annotations

import time
from typing import Any

import mujoco
import numpy as np
from mujoco import rollout

Answer = dict[str, Any]

# Steps that are too large are part of the search; else it writes a log into the folder.
mujoco.set_mju_user_warning(lambda _: None)


def mujoco_chain(links: list[Answer], gravity: list[float]) -> Any:
    """Return the model of a chain of links, stepped by the Runge-Kutta method of order 4."""
    bodies = ""
    for link in links:
        axis = "0 1 0" if link["axis"] == "y" else "0 0 1"
        bodies += (
            f'<body pos="{_text(link["at"])}"><joint type="hinge" axis="{axis}"/>'
            f'<inertial pos="{_text(link["com"])}" mass="{link["mass"]!r}" diaginertia="{_text(link["inertia"])}"/>'
        )
    text = (
        f'<mujoco><option integrator="RK4" gravity="{_text(gravity)}">'
        '<flag contact="disable" constraint="disable"/></option>'
        f"<worldbody>{bodies}{'</body>' * len(links)}</worldbody></mujoco>"
    )
    return mujoco.MjModel.from_xml_string(text)


def solve_chain(model: Any, q: list[float], steps: int, h: float) -> Answer:
    """Take steps, all of them in compiled code, and tell where the last link's centre of mass is."""
    model.opt.timestep = h
    data = mujoco.MjData(model)
    data.qpos[:] = q
    start = time.process_time()
    mujoco.mj_step(model, data, nstep=steps)
    seconds = time.process_time() - start
    mujoco.mj_kinematics(model, data)
    return {"seconds": seconds, "end": data.xipos[-1].tolist()}


def roll_out(model: Any, starts: list[list[float]], steps: int, h: float) -> Answer:
    """Take steps from many starts (angles, rates), and tell where the last link's centre of mass is after each."""
    model.opt.timestep = h
    data = mujoco.MjData(model)
    whole = mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    first = np.zeros((len(starts), whole))
    first[:, 1 : 1 + model.nq + model.nv] = starts  # behind the time
    start = time.process_time()
    states, _ = rollout.rollout(model, [data], first, nstep=steps)
    seconds, ends = time.process_time() - start, []
    for state in states[:, -1]:
        data.qpos[:] = state[1 : 1 + model.nq]
        mujoco.mj_kinematics(model, data)
        ends.append(data.xipos[-1].tolist())
    return {"seconds": seconds, "ends": ends}


def call_forward(model: Any, q: list[float], count: int) -> Answer:
    """Evaluate the accelerations of a chain at rest many times."""
    data, forward = mujoco.MjData(model), mujoco.mj_forward
    data.qpos[:] = q
    start = time.process_time()
    for _ in range(count):
        forward(model, data)
    return {"seconds": time.process_time() - start, "end": data.qacc.tolist()}


def _text(vector: list[float]) -> str:
    return " ".join(map(repr, vector))
