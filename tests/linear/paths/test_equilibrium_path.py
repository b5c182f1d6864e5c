"""Paths of equilibria against closed forms: snap-through, buckling and its branches, flutter, and what is refused."""

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.optimize import brentq

import kanefe as kf
from kanefe.errors import AccuracyWarning, ModelError, SimulationError, SimulationWarning
from kanefe.fe_model.load_pattern import NodalPattern
from kanefe.linear.paths import arc_length, crossings, zeros
from kanefe.reduction import flexible_body
from scenes import lattice_model

SOLVED = 1e-9
"""Points of a path end at corrections of 1e-7 that Newton's method squares: round-off, times the stiffness."""

BRANCHES = 1e-9
"""Branch points are interpolated with an error of the sixth power of 3 % of a step."""

K, REST, RISE = 1e4, 0.995, 0.1


def truss(force: float = -1.0, across: float = 0.0) -> kf.System:
    """Return half a von Mises truss: a bar of stiffness K over a span of REST, pressed down at its rise."""
    scene = kf.System()
    node = scene.add_rigid_body("node", 1.0, at=(REST, RISE, 0), joint=kf.Prismatic("y"))
    scene.add_spring("bar", scene.ground, node, stiffness=K)
    scene.add_force(node, (across, force, 0))
    return scene


def truss_load(y: np.ndarray) -> np.ndarray:
    return K * (np.hypot(REST, RISE) / np.hypot(REST, y) - 1.0) * y


def rod(aside: float = 0.0) -> kf.System:
    """Return a rod of length 1 on a hinge with a spring of K, under a dead load on its top."""
    scene = kf.System()
    hinge = kf.Revolute("y", forces=kf.CoordinateForce(stiffness=K))
    body = scene.add_rigid_body("rod", 1.0, 0.1, com=(0, 0, 0.5), joint=hinge)
    scene.add_force(body, (aside, 0, -1), point=(0, 0, 1))
    return scene


def bars(*forces: tuple[float, bool], damping: float = 0.0) -> kf.System:
    """Return Ziegler's two bars (length 1, springs of 1, masses 2 and 1) under end forces, each dead or following."""
    scene = kf.System()
    hinge = kf.Revolute("z", forces=kf.CoordinateForce(stiffness=1.0, damping=damping))
    a = scene.add_rigid_body("a", 2.0, 0.0, com=(1, 0, 0), joint=hinge)
    b = scene.add_rigid_body("b", 1.0, 0.0, com=(1, 0, 0), parent=a, at=(1, 0, 0), joint=hinge)
    for force, follows in forces:
        scene.add_force(b, (-force, 0, 0), point=(1, 0, 0), follows=follows)
    return scene


def angles(path: kf.EquilibriumPath, name: str = "rod") -> np.ndarray:
    return path.coordinates[f"{name}: angle [rad]"]


def test_a_truss_snaps_through():
    """P(y) = K (l / r - 1) y with r^2 = a^2 + y^2; its limit, where r^3 = l a^2, is K (l^(2/3) - a^(2/3))^(3/2)."""
    path = kf.equilibrium_path(truss(), to=4.0)
    limit = K * (np.hypot(REST, RISE) ** (2 / 3) - REST ** (2 / 3)) ** 1.5
    assert [point.factor for point in path.limit_points] == pytest.approx([limit, -limit], rel=SOLVED)
    assert not path.branch_points
    y = path.position("node")[:, 1]
    assert path.factors == pytest.approx(truss_load(y), abs=SOLVED * limit)
    first, second = (point.number for point in path.limit_points)
    assert path.factors[first] == path.factors.max(initial=0.0, where=np.arange(len(path)) <= second)
    assert (path.unstable == (np.arange(len(path)) > first) * (np.arange(len(path)) <= second)).all()
    assert path.is_whole
    assert path.factors[-1] == pytest.approx(4.0, rel=SOLVED)
    text = str(path)
    assert f"limit point at factor {limit:.8g}: node 100 %" in text
    assert "ended at 4 times the loads" in text


def test_a_factor_is_solved_for_wherever_the_path_passes_it():
    path = kf.equilibrium_path(truss(), to=4.0)
    found = [float(path.at(1.0, i).position("node")[1]) for i in range(3)]
    assert truss_load(np.array(found)) == pytest.approx(np.ones(3), rel=SOLVED)
    assert found[0] > found[1] > 0.0 > found[2]
    assert float(path.at(1.0, -1).position("node")[1]) == found[2]
    assert path.at(1.0, 1).imbalance.ratio < 1e-9
    with pytest.raises(ModelError, match=r"passes factor 1 3 times, and crossing 3.*factor from -1\.93"):
        path.at(1.0, 3)
    near = 1.0 - 1e-9
    limit = path.limit_points[0].factor
    pair = [float(path.at(near * limit, i).position("node")[1]) for i in range(2)]
    assert truss_load(np.array(pair)) == pytest.approx(np.full(2, near * limit), rel=SOLVED)
    assert 0.0 < pair[0] - pair[1] < 1e-4


def test_a_factor_that_jumps_is_told(monkeypatch):
    path = kf.equilibrium_path(truss(), to=4.0)
    monkeypatch.setattr(zeros, "brentq", lambda value, low, high, **_: low if value(low) else high)
    with pytest.raises(SimulationError, match=r"no equilibrium at factor 1 .* Remedy: a path with a shorter longest="):
        path.at(1.0)


def test_points_are_equilibria_with_the_loads_of_their_factor():
    path = kf.equilibrium_path(truss(across=5.0), to=1.0)
    pushed = path.read("joint_reaction", "node")[:, 0]
    y = path.position("node")[:, 1]
    assert len(path) == len(pushed) == len(list(path))
    assert pushed + 5.0 * path.factors == pytest.approx(-REST * path.factors / y, abs=1e-8)
    assert truss_load(y) == pytest.approx(path.factors, abs=1e-8)
    assert path.point(-1).linearise().modes().grows.sum() == path.unstable[-1] == 0
    again = kf.equilibrium(truss(across=5.0), start=path.point(-1))
    assert again.q == pytest.approx(path.point(-1).q, abs=1e-12)
    with pytest.raises(ModelError, match="no point of number 999"):
        path.point(999)


def test_a_rod_on_a_spring_buckles_and_its_branch_is_found_from_both_ends():
    """The pitchfork P = K theta / sin(theta)."""
    path = kf.equilibrium_path(rod(), to=2.0 * K)
    (point,) = path.branch_points
    assert point.factor == pytest.approx(K, rel=BRANCHES)
    assert not path.limit_points
    assert point.shape("rod")[0] == pytest.approx([0, 0, 0, 0, 1, 0])
    assert path.unstable.tolist() == (path.factors > 1.001 * K).astype(int).tolist()
    for side in (1, -1):
        branch = path.branch(side=side, to=10.0 * K, longest=0.2)
        theta = angles(branch)[1:]
        assert (np.sign(theta) == side).all()
        assert branch.factors[1:] == pytest.approx(K * theta / np.sin(theta), rel=SOLVED)
        assert not branch.unstable.any()
        assert branch.factors[-1] == pytest.approx(10.0 * K, rel=SOLVED)
    buckled = kf.buckling(rod())
    same = kf.equilibrium_path(rod(), branch=buckled)
    assert same.factors[0] == pytest.approx(buckled.factors[0], rel=BRANCHES)
    assert same.factors[-1] == pytest.approx(2.0 * K, rel=SOLVED)
    theta = angles(same)[1:]
    assert same.factors[1:] == pytest.approx(K * theta / np.sin(theta), rel=SOLVED)


def test_an_imperfect_rod_bends_instead_and_says_so():
    """P cos-and-sin about the hinge: K theta = P (sin(theta) + e cos(theta))."""
    path = kf.equilibrium_path(rod(0.01), to=2.0 * K)
    theta = angles(path)
    exact = K * theta / (np.sin(theta) + 0.01 * np.cos(theta))
    assert path.factors == pytest.approx(exact, rel=SOLVED, abs=SOLVED)
    assert not path.critical_points
    assert "no limit point and no branch point" in str(path)
    with pytest.raises(ModelError, match=r"has the shape of mode 0 .*branch points: none"):
        kf.equilibrium_path(rod(0.01), branch=kf.buckling(rod()))
    with pytest.raises(ModelError, match="has 0 branch points, and at=0 is none"):
        path.branch()


@pytest.mark.parametrize(("aside", "longest"), [(1e-3, 0.2), (1e-4, 0.05), (1e-4, 1.0), (1e-6, 0.2)])
def test_a_step_does_not_change_to_another_path_that_is_near(aside, longest):
    """The path of the imperfect rod bends away at K; beyond it, its other path is upright and nearly in line."""
    path = kf.equilibrium_path(rod(aside), to=2.0 * K, longest=longest)
    theta = angles(path)[1:]
    assert path.factors[1:] == pytest.approx(K * theta / (np.sin(theta) + aside * np.cos(theta)), rel=SOLVED)
    assert (theta > 0.0).all()
    assert theta[-1] > 1.8  # theta / sin(theta) = 2 at 1.895
    assert not path.critical_points
    assert path.is_whole


def test_a_path_passes_where_a_contact_closes():
    """A sharp bend is no jump: the spring of a node is doubled where it meets a stop."""
    scene = kf.System()
    node = scene.add_rigid_body("node", 1.0, joint=kf.Prismatic("y", forces=kf.CoordinateForce(stiffness=10.0)))
    stop = scene.add_surface("stop", scene.ground.frame(at=(0, 0.2, 0)), kf.shapes.Plane("-y"))
    scene.add_contact("buffer", node.frame(), stop, normal=kf.KelvinVoigt(10.0, damping=0.0))
    scene.add_force(node, (0, 1, 0))
    path = kf.equilibrium_path(scene, to=4.0)
    y = path.position("node")[:, 1]
    assert path.factors == pytest.approx(10.0 * y + 10.0 * np.maximum(y - 0.2, 0.0), abs=SOLVED)
    assert path.is_whole


def test_a_following_force_has_no_branch_and_flutters():
    """Ziegler: (7/2 - sqrt 2) k / l, without any static branch."""
    path = kf.equilibrium_path(bars((1.0, True)), to=10.0)
    assert not path.branch_points
    assert not path.limit_points
    (point,) = path.flutter_points
    assert point.factor == pytest.approx(3.5 - np.sqrt(2.0), rel=1e-9)
    assert (path.unstable == 2 * (path.factors > point.factor + 1e-6)).all()
    assert "flutter begins at factor 2.0857864" in str(path)
    assert "no limit point and no branch point" in str(path)
    with pytest.raises(
        ModelError, match="has 0 branch points, and at=0 is none of them: what makes it unstable is flutter"
    ):
        path.branch()


def test_an_onset_of_flutter_is_solved_for_in_few_stops(monkeypatch):
    """A smooth measure needs some ten of them; halving a step to 1e-10 takes 34."""
    lengths = []

    def counted(*arguments, **options):
        lengths.append(arguments[2])
        return arc_length.stepped(*arguments, **options)

    for module in (crossings, zeros):
        monkeypatch.setattr(module, "stepped", counted)
    path = kf.equilibrium_path(bars((1.0, True)), to=10.0)
    assert [point.kind for point in path.critical_points] == ["flutter"]
    assert 3 <= len(lengths) <= 15


def test_flutter_begins_where_a_damped_motion_grows():
    """Ziegler's bars with equal dampers c: 41/28 + c^2 / 2 (Herrmann and Jong 1965)."""
    damping = 0.1
    path = kf.equilibrium_path(bars((1.0, True), damping=damping), to=3.0)
    (point,) = path.flutter_points
    # a growth counts from 1e-9 of the frequency on, and it is slow
    assert point.factor == pytest.approx(41.0 / 28.0 + 0.5 * damping**2, rel=1e-7)
    assert path.unstable[-1] == 2


def side_by_side(bars_of: tuple[float, ...], rod_of: tuple[float, ...] = ()) -> kf.System:
    """Return pairs of Ziegler's bars by the stiffness of their springs, and a rod that buckles at those of its own."""
    scene = kf.System()
    for i, stiffness in enumerate(bars_of):
        hinge = kf.Revolute("z", forces=kf.CoordinateForce(stiffness=stiffness))
        a = scene.add_rigid_body(f"a{i}", 2.0, 0.0, com=(1, 0, 0), joint=hinge)
        b = scene.add_rigid_body(f"b{i}", 1.0, 0.0, com=(1, 0, 0), parent=a, at=(1, 0, 0), joint=hinge)
        scene.add_force(b, (-1, 0, 0), point=(1, 0, 0), follows=True)
    if rod_of:
        springs = [kf.CoordinateForce(stiffness=stiffness) for stiffness in rod_of]
        joint = kf.Revolute("y", forces=springs[0]) if len(springs) == 1 else kf.Universal("x", "y", forces=springs)
        rod = scene.add_rigid_body("rod", 1.0, 0.1, com=(0, 0, 0.5), joint=joint)
        scene.add_force(rod, (0, 0, -1), point=(0, 0, 1))
    return scene


ZIEGLER = 3.5 - np.sqrt(2.0)


@pytest.mark.parametrize(
    ("bars_of", "rod_of"),
    [
        ((1.0, 1.02), ()),
        ((1.0, 1.0, 1.3), ()),
        ((1.0,), (2.0,)),
        ((1.0,), (2.1,)),
        ((1.0,), (3.0,)),
        ((1.0,), (2.5, 3.0)),
        ((1.0,), (3.0, 3.0)),
    ],
)
def test_all_that_happens_on_one_long_step_without_potential_is_told(bars_of, rod_of):
    """Bars side by side do not feel each other: each pair flutters at its own load, and the rod buckles at its own."""
    path = kf.equilibrium_path(side_by_side(bars_of, rod_of), to=4.5, longest=1.0)
    exact = {ZIEGLER * stiffness: "flutter" for stiffness in bars_of} | dict.fromkeys(rod_of, "branch")
    found = path.critical_points
    assert [point.kind for point in found] == [exact[factor] for factor in sorted(exact)]
    assert [point.factor for point in found] == pytest.approx(sorted(exact), rel=1e-9)
    assert sum(point.tangents.shape[1] for point in found) == len(rod_of)
    assert path.unstable[-1] == 2 * len(bars_of) + len(rod_of)


def test_between_points_of_one_step_the_equilibrium_is_that_of_the_factor():
    """What is found on a part of a step is of a copy of the point where it begins."""
    path = kf.equilibrium_path(side_by_side((1.0, 1.02)), to=4.5, longest=0.2)
    for low, high in pairwise(path.factors):
        for factor in low + np.array((0.1, 0.5, 0.9)) * (high - low):
            direct = kf.linearise(path.loaded.model_at(float(factor))).A
            assert path.at(float(factor)).linearise().A == pytest.approx(direct, abs=1e-9)


def slider_on_rod(stiffness: float) -> kf.System:
    """Return a rod on a hinge with a spring, which a load on a slider makes unstable where this is at half its height.

    Under p times the load the slider, on a spring of 4 along the rod, is at 1 - p/4: the stiffness about the hinge is
    that of its spring less ``p (1 - p / 4)``.
    """
    scene = kf.System()
    hinge = kf.Revolute("y", forces=kf.CoordinateForce(stiffness=stiffness))
    body = scene.add_rigid_body("rod", 1.0, 0.1, joint=hinge)
    spring = kf.CoordinateForce(stiffness=4.0)
    slider = scene.add_rigid_body("slider", 1.0, 0.1, parent=body, at=(0, 0, 1), joint=kf.Prismatic("z", forces=spring))
    scene.add_force(slider, (0, 0, -1))
    return scene


@pytest.mark.parametrize("below", [0.01, 1e-4])
@pytest.mark.parametrize("longest", [0.3, 1.0])
def test_a_stiffness_that_falls_through_zero_and_comes_back_on_one_step_is_told(below, longest):
    path = kf.equilibrium_path(slider_on_rod(1.0 - below), to=4.0, down_to=0.0, longest=longest)
    exact = 2.0 + np.array((-2, 2)) * np.sqrt(below)
    assert [point.factor for point in path.branch_points] == pytest.approx(exact, rel=BRANCHES)
    at = [point.number for point in path.branch_points]
    assert path.unstable[at].tolist() == [0, 1]
    assert (path.unstable[at[1] + 1 :] == 0).all()


def test_a_stiffness_that_comes_near_zero_has_no_branch():
    path = kf.equilibrium_path(slider_on_rod(1.0 + 1e-4), to=4.0, down_to=0.0, longest=1.0)
    assert not path.critical_points
    assert not path.unstable.any()


def test_between_two_branch_points_of_one_step_one_motion_grows():
    scene = kf.System()
    for name, stiffness in (("first", 1.0), ("second", 1.01)):
        hinge = kf.Revolute("y", forces=kf.CoordinateForce(stiffness=stiffness))
        body = scene.add_rigid_body(name, 1.0, 0.1, com=(0, 0, 0.5), joint=hinge)
        scene.add_force(body, (0, 0, -1), point=(0, 0, 1))
    path = kf.equilibrium_path(scene, to=2.0, longest=1.0)
    assert [point.factor for point in path.branch_points] == pytest.approx([1.0, 1.01], rel=BRANCHES)
    first, second = (point.number for point in path.branch_points)
    assert second == first + 1  # they are on one step
    assert path.unstable[[first, second, second + 1]].tolist() == [0, 1, 2]


def test_a_force_that_follows_in_part_has_branches_of_an_unsymmetric_stiffness():
    """The share s follows: det K = 1 - (1 - s)(3 p - p^2), without a potential."""
    share = 0.1
    path = kf.equilibrium_path(bars((1.0 - share, False), (share, True)), to=4.0)
    exact = (3.0 + np.array((-1, 1)) * np.sqrt(9.0 - 4.0 / (1.0 - share))) / 2.0
    assert [point.factor for point in path.branch_points] == pytest.approx(exact, rel=BRANCHES)
    branch = path.branch(0, to=0.6)
    first, second = angles(branch, "a"), angles(branch, "a") + angles(branch, "b")
    p = branch.factors
    # moments about the second hinge and the first one
    assert p * (1.0 - share) * np.sin(second) == pytest.approx(angles(branch, "b"), abs=1e-9)
    across = (1.0 - share) * np.sin(first) + share * np.sin(first - second)
    assert p * across + angles(branch, "b") == pytest.approx(first, abs=1e-9)
    assert np.abs(first).max() > 0.3


def chain(n: int) -> kf.System:
    """Return a clamped column of n rigid links with springs, as long as one metre of E I = 1, under a dead load."""
    scene, parent, length = kf.System(), None, 1.0 / n
    for i in range(n):
        # the clamp is half a link away from the first spring
        joint = kf.Revolute("z", forces=kf.CoordinateForce(stiffness=n * (1.0 if i else 2.0)))
        place = {} if parent is None else {"parent": parent, "at": (length, 0, 0)}
        parent = scene.add_rigid_body(f"link {i}", length, 1e-4, com=(length / 2, 0, 0), joint=joint, **place)
    scene.add_force(parent, (-1, 0, 0), point=(length, 0, 0))
    return scene


def tip_first(n: int, load: float, tip: float) -> list[float]:
    """Return the angles of the links from the tip to the root: each spring carries the moment of what is above it."""
    found, lever = [tip], 0.0
    for i in range(n):
        lever += np.sin(found[-1]) / n
        found.append(found[-1] - load * lever / (n * (1.0 if i < n - 1 else 2.0)))
    return found


def test_a_chain_buckles_as_the_difference_equation_says():
    """Hencky's chain: P = 2 n^2 (1 - cos(pi / 2 n)), and its elastica by shooting from the tip."""
    n = 12
    path = kf.equilibrium_path(chain(n), to=30.0)
    exact = [2.0 * n**2 * (1.0 - np.cos((2 * i + 1) * np.pi / (2 * n))) for i in range(2)]
    assert [point.factor for point in path.branch_points] == pytest.approx(exact, rel=BRANCHES)
    assert path.unstable[-1] == 2
    for mode in range(2):
        branch = path.branch(mode, to=1.3 * exact[mode])
        last = branch.point(-1)
        turned = np.cumsum([float(last.joint_coordinates(f"link {i}")[0]) for i in range(n)])
        tip = float(turned[-1])
        assert abs(tip) > 0.5
        load = brentq(lambda p, tip=tip: tip_first(n, p, tip)[-1], 0.9 * branch.factors[-1], 1.1 * branch.factors[-1])
        assert branch.factors[-1] == pytest.approx(load, rel=1e-9)
        assert turned[::-1] == pytest.approx(tip_first(n, load, tip)[:-1], abs=1e-8)
        assert (branch.unstable == mode).all()


C, MIDDLE, ANGLE, SUPPORT = 1.0, 0.8, 0.5, 200.0


def arch() -> kf.System:
    """Return an arch of three bars (1, MIDDLE, 1) on pins with springs C between them, one pin on a spring SUPPORT."""
    scene = kf.System()
    spring = kf.CoordinateForce(stiffness=C, rest=-ANGLE)
    pin = kf.Revolute("z", position=-ANGLE, forces=spring)
    left = scene.add_rigid_body("left", 1.0, 0.1, com=(0.5, 0, 0), joint=kf.Revolute("z", position=ANGLE))
    middle = scene.add_rigid_body("middle", 1.0, 0.1, com=(0.4, 0, 0), parent=left, at=(1, 0, 0), joint=pin)
    right = scene.add_rigid_body("right", 1.0, 0.1, com=(0.5, 0, 0), parent=middle, at=(MIDDLE, 0, 0), joint=pin)
    slide = kf.Prismatic("x", forces=kf.CoordinateForce(stiffness=SUPPORT))
    support = scene.add_rigid_body("support", 1.0, 0.1, at=(2.0 * np.cos(ANGLE) + MIDDLE, 0, 0), joint=slide)
    scene.add_loop_joint("pin", kf.Revolute("z"), right.frame(at=(1, 0, 0)), support)
    for body, x in ((left, 1.0), (right, 0.0)):
        scene.add_force(body, (0, -0.5, 0), point=(x, 0, 0))
    return scene


def arch_load(a: float) -> float:
    """Return the load of the symmetric path at the angle of the outer bars."""
    return (4.0 * SUPPORT * (np.cos(a) - np.cos(ANGLE)) * np.sin(a) - 2.0 * C * (a - ANGLE)) / np.cos(a)


def arch_tilts(a: float) -> float:
    """Return the second derivative of the potential as one outer bar rises and the other falls."""
    g = 2.0 * np.cos(a) / MIDDLE
    closer = 2.0 * (np.cos(a) - np.cos(ANGLE))
    return 2.0 * C * (1.0 + g) ** 2 - SUPPORT * closer * (2.0 * np.cos(a) + MIDDLE * g**2) - arch_load(a) * np.sin(a)


def test_a_shallow_arch_tilts_before_it_snaps_and_the_tilted_path_joins_both_branch_points():
    path = kf.equilibrium_path(arch(), to=30.0, longest=0.1)
    tilts = [brentq(arch_tilts, *ends) for ends in ((0.3, 0.5), (-0.5, -0.3))]
    slope: Callable[[float], float] = lambda a: (arch_load(a + 1e-5) - arch_load(a - 1e-5)) / 2e-5  # noqa: E731
    tops = [brentq(slope, *ends) for ends in ((0.2, 0.4), (-0.4, -0.2))]
    assert [point.kind for point in path.critical_points] == ["branch", "limit", "limit", "branch"]
    loads = [arch_load(a) for a in tilts]
    assert [point.factor for point in path.branch_points] == pytest.approx(loads, rel=BRANCHES)
    assert [point.factor for point in path.limit_points] == pytest.approx([arch_load(a) for a in tops], rel=1e-8)
    a = angles(path, "left")
    assert path.factors == pytest.approx(arch_load(a), abs=1e-8)
    numbers = [0, *(point.number for point in path.critical_points)]
    assert path.unstable[numbers].tolist() == [0, 0, 1, 2, 1]
    tilted = path.branch(longest=0.1)
    assert "where it began: it is closed" in tilted.ended
    assert tilted.is_whole
    crossed = [point.factor for point in tilted.branch_points]
    assert min(crossed) == pytest.approx(loads[1], abs=1e-5)


def test_two_motions_that_buckle_at_once_are_one_point_with_two_shapes():
    scene = kf.System()
    spring = kf.CoordinateForce(stiffness=K)
    joint = kf.Universal("x", "y", forces=(spring, spring))
    body = scene.add_rigid_body("rod", 1.0, 0.1, com=(0, 0, 0.5), joint=joint)
    scene.add_force(body, (0, 0, -1), point=(0, 0, 1))
    path = kf.equilibrium_path(scene, to=2.0 * K)
    (point,) = path.branch_points
    assert point.factor == pytest.approx(K, rel=BRANCHES)
    assert point.tangents.shape == (2, 2)
    assert path.unstable[-1] == 2
    ends = [path.branch(mode=mode).position("rod")[-1] for mode in range(2)]
    assert np.isfinite(ends).all()
    with pytest.raises(ModelError, match="there is no mode 2"):
        path.branch(mode=2)


def test_a_rod_on_a_ball_joint_is_followed_through_large_rotations():
    """A rod that two springs hold upright, pushed over: each point is the rest of the scene under its loads."""

    def held(factor: float) -> kf.System:
        scene = kf.System(gravity=(0, 0, -9.81))
        body = scene.add_rigid_body("rod", 1.0, 0.1, com=(0, 0, 0.5), joint=kf.Spherical())
        top = body.frame(at=(0, 0.3, 1))
        for name, at in (("a", (2, 0, 1)), ("b", (-1, 1.7, 1)), ("c", (-1, -1.7, 1))):
            scene.add_spring(name, scene.ground.frame(at=at), top, stiffness=100.0, rest_length=1.0)
        scene.add_force(body, (30.0 * factor, 20.0 * factor, 0), point=(0, 0, 1))
        return scene

    path = kf.equilibrium_path(held(1.0), loads="the force on 'rod'", to=4.0)
    assert path.kept == ("gravity",)
    for factor in (1.0, 2.5, 4.0):
        found = path.at(factor)
        there = kf.equilibrium(held(factor), start=found)
        assert found.imbalance.ratio < 1e-9
        middle = [rest.read("center_of_mass", "rod") for rest in (found, there)]
        assert middle[0] == pytest.approx(middle[1], abs=1e-9)


def test_a_path_that_ends_early_says_where():
    with pytest.warns(SimulationWarning, match="the path ended after 5 points, at"):
        path = kf.equilibrium_path(truss(), to=4.0, points=5)
    assert not path.is_whole
    assert len(path) == 5


def test_the_path_ends_on_the_other_side_as_well():
    path = kf.equilibrium_path(truss(), to=4.0, down_to=-1.0)
    assert path.factors[-1] == pytest.approx(-1.0, rel=SOLVED)
    back = kf.equilibrium_path(truss(), to=-4.0, down_to=0.0)
    assert back.factors[-1] == pytest.approx(-4.0, rel=SOLVED)
    assert (np.diff(back.factors) < 0.0).all()


def test_a_picture_shows_what_is_stable(tmp_path):
    path = kf.equilibrium_path(truss(), to=4.0)
    for options in ({}, {"of": "node"}, {"of": "node", "axis": "y"}, {"of": "node: distance [m]"}):
        axes = path.plot(tmp_path / "path.png", **options).axes[0]
        assert [text.get_text() for text in axes.get_legend().get_texts()] == ["stable", "unstable", "limit point"]
    assert axes.get_xlabel() == "node: distance [m]"
    buckles = kf.equilibrium_path(rod(), to=2.0 * K)
    axes = buckles.plot(of="rod: angle [rad]", branches=[buckles.branch(), buckles.branch(side=-1)]).axes[0]
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["stable", "unstable", "branch point"]
    assert sorted(round(float(np.sign(line.get_xdata()[-1]))) for line in axes.lines) == [-1, 0, 0, 0, 1]
    with pytest.raises(ModelError, match="must be x, y or z, not 'w'"):
        path.plot(of="node", axis="w")


def hung() -> kf.System:
    scene = kf.System(gravity=(0, 0, -9.81))
    scene.add_rigid_body("free", 1.0, joint=kf.Prismatic("x"))
    return scene


def rubbing(spring: kf.CoordinateForce, mu: float = 0.0) -> kf.System:
    scene = kf.System(gravity=(0, 0, -9.81))
    block = scene.add_rigid_body("block", 1.0, joint=kf.Prismatic("z", forces=spring))
    friction = kf.Coulomb(mu) if mu else None
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    scene.add_contact("foot", block.frame(), floor, normal=kf.HuntCrossley(1e5), friction=friction)
    return scene


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: kf.equilibrium_path(truss(), to=0.0), "to must be a factor other than zero"),
        (lambda: kf.equilibrium_path(truss(), to=2.0, down_to=1.0), "down_to must be zero or of the other sign"),
        (lambda: kf.equilibrium_path(truss(), longest=2.0), "longest must be above 0 and at most 1"),
        (lambda: kf.equilibrium_path(truss(), points=1), "points must be a whole number of at least 2"),
        (lambda: kf.equilibrium_path(truss(), loads="wind"), "has no load 'wind'"),
        (lambda: kf.equilibrium_path(truss(), branch="first"), "branch must be the result of kanefe.buckling"),
        (lambda: kf.equilibrium_path(truss(), loads="gravity", branch=kf.buckling(rod())), "leave out loads="),
        (lambda: kf.equilibrium_path(hung()), "no restoring force along free: distance"),
        (
            lambda: kf.equilibrium_path(rubbing(kf.CoordinateForce(9.0, friction=1.0))),
            "'friction of block' is not supp",
        ),
        (lambda: kf.equilibrium_path(rubbing(kf.CoordinateForce(9.0), 0.3)), "friction of 'foot' is not supported"),
        (lambda: kf.equilibrium_path(rod(), to=2 * K).branch(side=0), "side of a branch must be 1 or -1"),
    ],
)
def test_bad_input_is_named(make, said):
    with pytest.raises(ModelError, match=said):
        make()


def test_a_pressure_turns_with_its_body_and_what_is_left_out_is_said():
    """On a hinge with a spring: its moment is constant in the frame of the body, k theta = p M_y, at any angle."""
    model = lattice_model(1)
    forces = np.random.default_rng(4).standard_normal((len(model.nodes), 3))
    side = NodalPattern.of_nodes(model.nodes, model.components, np.ones(len(forces)), forces)
    held = {"root": "clamped", "tip": "rigid"}
    plate = flexible_body(replace(model, load_patterns={"side": side}), held, reduction=kf.CraigBampton(modes=3))
    moment = float(side.pressure_moment[1])
    scene = kf.System()
    hinge = kf.Revolute("y", forces=kf.CoordinateForce(stiffness=2.0))
    scene.add_pressure(scene.add_flexible_body("plate", plate, joint=hinge), "side", 2e-3 / moment)
    with pytest.warns(AccuracyWarning, match="turns with the frame of its body, and how the surface itself deforms is"):
        path = kf.equilibrium_path(scene, to=1000.0)
    assert angles(path, "plate") == pytest.approx(1e-3 * path.factors, abs=1e-9)
    assert not path.unstable.any()
