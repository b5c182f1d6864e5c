"""What two bodies in a contact swing with: the masses of all that moves with each, in series."""

from __future__ import annotations

import math

import pytest

import kanefe as kf
from kanefe.contact.contact import compliant_contacts
from kanefe.loads.anchors import DAMPING_RATIO

SPRING = 3e4
LIGHT, HEAVY, CARRIED = 0.05, 20.0, 4.0


def masses() -> kf.System:
    """Return a light body, a heavy one that carries another, and what is driven, in contact with each other."""
    scene = kf.System()
    light = scene.add_rigid_body("light", LIGHT, 1e-3, joint=kf.Free())
    heavy = scene.add_rigid_body("heavy", HEAVY, 1.0, joint=kf.Prismatic("x"))
    carried = scene.add_rigid_body("carried", CARRIED, 1.0, parent=heavy, joint=kf.Revolute("z"))
    deck = scene.add_frame("deck", joint=kf.Prismatic("x", motion=kf.Motion.steady(1.0)))
    floors = {body.name: scene.add_surface(f"floor {body.name}", body, kf.shapes.Plane("z")) for body in (heavy, deck)}
    floors["ground"] = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    options = {"normal": kf.HuntCrossley(1e5, 0.3), "friction": kf.Coulomb(0.3, stiffness=SPRING)}
    for body in (light, heavy, carried, deck):
        for name, floor in floors.items():
            if name != body.name and (body.name, name) != ("carried", "heavy"):
                scene.add_contact(f"{body.name} {name}", body.frame(), floor, **options)
    return scene


def test_masses_of_both_sides_act_in_series() -> None:
    contacts = {contact.name: contact for _, contact in compliant_contacts(masses().freeze().loads)}
    both = HEAVY + CARRIED
    wanted = {
        "light heavy": LIGHT * both / (LIGHT + both),
        "light deck": LIGHT,
        "light ground": LIGHT,
        "heavy deck": both,
        "heavy ground": both,
        "carried deck": both,
        "carried ground": both,
        "deck heavy": both,
        "deck ground": 1.0,  # neither gives way
    }
    assert {name: contact.mass for name, contact in contacts.items()} == pytest.approx(wanted, rel=1e-14)
    for name, mass in wanted.items():
        friction = contacts[name].friction
        assert friction.damping == pytest.approx(2.0 * DAMPING_RATIO * math.sqrt(SPRING * mass), rel=1e-14)
