"""Pressures and tractions that vary by place and time, on shells and solids."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import kanefe as kf
from kanefe.errors import AccuracyWarning, FileError, ModelError
from kanefe.fe_model.loaded_face import LoadedFace
from kanefe.fe_model.place_field import PlaceField
from kanefe.kane.assemble import accelerations
from kanefe.kane.energy import load_power
from kanefe.states.state import State
from kanefe.tree.stiffening_check import StiffeningWarning
from kanefe_fem import Material, ShellFace, box_mesh, segmented, shell_body, shell_model, solid_body, surface_mesh
from order_n_rates import order_n

pytestmark = pytest.mark.fenicsx

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
SOFT = Material(E=2e8, nu=0.3, rho=1200.0)
WATER = 9810.0  # weight of water, N/m3


def depth(x):
    return 3.0 - x[:, 2]


def wall(kind, **options):
    """Return a wall 2 m wide and 3 m high, whose wet side is x = 0 and pushed along x."""
    statics = kf.CraigBampton(modes=4, loads=("depth",))
    if kind == "solid":
        mesh = box_mesh((0.4, 2.0, 3.0), (1, 2, 3)).with_groups(
            {"foot": kf.OnPlane((0, 0, 0), (0, 0, 1)), "wet": kf.OnPlane((0, 0, 0), (1, 0, 0))}
        )
        surfaces = {"inside": kf.OnPlane((0, 0, 0), (1, 0, 0)), "depth": kf.LoadShape("wet", depth)}
        return solid_body(mesh, STEEL, {"foot": "clamped"}, reduction=statics, surfaces=surfaces, **options)
    mesh = surface_mesh(lambda s, r: (0.0 * s, 2.0 * (1.0 - s), 3.0 * r), (2, 3))
    surfaces = {"inside": ShellFace("middle"), "depth": kf.LoadShape(ShellFace("middle"), depth)}
    held = kf.Interface("all", at=kf.OnPlane((0, 0, 0), (0, 0, 1)))
    return shell_body(mesh, STEEL, {"foot": held}, 0.1, statics, surfaces=surfaces, **options)


@pytest.mark.parametrize("kind", ["solid", "shell"])
def test_water_at_a_wall_has_its_resultant_and_both_ways_to_give_it_are_one(kind):
    body = wall(kind)
    named, late = body.load_pattern("depth"), body.load_pattern("inside", over=depth)
    sign = np.sign(named.pressure_force[0])
    np.testing.assert_allclose(sign * named.pressure_force, (9.0, 0.0, 0.0), atol=1e-12)
    along = 9.0 if kind == "solid" else 0.0 if body.nodes[:, 1].min() < -0.5 else 9.0
    np.testing.assert_allclose(sign * named.pressure_moment, (0.0, 9.0, -along), atol=1e-12)
    for name in ("measure", "shape_first", "pressure_elastic", "pressure_change"):
        np.testing.assert_allclose(getattr(late, name), getattr(named, name), rtol=1e-12, atol=1e-14)
    nodal = body.load_pattern("inside", over=depth(body.nodes))
    np.testing.assert_allclose(nodal.pressure_elastic, named.pressure_elastic, atol=1e-12)
    scene = kf.System()
    scene.add_pressure(scene.add_flexible_body("wall", body), "depth", WATER)
    assert f"the pressure on 'depth' of 'wall': ({sign * 88290:g}, 0, 0) N" in str(scene)


def ball(thickness):
    """A closed sphere of radius 1 about (0.2, -0.1, 0.3), six curved faces of a cube."""

    def side(axis, sign):
        def place(s, r):
            p = [np.zeros_like(s)] * 3
            p[axis], p[(axis + 1) % 3] = sign * np.ones_like(s), sign * np.tan((s - 0.5) * np.pi / 2.0)
            p[(axis + 2) % 3] = np.tan((r - 0.5) * np.pi / 2.0)
            length = np.sqrt(p[0] ** 2 + p[1] ** 2 + p[2] ** 2)
            return tuple(x / length + c for x, c in zip(p, (0.2, -0.1, 0.3), strict=True))

        return surface_mesh(place, (2, 2))

    from kanefe_fem.mesh.surface_grid import joined_surfaces

    mesh = joined_surfaces([side(axis, sign) for axis in range(3) for sign in (1.0, -1.0)])
    surfaces = {"wet": kf.LoadShape(ShellFace("top"), lambda x: 2.0 - x[:, 2])}
    return shell_model(mesh, STEEL, thickness, surfaces=surfaces)


def test_a_ball_in_water_floats_by_the_water_that_it_displaces():
    """Gauss: the resultant of a pressure that grows with depth is the volume inside of the face, through its middle."""
    pattern = ball(0.1).load_patterns["wet"]
    volume = pattern.pressure_force[2]
    np.testing.assert_allclose(pattern.pressure_force, (0.0, 0.0, volume), atol=1e-12)
    assert volume == pytest.approx(4.0 / 3.0 * np.pi * 1.05**3, rel=5e-3)  # two cells of order 2 a side
    np.testing.assert_allclose(pattern.pressure_moment, np.cross((0.2, -0.1, 0.3), pattern.pressure_force), atol=1e-3)


def test_patches_within_cells_are_resolved_and_what_is_rough_is_told():
    mesh = surface_mesh(lambda s, r: (s, r, 0.0 * s), (3, 3))
    surfaces = {"patch": kf.LoadShape("body", lambda x: (np.abs(x[:, :2] - 0.45).max(axis=1) < 0.2).astype(float))}
    pattern = shell_model(mesh, STEEL, 0.01, surfaces=surfaces).load_patterns["patch"]
    assert pattern.measure == pytest.approx(0.16, rel=3e-3)  # a thirtieth of a cell, of 3 a side
    np.testing.assert_allclose(pattern.first[:2] / pattern.measure, 0.45, rtol=1e-3)
    rough = {"noise": kf.LoadShape("body", lambda x: (np.sin(1e4 * x[:, 0]) > 0.5).astype(float))}
    with pytest.warns(AccuracyWarning, match=r"the surface 'noise' is rough within the facets.*Remedy"):
        shell_model(mesh, STEEL, 0.01, surfaces=rough)


def panel(**options):
    mesh = surface_mesh(lambda s, r: (s, 0.5 * (r - 0.5), 0.1 * s**2 + 0.2 * r**2), (3, 2))
    surfaces = {"top": ShellFace("top"), "edge": "tip", "low": ShellFace("bottom")}
    return shell_body(mesh, SOFT, {"root": "clamped"}, 0.02, kf.CraigBampton(modes=3), surfaces=surfaces, **options)


def loaded(body, is_moving=True):
    """Return a panel on a hinge under loads by place of every kind."""
    scene = kf.System(gravity=(0.0, 0.0, -1.0))
    member = scene.add_flexible_body("panel", body, joint=kf.Revolute("y", position=0.3))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", AccuracyWarning)  # of statics: here both routes are compared
        scene.add_pressure(member, "top", lambda t: 300.0 + 60.0 * t, follows=True, over=lambda x: 1.0 + x[:, 0] ** 2)
        scene.add_pressure(member, "low", lambda t, state: 90.0 * state.rotation("panel")[2, 2], over=lambda x: x[:, 2])
        for follows in (False, True):
            scene.add_traction(member, "top", (3.0, 1.0, -2.0), follows=follows, over=lambda x: x[:, 0])
            scene.add_traction(member, "low", lambda t: 1.0 + t, follows=follows, over=lambda x: np.cross(x, (0, 0, 1)))
            scene.add_line_load(member, "edge", (0.0, 4.0, 1.0), follows=follows, over=lambda x: x[:, 1])
        if is_moving:
            scene.add_pressure(member, "top", 2.0, over=lambda x, t: np.sin(9.0 * (x[:, 0] - t)))
            scene.add_traction(member, "low", (0.0, 2.0, 1.0), over=lambda x, t: np.cos(x[:, 1] - t))
            scene.add_traction(member, "low", 1.0, follows=True, over=lambda x, t: np.outer(x[:, 1] - t, (0, 2, 1)))
    return scene


@pytest.mark.parametrize("stiffening", ["none", "full"])
def test_both_routes_have_the_same_accelerations_and_powers(stiffening):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", StiffeningWarning)
        model = loaded(panel(stiffening=stiffening)).freeze()
    rng, count = np.random.default_rng(3), model.coordinate_count
    q, u = 0.01 * rng.standard_normal(count), rng.standard_normal(model.free_count)
    literal = accelerations(State(model, 0.5, q, u))
    found = order_n(model).held_rates(0.5, np.concatenate((q, u, np.zeros(2))))[0][count:]
    np.testing.assert_allclose(found[: len(u)], literal, rtol=0, atol=1e-11 * abs(literal).max())
    assert found[-1] == pytest.approx(load_power(State(model, 0.5, q, u)), rel=1e-12)


def test_a_field_of_places_and_time_is_the_sum_of_its_products():
    """A wave that travels, as such and as two that stand; tractions in N and G on a panel that turns and bends."""
    body, rates = panel(), []
    for is_one in (True, False):
        scene = kf.System()
        member = scene.add_flexible_body("panel", body, joint=kf.Revolute("y", position=0.3))
        add, direction = (scene.add_pressure, scene.add_traction), (2.0, (0.0, 2.0, 1.0))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", AccuracyWarning)
            for one, given in zip(add, direction, strict=True):
                for follows in (False, True) if one is add[1] else (False,):
                    if is_one:
                        one(member, "top", given, follows=follows, over=lambda x, t: np.sin(9.0 * (x[:, 0] - t)))
                        continue
                    times = (
                        (lambda t, g=given: np.cos(9.0 * t) * np.asarray(g)),
                        (lambda t, g=given: -np.sin(9.0 * t) * np.asarray(g)),
                    )
                    one(member, "top", times[0], follows=follows, over=lambda x: np.sin(9.0 * x[:, 0]))
                    one(member, "top", times[1], follows=follows, over=lambda x: np.cos(9.0 * x[:, 0]))
        model = scene.freeze()
        rng = np.random.default_rng(5)
        q, u = 0.05 * rng.standard_normal(model.coordinate_count), rng.standard_normal(model.free_count)
        rates.append(accelerations(State(model, 0.7, q, u)))
    # a quadrature of fixed points beside one that is refined
    np.testing.assert_allclose(rates[0], rates[1], rtol=0, atol=1e-6 * abs(rates[0]).max())


def test_a_run_keeps_its_balance_of_energy():
    energy = loaded(panel()).simulate((0.0, 0.3), rtol=1e-9).energy
    total = energy.kinetic + energy.elastic + energy.gravity
    error = total - total[0] - (energy.work - energy.work[0])
    assert np.ptp(energy.work) > 0.1
    assert abs(error).max() < 1e-6 * np.ptp(energy.work)


def test_a_pressure_that_follows_changes_as_the_one_on_the_deformed_face():
    """The shape stays with the material: central differences, with values at the same points of the facets."""
    body = panel()
    face = body.load_pattern("top").face
    shape = np.cos(3.0 * body.nodes[:, 0]) + body.nodes[:, 1]
    field = PlaceField(shape, "it")
    along = np.random.default_rng(1).standard_normal(face.points.shape)

    def forces(h):
        begun, blocks = 0, []
        for block in face.blocks:
            size = block.places.shape
            own = along[begun : begun + size[0] * size[1]].reshape(size)
            begun += size[0] * size[1]
            blocks.append(type(block)(block.kind, block.nodes, block.places + h * own, block.signs, block.arms))
        return LoadedFace(tuple(blocks), face.count, face.width).sums(field)[1]

    rate = (forces(1e-3) - forces(-1e-3)) / 2e-3  # of second degree in the displacements
    change = face.sums(field)[2] @ along.ravel()
    np.testing.assert_allclose(change, rate.ravel(), rtol=0, atol=1e-9 * abs(rate).max())


def test_what_late_fields_leave_open_is_told_and_loads_of_shapes_have_it():
    body = panel(stiffening="full")
    scene = kf.System()
    member = scene.add_flexible_body("panel", body)
    with pytest.warns(AccuracyWarning, match=r"chosen without it: the upper third of them holds .*LoadShape\('top'"):
        scene.add_pressure(member, "top", 1.0, follows=True, over=lambda x: (x[:, 0] < 0.2).astype(float))
    with pytest.warns(StiffeningWarning, match=r"stiffening='full', which leaves out .*Remedy: surfaces=.*LoadShape"):
        scene.freeze()
    named = wall("shell", stiffening="full")
    assert named.load_pattern("depth").quadratic_first is not None
    assert named.load_pattern("inside", over=depth).quadratic_first is None


def test_a_file_keeps_the_face_and_bodies_without_reduction_and_in_segments_take_fields(tmp_path):
    body = wall("solid")
    body.save(tmp_path / "wall.npz")
    read = kf.FlexibleBody.load(tmp_path / "wall.npz").load_pattern("inside", over=depth)
    np.testing.assert_array_equal(read.pressure_elastic, body.load_pattern("inside", over=depth).pressure_elastic)
    mesh = box_mesh((1.0, 0.1, 0.1), (8, 1, 1))
    held = {"root": "clamped", "tip": "rigid"}
    sparse = solid_body(mesh, STEEL, held, surfaces=["top"]).load_pattern("top", over=lambda x: x[:, 0] ** 2)
    np.testing.assert_allclose(sparse.pressure_force, (0.0, 0.0, -0.1 / 3.0), atol=1e-15)
    np.testing.assert_allclose(sparse.pressure_elastic, -sparse.shape_first[2], atol=1e-15)
    whole = solid_body(mesh, STEEL, held, reduction=kf.CraigBampton(modes=8), surfaces=["top"])
    cut = segmented(mesh, held, STEEL, segments=2, surfaces=["top"])
    tips = []
    for given in (whole, cut):
        for over in (lambda x: x[:, 0] ** 2, given.nodes[:, 0] ** 2):
            scene = kf.System()
            add = scene.add_flexible_body if given is whole else scene.add_segmented_body
            scene.add_pressure(add("arm", given), "top", 1e5, over=over)
            tips.append(kf.equilibrium(scene).position("arm", "tip")[2])
    np.testing.assert_allclose(tips, tips[0], rtol=2e-2)  # modes of two halves
    np.testing.assert_allclose(tips[::2], tips[1::2], rtol=1e-9)


class TestMaps:
    def test_a_map_is_exact_for_linear_fields_and_keeps_its_values(self, tmp_path):
        rng = np.random.default_rng(2)
        points = np.column_stack((rng.uniform(0, 2, (200, 2)), np.zeros(200)))
        values = 3.0 + points @ (1.0, -2.0, 0.0)
        field = kf.MappedField(points, values, reach=0.3)
        places = np.column_stack((rng.uniform(0.1, 1.9, (50, 2)), np.full(50, 1e-3)))
        np.testing.assert_allclose(field(places), 3.0 + places @ (1.0, -2.0, 0.0), rtol=1e-10)
        wild = kf.MappedField(points, rng.standard_normal((200, 3)))
        np.testing.assert_allclose(wild(points), wild.values, rtol=1e-9)
        table = np.column_stack((1e3 * points, 1e-6 * values))
        np.savetxt(tmp_path / "map.csv", table, delimiter=",", header="x,y,z,p [MPa]", comments="")
        read = kf.MappedField.read(tmp_path / "map.csv", length=1e-3, value=1e6, reach=0.3)
        np.testing.assert_allclose(read(places), field(places), rtol=1e-9)
        with pytest.raises(ModelError, match=r"from the nearest point of a MappedField, which reaches.*in mm"):
            kf.MappedField.read(tmp_path / "map.csv")(places)
        history = kf.MappedHistory(points, [1.0, 3.0], [values, 3.0 * values], reach=0.3)
        np.testing.assert_allclose(history(places, 1.5), 1.5 * field(places), rtol=1e-10)
        np.testing.assert_allclose(history(places, 9.0), 3.0 * field(places), rtol=1e-10)

    def test_a_map_on_a_wall_is_the_field_that_it_was_made_of(self):
        body = wall("shell")
        rng = np.random.default_rng(0)
        points = np.column_stack((np.zeros(400), rng.uniform(0.0, 2.0, 400), rng.uniform(0.0, 3.0, 400)))
        mapped = body.load_pattern("inside", over=kf.MappedField(points, depth(points), reach=0.5))
        exact = body.load_pattern("depth")
        np.testing.assert_allclose(mapped.pressure_elastic, exact.pressure_elastic, atol=1e-9)

    def test_bad_maps_are_named(self, tmp_path):
        with pytest.raises(ModelError, match=r"points of a MappedField must be finite, of shape \(n, 3\)"):
            kf.MappedField([[0.0, 1.0]], [1.0])
        with pytest.raises(ModelError, match="one or three for each of 1 points"):
            kf.MappedField([[0.0, 1.0, 2.0]], [1.0, 2.0])
        with pytest.raises(ModelError, match="times of a MappedHistory must be two or more, rising"):
            kf.MappedHistory([[0.0, 1.0, 2.0]], [1.0, 1.0], [[1.0], [2.0]])
        with pytest.raises(ModelError, match=r"need a row a time, \(2, n\)"):
            kf.MappedHistory([[0.0, 1.0, 2.0]], [1.0, 2.0], [1.0, 2.0])
        (tmp_path / "bad.csv").write_text("x y z p\n1 2 3 4\n1 2 3\n")
        with pytest.raises(FileError, match="line 3: 3 numbers, and x, y, z and one or three values are meant"):
            kf.MappedField.read(tmp_path / "bad.csv")
        with pytest.raises(FileError, match="the table cannot be read"):
            kf.MappedField.read(tmp_path / "none.csv")


@pytest.fixture(scope="module")
def bare():
    return panel()


BAD = {
    "shape": (lambda x: x[:, :2], r"one number for each place, or three.*gave shape \(1, 2\)"),
    "one": (lambda x: 1.0, r"gave shape \(\).*np\.full"),
    "nan": (lambda x: np.where(x[:, 0] > 0.5, np.nan, 1.0), r"is not a finite number at the place \("),
    "arguments": (lambda x, t, state: x[:, 0], r"must be a function of places, f\(x\), or of places and time"),
    "nodes": (np.ones(5), r"finite numbers at the \d+ nodes of the body"),
    "vectors": (lambda x: x, "gives three numbers a place. Remedy: one, or add_traction"),
    "follows": (lambda x, t: x[:, 0], "which cannot follow the surface"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_fields_are_named(bare, name):
    over, words = BAD[name]
    scene = kf.System()
    with pytest.raises(ModelError, match=words):
        scene.add_pressure(scene.add_flexible_body("panel", bare), "top", 1.0, over=over, follows=name == "follows")


def test_more_bad_input(bare):
    scene = kf.System()
    member = scene.add_flexible_body("panel", bare)
    with pytest.raises(ModelError, match="and the factor is one too"):
        scene.add_pressure(member, "top", lambda t: t, over=lambda x, t: x[:, 0])
    with pytest.raises(ModelError, match="must be one finite number or a function of time"):
        scene.add_traction(member, "top", (1.0, 0.0, 0.0), over=lambda x: x)
    with pytest.raises(ModelError, match=r"over= of a LoadShape is a function of places, f\(x\)"):
        kf.LoadShape("top", np.ones(3))
    with pytest.raises(ModelError, match=r"what varies by time too, over= of add_pressure"):
        kf.LoadShape("top", lambda x, t: x[:, 0])
    with pytest.raises(IndexError) as told:
        scene.add_pressure(member, "top", 1.0, over=lambda x: x["z"])
    assert "which is asked for 1 places" in told.value.__notes__[0]
    scene.add_pressure(member, "top", lambda x: 1.0 + x[:, 2])
    with pytest.raises(TypeError) as told:
        kf.equilibrium(scene)
    assert "a function of places is over=" in told.value.__notes__[0]
