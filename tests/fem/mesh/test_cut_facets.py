"""Places whose border cuts facets: what is left out is told, on shells and solids; what is another side is not."""

import warnings

import pytest

import kanefe as kf
from kanefe.fe_model.skin import facets_at
from kanefe_fem import ShellFace, box_mesh, shell_model, surface_mesh
from kanefe_fem.materials.isotropic import Material

STEEL = Material(E=210e9, nu=0.3, rho=7850.0)
PLATE = surface_mesh(lambda s, r: (0.5 * s, 0.4 * r, 0.0 * s), (4, 4))
BOX = box_mesh((1.0, 0.1, 0.1), (10, 2, 2))


@pytest.mark.fenicsx
def test_load_on_a_part_of_a_plate():
    with pytest.warns(kf.AccuracyWarning, match=r"surface 'patch'.* 0\.0\d+ m2 .* 0\.025 m2, [3-5]\d % less"):
        model = shell_model(PLATE, STEEL, 2e-3, surfaces={"patch": kf.InBox((0.15, 0.1, -1), (0.375, 0.3, 1))})
    assert model.load_patterns["patch"].measure == pytest.approx(0.025, rel=1e-12)  # two cells of 0.125 m by 0.1 m


@pytest.mark.fenicsx
def test_cells_along_the_border_are_taken_without_a_word():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        place = kf.InBox((0.125, 0.1, -1), (0.375, 0.3, 1))
        model = shell_model(PLATE, STEEL, 2e-3, surfaces={"patch": ShellFace("bottom", place)})
    assert model.load_patterns["patch"].measure == pytest.approx(0.05, rel=1e-12)


def test_sides_of_a_solid():
    def area(place):
        return sum(len(block.nodes) for block in facets_at(BOX.nodes, BOX.cell_blocks, place, "pad")) * 0.1 * 0.05

    with (
        warnings.catch_warnings()
    ):  # the thin box holds an edge of the neighbouring sides, which do not continue the face
        warnings.simplefilter("error")
        assert area(kf.InBox((-1e-3, -1, -1), (3e-2, 1, 1))) == pytest.approx(4 * 0.1 * 0.05)
        assert area(kf.OnPlane((0, 0, 0.1), (0, 0, 1))) == pytest.approx(0.1)
    with pytest.warns(kf.AccuracyWarning, match="pad.*cuts facets"):
        area(kf.InBox((0.25, -1, 0.099), (0.65, 1, 1)))
