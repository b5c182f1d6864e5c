"""Rigid contacts against Siconos (Debian's python3-siconos), an independent solver of set-valued laws.

It steps over impacts (Moreau and Jean), an error of the first order in the step, with which the difference has to fall;
kanefe locates events, so that what is left is Siconos' own.
"""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
from kanefe import shapes

G = 9.81
kernel = pytest.importorskip("siconos.kernel", reason="Siconos is not installed: apt install python3-siconos")


TIMES = np.linspace(0.0, 2.2, 56)


def stepped(q0, v0, step: float, stiffness: float, normal_law) -> np.ndarray:
    """Return positions (n, 2) along and above the floor of a mass of 1 kg at `TIMES`, by Siconos."""
    body = kernel.LagrangianLinearTIDS(list(q0), list(v0), np.eye(2))
    body.setKPtr(np.diag((stiffness, 0.0)))
    body.setFExtPtr([0.0, -G])
    rows = [[0.0, 1.0], [1.0, 0.0]]  # the gap, and what slips
    friction = isinstance(normal_law, kernel.NewtonImpactFrictionNSL)
    relation = kernel.LagrangianLinearTIR(rows if friction else rows[:1], [0.0, 0.0] if friction else [0.0])
    scene = kernel.NonSmoothDynamicalSystem(0.0, TIMES[-1] + step)
    scene.insertDynamicalSystem(body)
    scene.link(kernel.Interaction(normal_law, relation), body)
    problem = kernel.FrictionContact(2) if friction else kernel.LCP()
    method = kernel.TimeStepping(scene, kernel.TimeDiscretisation(0.0, step), kernel.MoreauJeanOSI(0.5), problem)
    places = [body.q().copy()]
    while method.hasNextEvent():
        method.computeOneStep()
        places.append(body.q().copy())
        method.nextStep()
    return np.array(places)[np.rint(TIMES / step).astype(int)]


def test_a_ball_that_bounces_is_that_of_siconos():
    scene = kf.System(gravity=(0, 0, -G))
    floor = scene.add_surface("floor", scene.ground, shapes.Plane("z"))
    ball = scene.add_point("ball", 1.0, joint=kf.Prismatic("z", position=1.0))
    scene.add_contact("c", ball, floor, normal=kf.Rigid(0.8))
    result = scene.simulate((0.0, TIMES[-1]), output_times=TIMES, rtol=1e-9)
    assert len(result.events["c touch"]) == 3
    apart = []
    for step in (2e-3, 2e-4):
        q = stepped((0.0, 1.0), (0.0, 0.0), step, 0.0, kernel.NewtonImpactNSL(0.8))
        apart.append(np.abs(result.position("ball")[:, 2] - q[:, 1]).max())
    # an impact is late by up to a step, at up to 4.4 m/s, and so is each that follows
    assert apart[0] < 0.02
    assert apart[1] < 0.2 * apart[0]


def test_a_block_on_a_spring_stops_where_that_of_siconos_does():
    """Coulomb's decay: 2 D = 2 mu g/w2 a swing, until it sticks off the middle."""
    k, mu, start = 100.0, 0.3, 0.2
    drop = mu * G / k
    swings = int(np.ceil((start - drop) / (2.0 * drop)))
    rest = (-1.0) ** swings * (start - 2.0 * drop * swings)
    scene = kf.System(gravity=(0, 0, -G))
    floor = scene.add_surface("floor", scene.ground, shapes.Plane("z"))
    block = scene.add_point("block", 1.0, joint=kf.Translation(position=(start, 0.0, 0.0)))
    scene.add_bushing("spring", scene.ground, block, stiffness=(k, 0.0, 0.0))
    scene.add_contact("c", block, floor, normal=kf.Rigid(0.0), friction=kf.Coulomb(mu))
    result = scene.simulate((0.0, TIMES[-1]), output_times=TIMES, rtol=1e-8)
    place = result.position("block")[:, 0]
    apart = []
    for step in (2e-3, 2e-4):
        q = stepped((start, 0.0), (0.0, 0.0), step, k, kernel.NewtonImpactFrictionNSL(0.0, 0.0, mu, 2))
        apart.append(np.abs(place - q[:, 0]).max())
    assert place[-1] == pytest.approx(rest, abs=1e-7)
    assert result.contact("c").status[-1] == "sticks"
    assert q[-1, 0] == pytest.approx(rest, abs=1e-4)
    assert apart[0] < 1e-3
    assert apart[1] < 0.2 * apart[0]
