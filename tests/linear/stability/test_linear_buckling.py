"""Buckling and flutter of rigid bodies on springs, against closed forms, and what is refused."""

import numpy as np
import pytest

import kanefe as kf
from kanefe.errors import AccuracyWarning, ModelError
from scenes import lattice_body

K, LENGTH = 100.0, 1.0
EXACT = 1e-9
"""Round-off of differences of the fourth order (some 1e-12) and of the eigenvalues."""


def rod(weight: float = 20.0, force: float = 0.0, stiffness: float = K) -> kf.System:
    """Return a rod that stands on a hinge with a spring, under its weight (N) and a force on its top."""
    return rod_and_scene(weight, force, stiffness)[1]


def rod_and_scene(weight: float = 20.0, force: float = 0.0, stiffness: float = K) -> tuple[kf.Frame, kf.System]:
    scene = kf.System(gravity=(0, 0, -10.0))
    hinge = kf.Revolute("y", forces=kf.CoordinateForce(stiffness=stiffness))
    body = scene.add_rigid_body("rod", weight / 10.0, 0.2, com=(0, 0, 0.5 * LENGTH), joint=hinge)
    if force:
        scene.add_force(body, (0, 0, -force), point=(0, 0, LENGTH))
    return body, scene


def ziegler(damping: float = 0.0, force: float = 1.0, follows: bool = True) -> kf.System:
    """Return two bars of length 1 with springs of 1 N m/rad, masses of 2 and 1 kg at their ends, and a force."""
    scene = kf.System()
    hinge = kf.Revolute("z", forces=kf.CoordinateForce(stiffness=1.0, damping=damping))
    a = scene.add_rigid_body("a", 2.0, 0.0, com=(1, 0, 0), joint=hinge)
    b = scene.add_rigid_body("b", 1.0, 0.0, com=(1, 0, 0), parent=a, at=(1, 0, 0), joint=hinge)
    scene.add_force(b, (-force, 0, 0), point=(1, 0, 0), follows=follows)
    return scene


def test_a_rod_on_a_spring_under_its_weight():
    found = kf.buckling(rod())
    assert found.factors == pytest.approx([K / (20.0 * 0.5 * LENGTH)], rel=EXACT)
    assert found.reversed_factor == np.inf
    assert found.shape("rod")[0] == pytest.approx([0, 0, 0, 0, 1, 0])  # one rad
    assert "raised: gravity" in str(found)
    assert "rod 100 %" in str(found)


def test_what_is_not_raised_is_kept():
    """The force that buckles a rod which carries its weight: k = (m g / 2 + P) l."""
    found = kf.buckling(rod(force=3.0), loads="the force on 'rod'")
    assert found.factors == pytest.approx([(K - 10.0) / 3.0], rel=EXACT)
    assert "raised: the force on 'rod'; kept: gravity" in str(found)
    both = kf.buckling(rod(force=3.0))
    assert both.factors == pytest.approx([K / 13.0], rel=EXACT)
    named = kf.buckling(rod(force=3.0), loads=["gravity", "load the force on 'rod'"])
    assert named.factors == pytest.approx(both.factors, rel=EXACT)


def test_functions_of_time_count_as_they_are_then():
    body, scene = rod_and_scene(weight=1e-9)
    scene.add_force(body, lambda t: (0, 0, -2.0 * t), point=(0, 0, LENGTH))
    assert kf.buckling(scene, loads="the force on 'rod'", t=3.0).factors == pytest.approx([K / 6.0], rel=1e-6)


@pytest.mark.parametrize("size", [1e-9, 1e9])
def test_the_size_of_the_load_does_not_matter(size):
    found = kf.buckling(rod(1e-6, size), loads="the force on 'rod'")
    assert found.factors * size == pytest.approx([K], rel=1e-7)  # the weight is 1e-8 of K


def test_loads_that_pull_have_no_factor():
    found = kf.buckling(rod(1e-9, -4.0), loads="the force on 'rod'")
    assert len(found.factors) == 0
    assert found.reversed_factor == pytest.approx(K / 4.0, rel=1e-6)
    assert "these loads stiffen" in str(found)
    assert "with reversed loads" in str(found)
    with pytest.raises(ModelError, match="no mode 0: there are none"):
        found.shown(0)


def test_two_bars_and_their_shapes():
    """K = k [[2, -1], [-1, 1]] of absolute angles, dK = -P l I: factors k / P l (3 -+ sqrt 5) / 2."""
    found = kf.buckling(ziegler(follows=False))
    assert found.factors == pytest.approx((3.0 + np.sqrt(5.0) * np.array((-1, 1))) / 2.0, rel=EXACT)
    first, second = (found.shape(name)[0, 5] for name in "ab")
    assert second / first == pytest.approx((1.0 + np.sqrt(5.0)) / 2.0, rel=EXACT)
    assert kf.buckling(ziegler(follows=False), count=1).factors == pytest.approx(found.factors[:1])
    moved = found.shown(1, size=0.2)
    assert moved.joint_coordinates("a") == pytest.approx(0.2 * found.tangents[:1, 1])
    limit = kf.stability_limit(ziegler(follows=False))
    assert limit.factor == pytest.approx(found.factors[0], rel=1e-10)
    assert not limit.is_flutter
    assert limit.frequency == 0.0
    assert "divergence" in str(limit)


def test_springs_that_are_compressed_by_the_load_buckle():
    """A point at the end of a spring: across, its thrust P takes P / L of the stiffness, told by displacement alone."""
    scene = kf.System()
    point = scene.add_point("point", 1.0, at=(2, 0, 0))
    for name, at, k in (("strut", (0, 0, 0), 1e6), ("side", (2, 1, 0), 30.0), ("top", (2, 0, 1), 50.0)):
        scene.add_spring(name, scene.ground.frame(at=at), point, stiffness=k)
    scene.add_force(point, (-1.0, 0, 0))
    found = kf.buckling(scene)
    assert found.factors == pytest.approx([60.0, 100.0], rel=1e-6)  # linear in the strain of 1e-6 per N, at rest


def test_loops_buckle_as_trees_do():
    """A strut between a hinge and a slider, with a spring in the middle: 4 k_angle / l of two bars of length l / 2."""
    scene = kf.System()
    spring = kf.CoordinateForce(stiffness=1.0)
    a = scene.add_rigid_body("a", 1.0, 0.1, com=(0.5, 0, 0), joint=kf.Revolute("z"))
    b = scene.add_rigid_body(
        "b", 1.0, 0.1, com=(0.5, 0, 0), parent=a, at=(1, 0, 0), joint=kf.Revolute("z", forces=spring)
    )
    slider = scene.add_rigid_body("slider", 0.1, 0.1, at=(2, 0, 0), joint=kf.Prismatic("x"))
    scene.add_loop_joint("pin", kf.Revolute("z"), b.frame(at=(1, 0, 0)), slider)
    scene.add_force(slider, (-1, 0, 0))
    assert kf.buckling(scene).factors == pytest.approx([2.0], rel=EXACT)


def test_flutter_of_two_bars():
    """Ziegler (1952): (7/2 - sqrt 2) k / l; with dampers Herrmann & Jong (1965): 41/28 k / l + c^2 / 2 m l^3."""
    limit = kf.stability_limit(ziegler())
    assert limit.is_flutter
    assert limit.factor == pytest.approx(3.5 - np.sqrt(2.0), rel=1e-10)
    square = np.sqrt(0.5)  # s^4 m^2 l^4 2 + s^2 (7 k - 2 P l) m l^2 + k^2: two roots meet at s^2 = -1 / sqrt 2
    assert limit.frequency == pytest.approx(np.sqrt(square) / (2 * np.pi), rel=1e-5)
    assert "flutter at" in str(limit)
    for c in (1e-3, 0.3):
        damped = kf.stability_limit(ziegler(c))
        assert damped.factor == pytest.approx(41.0 / 28.0 + 0.5 * c**2, rel=1e-8 / c)  # growth of 1e-9 is told


def test_linearise_knows_that_forces_turn():
    """Just below and above the limit, where M and K of the scene itself say so too."""
    limit = 3.5 - np.sqrt(2.0)
    assert kf.linearise(ziegler(force=limit - 1e-3)).modes().is_stable
    beyond = kf.linearise(ziegler(force=limit + 1e-3))
    assert not beyond.modes().is_stable
    assert np.abs(beyond.stiffness - beyond.stiffness.T).max() > 1.0


def test_a_scene_that_stays_stable():
    found = kf.stability_limit(ziegler(force=-1.0), up_to=50.0)
    assert found.factor == np.inf
    assert found.looked_at == 50.0
    assert not found.is_flutter
    assert "stable up to 50 times" in str(found)


def test_a_displacement_before_is_told():
    body, scene = rod_and_scene(force=1.0)
    scene.add_force(body, (2.0, 0, 0), point=(0, 0, LENGTH))
    with pytest.warns(AccuracyWarning, match="the scene moves by some"):
        kf.buckling(scene)


def unheld() -> kf.System:
    scene = kf.System()
    body = scene.add_rigid_body("rod", 1.0, 0.2, com=(0, 0, 0.5), joint=kf.Revolute("y"))
    scene.add_force(body, (0, 0, -1.0), point=(0, 0, 1.0))
    return scene


def with_law() -> kf.System:
    body, scene = rod_and_scene()
    scene.add_force(body, lambda t, state: (0.0, 0.0, 0.0))
    return scene


def driven() -> kf.System:
    scene = rod()
    scene.add_rigid_body("wheel", 1.0, 1.0, joint=kf.Revolute("z", motion=kf.Motion.steady(2.0)))
    return scene


def soft() -> kf.System:
    scene = kf.System(gravity=(0, 0, -10))
    scene.add_flexible_body("lattice", lattice_body(), joint=kf.Fixed())
    return scene


@pytest.mark.parametrize(
    ("scene", "options", "words"),
    [
        (lambda: rod(), {"count": 0}, "count must be a whole number"),
        (lambda: rod(), {"loads": "wind"}, "no load 'wind'. It has: gravity"),
        (lambda: rod(), {"loads": ()}, "no load is raised"),
        (lambda: kf.System(), {}, "no bodies"),
        (unheld, {}, "there is no restoring force along rod: angle"),
        (lambda: rod(force=1.0, stiffness=5.0), {"loads": "the force on 'rod'"}, "it tips along rod: angle"),
        (with_law, {"loads": "the force on 'rod'"}, "is a function of the state"),
        (driven, {}, "a driven joint moves"),
        (soft, {}, "flexible body 'lattice' has no geometric stiffness.*stiffening='full'"),
        (ziegler, {}, "the force on 'b' has no potential.*stability_limit"),
    ],
)
def test_what_is_refused_is_named(scene, options, words):
    with pytest.raises(ModelError, match=words):
        kf.buckling(scene(), **options)


def test_what_stability_refuses_is_named():
    with pytest.raises(ModelError, match="up_to must be a positive finite factor"):
        kf.stability_limit(ziegler(), up_to=0.0)
    body, scene = rod_and_scene()
    scene.add_motor(body, lambda t, state: 0.1 * state.joint_speeds("rod")[0])
    with pytest.raises(ModelError, match="grows even without the raised loads"):
        kf.stability_limit(scene)
