"""Input of seas and ships that is read without fault and cannot be meant."""

import math
from collections.abc import Callable
from importlib.resources import files
from pathlib import Path

import pytest

import kanefe as kf

S175 = Path(kf.__file__).parent / "checks" / "verification" / "s175.re1"


def test_a_sea_that_would_break_is_refused_with_the_limit() -> None:
    # Bretschneider's spectrum: m0 = Hs^2 / 16 and m2 = m0 sqrt(5 pi / 4) wp^2 give Tz = 0.710 Tp, and Hs by a seventh
    tz = 10.0 * (1.25 * math.pi) ** -0.25
    limit = 9.81 * tz**2 / (2.0 * math.pi) / 7.0
    kf.Sea.bretschneider(0.999 * limit, 10.0)
    with pytest.raises(kf.ModelError, match=r"steeper than the limit of breaking.*Remedy: check height"):
        kf.Sea.bretschneider(1.001 * limit, 10.0)
    with pytest.raises(kf.ModelError, match=r"Hs 100 m, Tp 1 s is steeper"):
        kf.Sea.bretschneider(100.0, 1.0)
    with pytest.raises(kf.ModelError, match=r"steeper"):
        kf.Sea.jonswap(20.0, 8.0)
    for number in range(3, 8):
        kf.Sea.state(number)


def test_options_that_a_sea_does_not_have_and_times_that_are_none_are_named() -> None:
    with pytest.raises(kf.ModelError, match=r"a sea has no colour=3. Remedy: .*duration"):
        kf.Sea.bretschneider(2.0, 10.0, colour=3)
    with pytest.raises(kf.ModelError, match=r"a sea has no colour"):
        kf.Sea.measured((0.2, 0.5, 1.0), (0.0, 1.0, 0.0), colour=3)
    assert kf.Sea.state(5, sea_state=2).sea_state == 2
    with pytest.raises(kf.ModelError, match=r"the spectrum of a sea is not 5"):
        kf.Sea(5)  # type: ignore[arg-type]
    with pytest.raises(kf.ModelError, match=r"times of an elevation must be finite"):
        kf.Sea.state(5).elevation((0.0, math.nan))


def table(tmp_path: Path, heading: str) -> Path:
    lines = (files("kanefe.environment") / "data" / "frigate.csv").read_text().splitlines()
    start = next(i for i, line in enumerate(lines) if line and not line.startswith("#")) + 1

    def swap(line: str) -> str:
        first, comma, rest = line.partition(",")
        return f"{heading if first == '180' else first}{comma}{rest}"

    path = tmp_path / "ship.csv"
    path.write_text("\n".join(lines[:start] + [swap(line) for line in lines[start:]]) + "\n")
    return path


@pytest.mark.parametrize("heading", ["400", "-361", "1e9"])
def test_headings_of_files_beyond_a_circle_are_refused(tmp_path: Path, heading: str) -> None:
    with pytest.raises(kf.KanefeError, match=r"is not a direction.*-360 to 360"):
        kf.read_rao(table(tmp_path, heading))
    kf.read_rao(table(tmp_path, "-180"))


def test_headings_of_ships_are_within_a_circle() -> None:
    rao, sea = kf.example_rao(), kf.Sea.state(5, seed=1)
    with pytest.raises(kf.ModelError, match=r"heading_deg of a ship must be -360 to 360 degrees, not 400"):
        kf.Ship(rao, sea, heading_deg=400.0)
    assert kf.Ship(rao, sea, heading_deg=-60.0).motions_std() == kf.Ship(rao, sea, heading_deg=300.0).motions_std()


@pytest.mark.parametrize("cut", range(1, 13))
def test_a_file_cut_anywhere_in_its_last_number_is_refused(tmp_path: Path, cut: int) -> None:
    text = S175.read_text().rstrip()
    path = tmp_path / "cut.re1"
    path.write_text(text[:-cut])
    with pytest.raises(Exception, match=r"Remedy: export it again") as told:
        kf.read_rao(path)
    assert isinstance(told.value, kf.KanefeError)


def test_a_whole_file_whose_last_line_has_no_end_is_read(tmp_path: Path) -> None:
    path = tmp_path / "whole.re1"
    path.write_text(S175.read_text().rstrip())
    assert (kf.read_rao(path).values == kf.read_rao(S175).values).all()
    lines = (files("kanefe.environment") / "data" / "frigate.csv").read_text().rstrip()
    csv = tmp_path / "whole.csv"
    csv.write_text(lines)
    assert (kf.read_rao(csv).values == kf.example_rao().values).all()


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (lambda: kf.RollDamping(8.0), r"ratio of a RollDamping .* not 8\. Remedy: 0\.08 for 8 %"),
        (lambda: kf.RollDamping(0.08, frequency=0.43, ratio_of_rao=3.0), r"ratio_of_rao .*Remedy: 0\.03 for 3 %"),
        (lambda: kf.Sea.bretschneider(2.0, 10.0, spreading_deg=720.0), "do not spread by 720 degrees"),
        (lambda: kf.Sea.bretschneider(8.0, 12.0, depth=5.0), r"in water of 5 m is steeper .* break above 4\.\d+ m"),
        (lambda: kf.RayleighDamping.fit((10.0, 100.0), (2.0, 2.0)), r"above 1, .*Remedy: 0\.02 for 2 %"),
    ],
)
def test_percent_degrees_and_depths_that_cannot_be_are_refused(given: Callable[[], object], words: str) -> None:
    with pytest.raises(kf.ModelError, match=words):
        given()
    kf.RollDamping(0.3)
    kf.Sea.bretschneider(2.5, 12.0, depth=5.0, spreading_deg=60.0)
    kf.RayleighDamping.fit((10.0, 100.0), (0.3, 1.0))
