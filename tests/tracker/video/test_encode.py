"""Films that are written are read again: pictures, times, sizes; and nothing is left half-done."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import av
import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.errors import VideoError
from keypose.tracker.video import Video
from keypose.tracker.video.encode import MOV, FilmWriter, film_file

SIZE = (96, 64)


def picture(number: int) -> NDArray[np.uint8]:
    """Smooth colours, and a white block whose place tells the number."""
    coarse = np.random.default_rng(7).integers(30, 200, (5, 7, 3)).astype(np.uint8)
    drawn = np.asarray(cv2.resize(coarse, SIZE, interpolation=cv2.INTER_CUBIC), np.uint8)
    drawn[20:40, 4 * number : 4 * number + 8] = 255
    return drawn


def write(place: Path, pts: list[int], time_base: Fraction, **more: Fraction) -> None:
    with (
        film_file(place, overwrite=False) as beside,
        FilmWriter(beside, SIZE, time_base, Fraction(25), **more) as film,
    ):
        for number, at in enumerate(pts):
            film.add(picture(number), at)


@pytest.mark.parametrize(
    ("pts", "time_base"),
    [
        (list(range(12)), Fraction(1, 25)),
        (list(range(0, 12 * 1001, 1001)), Fraction(1, 30000)),
        ([0, 3, 4, 11, 40, 41, 43, 90, 91, 92, 100, 170], Fraction(1, 1000)),
        (list(range(12)), Fraction(1001, 24000)),
        ([0], Fraction(1, 25)),
    ],
)
def test_every_frame_comes_back_at_its_time(
    tmp_path: Path, pts: list[int], time_base: Fraction
) -> None:
    write(tmp_path / "film.mp4", pts, time_base)
    with Video.open(tmp_path / "film.mp4") as video:
        assert video.info.frame_count == len(pts)
        expected = [float(at * time_base) for at in pts]
        np.testing.assert_allclose(video.info.times_s, expected, atol=1e-9)
        for number in range(len(pts)):
            error = (video.frame(number).astype(float) - picture(number)) ** 2
            assert 10 * np.log10(255**2 / error.mean()) > 32


def test_colours_are_not_shifted(tmp_path: Path) -> None:
    colours = [(111, 180, 255), (255, 157, 108), (217, 213, 199), (244, 245, 247), (16, 17, 20)]
    with FilmWriter(tmp_path / "film.mp4", SIZE, Fraction(1, 5), Fraction(5)) as film:
        for number, colour in enumerate(colours):
            film.add(np.full((64, 96, 3), colour, np.uint8), number)
    with Video.open(tmp_path / "film.mp4") as video:
        for number, colour in enumerate(colours):
            assert np.abs(video.frame(number).mean(axis=(0, 1)) - colour).max() < 4


def test_pixels_that_are_not_square_stay_so(tmp_path: Path) -> None:
    write(tmp_path / "film.mp4", [0, 1], Fraction(1, 25), pixel_aspect=Fraction(4, 3))
    with Video.open(tmp_path / "film.mp4") as video:
        assert video.info.pixel_aspect == Fraction(4, 3)


def test_a_film_that_breaks_off_leaves_nothing(tmp_path: Path) -> None:
    def broken() -> None:
        with (
            film_file(tmp_path / "film.mp4", overwrite=False) as beside,
            FilmWriter(beside, SIZE, Fraction(1, 25), Fraction(25)) as film,
        ):
            for number in range(90):  # so many that some are on the disk
                film.add(picture(number % 20), number)
            assert list(tmp_path.iterdir()) == [beside]
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        broken()
    assert list(tmp_path.iterdir()) == []


def test_a_film_that_breaks_off_leaves_the_old_one(tmp_path: Path) -> None:
    (tmp_path / "film.mp4").write_bytes(b"old")

    def broken() -> None:
        with film_file(tmp_path / "film.mp4", overwrite=True) as beside:
            beside.write_bytes(b"new")
            raise ValueError

    with pytest.raises(ValueError):  # noqa: PT011
        broken()
    assert [(path.name, path.read_bytes()) for path in tmp_path.iterdir()] == [("film.mp4", b"old")]


def test_a_film_takes_no_other_files_name_unless_asked(tmp_path: Path) -> None:
    (tmp_path / "film.mp4").write_bytes(b"mine")
    with pytest.raises(VideoError, match="exists already"):
        write(tmp_path / "film.mp4", [0], Fraction(1, 25))
    assert (tmp_path / "film.mp4").read_bytes() == b"mine"
    assert len(list(tmp_path.iterdir())) == 1


@pytest.mark.parametrize("size", [(95, 64), (96, 63), (0, 0), (96, 8194)])
def test_sizes_that_cannot_be_coded_are_refused(tmp_path: Path, size: tuple[int, int]) -> None:
    with pytest.raises(VideoError, match="both sides must be even"):
        FilmWriter(tmp_path / "film.mp4", size, Fraction(1, 25), Fraction(25))
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("size", [(1, 64), (8193, 63)])
def test_a_film_with_alpha_is_never_told_to_be_even(tmp_path: Path, size: tuple[int, int]) -> None:
    with pytest.raises(VideoError, match="both sides must be 2 or more, and at most 8192"):
        FilmWriter(tmp_path / "a.mov", size, Fraction(1, 25), Fraction(25), kind=MOV, alpha=True)


def test_without_the_encoder_it_is_reported_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(av, "codecs_available", {"h264"})
    with pytest.raises(VideoError, match=r"pip install av\.$"):
        FilmWriter(tmp_path / "film.mp4", SIZE, Fraction(1, 25), Fraction(25))


def test_a_folder_that_is_not_there_is_reported_in_a_sentence(tmp_path: Path) -> None:
    with pytest.raises(VideoError, match=r"film\.mp4' cannot be written: .*\.$"):
        write(tmp_path / "absent" / "film.mp4", [0], Fraction(1, 25))


def test_times_that_do_not_grow_are_a_mistake_of_the_caller(tmp_path: Path) -> None:
    with FilmWriter(tmp_path / "film.mp4", SIZE, Fraction(1, 25), Fraction(25)) as film:
        film.add(picture(0), 3)
        with pytest.raises(ValueError, match="cannot follow"):
            film.add(picture(1), 3)
