"""Bodies made again from their source: what changes, what stays, and what is told to be impossible."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest

import kanefe as kf
from kanefe_fem import (
    LumpedMass,
    Material,
    Mesh,
    Preload,
    Rectangle,
    attach,
    beam_body,
    beam_model,
    box_mesh,
    exact_beam,
    preloaded,
    rectangle_mesh,
    segmented,
    shell_body,
    solid_body,
    solid_model,
    straight_beam,
)
from repository import ROOT

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
MODES = kf.CraigBampton(modes=3)


def rod(elements: int = 6) -> kf.FiniteElementModel:
    return straight_beam(1.0, Rectangle(0.02, 0.03), STEEL, elements=elements)


def box() -> Mesh:
    return box_mesh((1.0, 0.1, 0.1), (3, 1, 1), "tetra")


def of_beams() -> kf.FlexibleBody:
    return beam_body(rod(), {"root": "clamped", "tip": "rigid"}, MODES)


def of_solid(**options: Any) -> kf.FlexibleBody:
    return solid_body(
        box(), STEEL, {"root": "clamped", "tip": "rigid"}, MODES, surfaces=["tip"], cache=False, **options
    )


def of_shell() -> kf.FlexibleBody:
    sheet = rectangle_mesh(1.0, 0.5, (2, 1))
    return shell_body(sheet, STEEL, {"root": "clamped"}, 0.01, MODES, cache=False)


def of_chain() -> kf.SegmentedBody:
    return segmented(rod(), {"root": "clamped", "tip": "rigid"}, segments=3)


MAKERS = [
    of_beams,
    pytest.param(of_solid, marks=pytest.mark.fenicsx),
    pytest.param(of_shell, marks=pytest.mark.fenicsx),
]


@pytest.mark.parametrize("make", MAKERS)
def test_each_change_is_that_of_the_maker(make: Any):
    body = make()
    assert all(getattr(body.rebuildable, name) for name in ("reduction", "stiffening", "mesh"))
    finer = body.rebuilt(refined=1)
    assert finer.mass == pytest.approx(body.mass, rel=1e-12)
    assert len(finer.nodes) > len(body.nodes)
    assert [frame.name for frame in finer.interfaces] == [frame.name for frame in body.interfaces]
    for one, other in zip(finer.interfaces, body.interfaces, strict=True):
        assert np.abs(one.position - other.position).max() < 1e-12
        assert one.fixed_components == other.fixed_components
    assert [pattern.name for pattern in finer.load_patterns] == [pattern.name for pattern in body.load_patterns]
    if make is not of_shell:  # whose strains are assumed, so that a finer mesh may be stiffer
        assert finer.frequencies[0] < body.frequencies[0] * (1 + 1e-9)
    more = body.rebuilt(kf.CraigBampton(modes=5))
    assert more.free_count == body.free_count + 2
    assert more.frequencies[:2] == pytest.approx(body.frequencies[:2], rel=1e-3)
    assert body.rebuilt(stiffening="inertial").provenance["stiffening"] == "inertial"
    assert body.rebuilt() is body
    assert finer.rebuilt(refined=1).rebuildable.mesh.now == body.rebuilt(refined=2).rebuildable.mesh.now


@pytest.mark.fenicsx
def test_a_rebuilt_body_is_the_one_made_so():
    """To the bit."""
    again = of_solid().rebuilt(kf.CraigBampton(modes=4), stiffening="full", order=1)
    direct = solid_body(
        box(),
        STEEL,
        {"root": "clamped", "tip": "rigid"},
        kf.CraigBampton(modes=4),
        surfaces=["tip"],
        stiffening="full",
        order=1,
    )
    assert np.array_equal(again.stiffness, direct.stiffness)
    assert np.array_equal(again.basis, direct.basis)


@pytest.mark.fenicsx
def test_rebuilt_bodies_are_in_the_cache(tmp_path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("KANEFE_CACHE", "1")
    monkeypatch.setenv("KANEFE_CACHE_DIR", str(tmp_path / "cache"))
    first = solid_body(box(), STEEL, {"root": "clamped", "tip": "rigid"}, MODES)
    keys = [first.rebuilt(refined=1).provenance["cache"] for _ in range(2)]
    assert keys[0]["key"] == keys[1]["key"] != first.provenance["cache"]["key"]
    assert keys[1]["found"]


@pytest.mark.fenicsx
def test_places_hold_the_same_facets_on_a_finer_mesh():
    """A box that holds half of the side: of smaller facets more of them would lie inside."""
    half = kf.InBox((0.3, -0.01, -0.01), (0.85, 0.11, 0.001))
    interfaces = {"root": "clamped", "under": kf.Interface(kind="average", at=half)}
    surfaces = {"below": half, "heavy": kf.LoadShape(half, over=lambda x: x[:, 0]), "end": "tip"}
    body = solid_body(box(), STEEL, interfaces, MODES, surfaces=surfaces, cache=False)
    finer = body.rebuilt(refined=1)
    for name in surfaces:
        assert finer.load_pattern(name).measure == pytest.approx(body.load_pattern(name).measure, rel=1e-12)
    assert np.abs(body.interface("under").position - finer.interface("under").position).max() < 1e-12
    again = solid_body(box_mesh((1.0, 0.1, 0.1), (6, 1, 1), "tetra"), STEEL, interfaces, MODES, cache=False)
    assert again.interface("under").position[0] > finer.interface("under").position[0] + 0.05


def test_models_remember_what_was_added_to_them():
    heavy = preloaded(
        attach(rod(), [LumpedMass("tip", mass=1.0)]),
        Preload(held={"root": ("x", "y", "z", "rx", "ry", "rz")}, forces={"tip": (1e3, 0, 0)}),
    )
    body = beam_body(heavy, {"root": "clamped"}, MODES, lines=["span"])
    finer = body.rebuilt(refined=1)
    assert finer.mass == pytest.approx(body.mass)
    direct = preloaded(
        attach(rod(12), [LumpedMass("tip", mass=1.0)]),
        Preload(held={"root": ("x", "y", "z", "rx", "ry", "rz")}, forces={"tip": (1e3, 0, 0)}),
    )
    expected = beam_body(direct, {"root": "clamped"}, MODES).frequencies
    assert finer.frequencies == pytest.approx(expected, rel=1e-9)


def test_frames_keep_sections_directions_groups_and_lines():
    nodes = [[0, 0, 0], [1, 0, 0], [1, 1, 0.3]]
    sections = [Rectangle(0.02, 0.03), Rectangle(0.01, 0.04)]
    frame = beam_model(
        nodes,
        [[0, 1], [1, 2]],
        sections,
        STEEL,
        orientation=[[0, 0, 1], [0.3, 0, 1]],
        groups={"foot": 0, "head": -1},
        lines={"upper": [1]},
    )
    body = beam_body(frame, {"foot": "clamped", "head": "rigid"}, None)
    finer = body.rebuilt(refined=2)
    assert np.array_equal(finer.nodes[:3], np.array(nodes, float))
    assert len(finer.nodes) == 3 + 2 * 3
    statics = [
        np.linalg.solve(b.stiffness[:k, :k], b.interface("head").motion[:, :k].T)
        for b in (body, finer)
        if (k := b.free_count)
    ]
    compliance = [
        b.interface("head").motion[:, : b.free_count] @ s for b, s in zip((body, finer), statics, strict=True)
    ]
    # statics under loads at nodes are exact with one element
    assert np.abs(compliance[1] - compliance[0]).max() < 1e-9 * np.abs(compliance[0]).max()
    assert finer.load_pattern("upper").measure == pytest.approx(body.load_pattern("upper").measure)


def test_exact_beams_take_more_functions():
    strip = exact_beam(
        1.0, Rectangle(0.001, 0.02), STEEL, basis={"twist": 3, "curvature_y": 4, "curvature_z": kf.BSpline(2, 3)}
    )
    finer = strip.rebuilt(refined=1)
    assert (strip.free_count, finer.free_count) == (3 + 4 + 5, 6 + 8 + 8)
    assert strip.rebuilt(9).free_count == 27
    with pytest.raises(kf.ModelError, match="stiffened by its loads as it is"):
        strip.rebuilt(stiffening="full")


def test_chains_of_segments_keep_or_change_their_number():
    chain = of_chain()
    finer = chain.rebuilt(refined=1)
    assert (len(finer.segments), len(finer.nodes)) == (3, 13)
    assert len(chain.rebuilt(segments=6).segments) == 6
    assert finer.mass == pytest.approx(chain.mass)
    assert np.abs(finer.inertia - chain.inertia).max() < 1e-4 * np.abs(chain.inertia).max()
    with pytest.raises(kf.ModelError, match="the order of this body"):
        chain.rebuilt(order=2)


class TestWhatCannotBeMadeAgain:
    def test_a_body_from_a_file_or_another_process(self, tmp_path):
        body = of_beams()
        body.save(tmp_path / "rod.npz")
        for other in (kf.FlexibleBody.load(tmp_path / "rod.npz"), pickle.loads(pickle.dumps(body))):
            assert not any(getattr(other.rebuildable, n) for n in ("reduction", "stiffening", "mesh", "order"))
            with pytest.raises(kf.ModelError, match="what it was made from is not known"):
                other.rebuilt(refined=1)

    def test_matrices_once_they_are_gone(self):
        model = kf.FiniteElementModel(
            **{
                name: getattr(rod(), name)
                for name in ("nodes", "components", "stiffness", "mass", "groups", "mass_field")
            }
        )
        body = kf.flexible_body(model, {"root": "clamped"}, reduction=MODES)
        assert body.rebuilt(kf.CraigBampton(modes=5)).free_count == 5
        assert "not what they were made from" in body.rebuildable.mesh.why_not
        assert "without a geometric stiffness" in body.rebuildable.stiffening.why_not
        del model
        assert "a variable that holds the model" in body.rebuildable.reduction.why_not

    def test_what_belongs_to_the_nodes_of_one_mesh(self):
        weighed = {"root": "clamped", "tip": kf.Interface(kind="average", weights=(1.0,))}
        assert "weight for each of its nodes" in beam_body(rod(), weighed, MODES).rebuildable.mesh.why_not
        matrix = np.zeros((42, 42))
        assert "damping is a matrix" in beam_body(rod(), {"root": "clamped"}, MODES, matrix).rebuildable.mesh.why_not

    @pytest.mark.fenicsx
    def test_a_file_that_was_changed_or_is_gone(self, tmp_path):
        path = tmp_path / "bar.msh"
        path.write_bytes((ROOT / "meshes" / "bracket.msh").read_bytes())
        body = solid_body(path, STEEL, {"foot": "clamped"}, MODES, order=1)
        finer = body.rebuilt(refined=1)  # the file has curved sides, which smaller straight ones follow better
        assert finer.mass == pytest.approx(solid_body(path, STEEL, {"foot": "clamped"}, MODES).mass, rel=1e-3)
        path.write_bytes(path.read_bytes() + b"\n")
        with pytest.raises(kf.FileError, match="not the file any more"):
            body.rebuilt(refined=1)
        path.unlink()
        assert "there is no file" in body.rebuildable.mesh.why_not

    @pytest.mark.fenicsx
    def test_a_lumped_part_on_a_node_by_its_number(self):
        model = solid_model(box(), STEEL, lumped=[LumpedMass(0, mass=0.1)])
        body = kf.flexible_body(model, {"root": "clamped"}, reduction=MODES)
        assert "node 0 by its number" in body.rebuildable.mesh.why_not
        assert body.rebuilt(kf.CraigBampton(modes=4)).free_count == 4


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"refined": -1}, "refined=-1"),
        ({"refined": True}, "refined= of rebuilt"),
        ({"reduction": "some"}, "reduction='some'"),
        ({"stiffening": "half"}, "stiffening='half'"),
        ({"order": 3}, "order=3"),
        ({"order": 1}, "one order"),
    ],
)
def test_bad_input(options: dict[str, Any], message: str):
    with pytest.raises(kf.ModelError, match=message):
        of_beams().rebuilt(**options)
