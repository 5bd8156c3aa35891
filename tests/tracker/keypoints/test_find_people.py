"""Who is in a film is found before anybody has said it, with a box to draft each from."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from keypose import sample_videos
from keypose.tracker.keypoints.find_people import (
    FAR,
    FoundPerson,
    PeopleFinder,
    PeopleInFilm,
    people_in_film,
    searched_squares,
    spread_frames,
)
from keypose.tracker.video import Video
from tests.tracker.keypoints import keypoint_cases as cases

SAMPLES = Path(sample_videos.__file__).parent


@pytest.fixture(scope="module")
def finder() -> PeopleFinder:
    return PeopleFinder.open()


def picture(sample: str, frame: int) -> np.ndarray:
    with Video.open(SAMPLES / sample / f"{sample}.mp4") as video:
        return video.frame(frame)


def test_the_one_man_of_a_film_is_found_with_all_his_joints(finder: PeopleFinder) -> None:
    (man,) = finder(picture("balance", 0))
    left, top, right, bottom = man.box
    for u, v in cases.marks()[0].values():
        assert left <= u <= right
        assert top <= v <= bottom
    assert man.height_px < 1.5 * np.ptp([uv[1] for uv in cases.marks()[0].values()])


def test_two_people_are_two(finder: PeopleFinder) -> None:
    on_roof, walker = sorted(finder(picture("walk", 25)), key=lambda person: person.box[0])
    assert on_roof.box[3] < 400 < walker.box[3]
    assert on_roof.box[2] < walker.box[0]


def test_where_nobody_is_nobody_is_found(finder: PeopleFinder) -> None:
    assert finder(picture("box", 20)) == ()
    assert finder(picture("box", 20), FAR) == ()


def test_somebody_far_away_is_found_among_smaller_squares(finder: PeopleFinder) -> None:
    near = picture("balance", 0)
    small = cv2.resize(near, (136, 240), interpolation=cv2.INTER_AREA)
    wide = np.full((1080, 1920, 3), 128, np.uint8)
    wide[500:740, 900:1036] = small
    (man,) = finder(wide, FAR)
    marked = np.array(list(cases.marks()[0].values())) * 240 / near.shape[0] + (900, 500)
    assert np.all(marked.min(axis=0) >= man.box[:2])
    assert np.all(marked.max(axis=0) <= man.box[2:])


def person(left: float, height: float, confidence: float = 0.8) -> FoundPerson:
    return FoundPerson((left, 100.0, left + 50.0, 100.0 + height), confidence)


TALL = person(10, 200)
OTHER = person(300, 150, 0.6)
CHILD = person(200, 80)
FILMS = {
    "one, where they are surest": (
        {3: [person(10, 200, 0.5)], 9: [TALL]}, PeopleInFilm(9, (TALL,), {})
    ),
    "two, in a frame that shows both": (
        {3: [TALL], 9: [OTHER, TALL]}, PeopleInFilm(9, (TALL, OTHER), {})
    ),
    "one, and somebody much smaller": (
        {3: [TALL, CHILD]}, PeopleInFilm(3, (TALL,), {3: (CHILD,)})
    ),
    "one, and a passer-by who is surer where they are alone": (
        {3: [TALL], 9: [person(200, 80, 0.95)]},
        PeopleInFilm(3, (TALL,), {9: (person(200, 80, 0.95),)}),
    ),
    "nobody": ({3: [], 9: []}, None),
}  # fmt: skip


@pytest.mark.parametrize("film", FILMS)
def test_who_may_be_meant(film: str) -> None:
    seen, expected = FILMS[film]
    assert people_in_film(seen) == expected


@pytest.mark.parametrize("frames", [(0, 0), (0, 1), (10, 13), (0, 99)])
def test_frames_to_look_at_lie_within_those_asked_for(frames: tuple[int, int]) -> None:
    spread = spread_frames(*frames)
    assert spread
    assert frames[0] <= spread[0] <= spread[-1] <= frames[1]
    assert len(set(spread)) == len(spread)


@pytest.mark.parametrize(("width", "height"), [(1920, 1080), (17, 31), (544, 960)])
def test_squares_cover_the_whole_picture(width: int, height: int) -> None:
    covered = np.zeros((height, width), bool)
    for square in searched_squares(width, height, FAR):
        x, y = np.arange(width), np.arange(height)
        inside_x, inside_y = (
            abs(a - b) <= square.side / 2 for a, b in ((x, square.x), (y, square.y))
        )
        covered |= inside_y[:, None] & inside_x
    assert covered.all()
