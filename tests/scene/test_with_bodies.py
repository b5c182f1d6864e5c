"""Scenes with other bodies in the places of their own: all that was attached is attached again, and starts go along."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import kanefe as kf
from kanefe_fem import (
    Material,
    Rectangle,
    beam_body,
    box_mesh,
    exact_beam,
    segmented,
    solid_body,
    straight_beam,
)

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)


def rod_body(modes: int = 3, elements: int = 8) -> kf.FlexibleBody:
    rod = straight_beam(1.0, Rectangle(0.02, 0.01), STEEL, elements=elements)
    return beam_body(rod, {"root": "clamped", "tip": "rigid"}, kf.CraigBampton(modes=modes), stiffening="full")


def sagging(x: np.ndarray) -> np.ndarray:
    return np.column_stack((0 * x[:, 0], 0 * x[:, 0], -4e-3 * x[:, 0] ** 2))


def scene_of(body: kf.FlexibleBody, displacement: Any = None) -> kf.System:
    """A rod with something of each kind: a child, a spring at a node, loads, a contact, a surface, a loop."""
    scene = kf.System(gravity=(0, 0, -9.81))
    rod = scene.add_flexible_body("rod", body, joint=kf.Revolute("y"), displacement=displacement)
    scene.add_rigid_body("end", 0.2, 1e-3, parent=rod.interface("tip"), joint=kf.Revolute("y", speed=1.0))
    middle = int(np.argmin(np.linalg.norm(body.nodes - (0.5, 0, 0), axis=1)))
    scene.add_spring("spring", rod.node(middle), scene.ground.frame(at=(0.5, 0, 0.4)), stiffness=500.0, damping=1.0)
    scene.add_force(rod.interface("tip"), (0.0, 0.0, 3.0), follows=True)
    scene.add_force(rod.node(middle), (0.0, 0.0, -2.0))
    scene.add_line_load(rod, "span", (0.0, 0.0, 1.0))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"), at=(0, 0, -0.01))
    scene.add_contact("rest", [rod.interface("tip")], floor, normal=kf.HuntCrossley(1e4, damping=0.3))
    scene.add_surface("skin", rod.interface("tip"), kf.shapes.Sphere(0.01))
    column = scene.add_rigid_body("column", 1.0, 0.1, joint=kf.Prismatic("z"))
    scene.add_distance("link", rod.interface("tip"), column.frame(at=(1.0, 0.5, 0.0)), 0.5)
    return scene


def final(scene: kf.System) -> np.ndarray:
    result = scene.simulate((0.0, 0.05), rtol=1e-8)
    result.raise_for_status()
    return np.concatenate((result.position("end")[-1], result.velocity("end")[-1]))


def test_the_scene_is_that_built_with_the_other_body():
    body = rod_body()
    scene = scene_of(body)
    before = final(scene)
    for other in (body.rebuilt(kf.CraigBampton(modes=6)), body.rebuilt(refined=1)):
        replaced = scene.with_bodies({"rod": other})
        assert final(replaced) == pytest.approx(final(scene_of(other)), abs=1e-7)
    assert final(scene.with_bodies({"rod": body})) == pytest.approx(before, abs=1e-12)
    assert final(scene) == pytest.approx(before, abs=1e-15)


def test_states_go_from_one_scene_to_the_other():
    body = rod_body(modes=6)
    scene = scene_of(body, sagging)
    run = scene.simulate((0.0, 0.03), rtol=1e-9)
    for other in (body.rebuilt(kf.CraigBampton(modes=8)), body.rebuilt(refined=1), body.rebuilt(stiffening="none")):
        finer = scene.with_bodies({"rod": other})
        on, direct = (one.simulate((0.03, 0.04), start=run.at(0.03), rtol=1e-9) for one in (finer, scene))
        assert np.abs(on.nodal_positions("rod")[0][: len(body.nodes)] - direct.nodal_positions("rod")[0]).max() < 1e-7
        assert on.position("end")[-1] == pytest.approx(direct.position("end")[-1], abs=1e-5)


def test_fewer_modes_take_what_they_can_and_say_so():
    body = rod_body(modes=12)
    scene = kf.System()
    scene.add_flexible_body("rod", body, modal_coordinates=np.eye(18)[17] * 1e-3)
    with pytest.warns(kf.AccuracyWarning, match="'rod': the other body can take"):
        scene.with_bodies({"rod": body.rebuilt(kf.CraigBampton(modes=1))})


def test_loads_along_exact_beams_are_spread_anew():
    beam = exact_beam(1.0, Rectangle(0.005, 0.02), STEEL)
    scene = kf.System()
    member = scene.add_flexible_body("strip", beam)
    scene.add_line_load(member, "span", (0.0, 0.0, -20.0))
    scene.add_force(member.interface("tip"), (0.0, 0.0, -1.0))
    finer = scene.with_bodies({"strip": beam.rebuilt(refined=1)})
    tips = [kf.equilibrium(one).nodal_positions("strip")[-1] for one in (scene, finer)]
    # a strip under a uniform load and a tip force is smooth: eight polynomials have it to 1e-9
    assert tips[0] == pytest.approx(tips[1], abs=1e-9)
    start = kf.equilibrium(scene)
    assert finer.simulate((0.0, 1e-3), start=start).nodal_positions("strip")[0][-1] == pytest.approx(tips[0], abs=1e-9)


def test_segments_are_replaced_one_by_one():
    rod = straight_beam(1.0, Rectangle(0.02, 0.01), STEEL, elements=8)
    chain = segmented(rod, {"root": "clamped", "tip": "rigid"}, segments=4)
    scene = kf.System(gravity=(0, 0, -9.81))
    blade = scene.add_segmented_body("blade", chain)
    scene.add_force(blade.interface("tip"), (0.0, 0.0, -30.0))
    finer = scene.with_bodies({"blade": chain.rebuilt(refined=1)})
    tips = [kf.equilibrium(one).nodal_positions("blade") for one in (scene, finer)]
    assert len(tips[1]) == 17
    assert tips[0][8] == pytest.approx(tips[1][8], abs=1e-6)
    with pytest.raises(kf.ModelError, match="has 4 segments in the scene, and the other one 8"):
        scene.with_bodies({"blade": chain.rebuilt(segments=8)})


def test_what_does_not_fit_is_refused():
    body = rod_body()
    scene = scene_of(body)
    rod = straight_beam(1.0, Rectangle(0.02, 0.01), STEEL, elements=8)
    modes = kf.CraigBampton(modes=2)
    cases = [
        ({"rob": body}, "no flexible body called 'rob'. It has: rod"),
        ({}, "bodies={}"),
        ({"rod": beam_body(rod, {"root": "clamped"}, modes)}, "no interface called 'tip'"),
        ({"rod": beam_body(rod, {"root": "rigid", "tip": "rigid"}, modes)}, "no interface fixed in G"),
        ({"rod": beam_body(rod, {"root": "clamped", "tip": "rigid"}, modes, lines=[])}, "'span'"),
        ({"end": body}, "no flexible body called 'end'"),
    ]
    for bodies, message in cases:
        with pytest.raises(kf.ModelError, match=message):
            scene.with_bodies(bodies)


def test_nodes_are_found_by_their_place():
    scene = kf.System()
    rod = scene.add_flexible_body("rod", rod_body())
    scene.add_force(rod.node(4), (0.0, 0.0, -2.0))
    assert scene.with_bodies({"rod": rod_body(elements=16)})._entries[0].loads[0][1].name == "node 8"
    with pytest.raises(kf.ModelError, match=r"at node 4 of 'rod', .* no node at its place, \[0.5, 0.0, 0.0\] m"):
        scene.with_bodies({"rod": rod_body(elements=5)})


def test_controllers_that_read_modes_are_refused():
    body = rod_body()
    scene = kf.System()
    scene.add_flexible_body("rod", body, joint=kf.Revolute("y"))
    scene.add_controller(
        "damper", lambda t, reads, memory: [0.0], every=0.01, reads="modal_coordinates rod 0", drives="torque rod/tip y"
    )
    with pytest.raises(kf.ModelError, match="a coordinate of a mode"):
        scene.with_bodies({"rod": body.rebuilt(kf.CraigBampton(modes=5))})


@pytest.mark.fenicsx
def test_loads_by_place_are_made_anew():
    """A load along x that grows with x, a pressure by a table of the nodes, and a field that moves in time."""
    mesh = box_mesh((1.0, 0.1, 0.02), (6, 1, 1), "hexahedron")
    modes = kf.CraigBampton(modes=6)
    body = solid_body(mesh, STEEL, {"root": "clamped"}, modes, surfaces=["top"], stiffening="none")
    scene = kf.System()
    plate = scene.add_flexible_body("plate", body)
    scene.add_pressure(plate, "top", 1e3, over=lambda x: x[:, 0] ** 2)
    scene.add_traction(plate, "top", 1e4, over=lambda x: np.stack((x[:, 0], 0 * x[:, 0], x[:, 0]), axis=-1))
    finer = scene.with_bodies({"plate": body.rebuilt(kf.CraigBampton(modes=12), refined=1)})
    built = kf.System()
    again = built.add_flexible_body("plate", finer.body("plate").body)
    built.add_pressure(again, "top", 1e3, over=lambda x: x[:, 0] ** 2)
    built.add_traction(again, "top", 1e4, over=lambda x: np.stack((x[:, 0], 0 * x[:, 0], x[:, 0]), axis=-1))
    places = [kf.equilibrium(one).nodal_positions("plate") for one in (finer, built)]
    assert np.abs(places[0] - places[1]).max() < 1e-12
    assert len(finer._entries[0].field_loads) == len(scene._entries[0].field_loads) == 3
    table = kf.System()
    plate = table.add_flexible_body("plate", body)
    table.add_pressure(plate, "top", 1e3, over=body.nodes[:, 0])
    with pytest.raises(kf.ModelError, match="over="):
        table.with_bodies({"plate": finer.body("plate").body})
