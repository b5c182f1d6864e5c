"""Contacts: literal and compiled route agree to round-off for all shapes and laws; what contacts refuse."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import kanefe as kf
from contact_scenes import FRICTION, LAW, assert_routes_agree, random_state, scene_of
from kanefe import shapes
from kanefe.scene.scene import ContactPatch
from scenes import lattice_body
from touched_shapes import TOUCHED


@pytest.mark.parametrize("touched", TOUCHED.values(), ids=TOUCHED)
def test_routes_agree_on_all_that_can_be_touched(touched):
    assert_routes_agree(
        scene_of(touched, shapes.Sphere(0.2), friction=FRICTION["turning"]), range(30), (0.0, 0.4, 0.7, 0.9, 1.0)
    )


@pytest.mark.parametrize(
    "touching",
    [
        shapes.Capsule(0.2, 0.5),
        shapes.Cylinder(0.3, 0.4),
        shapes.Box((0.4, 0.5, 0.6)),
        shapes.Torus(0.3, 0.1),
        shapes.Torus(0.3, 0.0),
        shapes.Points([(0, 0, -0.2), (0.3, 0, -0.2), (0, 0.3, -0.2)], radius=0.05),
    ],
    ids=["capsule", "cylinder", "box", "tyre", "disc", "points"],
)
def test_routes_agree_on_all_that_touches_a_plane(touching):
    assert_routes_agree(scene_of(TOUCHED["plane"], touching, friction=FRICTION["one"]), range(20), (0.1, 0.2, 0.3))


@pytest.mark.parametrize("tube", [0.1, 0.0])
def test_routes_agree_on_tyres_on_hills(tube):
    scene = scene_of(TOUCHED["hills"], shapes.Torus(0.3, tube), friction=FRICTION["one"])
    assert_routes_agree(scene, range(20), (0.1, 0.3))


@pytest.mark.parametrize("friction", FRICTION.values(), ids=FRICTION)
@pytest.mark.parametrize(
    "normal",
    [
        LAW,
        kf.Hertz(3e4, damping=0.2),
        kf.HuntCrossley(3e4, 0.2, exponent=2.2),
        kf.KelvinVoigt(3e4, damping=200.0),
        kf.Restitution(3e4, 0.7),
        kf.TableLaw((0.02, 0.1, 0.2), (200.0, 3e3, 9e3), damping=0.2),
    ],
    ids=["hunt-crossley", "hertz", "exponent", "kelvin-voigt", "restitution", "table"],
)
def test_routes_agree_on_all_laws(normal, friction):
    belt = (0.15, 0.3, 0.0) if friction is not None else (0.0, 0.0, 0.0)
    assert_routes_agree(scene_of(TOUCHED["plane"], shapes.Sphere(0.3), normal, friction, belt), range(12), (0.1, 0.2))


def test_derivatives_of_the_compiled_route_are_those_of_differences():
    """The complex step through all of a contact that slips; a step of the root of round-off leaves 1e-6."""
    model = scene_of(shapes.Cylinder(0.6, 1.0), shapes.Sphere(0.3), kf.Hertz(3e4, 0.2), FRICTION["stribeck"]).freeze()
    y = random_state(model, 4, (0.1, 0.1, 0.6))
    assert model.literal.evaluate(0.0, y).rates[-2] != 0.0
    along = np.random.default_rng(1).standard_normal((3, len(y)))
    along[:, -2:] = 0.0
    found = model.route.derivatives(0.0, y, along)
    h = 1e-6
    for direction, derivative in zip(along, found, strict=True):
        ends = [model.route.evaluate(0.0, y + side * h * direction).rates for side in (1.0, -1.0)]
        wanted = (ends[0] - ends[1]) / (2.0 * h)
        assert np.abs(derivative - wanted).max() < 1e-6 * np.abs(wanted).max()


@pytest.mark.parametrize("touched", TOUCHED.values(), ids=TOUCHED)
def test_normals_are_the_gradients_of_distances(touched):
    rng = np.random.default_rng(2)
    for x in rng.uniform(-0.8, 0.8, (20, 3)):
        normal = touched.distance(x)[1]
        assert np.linalg.norm(normal) == pytest.approx(1.0, rel=1e-12)
        h = 1e-6
        gradient = [(touched.distance(x + e)[0] - touched.distance(x - e)[0]) / (2 * h) for e in h * np.eye(3)]
        np.testing.assert_allclose(gradient, normal, atol=1e-7)


def test_a_model_with_contacts_pickles():
    model = scene_of(TOUCHED["plane"], shapes.Sphere(0.3), kf.Restitution(1e4, 0.5), FRICTION["static"]).freeze()
    again = pickle.loads(pickle.dumps(model))
    y = random_state(model, 3, (0, 0, 0.1))
    np.testing.assert_array_equal(again.route.evaluate(0.0, y).rates, model.route.evaluate(0.0, y).rates)


def test_what_is_refused_by_name():
    with pytest.raises(kf.ModelError, match="mu of Coulomb"):
        kf.Coulomb(-0.1)
    with pytest.raises(kf.ModelError, match=r"static of Coulomb, 0\.1, is below mu, 0\.2"):
        kf.Coulomb(0.2, static=0.1)
    with pytest.raises(kf.ModelError, match="rolling of Coulomb must be one number"):
        kf.Coulomb(0.2, rolling=-1e-3)
    with pytest.raises(kf.ModelError, match="depths of TableLaw must rise, and forces must not fall"):
        kf.TableLaw((1e-3, 2e-3), (10.0, 5.0))
    with pytest.raises(kf.ModelError, match="must start with zero force at zero depth, not 3 N at 0 m"):
        kf.TableLaw((0.0, 2e-3), (3.0, 5.0))
    with pytest.raises(kf.ModelError, match="as many finite numbers"):
        kf.TableLaw((0.0, 2e-3), (3.0,))
    with pytest.raises(kf.ModelError, match="damping of TableLaw"):
        kf.TableLaw((1e-3, 2e-3), (1.0, 5.0), damping=-1.0)
    with pytest.raises(kf.ModelError, match="static of LuGre must be a number of at least coulomb = 1"):
        kf.LuGre(1e5, 300.0, 0.4, 1.0, 0.5, 1e-3)
    with pytest.raises(kf.ModelError, match="sigma2 of LuGre must be"):
        kf.LuGre(1e5, 300.0, -0.4, 1.0, 1.5, 1e-3)
    with pytest.raises(kf.ModelError, match="sigma1 of LuGre must be one number, finite and > 0"):
        kf.LuGre(1e5, 0.0, 0.4, 1.0, 1.5, 1e-3)
    with pytest.raises(kf.ModelError, match="torsional of Coulomb must be one number"):
        kf.Coulomb(0.2, torsional=float("nan"))
    with pytest.raises(kf.ModelError, match="stiffness of HuntCrossley"):
        kf.HuntCrossley(-1.0)
    with pytest.raises(kf.ModelError, match="restitution must be"):
        kf.Restitution(1e4, 1.5)
    with pytest.raises(kf.ModelError, match="normal of a plane"):
        shapes.Plane("w")
    scene = kf.System()
    body = scene.add_rigid_body("body", 1.0, 0.1, joint=kf.Free())
    box, ball = scene.add_surface("box", body, shapes.Box((1, 1, 1))), scene.add_surface("ball", body, shapes.Sphere(1))
    floor = scene.add_surface("floor", scene.ground, shapes.Box((1, 1, 1)))
    with pytest.raises(kf.ModelError, match="already has a surface called 'box'"):
        scene.add_surface("box", body, shapes.Sphere(1))
    tin = scene.add_surface("tin", scene.ground, shapes.Cylinder(1, 1))
    with pytest.raises(kf.ModelError, match="cylinder 'tin' and torus 'tyre' do not touch by points"):
        scene.add_contact("c", tin, scene.add_surface("tyre", body, shapes.Torus(1, 0.1)), normal=LAW)
    with pytest.raises(kf.ModelError, match="cannot touch itself"):
        scene.add_contact("c", ball, box, normal=LAW)
    with pytest.raises(kf.ModelError, match="no friction that it could act by"):
        scene.add_contact("c", ball, floor, normal=LAW, surface_velocity=(1, 0, 0))
    with pytest.raises(kf.ModelError, match="no single stiffness"):
        scene.add_contact("c", ball, floor, normal=kf.Hertz(1e5), friction=kf.Coulomb(0.1))
    with pytest.raises(kf.ModelError, match="has points, which do not roll"):
        scene.add_contact("c", body, floor, normal=LAW, friction=kf.Coulomb(0.1, rolling=1e-3))
    with pytest.raises(kf.ModelError, match="needs a surface that is touched"):
        scene.add_contact("c", ball, body, normal=LAW)
    with pytest.raises(kf.ModelError, match="the ground cannot touch itself"):
        scene.add_contact("c", scene.add_surface("stone", scene.ground, shapes.Sphere(1)), floor, normal=LAW)
    with pytest.raises(kf.ModelError, match="add_contacts needs surfaces, not"):
        scene.add_contacts([ball, body], normal=LAW)
    with pytest.raises(kf.ModelError, match="ignore of add_contacts takes pairs of the surfaces"):
        scene.add_contacts([ball, floor], normal=LAW, ignore=[(ball, box)])
    for among, named in (([], "none"), ([ball], "'ball'"), ([ball, box], "'ball', 'box'")):
        with pytest.raises(kf.ModelError, match=f"finds no two surfaces on two bodies .* given: {named}. Remedy"):
            scene.add_contacts(among, normal=LAW)


@pytest.mark.parametrize("normal", [LAW, kf.Rigid()])
def test_a_surface_velocity_that_leaves_its_plane_is_refused(normal):
    scene = kf.System()
    plane = scene.add_surface("plane", scene.ground, shapes.Plane((0.2, -0.1, 1.0)))
    ball = scene.add_surface("ball", scene.add_rigid_body("body", 1.0, 0.1, joint=kf.Free()), shapes.Sphere(1))
    given = {"normal": normal, "friction": kf.Coulomb(0.1)}
    with pytest.raises(kf.ModelError, match=r"0\.195 m/s of its surface velocity are along the normal of the plane"):
        scene.add_contact("c", ball, plane, surface_velocity=(1.0, 0.0, 0.0), **given)
    along = np.array((1.0, 0.3, -0.17)) * 1e3
    scene.add_contact("c", ball, plane, surface_velocity=along, **given)


def test_of_the_shapes_only_shapes_are_seen():
    assert dir(shapes) == sorted(shapes.__all__)
    assert all(issubclass(getattr(shapes, name), shapes.SurfaceShape) for name in shapes.__all__)


@pytest.mark.parametrize(
    ("shape", "message"),
    [
        (lambda: shapes.Box((0.0, 1.0, 1.0)), "size of a box must be three finite numbers > 0"),
        (lambda: shapes.Sphere(0.0), "radius of a sphere must be one number, finite and > 0"),
        (lambda: shapes.Capsule(0.1, -1.0), "length of a capsule"),
        (lambda: shapes.Cylinder(float("nan"), 1.0), "radius of a cylinder"),
        (lambda: shapes.Torus(0.0, 0.1), "radius of a torus"),
        (lambda: shapes.Points([]), "points of a surface must be finite"),
        (lambda: shapes.HeightField([0, 1, 2], [0, 1], np.zeros((3, 2))), "y of a height field must be three or more"),
    ],
)
def test_surfaces_without_area_are_refused(shape, message):
    with pytest.raises(kf.ModelError, match=message):
        shape()


def test_what_begins_in_a_surface_is_told_how_deep():
    scene = kf.System()
    ball = scene.add_rigid_body("ball", 1.0, 0.1, joint=kf.Free(position=(0, 0, 0.35)))
    skin = scene.add_surface("skin", ball, shapes.Sphere(0.4))
    floor = scene.add_surface("floor", scene.ground, shapes.Plane("z"))
    scene.add_contact("drop", skin, floor, normal=LAW)
    with pytest.warns(
        kf.SimulationWarning, match=r"'drop' begins 0\.05 m deep .* Remedy: place it outside, or start from"
    ):
        scene.freeze()


def test_patches_need_nodes_and_touch_surfaces():
    scene = kf.System()
    arm, other = (scene.add_flexible_body(name, lattice_body(), joint=kf.Free()) for name in ("arm", "other"))
    with pytest.raises(kf.ModelError, match=r"a patch of 'arm'.*no node"):
        arm.patch(kf.Near((9.0, 9.0, 9.0), 0.1))
    feet = [ContactPatch((body.node(0), body.node(1)), (0.5, 0.5)) for body in (arm, other)]
    with pytest.raises(kf.ModelError, match=r"facets of flexible bodies, here 'node 0' of 'other'.*add_surface"):
        scene.add_contact("c", *feet, normal=LAW)
