"""Contact patches: points of a group, how they yield in a reduced body, and what is told where modes leave that out."""

import warnings

import numpy as np
import pytest

import kanefe as kf
from kanefe_fem import Material, box_mesh, solid_body

pytestmark = pytest.mark.fenicsx

STEEL = Material(E=2e11, nu=0.3, rho=7800.0)
MESH = box_mesh((1.0, 0.1, 0.1), (8, 2, 2))
MOST = 4


def arm(*loads, reduction=True, modes=8):
    chosen = kf.CraigBampton(modes, loads=loads) if reduction else None
    return solid_body(MESH, STEEL, interfaces={"root": "clamped"}, surfaces=["bottom"], reduction=chosen)


def member(body):
    return kf.System(gravity=(0, 0, -9.81)).add_flexible_body("arm", body)


def compliance(body):
    """Return the displacements of the patch's points under unit forces on them, m/N."""
    frames = member(body).patch("bottom", most=MOST).frames
    rows = np.vstack([frame.interface_frame.motion[:3, : body.free_count] for frame in frames])
    k = body.free_count
    stiffness = body.stiffness[:k, :k]
    return rows @ np.linalg.solve(stiffness if isinstance(stiffness, np.ndarray) else stiffness.toarray(), rows.T)


@pytest.fixture(scope="module")
def whole():
    return compliance(arm(reduction=False))


def test_a_patch_case_makes_the_points_yield_as_the_mesh(whole):
    found = compliance(arm(kf.PatchCase("bottom", most=MOST)))
    np.testing.assert_allclose(found, whole, atol=1e-9 * np.abs(whole).max())


def test_the_record_tells_the_share_that_the_modes_have(whole):
    body = arm()
    (entry,) = body.provenance["reduction"]["contact_compliance"]
    moved = np.diag(whole) > 1e-9 * whole.max()
    shares = np.diag(compliance(body))[moved] / np.diag(whole)[moved]
    assert entry["held"] == pytest.approx(shares.min(), rel=1e-6)
    assert entry["compliance"] == pytest.approx(np.diag(whole)[moved].mean(), rel=1e-6)
    assert entry["held"] < 0.5
    assert "contact compliance" in str(body.report())


def test_auto_takes_a_patch_as_a_load_case(whole):
    chosen = kf.CraigBampton("auto", up_to_frequency=200.0, loads=(kf.PatchCase("bottom", most=MOST),))
    body = solid_body(MESH, STEEL, interfaces={"root": "clamped"}, reduction=chosen)
    np.testing.assert_allclose(compliance(body), whole, atol=1e-9 * np.abs(whole).max())
    assert body.provenance["reduction"]["error_estimate"]["value"] < 1e-3


def test_a_group_and_its_place_have_the_same_points():
    held = member(arm())
    by_name, by_place = held.patch("bottom", most=6), held.patch(kf.OnPlane((0, 0, 0), (0, 0, 1)), most=6)
    assert [frame.interface_frame.name for frame in by_name.frames] == [
        frame.interface_frame.name for frame in by_place.frames
    ]
    np.testing.assert_allclose(by_name.shares, by_place.shares)


def touching(body, stiffness):
    scene = kf.System(gravity=(0, 0, -9.81))
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"), at=(0, 0, -1e-3))
    patch = scene.add_flexible_body("arm", body).patch("bottom", most=MOST)
    scene.add_contact("stop", patch, floor, normal=kf.KelvinVoigt(stiffness, damping=10.0))


def test_modes_that_leave_out_what_a_contact_yields_by_are_told():
    stiff = 1e9
    with pytest.warns(kf.AccuracyWarning, match=r"'stop'.*modes of 'arm'.*PatchCase.*most=4"):
        touching(arm(), stiff)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        touching(arm(), 1e5)  # its law yields by far more
        touching(arm(kf.PatchCase("bottom", most=MOST)), stiff)


def test_what_makes_no_patch_is_refused():
    with pytest.raises(kf.ModelError, match=r"no group of nodes called 'side'.*root, tip, right, left, bottom, top"):
        member(arm()).patch("side")
    with pytest.raises(kf.ModelError, match="no group of nodes called 'side'"):
        arm(kf.PatchCase("side"))
    with pytest.raises(kf.ModelError, match="place of a PatchCase"):
        kf.PatchCase(lambda x: x[:, 0] > 0)
    with pytest.raises(kf.ModelError, match="whole number of points"):
        kf.PatchCase("side", most=0)
