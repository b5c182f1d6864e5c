"""Forces of loads on their ends, and vectors in the axes of bodies."""

import numpy as np
import pytest

import kanefe as kf
from kanefe.frames import rotation_matrix


@pytest.fixture(scope="module")
def run():
    scene = kf.System(gravity=(0, 0, -9.81))
    deck = scene.add_frame("deck", joint=kf.Revolute("x", motion=kf.Motion.steady(0.5, 0.2)))
    crate = scene.add_rigid_body("crate", 20.0, 1.0, parent=deck, joint=kf.Free(position=(0, 0, 1)))
    scene.add_bushing("held", deck, crate, stiffness=(1e4,) * 3 + (1e3,) * 3, damping=(300.0,) * 3 + (30.0,) * 3)
    way = deck.frame(at=(0, 0, -2)), deck.frame(at=(0, 1, 0)), crate.frame(at=(0.1, 0.2, 0))
    scene.add(kf.Rope("lashing", way, axial_stiffness=1e5, preload=200.0))
    return scene.simulate((0.0, 0.6), output_step=0.05)


def test_a_rope_pulls_along_its_ends(run):
    result = run
    tension = result.load("lashing")[:, 2]
    pull = result.in_axes_of("deck", result.load_force("lashing"))
    np.testing.assert_allclose(np.linalg.norm(pull[:, :3], axis=1), tension, rtol=1e-12)
    assert np.all(pull[:, 3:] == 0.0)
    # in axes of the deck the first part of the rope stands still: from (0, 1, 0) to the winch at (0, 0, -2)
    first = result.in_axes_of("deck", result.load_force("lashing", 0))
    np.testing.assert_allclose(first[:, :3], tension[:, None] * (0, 1, 2) / np.sqrt(5), rtol=1e-10, atol=1e-10)
    # ends of a rope are in balance as a whole
    total = sum(result.load_force("lashing", i)[:, :3] for i in range(3))
    np.testing.assert_allclose(total, 0.0, atol=1e-10)


def test_a_moment_is_turned_as_a_force_is(run):
    result = run
    wrench = result.load_force("held")
    axes = result.rotation("crate")
    turned = result.in_axes_of("crate", wrench)
    for row, e in enumerate(axes):
        A = rotation_matrix(e)
        expected = np.concatenate((A.T @ wrench[row, :3], A.T @ wrench[row, 3:]))
        np.testing.assert_allclose(turned[row], expected, atol=1e-14 * np.abs(expected).max())  # round-off of its sums
    now = result.at(0.3)
    np.testing.assert_allclose(now.in_axes_of("crate", now.load_force("held")), turned[6], atol=1e-6)


def test_what_is_not_there_is_named(run, tmp_path):
    result = run
    with pytest.raises(kf.ModelError, match=r"no load between frames called 'chain'.*lashing"):
        result.load_force("chain")
    with pytest.raises(kf.ModelError, match="ends 0 to 2, there is no end 3"):
        result.load_force("lashing", 3)
    with pytest.raises(kf.ModelError, match="axes of 'deck' must have shape"):
        result.in_axes_of("deck", np.zeros((2, 3)))
    result.save(tmp_path / "run.h5")
    read = kf.load_result(tmp_path / "run.h5")
    with pytest.raises(kf.ModelError, match="which a file does not contain"):
        read.load_force("lashing")
    np.testing.assert_allclose(read.in_axes_of("deck", np.ones((13, 3))), result.in_axes_of("deck", np.ones((13, 3))))


def test_rigid_contacts_tell_their_force_elsewhere():
    scene = kf.System(gravity=(0, 0, -9.81))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    ball = scene.add_point("ball", 1.0, at=(0, 0, 0.01), joint=kf.Prismatic("z"))
    scene.add_contact("drop", ball, floor, normal=kf.Rigid(0.5))
    with pytest.raises(kf.ModelError, match=r"rigid contact. Remedy: result.contact\('drop'\).force"):
        scene.simulate((0.0, 0.01)).load_force("drop")
