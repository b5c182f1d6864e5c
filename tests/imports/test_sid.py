"""Standard Input Data: what is written is read back as the same equations, and what is wrong is refused."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import kanefe as kf
from kanefe.bodies.mass_moments import MassMoments
from kanefe.errors import FileError, ModelError
from kanefe.fe_model.model import rigid_motion
from kanefe.frames import rotation_matrix, skew
from kanefe.imports.sid import read_sid, write_sid
from kanefe.imports.sid_file import SidWarning, parse_sid
from kanefe.imports.sid_terms import terms_of_moments
from scenes import lattice_model

MODEL = lattice_model(3)
HELD = kf.flexible_body(
    MODEL, {"root": "clamped", "tip": "rigid"}, reduction=kf.CraigBampton(modes=3), damping=kf.ModalDamping(0.02)
)
FLOATING = kf.flexible_body(MODEL, {"tip": "rigid"}, reduction=kf.CraigBampton(modes=2))
NAMES = {"root": "1", "tip": "2"}


def stiffened(body: kf.FlexibleBody) -> kf.FlexibleBody:
    """Return the body with some second-order displacement, as a stiffening gives it."""
    rng = np.random.default_rng(5)
    K = body.count

    def symmetric(*shape: int) -> np.ndarray:
        x = 0.1 * rng.standard_normal((*shape, K, K))
        return x + np.swapaxes(x, -1, -2)

    moments = replace(body.moments, quadratic_first=symmetric(3), quadratic_second=symmetric(3, 3))
    frames = tuple(replace(f, quadratic=symmetric(6)) if f.name == "tip" else f for f in body.interfaces)
    return replace(body, moments=moments, interfaces=frames)


def round_trip(body: kf.FlexibleBody, tmp_path: Path, edit: Callable[[str], str] = str) -> kf.FlexibleBody:
    path = tmp_path / "body.SID_FEM"
    names = write_sid(body, path)
    path.write_text(edit(path.read_text()))
    return read_sid(path, names=names)


def states(k: int) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    rng = np.random.default_rng(1)
    return [(0.1 * rng.standard_normal(k), rng.standard_normal(k), rng.standard_normal(3)) for _ in range(3)]


def assert_same_equations(ours: kf.FlexibleBody, body: kf.FlexibleBody, tolerance: float = 1e-11) -> None:
    k = body.free_count
    assert ours.free_count == k
    for eta, deta, w in states(k):
        for found, expected in zip(
            ours.moments.leading(k).terms(eta, deta, w), body.moments.leading(k).terms(eta, deta, w), strict=True
        ):
            # numbers are written with 17 digits; the Gram matrix loses two of them
            assert found == pytest.approx(expected, rel=tolerance, abs=tolerance * abs(expected).max())
    assert ours.stiffness[:k, :k] == pytest.approx(body.stiffness[:k, :k], abs=1e-13 * abs(body.stiffness).max())
    assert ours.damping == pytest.approx(body.damping, abs=1e-13)
    for frame in body.interfaces:
        read = ours.interface(frame.name)
        assert read.position == pytest.approx(frame.position, abs=1e-15)
        for found, expected in zip(read.moved(states(k)[0][0]), frame.moved(states(k)[0][0]), strict=True):
            assert found == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("body", [HELD, FLOATING, stiffened(HELD)], ids=["held", "floating", "stiffened"])
def test_a_round_trip_gives_the_same_equations(body: kf.FlexibleBody, tmp_path: Path) -> None:
    ours = round_trip(body, tmp_path)
    assert_same_equations(ours, body)
    assert ours.is_floating == body.is_floating
    assert (ours.mass, *ours.center_of_mass) == pytest.approx((body.mass, *body.center_of_mass), rel=1e-12)
    assert ours.inertia == pytest.approx(body.inertia, abs=1e-12)
    assert ours.frequencies == pytest.approx(body.frequencies, rel=1e-10)


def test_terms_are_the_integrals_of_the_standard() -> None:
    # oracle: the definitions with tilde matrices over mass points, of Wallrapp 1994, term by term
    rng = np.random.default_rng(0)
    points, masses, k = rng.standard_normal((7, 3)), rng.uniform(0.5, 1.5, 7), 2
    shapes = rng.standard_normal((7, 3, k))
    terms = terms_of_moments(MassMoments.of_points(points, np.diag(masses), shapes.reshape(21, k)))

    def total(term: Callable[[np.ndarray, np.ndarray], np.ndarray]) -> np.ndarray:
        return sum(m * term(x, phi) for m, x, phi in zip(masses, points, shapes, strict=True))

    def tilde(phi: np.ndarray, mode: int) -> np.ndarray:
        return skew(phi[:, mode])

    exact = {"rel": 1e-12, "abs": 1e-12}
    assert terms["J"].m0 == pytest.approx(total(lambda x, phi: -skew(x) @ skew(x)), **exact)
    assert terms["Cr"].m0 == pytest.approx(total(lambda x, phi: (skew(x) @ phi).T), **exact)
    w = np.array((0.3, -0.7, 1.1))
    W, W2 = skew(w), np.array((w[0] ** 2, w[1] ** 2, w[2] ** 2, w[0] * w[1], w[1] * w[2], w[0] * w[2]))
    assert terms["Oe"].m0 @ W2 == pytest.approx(total(lambda x, phi: phi.T @ W @ W @ x), **exact)
    for j in range(k):
        both = total(lambda x, phi, j=j: -skew(x) @ tilde(phi, j) - tilde(phi, j) @ skew(x))
        assert terms["J"].m1[:, :, j] == pytest.approx(both, **exact)
        assert terms["Cr"].m1[:, :, j] == pytest.approx(total(lambda x, phi, j=j: (tilde(phi, j) @ phi).T), **exact)
        moved = total(lambda x, phi, j=j: phi.T @ W @ W @ phi[:, j])
        assert terms["Oe"].m1[:, :, j] @ W2 == pytest.approx(moved, **exact)
        block = slice(3 * j, 3 * j + 3)
        assert terms["Gr"].m0[:, block] == pytest.approx(
            total(lambda x, phi, j=j: -2 * skew(x) @ tilde(phi, j)), **exact
        )
        assert terms["Ge"].m0[:, block] == pytest.approx(total(lambda x, phi, j=j: -2 * phi.T @ tilde(phi, j)), **exact)
        for i in range(k):
            second = total(lambda x, phi, i=i, j=j: -2 * tilde(phi, i) @ tilde(phi, j))
            assert terms["Gr"].m1[:, block, i] == pytest.approx(second, **exact)


def test_the_body_moves_as_the_one_that_was_written(tmp_path: Path) -> None:
    paths = []
    for body in (HELD, round_trip(HELD, tmp_path)):
        scene = kf.System(gravity=(0, 0, -9.81))
        hub = scene.add_rigid_body("hub", mass=4.0, inertia=0.05, joint=kf.Revolute("y", speed=3.0))
        arm = scene.add_flexible_body("arm", body, parent=hub, at=(0.1, 0, 0))
        scene.add_rigid_body("tip", mass=0.2, inertia=1e-3, parent=arm.interface("tip"))
        result = scene.simulate((0.0, 0.02), method="dop853", rtol=1e-9, atol=1e-11)
        paths.append((result.position("tip"), result.coupling_force("arm", "root")))
    assert paths[1][0] == pytest.approx(paths[0][0], abs=1e-8)
    assert paths[1][1] == pytest.approx(paths[0][1], abs=1e-5 * abs(paths[0][1]).max())


def test_the_frame_that_holds_the_body_moves_it_rigidly(tmp_path: Path) -> None:
    # rows of the fixed columns give the forces there: their inertia is that of the rigid body about the frame
    body = round_trip(HELD, tmp_path)
    k, root = body.free_count, body.interface("root")
    assert root.fixed_columns == tuple(range(k, k + 6))
    motion = rigid_motion(MODEL.nodes, root.position)
    held = MODEL.mass @ motion
    assert body.moments.elastic_mass[k:, k:] == pytest.approx(motion.T @ held, abs=1e-12)
    # the modes of the mesh, which the file does not know, couple with it as they did
    assert body.moments.elastic_mass[k:, :k] == pytest.approx(held.T @ HELD.basis[:, :k], abs=1e-12)
    assert body.stiffness[k:] == pytest.approx(0.0, abs=0.0)


def test_turned_frames_and_nodes(tmp_path: Path) -> None:
    axes = rotation_matrix(np.array((0.8, 0.6, 0.0, 0.0)))
    turned = replace(HELD, interfaces=tuple(replace(f, axes=axes) for f in HELD.interfaces))
    path = tmp_path / "b.sid"
    names = write_sid(turned, path, nodes=[4])
    assert names == {"root": "1", "tip": "2", "node 4": "3"}
    body = read_sid(path, names=names)
    assert body.interface("tip").axes == pytest.approx(axes, abs=1e-15)
    assert body.interface("node 4").position == pytest.approx(MODEL.nodes[4])
    root = body.interface("root")
    assert root.motion[:, list(root.fixed_columns)] == pytest.approx(np.kron(np.eye(2), axes), abs=1e-15)


def columns_before_modes(text: str) -> str:
    return re.sub(r"m1\((\d+), (\d+), (\d+)\)", r"m1(\1, \3, \2)", text)


def fortran(text: str) -> str:
    return re.sub(r"e([+-]\d+)", r"D\1", text)


def swapped_products(text: str) -> str:
    """Return the file of a writer that lists the products of Oe as xy, xz, yz."""
    head, oe, tail = re.split(r"(?s)(\n  Oe\n.*?end Oe)", text)
    swap = {"5": "6", "6": "5"}
    oe = re.sub(r"(m\d\([\d, ]*?)(\d)\)", lambda m: f"{m[1]}{swap.get(m[2], m[2])})", oe)
    return head + oe + tail


def moments_as_six_numbers(text: str) -> str:
    """Return the file of a writer whose J is xx, yy, zz, xy, xz, yz, as in files of EMBS_ModelicaLib."""
    head, J, tail = re.split(r"(?s)(\n  J\n.*?end J)", text)
    J = J.replace("nrow = 3", "nrow = 6").replace("ncol = 3", "ncol = 1").replace("structure = 2", "structure = 3")
    places = {"1, 1": 1, "2, 2": 2, "3, 3": 3, "2, 1": 4, "3, 1": 5, "3, 2": 6}
    J = re.sub(r"m0\((\d, \d)\)", lambda m: f"m0({places[m[1]]}, 1)", J)
    J = re.sub(r"m1\((\d), (\d+), (\d)\)", lambda m: f"m1({places[f'{m[1]}, {m[3]}']}, {m[2]}, 1)", J)
    return head + J + tail


@pytest.mark.parametrize(
    "edit", [columns_before_modes, fortran, swapped_products, moments_as_six_numbers], ids=lambda f: f.__name__
)
def test_dialects(edit: Callable[[str], str], tmp_path: Path) -> None:
    assert_same_equations(round_trip(HELD, tmp_path, edit), HELD)


def test_refmod_may_list_more_coordinates_than_the_terms_have(tmp_path: Path) -> None:
    with pytest.warns(SidWarning, match="lists nelastq = 18 coordinates, the terms have 2"):
        ours = round_trip(FLOATING, tmp_path, lambda text: re.sub(r"nelastq = \d+", "nelastq = 18", text))
    assert_same_equations(ours, FLOATING)
    with pytest.raises(FileError, match=r"1 coordinates in refmod .* an Me of 2 rows"):
        round_trip(FLOATING, tmp_path, lambda text: re.sub(r"\n.*ielastq.*", "", re.sub(r"q = 2\n", "q = 1\n", text)))


def without_gr1(text: str) -> str:
    head, gr, tail = re.split(r"(?s)(\n  Gr\n.*?end Gr)", text)
    return head + re.sub(r"\n\s*m1\(.*", "", gr).replace("order = 1", "order = 0") + tail


def test_an_unstiffened_body_needs_no_gr_of_order_1(tmp_path: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert_same_equations(round_trip(HELD, tmp_path, without_gr1), HELD)


def test_a_stiffened_body_without_gr_of_order_1_says_what_is_approximate(tmp_path: Path) -> None:
    body = stiffened(HELD)
    with pytest.warns(SidWarning, match="terms of second order in J and Gr are approximate"):
        ours = round_trip(body, tmp_path, without_gr1)
    k = body.free_count
    for eta, deta, w in states(k):
        mass, bias = ours.moments.leading(k).terms(eta, deta, w)
        expected_mass, expected_bias = body.moments.leading(k).terms(eta, deta, w)
        assert bias[6:] == pytest.approx(expected_bias[6:], rel=1e-11)  # Oe and Ge are kept whole
        assert mass[:6, 6:] == pytest.approx(expected_mass[:6, 6:], rel=1e-11)
        assert mass[3:6, 3:6] == pytest.approx(expected_mass[3:6, 3:6], abs=1e-1)


def test_a_body_in_mean_axes_floats_and_another_gets_a_reference(tmp_path: Path) -> None:
    path = tmp_path / "b.sid"
    write_sid(HELD, path)
    text = re.sub(r"(?s)   new node = 1\n.*?end node\n", "", path.read_text())
    path.write_text(text)
    body = read_sid(path, names={"tip": "2"})
    assert not body.is_floating
    assert body.interface("reference").fixed_components == tuple(range(6))
    assert read_sid(path, fixed=False).is_floating
    with pytest.raises(ModelError, match=r"has modes that move its node frame '2'\. Remedy: fixed= one of .*\(none\)"):
        read_sid(path, fixed="2")


def scaled_term(name: str, factor: float) -> Callable[[str], str]:
    def edit(text: str) -> str:
        head, term, tail = re.split(rf"(?s)(\n  {name}\n.*?end {name})", text)
        return head + re.sub(r"= (-?\d\.\S+)", lambda m: f"= {factor * float(m[1]):.17e}", term) + tail

    return edit


@pytest.mark.parametrize(
    ("edit", "error", "message"),
    [
        (lambda t: t[: len(t) // 2], FileError, "truncated"),
        (lambda t: t[: t.index("end modal")], FileError, "truncated or not a SID file"),
        (lambda t: "", FileError, "is empty"),
        (lambda t: re.sub(r"(?s)  Oe\n.*?end Oe\n", "", t), FileError, "lacks Oe"),
        (lambda t: t.replace("nelastq", "elastq"), FileError, "lacks mass or nelastq|damaged line"),
        (lambda t: t.replace("m0(1, 1) = ", "m0(1, 1) = x", 1), FileError, r"damaged line \d+"),
        (lambda t: t.replace("new node = 2", "new node = 1"), FileError, "two nodes '1'"),
        (lambda t: re.sub(r"m0\(3, 1\)", "m0(9, 1)", t), FileError, r"outside its 3 x \d matrix"),
        (scaled_term("Ct", 2.0), ModelError, "mdCM of order 1 and Ct of order 0 .* contradict"),
        (scaled_term("Oe", 2.0), ModelError, "Oe of order 0 and J of order 1 .* contradict"),
        (scaled_term("Ge", -1.0), ModelError, "Ge and Gr of order 1 .* contradict"),
        (scaled_term("Ke", -1.0), ModelError, "Ke .* negative eigenvalue"),
        (scaled_term("J", 1e-4), ModelError, "contradict|not those of a body"),
        (lambda t: re.sub(r"mass = \S+", "mass = -1.0", t), ModelError, "mass in .* is -1 kg"),
    ],
)
def test_bad_files_are_named(edit: Callable[[str], str], error: type[Exception], message: str, tmp_path: Path) -> None:
    with pytest.raises(error, match=f"(?s){message}.*"):
        round_trip(HELD, tmp_path, edit)


def test_bad_arguments_are_named(tmp_path: Path) -> None:
    path = tmp_path / "b.sid"
    write_sid(HELD, path)
    with pytest.raises(ModelError, match=r"has no node frame 7; it has 1, 2"):
        read_sid(path, names={"tip": "7"})
    with pytest.raises(ModelError, match="has no node frame 'tip'"):
        read_sid(path, fixed="tip")
    with pytest.raises(ModelError, match="it should be 5 kg"):
        read_sid(path, expected_mass=5.0)
    with pytest.raises(FileError, match="there is no file"):
        read_sid(tmp_path / "none.sid")
    nodal = kf.flexible_body(replace(MODEL, mass_field=None), {"root": "clamped"})
    with pytest.raises(ModelError, match="nodal approximation"):
        write_sid(nodal, path)
    assert len(parse_sid(path).modes) == HELD.free_count
