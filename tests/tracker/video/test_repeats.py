"""Repeated frames of a film are known as such, and no others are."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
import pytest

from keypose.tracker.session.references import Repeats
from keypose.tracker.video import Video
from keypose.tracker.video.repeats import repeats_of
from tests.tracker.video_cases import Picture, write_clip, write_image

SAMPLES = sorted((Path(__file__).parents[3] / "sample_videos").glob("*/*.mp4"))
PERIOD = 6


def found_in(path: Path) -> Repeats:
    with Video.open(path) as video:
        deque(video.examine(0, video.info.frame_count - 1), maxlen=0)
        return video.repeats()


def with_copies(pictures: Sequence[Picture], even: bool) -> tuple[list[Picture], list[int]]:
    """Copies put after every fifth picture, or in the place of every sixth; and their numbers."""
    if even:
        groups = [pictures[n : n + PERIOD - 1] for n in range(0, len(pictures), PERIOD - 1)]
        shown = [each for group in groups for each in (*group, group[-1])]
    else:
        shown = [pictures[n - (n % PERIOD == PERIOD - 1)] for n in range(len(pictures))]
    return shown, [*range(PERIOD - 1, len(shown), PERIOD)]


def lettered(width: int, height: int, ground: int) -> Picture:
    """Words on a dark ground."""
    picture = np.full((height, width, 3), ground, np.uint8)
    cv2.putText(picture, "A WALK", (80, 100), cv2.FONT_HERSHEY_SIMPLEX, 1.0, (80, 80, 80), 2)
    return picture


@pytest.mark.parametrize("path", SAMPLES, ids=lambda path: path.stem)
def test_films_without_copies_have_none(path: Path) -> None:
    assert found_in(path) == Repeats()


STILL = {
    "a gradient": np.tile(np.linspace(0, 255, 640).astype(np.uint8)[:, None], (352, 1, 3)),
    "a title card": lettered(640, 352, ground=0),
    "a dark room": lettered(640, 352, ground=12),
}


@pytest.mark.parametrize("crf", ["23", "35"])
@pytest.mark.parametrize("shown", STILL)
def test_what_compression_does_where_nothing_moves_is_no_copy(
    tmp_path: Path, shown: str, crf: str
) -> None:
    rng = np.random.default_rng(0)
    pictures = [
        np.clip(STILL[shown] + rng.normal(0, 0.7, STILL[shown].shape), 0, 255).astype(np.uint8)
        for _ in range(24)
    ]
    options = {"g": "6", "crf": crf, "threads": "1"}
    assert found_in(write_clip(tmp_path / "film.mp4", pictures, options=options)) == Repeats()


@pytest.mark.parametrize("even", [True, False], ids=["put between", "instead of a frame"])
@pytest.mark.parametrize("name", ["person", "balance"])
def test_copies_of_an_encoded_film_are_found(tmp_path: Path, name: str, even: bool) -> None:
    (path,) = (path for path in SAMPLES if path.stem == name)
    with Video.open(path) as video:
        pictures = [p for _, p in video.frames(0, 60) if p is not None]
    shown, copies = with_copies(pictures, even)
    film = write_clip(tmp_path / "film.mp4", shown, options={"crf": "28"})
    found = found_in(film)
    assert {*found.frames} <= {*copies}
    assert len(found.frames) >= len(copies) - 2  # the last has nothing after it
    assert found.even is even


def test_copies_among_images_are_found(tmp_path: Path) -> None:
    generator = np.random.default_rng(0)
    noise = [generator.integers(0, 255, (48, 64, 3)).astype(np.uint8) for _ in range(30)]
    shown, copies = with_copies(noise, even=True)
    for number, picture in enumerate(shown):
        write_image(tmp_path / f"{number:03}.png", picture)
    assert found_in(tmp_path).frames == tuple(copies[:-1])


def test_a_body_that_comes_to_rest_is_not_repeated() -> None:
    swinging = np.abs(np.sin(2 * np.pi * np.arange(1, 90) / 30))  # without any noise
    swinging[np.isclose(swinging, 0, atol=1e-9)] = 0.0
    assert repeats_of(dict(enumerate(swinging, 1)), 90) == Repeats()
    resting = np.r_[np.ones(20), np.zeros(8), np.ones(20)] * 2.0
    assert repeats_of(dict(enumerate(np.tile(resting, 3), 1)), 145) == Repeats()


@pytest.mark.parametrize("shown", [2, 3, 4])
def test_every_frame_may_be_shown_several_times(shown: int) -> None:
    changes = {n: 1.0 if n % shown == 0 else 0.0 for n in range(1, 120)}
    found = repeats_of(changes, 120)
    assert {*found.frames} == {n for n in changes if n % shown and shown < n < 120 - shown}
    assert found.even
