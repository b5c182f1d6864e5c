"""What the modes of a body miss of what it carries in a scene: against bodies that miss nothing."""

import re
import warnings

import numpy as np
import pytest

import kanefe as kf
from kanefe.errors import AccuracyWarning
from kanefe_fem import Material, Rectangle, beam_body, straight_beam

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
ALL = ("gravity", "angular acceleration", "centrifugal", "span")


def blade(modes: int, loads: tuple[str, ...] = (), length: float = 1.0) -> kf.FlexibleBody:
    model = straight_beam(length, Rectangle(0.05, 0.02), STEEL, elements=20)
    return beam_body(model, {"root": "clamped"}, reduction=kf.CraigBampton(modes=modes, loads=loads))


def scene_of(body: kf.FlexibleBody, gravity=(0.0, 0.0, 0.0), spin: float = 0.0, line=None) -> kf.System:
    scene = kf.System(gravity=gravity)
    member = scene.add_flexible_body("blade", body, joint=kf.Revolute("z", motion=kf.Motion.steady(spin)))
    if line is not None:
        scene.add_line_load(member, "span", line)
    return scene


CASES = {
    "gravity": ({"gravity": (0.0, 0.0, -9.81)}, 1),
    "centrifugal": ({"spin": 30.0, "gravity": (0.0, 0.0, -9.81)}, 8),  # they bend, and none of them stretches
    "span": ({"line": (0.0, 0.0, 200.0)}, 1),
}


@pytest.mark.parametrize("load", CASES)
def test_the_share_is_that_of_the_energy(load):
    """Of a static response E the modes hold E_m: root of 1 - E_m / E."""
    options, modes = CASES[load]
    energies = []
    for body in (blade(modes), blade(modes, ALL)):
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            rest = kf.equilibrium(scene_of(body, **options))
        energies.append(rest.energy.elastic)
        if len(energies) == 1:
            message = str(next(w.message for w in told if w.category is AccuracyWarning))
        else:
            assert not [w for w in told if w.category is AccuracyWarning]
    share = 100.0 * np.sqrt(1.0 - energies[0] / energies[1])
    assert f"the modes of 'blade' miss {share:.2g} % of its deformation" in message
    assert f"loads=('{load}',)" in message


@pytest.mark.parametrize("load", CASES)
def test_a_linearisation_tells_it_too(load):
    """At the start, which is not deformed yet, as in balance; and once, where an equilibrium has told it."""
    options, modes = CASES[load]
    words = []
    for ask in (kf.equilibrium, kf.linearise, lambda scene: kf.equilibrium(scene).linearise()):
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            ask(scene_of(blade(modes), **options))
        found = [w for w in told if w.category is AccuracyWarning and "modes" in str(w.message)]
        assert [w.filename for w in found] == [__file__]
        words.append(str(found[0].message).partition(": "))
    assert [word[0] for word in words] == ["equilibrium", "linearise", "equilibrium"]
    shares = [float(re.search(r"miss ([\d.]+) %", word[2])[1]) for word in words]
    assert shares[1] == pytest.approx(shares[0], rel=0.02)


def test_enough_modes_are_not_told():
    """Four modes, two a plane, hold all but 2 % of a bent beam; the stretch of one that hangs is not felt."""
    for gravity in ((0, 0, -9.81), (9.81, 0, 0)):
        with warnings.catch_warnings():
            warnings.simplefilter("error", AccuracyWarning)
            kf.equilibrium(scene_of(blade(4), gravity=gravity))
            kf.linearise(scene_of(blade(4), gravity=gravity))


def test_runs_tell_it_in_print():
    few = scene_of(blade(8), spin=30.0).simulate((0.0, 0.02), rtol=1e-5)
    assert "miss" in str(few)
    assert "loads=('centrifugal',)" in str(few)
    enough = scene_of(blade(8, ("centrifugal",)), spin=30.0).simulate((0.0, 0.02), rtol=1e-5)
    assert "miss" not in str(enough)


def test_a_campbell_diagram_tells_it_once():
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        kf.campbell(lambda speed: scene_of(blade(4), spin=speed), np.linspace(0.0, 30.0, 4), modes=2)
    words = [str(w.message) for w in told if w.category is AccuracyWarning]
    assert len(words) == 1
    assert "campbell at 30 rad/s: the modes of 'blade' miss" in words[0]


def test_a_body_in_free_fall_carries_nothing():
    model = straight_beam(1.0, Rectangle(0.05, 0.02), STEEL, elements=20)
    body = beam_body(model, {}, reduction=kf.CraigBampton(modes=1))
    scene = kf.System(gravity=(0, 0, -9.81))
    scene.add_flexible_body("bar", body, joint=kf.Free())
    assert "miss" not in str(scene.simulate((0.0, 0.1)))
    scene = kf.System(gravity=(0, 0, -9.81))
    scene.add_flexible_body("blade", blade(1), joint=kf.Prismatic("z"))
    assert "miss" not in str(scene.simulate((0.0, 0.1)))


def test_what_is_left_out_is_the_residual_flexibility():
    """R and D of the record against dense solutions of the finite-element matrices."""
    model = straight_beam(1.0, Rectangle(0.05, 0.02), STEEL, elements=8)
    body = beam_body(model, {"root": "clamped"}, reduction=kf.CraigBampton(modes=3))
    record = body.provenance["reduction"]["left_out"]
    K, M = model.stiffness.toarray(), model.mass.toarray()
    free = np.arange(6, len(K))
    V = body.basis[free][:, :3]
    flexibility = np.linalg.inv(K[np.ix_(free, free)])
    flexibility -= V @ np.linalg.solve(V.T @ K[np.ix_(free, free)] @ V, V.T)
    forces = {
        "gravity": (M @ model.rigid_modes())[free, :3],
        "span traction": model.load_patterns["span"].traction[free],
    }
    for i, (name, component) in enumerate(record["loads"]):
        if name in forces:
            f = forces[name][:, component]
            u = flexibility @ f
            assert record["energy"][i][i] == pytest.approx(f @ u, rel=1e-6)  # a difference: 1e-6 is kept at least
            mean = u @ M[np.ix_(free, free)] @ u / body.mass
            assert record["displacement"][i][i] == pytest.approx(mean, rel=1e-6)
    assert {name for name, _ in record["loads"]} >= set(forces)
