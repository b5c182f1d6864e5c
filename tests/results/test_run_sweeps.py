"""What a result reads from compiled sweeps over all states is what the literal route says of each."""

from collections.abc import Callable

import numpy as np
import pytest

import kanefe as kf
from kanefe.equations.model import Model
from kanefe.integrate.run import integrate
from kanefe.integrate.trajectory import Trajectory
from kanefe.results.channels import RunChannels
from kanefe.results.quantities import ENERGIES, MOMENTA, MOTIONS
from kanefe_fem.beams.body import straight_beam
from kanefe_fem.beams.sections import Rectangle
from loop_scenes import spatial_loop
from random_scenes import Recipe, planar_model, random_model
from result_scenes import SOFT, robot
from scenes import random_state

TIMES = np.array((0.0, 0.1, 0.35))


def wandering(model: Model) -> Trajectory:
    """Return a run whose states have nothing to do with each other, so that no order of them can hide a mistake."""
    states = [random_state(model, seed) for seed in range(len(TIMES))]
    q, u = (np.array(part) for part in zip(*states, strict=True))
    z = np.tile(model.initial_states, (len(TIMES), 1))
    none = np.zeros(len(TIMES))
    return Trajectory(TIMES, q, u, none, none, {}, internal=z)


SCENES: dict[str, Callable[[], Model]] = {
    "flexible": lambda: random_model(Recipe(4, bodies=8, elastic=0.5, loads=5, slopes="tait-bryan")),
    "springs": lambda: random_model(Recipe(5, bodies=8, elastic=0.4, loads=3, between=4)),
    "planar": lambda: planar_model(Recipe(6, bodies=8, loads=3)),
    "loop": lambda: spatial_loop(2).freeze(),
}


@pytest.mark.parametrize("name", SCENES)
def test_channels_are_those_of_the_literal_route(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    model = SCENES[name]()
    run = wandering(model)
    swept, literal = RunChannels(model, run), RunChannels(model, run)
    assert swept.is_swept
    monkeypatch.setattr(literal, "swept", literal.literal)
    keys = [(quantity, "", "") for quantity in (*ENERGIES, *MOMENTA)]
    keys += [(q, s.name, n) for s in swept.bodies for n in ("", *s.interfaces) for q in MOTIONS]
    keys += [("load", load, "") for load in swept.loads]
    assert name != "springs" or len(swept.loads) == 4
    for quantity, body, interface in keys:
        found, expected = (channels.read(quantity, body, interface) for channels in (swept, literal))
        if quantity == "rotation":  # its signs are another matter
            expected = expected * np.sign(np.sum(expected * found, axis=1))[:, None]
        # round-off of sums, of the largest number in them
        size = max(1.0, abs(expected).max())
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9 * size, err_msg=f"{quantity} {body} {interface}")


def test_motions_are_the_same_whatever_is_read_first() -> None:
    """Those without accelerations are read from those with them, where these are there."""
    model = SCENES["flexible"]()
    one, other = (RunChannels(model, wandering(model)) for _ in range(2))
    found = [one.read(quantity, "b3") for quantity in MOTIONS]
    for quantity, expected in reversed(list(zip(MOTIONS, found, strict=True))):  # accelerations first
        np.testing.assert_array_equal(other.read(quantity, "b3"), expected, err_msg=quantity)


def test_contacts_of_patches_and_driven_bodies_are_told_alike(monkeypatch: pytest.MonkeyPatch) -> None:
    """A node of a beam rubs on a deck that is driven: frames of nodes, which no sweep has, and of given motions."""
    scene = kf.System(gravity=(0.0, 0.0, -9.81))
    deck = scene.add_rigid_body("deck", 1.0, 1.0, joint=kf.Revolute("x", motion=kf.Motion.steady(0.2)))
    plate = scene.add_surface("plate", deck, kf.shapes.Plane("z"))
    model = straight_beam(1.0, Rectangle(0.02, 0.04), SOFT, elements=4)
    body = kf.flexible_body(model, {}, reduction=kf.CraigBampton(modes=4))
    beam = scene.add_flexible_body("beam", body, joint=kf.Free(position=(0.0, 0.0, -1e-3), velocity=(0.3, 0.1, 0.0)))
    for node in (0, 2, 4):
        friction = kf.Coulomb(0.3, stiffness=1e4, damping=10.0)
        scene.add_contact(f"rub {node}", beam.node(node), plate, normal=kf.KelvinVoigt(1e3), friction=friction)
    result = scene.simulate((0.0, 0.05), output_step=0.01)
    model_of = result.run.model
    swept, literal = (RunChannels(model_of, result.run.trajectory) for _ in range(2))
    assert swept.is_swept
    monkeypatch.setattr(literal, "swept", literal.literal)
    for name in swept.loads:
        found, expected = swept.read("load", name), literal.read("load", name)
        assert np.abs(expected).max() > 1e-3
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9 * np.abs(expected).max())


def test_signs_of_euler_parameters_do_not_depend_on_the_outputs() -> None:
    scene = kf.System()
    top = scene.add_rigid_body("top", 1.0, 1.0, joint=kf.Revolute("z", speed=7.0))
    scene.add_rigid_body("ball", 1.0, 1.0, parent=top, at=(1, 0, 0), joint=kf.Universal(speed=(3.0, 1.0)))
    model = scene.freeze()  # eleven turns; outputs of the second run are four turns apart and more
    runs = (integrate(model, (0.0, 10.0), output_times=times) for times in (np.linspace(0, 10, 401), (0, 4, 10)))
    close, far = (kf.Result(model, run).rotation("ball") for run in runs)
    np.testing.assert_allclose(far, close[[0, 160, 400]], atol=1e-5)  # two runs at rtol 1e-6, over 70 rad
    assert np.linalg.norm(np.diff(close, axis=0), axis=1).max() < 0.2  # half of some 10 rad/s in 0.025 s


def hanging(reduction: object) -> kf.Result:
    beam = straight_beam(1.0, Rectangle(0.02, 0.04), SOFT, elements=2)
    body = kf.flexible_body(beam, {"root": "clamped"}, reduction=reduction)
    scene = kf.System(gravity=(1.0, 2.0, -9.81))
    hub = scene.add_rigid_body("hub", 1.0, 0.1, com=(0.1, 0, 0.2), joint=kf.Revolute("y"))
    scene.add_flexible_body("arm", body, parent=hub, at=(0.1, 0, 0))
    return scene.simulate((0.0, 0.02), method="generalised-alpha", rtol=1e-3, output_step=0.01)


@pytest.mark.parametrize("make", [robot, lambda: hanging(None)], ids=["reduced", "unreduced"])
def test_the_energy_of_position_is_that_of_the_centre_of_mass(make: Callable[[], kf.Result]) -> None:
    result = make()
    assert result.run is not None
    masses = {name: result.body(name).mass for name in result.bodies}
    parts = sum(mass * result.center_of_mass(name) for name, mass in masses.items())
    np.testing.assert_allclose(result.center_of_mass() * sum(masses.values()), parts, atol=1e-14)
    np.testing.assert_allclose(-parts @ result.run.model.gravity, result.energy.gravity, atol=1e-12)


def stiffened() -> Model:
    """A hub with a stiffened arm on it that carries a tool, all of which turn in space."""
    beam = straight_beam(1.0, Rectangle(0.02, 0.04), SOFT, elements=4)
    turned = kf.Interface(axes=kf.rotation_about((1, 2, 3), 0.7))
    body = kf.flexible_body(
        beam, {"root": "clamped", "tip": turned}, reduction=kf.CraigBampton(modes=3), stiffening="full"
    )
    scene = kf.System(gravity=(1.0, 2.0, -9.81))
    hub = scene.add_rigid_body("hub", 1.0, np.diag((1.0, 2.0, 2.5)), com=(0.1, 0, 0.2), joint=kf.Spherical())
    arm = scene.add_flexible_body("arm", body, parent=hub, at=(0.1, 0, 0), joint=kf.Revolute("z"))
    scene.add_rigid_body("tool", 0.5, 0.1, com=(0, 0.1, 0), parent=arm.interface("tip"), joint=kf.Universal())
    return scene.freeze()


BARE: dict[str, Callable[[], Model]] = {
    "flexible": lambda: random_model(Recipe(4, bodies=8, elastic=0.5, loads=0)),
    "rigid": lambda: random_model(Recipe(5, bodies=8, elastic=0.0, loads=0)),
    "stiffened": stiffened,
}


@pytest.mark.parametrize("name", BARE)
def test_reactions_of_all_states_are_those_of_each(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    model = BARE[name]()
    run = wandering(model)
    if name == "stiffened":  # bent no beyond the valid range of its stiffening
        run.coordinates[:, model.flexible_terms("arm").eta] *= 0.05
    swept, literal = RunChannels(model, run), RunChannels(model, run)
    monkeypatch.setattr(literal, "swept", literal.literal)
    keys = [("joint_reaction", shape.name, "") for shape in swept.bodies]
    keys += [("coupling_force", shape.name, n) for shape in swept.bodies for n in shape.interfaces]
    for key in keys:
        found, expected = swept.read(*key), literal.read(*key)
        size = max(1.0, abs(expected).max())  # round-off of sums, of the largest number in them
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9 * size, err_msg=" ".join(key))
    assert any(swept.read(*key).any() for key in keys)
