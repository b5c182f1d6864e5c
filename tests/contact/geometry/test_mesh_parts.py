"""Meshes of several parts: hollows, parts apart and touching ones pass; nested, overlapping and turned ones do not."""

import numpy as np
import pytest

import kanefe as kf
from kanefe.frames import rotation_about, rotation_matrix

TETRAHEDRON = np.array([(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)])
FACES = np.array([(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])
BOX_FACES = np.array(
    [(0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4),
     (1, 5, 7), (1, 7, 3)]
)  # fmt: skip


def box(low: tuple[float, ...], high: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
    corners = [(i, j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1)]
    return np.where(np.array(corners) == 1, high, low).astype(float), BOX_FACES


def mesh(*parts: tuple[np.ndarray, np.ndarray]) -> kf.shapes.Mesh:
    starts = np.cumsum([0] + [len(vertices) for vertices, _ in parts])
    faces = [faces + start for (_, faces), start in zip(parts, starts, strict=False)]
    return kf.shapes.Mesh(np.concatenate([vertices for vertices, _ in parts]), np.concatenate(faces))


WHOLE = (TETRAHEDRON, FACES)
SMALL = 0.1 + 0.2 * TETRAHEDRON
LONG, ACROSS = box((-2, -0.1, -0.1), (2, 0.1, 0.1)), box((-0.05, -2, -0.05), (0.05, 2, 0.05))
CUBE = box((0, 0, 0), (1, 1, 1))


@pytest.mark.parametrize(
    "parts",
    [
        (WHOLE, (SMALL, FACES[:, ::-1])),
        (WHOLE, (TETRAHEDRON + np.array((3.0, 0.0, 0.0)), FACES)),
        (WHOLE, (TETRAHEDRON + np.array((1.0, 0.0, 0.0)), FACES)),
        (CUBE, box((1, 0, 0), (2, 1, 1))),
        # what is in a hollow of another one is a part again
        (WHOLE, (SMALL, FACES[:, ::-1]), (0.12 + 0.05 * TETRAHEDRON, FACES)),
    ],
)
def test_hollows_and_parts_apart_are_taken(parts: tuple[tuple[np.ndarray, np.ndarray], ...]) -> None:
    mesh(*parts)


@pytest.mark.parametrize(
    ("parts", "said"),
    [
        ((WHOLE, (SMALL, FACES)), r"part 1 of a mesh .*is within part 0, .*for a hollow turn its triangles round"),
        ((WHOLE, (TETRAHEDRON + 0.3, FACES)), r"parts \d and \d of a mesh overlap, near"),
        ((WHOLE, (TETRAHEDRON + np.array((3.0, 0.0, 0.0)), FACES[:, ::-1])), "part 1 of a mesh .*is inside out"),
        ((WHOLE, WHOLE), "within part 1, or shares room with it"),
        ((LONG, ACROSS), r"parts \d and \d of a mesh overlap"),
        ((CUBE, box((0.5, 0, 0), (1.5, 1, 1))), "shares room"),
        ((CUBE, CUBE), "shares room"),
        (((TETRAHEDRON, FACES[:, ::-1]),), "a mesh is inside out"),
    ],
)
def test_parts_in_one_another_are_refused(parts: tuple[tuple[np.ndarray, np.ndarray], ...], said: str) -> None:
    with pytest.raises(kf.ModelError, match=said):
        mesh(*parts)


def torus(n: int, m: int, winding: int = 1) -> tuple[np.ndarray, np.ndarray]:
    u, w = np.meshgrid(np.arange(n) * 2 * np.pi / n, np.arange(m) * 2 * np.pi / m, indexing="ij")
    around = 1.0 + 0.3 * np.cos(w)
    vertices = np.stack((around * np.cos(winding * u), around * np.sin(winding * u), 0.3 * np.sin(w)), -1)
    i, j = (x.ravel() for x in np.meshgrid(range(n), range(m), indexing="ij"))
    a, b, c, d = i * m + j, (i + 1) % n * m + j, (i + 1) % n * m + (j + 1) % m, i * m + (j + 1) % m
    return vertices.reshape(-1, 3), np.concatenate((np.column_stack((a, b, c)), np.column_stack((a, c, d))))


def test_one_part_that_goes_through_itself_is_told() -> None:
    mesh(torus(40, 16))
    vertices, faces = torus(40, 16)
    pushed = vertices.copy()
    pushed[0] *= 1.2
    mesh((pushed, faces))
    pushed[0, :] = (-1.7, 0.0, 0.0)  # through the other side
    with pytest.warns(kf.AccuracyWarning, match="a mesh goes through itself, near"):
        mesh((pushed, faces))


def test_random_pairs_of_boxes_are_refused_where_they_meet_and_taken_where_not() -> None:
    rng = np.random.default_rng(3)
    for _ in range(40):
        size, turn = (
            rng.uniform(0.1, 2.0, (2, 3)),
            rotation_matrix(rotation_about(rng.normal(size=3), rng.uniform(0, 3))),
        )
        shift = rng.uniform(-1.5, 1.5, 3)
        one = box(tuple(-0.5 * size[0]), tuple(0.5 * size[0]))
        other = box(tuple(-0.5 * size[1]), tuple(0.5 * size[1]))
        # of the other: points of its inside, in the axes of the first
        inside = rng.uniform(-0.5, 0.5, (4000, 3)) * size[1] @ turn.T + shift
        share = np.mean(np.all(np.abs(inside) < 0.5 * size[0], axis=1))
        if 0.0 < share < 0.01:
            continue  # too little to be sure of by points
        parts = one, (other[0] @ turn.T + shift, other[1])
        if share:
            with pytest.raises(kf.ModelError, match=r"overlap|within"):
                mesh(*parts)
        elif np.linalg.norm(shift) > 0.5 * (np.linalg.norm(size[0]) + np.linalg.norm(size[1])):
            mesh(*parts)


def test_a_fine_sampling_is_refused_before_its_points_are_made() -> None:
    for shape in (kf.shapes.Box((1.0, 1.0, 1.0)), kf.shapes.Cylinder(1.0, 1.0), kf.shapes.Torus(1.0, 0.1)):
        with pytest.raises(kf.ModelError, match=r"points would represent a .*Remedy: a larger spacing"):
            shape.sampled(1e-9)


def test_poissons_ratio_is_within_its_bounds() -> None:
    for nu in (1.0, -1.0, 0.6, 2.0):
        with pytest.raises(kf.ModelError, match=r"nu of a ball, Poisson's ratio, must be above -1 and at most 0.5"):
            kf.Hertz.of_sphere(0.1, 210e9, nu)
    assert kf.Hertz.of_sphere(0.1, 210e9, 0.5).stiffness > 0.0


def test_nothing_in_the_place_of_surfaces_is_named() -> None:
    scene = kf.System()
    floor = scene.add_surface("floor", scene.ground, kf.shapes.Plane("z"))
    for wrong in (None, 3.0, "floor"):
        with pytest.raises(kf.ModelError, match="contact 'c' needs something that touches"):
            scene.add_contact("c", wrong, floor, normal=kf.HuntCrossley(1e5))  # type: ignore[arg-type]
        with pytest.raises(kf.ModelError, match="add_contacts needs a list of surfaces"):
            scene.add_contacts(wrong, normal=kf.HuntCrossley(1e5))  # type: ignore[arg-type]
    with pytest.raises(kf.ModelError, match="a screened run needs a scene, not None"):
        kf.screen(None, 1.0)  # type: ignore[arg-type]
