"""Beams cut into segments: convergence to closed forms, mass, rigid motion, results of the whole, bad input."""

from __future__ import annotations

import numpy as np
import pytest

import kanefe as kf
import kanefe_fem
from kanefe.checks.verification.references import load_references
from kanefe_fem import Material, Rectangle, beam_body, beam_model, segmented, straight_beam
from kanefe_fem.verification.segmented_beams import tip_of_elastica
from vtk_files import read_fields, read_grid, read_series

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
SECTION = Rectangle(0.01, 0.02)
ENDS = {"root": "clamped", "tip": "rigid"}
EI = STEEL.E * 0.02 * 0.01**3 / 12


def beam(elements: int = 24, planar: bool = False):
    """Return a cantilever of 1 m."""
    return straight_beam(1.0, SECTION, STEEL, elements=elements, planar=planar, theory="euler-bernoulli")


def loaded(chain, force, gravity=(0.0, 0.0, 0.0)):
    """Return the rest of a chain under a force at its tip."""
    scene = kf.System(gravity=gravity)
    scene.add_force(scene.add_segmented_body("blade", chain).interface("tip"), force)
    return kf.equilibrium(scene)


@pytest.mark.filterwarnings("ignore::kanefe.AccuracyWarning")
@pytest.mark.parametrize(
    ("stiffening", "order", "load", "worst"),
    [
        pytest.param("none", 2, "1", 2e-4, marks=pytest.mark.slow),
        pytest.param("none", 2, "2", 5.5e-4, marks=pytest.mark.slow),
        ("none", 2, "5", 1.25e-3),
        ("full", 3, "1", 1e-5),
        pytest.param("full", 3, "2", 5e-5, marks=pytest.mark.slow),
        pytest.param("full", 3, "5", 2e-4, marks=pytest.mark.slow),
    ],
)
def test_elastica_g05(stiffening, order, load, worst):
    """Tip of the cantilever at P L^2 / EI = 1, 2, 5; 16 segments have 1e-3 of the length, or 1.2e-3 at 5."""
    exact = np.array([load_references()["G05"].values[load][key] for key in ("deflection_over_L", "x_over_L")])
    errors = [np.linalg.norm(tip_of_elastica(float(load), k, stiffening)[1:] - exact) for k in (8, 16)]
    assert errors[1] < worst
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.15)


@pytest.mark.filterwarnings("ignore::kanefe.AccuracyWarning")
@pytest.mark.parametrize("turns", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_roll_up_by_an_end_moment(turns):
    """Everywhere u = L (sin t / t - 1), v = L (1 - cos t) / t along the whole line, with order 2."""
    model, angle, errors = beam(64, planar=True), 2 * np.pi * turns, []
    along = np.linspace(0, 1, 65)
    exact = np.column_stack([np.sin(angle * along), 1 - np.cos(angle * along), 0 * along]) / angle
    stiffness = model.elasticity.table[0, 5, 5]
    for count in (16, 32):
        scene = kf.System()
        body = scene.add_segmented_body("b", segmented(model, ENDS, segments=count))
        scene.add_torque(body.interface("tip"), (0, 0, angle * stiffness))
        rest = kf.equilibrium(scene)
        errors.append(abs(rest.nodal_positions("b") - exact).max())
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2, abs=0.05)
    assert errors[1] < 2.1e-3 * turns
    assert np.linalg.norm(rest.position("b", "tip")) < 1e-9


def test_frequencies_of_a_cantilever():
    """The first three about the weaker axis, with order 4 of consistent masses: 1e-4 with 16 segments."""
    exact = np.array([1.87510407, 4.69409113, 7.85475744]) ** 2 * np.sqrt(EI / (7850 * 2e-4)) / (2 * np.pi)
    errors = []
    for count in (8, 16):
        scene = kf.System()
        scene.add_segmented_body("b", segmented(beam(32), ENDS, segments=count))
        found = kf.linearise(scene).modes().frequencies
        errors.append(max(abs(found / f - 1).min() for f in exact))
    assert errors[0] < 1e-3
    # what is left is the rotary inertia of the sections
    assert errors[1] < 6e-4


@pytest.mark.parametrize("count", [1, 5, 24])
def test_mass_and_inertia_are_those_of_the_whole(count):
    """Of a curved and twisted beam, to round-off; one element a segment is the limit."""
    t = np.linspace(0, 2, 25)
    nodes = np.column_stack([np.sin(t), 1 - np.cos(t), 0.2 * t])
    model = beam_model(nodes, np.column_stack([np.arange(24), np.arange(1, 25)]), SECTION, STEEL)
    chain, whole = segmented(model, ENDS, segments=count), beam_body(model, ENDS, kf.CraigBampton(modes=1))
    assert chain.mass == pytest.approx(whole.mass, rel=1e-14)
    np.testing.assert_allclose(chain.center_of_mass, whole.center_of_mass, atol=1e-14)
    np.testing.assert_allclose(chain.inertia, whole.inertia, atol=1e-13 * whole.inertia.max())
    assert len(chain.segments) == count
    scene = kf.System()
    scene.add_segmented_body("b", chain, at=(1, 2, 3))
    np.testing.assert_allclose(kf.equilibrium(scene).nodal_positions("b"), nodes + np.array((1, 2, 3)), atol=1e-13)


def test_small_deflection_is_that_of_one_body():
    """Under a small force tip, section forces and fibre stresses are those of the whole, whatever the cuts."""
    model, force = beam(), (0.0, 0.1, -0.2)
    rest = loaded(segmented(model, ENDS, segments=7), force)
    scene = kf.System()
    body = scene.add_flexible_body("blade", beam_body(model, ENDS, kf.CraigBampton(modes=0)))
    scene.add_force(body.interface("tip"), force)
    one = kf.equilibrium(scene)
    # both are linear up to the square of the slope, 1e-4
    np.testing.assert_allclose(rest.deflection("blade", "tip"), one.deflection("blade", "tip"), atol=1e-7)
    own, other = (kanefe_fem.recover(r, "blade") for r in (rest, one))
    np.testing.assert_allclose(own.section_forces().forces, other.section_forces().forces, atol=1e-3 * 0.2)
    np.testing.assert_allclose(own.stress_of(own.eta), other.stress_of(other.eta), atol=1e-3 * 6e5)
    np.testing.assert_allclose(rest.nodal_displacements("blade"), one.nodal_displacements("blade"), atol=1e-7)


def test_rigid_motion_has_no_strain():
    """A free chain without forces that starts to drift stays straight: strain energy is round-off."""
    scene = kf.System()
    chain = segmented(beam(), {"tip": "rigid"}, segments=6)
    scene.add_segmented_body("b", chain, joint=kf.Free(velocity=(1.0, 2.0, 3.0)))
    result = scene.simulate((0, 0.5))
    assert result.energy.elastic.max() < 1e-24 * result.energy.kinetic[0]
    np.testing.assert_allclose(result.nodal_positions("b")[-1], chain.nodes + np.array((0.5, 1.0, 1.5)), atol=1e-12)
    turned = kf.System()
    turned.add_segmented_body("b", chain, joint=kf.Free(orientation=kf.rotation_about((1, 2, 3), 2.0)))
    assert kf.equilibrium(turned).modal_coordinates("b") == pytest.approx(0.0, abs=1e-12)


def test_free_flight_keeps_momenta_and_energy():
    """A chain that floats and spins, held at a cut in the middle."""
    scene = kf.System()
    chain = segmented(beam(), {"tip": "rigid"}, segments=6)
    scene.add_segmented_body("b", chain, joint=kf.Free(angular_velocity=(0.3, 2.0, 5.0)))
    result = scene.simulate((0, 0.1), rtol=1e-8)
    assert result.energy.balance_error == pytest.approx(0.0, abs=1e-7 * result.energy.kinetic[0])
    angular = result.momentum.angular
    np.testing.assert_allclose(angular - angular[0], 0.0, atol=1e-7 * np.linalg.norm(angular[0]))
    # the origin, which is at an end, is at rest at first
    drift = np.array((0.5, 0, 0)) + np.outer(result.times, (0.0, 2.5, -1.0))
    np.testing.assert_allclose(result.center_of_mass("b"), drift, atol=1e-8)


def test_damping_is_that_of_the_whole():
    """In proportion to the stiffness: the ratio of the first mode is half of factor times its frequency."""
    scene = kf.System()
    chain = segmented(beam(), ENDS, segments=8, damping=kf.RayleighDamping(0.0, 1e-6))
    scene.add_segmented_body("b", chain)
    modes = kf.linearise(scene).modes()
    assert modes.damping_ratios[0] == pytest.approx(np.pi * modes.frequencies[0] * 1e-6, rel=1e-3)


def test_channels_are_named_by_the_whole():
    """Inputs and readings of linear analysis and controllers know interfaces of the whole."""
    scene = kf.System()
    scene.add_segmented_body("b", segmented(beam(), ENDS, segments=3))
    linear = kf.linearise(scene, inputs="force b/tip z", outputs="position b/tip z")
    static = (linear.C @ np.linalg.solve(-linear.A, linear.B)).item()
    assert static == pytest.approx(1.0 / (3.0 * STEEL.E * 0.01 * 0.02**3 / 12), rel=1e-4)
    with pytest.raises(kf.ModelError, match="no body called 'b/cut 1 z'"):
        kf.linearise(scene, inputs="force b/cut 1 z")


def test_results_of_the_whole(tmp_path):
    """By name, from a file, as VTK of one body and as a page with stresses."""
    scene = kf.System(gravity=(0, 0, -9.81))
    member = scene.add_segmented_body("blade", segmented(beam(), ENDS, segments=4))
    scene.add_line_load(member, "span", (0.0, 3.0, 0.0))
    scene.add_force(member.node(12), lambda t: (0.0, 0.0, 5.0 * np.sin(20 * t)))
    result = scene.simulate((0, 0.02), output_step=0.002)
    assert result.segmented == {"blade": ("blade 1", "blade 2", "blade 3", "blade 4")}
    assert result.body("blade").mass == pytest.approx(7850 * 2e-4)
    assert result.interfaces("blade") == ("root", "tip")
    assert result.nodal_positions("blade").shape == (len(result.times), 25, 3)
    np.testing.assert_allclose(result.nodal_positions("blade")[:, 24], result.position("blade", "tip"), atol=1e-12)
    result.save(tmp_path / "run.h5")
    again = kf.load_result(tmp_path / "run.h5")
    np.testing.assert_array_equal(again.nodal_displacements("blade"), result.nodal_displacements("blade"))
    np.testing.assert_array_equal(again.deflection("blade", "tip"), result.deflection("blade", "tip"))
    stress = kanefe_fem.recover(result, "blade")
    page = result.to_html(tmp_path / "run.html", stress=stress)
    text = page.read_text()
    assert '"name":"blade"' in text
    assert "blade 4" not in text
    pvd = result.to_vtk(tmp_path / "run.pvd", every=5).read_text()
    assert 'name="blade"' in pvd
    assert "blade 4" not in pvd
    with pytest.raises(kf.ModelError, match="cut into segments"):
        stress.section_forces(inertia=True)


def test_a_segmented_body_counts_as_its_segments(tmp_path):
    """So does `bodies`: the number of any other body is its own."""
    ends = {"root": "clamped", "tip": "rigid"}
    plain = beam_body(straight_beam(0.4, SECTION, STEEL, elements=4), ends, kf.CraigBampton(modes=2))
    scene = kf.System(gravity=(0, 0, -9.81))
    last = scene.add_segmented_body("chain", segmented(beam(8, planar=False), ends, segments=4))
    hub = scene.add_rigid_body("hub", 0.1, 1e-4, parent=last.interface("tip"))
    for name in "ab":
        scene.add_flexible_body(name, plain, parent=hub)
    rest = kf.equilibrium(scene)
    entries = read_series(rest.to_vtk(tmp_path / "scene.pvd"))
    numbers = {}
    for _, name, file in entries:
        assert read_fields(file)["bodies"] == list(rest.bodies)
        numbers[name] = [rest.bodies[i] for i in read_grid(file)["body"]]
    assert numbers["chain"] == [f"chain {i}" for i in (1, 1, 2, 2, 3, 3, 4, 4)]
    assert set(numbers["a"]) == {"a"}
    assert set(numbers["b"]) == {"b"}
    assert numbers["rigid bodies"] == ["hub"]


def test_a_line_load_is_that_of_the_whole():
    """Its resultant at the root is the load times the length, for a line of half the beam too."""
    table = np.column_stack([np.arange(10), np.arange(1, 11)])
    model = beam_model(
        [[0.1 * i, 0, 0] for i in range(11)], table, SECTION, STEEL, lines={"all": range(10), "outer": range(5, 10)}
    )
    for line, force, moment in (("all", 2.0, 1.0), ("outer", 1.0, 0.75)):
        scene = kf.System()
        member = scene.add_segmented_body("b", segmented(model, ENDS, segments=4))
        scene.add_line_load(member, line, (0.0, 2.0, 0.0))
        held = kf.equilibrium(scene).coupling_force("b", "root")
        np.testing.assert_allclose(held[[1, 5]], (-force, -moment), rtol=1e-5)
    with pytest.raises(kf.ModelError, match="no segment has a surface or line for loads called 'cut 1'"):
        scene.copy().add_line_load(scene.copy().segmented_body("b"), "cut 1", (0, 1, 0))


def test_the_middle_may_hold_the_whole():
    """Fixed at its middle, a beam bends to both sides alike."""
    model = straight_beam(1.0, SECTION, STEEL, elements=20, start=(-0.5, 0, 0))
    fixed = {"middle": kf.Interface("all", at=kf.Near((0, 0, 0), 1e-6)), "root": "rigid", "tip": "rigid"}
    scene = kf.System()
    member = scene.add_segmented_body("b", segmented(model, fixed, segments=5))
    for end in ("root", "tip"):
        scene.add_force(member.interface(end), (0, 0, 300.0))
    rest = kf.equilibrium(scene)
    x = rest.nodal_positions("b")
    np.testing.assert_allclose(x[::-1, 2], x[:, 2], atol=1e-9)
    np.testing.assert_allclose(x[::-1, 0], -x[:, 0], atol=1e-9)


def test_accuracy_chooses_the_number():
    """What it found holds against the elastica; a run can be compared instead."""
    load = EI  # P L^2 / EI = 1 about the weaker axis
    model = beam(64)
    chain = segmented(model, ENDS, accuracy=2e-3, loads={"tip": (0, load, 0, 0, 0, 0)})
    exact = load_references()["G05"].values["1"]
    x, y, _ = loaded(chain, (0, load, 0)).position("blade", "tip")
    error = np.hypot(x - exact["x_over_L"], y - exact["deflection_over_L"])
    assert error < 2e-3
    assert error == pytest.approx(chain.found["displacement"], rel=0.5)
    assert "displacement" in repr(chain)
    assert set(chain.found) == {"displacement", "rotation", "frequency"}

    def along(chain):
        scene = kf.System(gravity=(0, 0, -9.81))
        scene.add_segmented_body("body", chain)
        return scene.simulate((0, 0.02), output_step=0.005)

    assert len(segmented(model, ENDS, segments=2, accuracy=1e-2, along=along).segments) in (2, 4)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({}, "needs segments"),
        ({"segments": 0}, "at least 1"),
        ({"segments": 25}, "25 segments of 24 elements"),
        ({"segments": 2, "loads": {"tip": np.zeros(6)}}, "Remedy: give accuracy too"),
        ({"accuracy": 1e-7, "segments": 12}, "accuracy 1e-07 is not reached by"),
        ({"accuracy": 2.0}, "between 0 and 1"),
        ({"accuracy": 0.1, "loads": (0.0, 1.0)}, "loads= of segmented must be a mapping"),
        ({"accuracy": 0.1, "loads": {"nose": np.zeros(6)}}, "no interface called 'nose'"),
        ({"segments": 2, "damping": kf.ModalDamping(0.01)}, "modes of each segment"),
        ({"segments": 2, "damping": kf.RayleighDamping(1.0, 1e-5)}, "modes of each segment"),
        ({"segments": 2, "order": 2}, "is for meshes"),
        ({"segments": 2, "materials": STEEL}, "is for meshes"),
    ],
)
def test_bad_numbers(given, message):
    with pytest.raises(kf.ModelError, match=message):
        segmented(beam(), ENDS, **given)


@pytest.mark.parametrize(
    ("interfaces", "message"),
    [
        (
            {"root": "clamped", "middle": kf.Interface(at=kf.Near((0.5, 0, 0), 1e-6))},
            "at the cut between segments 2 and 3",
        ),
        ({"root": "clamped", "tip": "clamped"}, "'root' and 'tip' are fixed in G, but belong to segments 1 and 4"),
        ({"root": "clamped", "cut 1": "rigid"}, "has a name of the faces of cuts"),
        ({"part": kf.Interface("all", at=kf.Near((0.5, 0, 0), 0.3))}, "at the cut between segments"),
        ("clamped", "dict of names"),
    ],
)
def test_bad_interfaces(interfaces, message):
    with pytest.raises(kf.ModelError, match=message):
        segmented(beam(), interfaces, segments=4)


def test_bad_shapes():
    """A frame, a ring, a line that crosses itself, a stout beam, something attached."""
    corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0, 0.0]]
    for table, message in (
        ([[0, 1], [1, 2], [1, 3], [3, 4]], "branch at node 1"),
        ([[0, 1], [1, 2], [2, 3], [3, 4], [4, 0]], "form a ring"),
        ([[0, 1], [1, 2], [2, 3], [3, 4]], "crosses or touches itself at"),
    ):
        with pytest.raises(kf.ModelError, match=message):
            segmented(beam_model(corners, table, SECTION, STEEL), {"root": "clamped"}, segments=2)
    with pytest.raises(kf.ModelError, match="too stout to be cut"):
        segmented(straight_beam(0.05, SECTION, STEEL), ENDS, segments=2)
    heavy = kanefe_fem.attach(beam(), [kanefe_fem.LumpedMass("tip", mass=1.0)])
    with pytest.raises(kf.ModelError, match="lumped masses"):
        segmented(heavy, ENDS, segments=2)
    with pytest.raises(kf.ModelError, match="a beam model or a mesh"):
        segmented(beam_body(beam(), ENDS, kf.CraigBampton(modes=1)), ENDS, segments=2)


def test_bad_use_in_a_scene():
    chain = segmented(beam(), ENDS, segments=4)
    scene = kf.System()
    member = scene.add_segmented_body("blade", chain)
    for call, message in (
        (lambda: scene.add_segmented_body("blade", chain), "already has a body called"),
        (lambda: scene.add_flexible_body("wing", chain), "add_segmented_body"),
        (lambda: scene.add_segmented_body("wing", chain.segments[0].body), "must be a SegmentedBody"),
        (lambda: scene.add_rigid_body("blade", 1.0), "already has a body"),
        (lambda: member.interface("cut 2"), "face inside the body"),
        (lambda: member.interface("nose"), "no interface called 'nose'"),
        (lambda: member.node(99), "not one of the 25 nodes"),
        (lambda: scene.segmented_body("wing"), "no segmented body called 'wing'. It has: blade"),
    ):
        with pytest.raises(kf.ModelError, match=message):
            call()
    copy = scene.copy()
    assert copy.segmented_body("blade").members[3].name == "blade 4"


def test_a_step_of_a_hundred_segments():
    """An evaluation of order n: ten times the segments take about 11 times as long, not 100; between them, 33."""
    seconds = []
    for count in (10, 100):
        scene = kf.System(gravity=(0, 0, -9.81))
        scene.add_segmented_body("b", segmented(beam(100), ENDS, segments=count))
        runs = [scene.copy().simulate((0, 2e-5), method="rk4", step=1e-7, output_step=2e-5) for _ in range(3)]
        seconds.append(min(run.statistics["seconds_by_part"]["steps"] for run in runs))
    assert seconds[1] / seconds[0] < 33
