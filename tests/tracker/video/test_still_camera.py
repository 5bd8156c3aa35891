"""A camera that stands still is told from its frames; one that moves is not called still."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.video import Video
from keypose.tracker.video.still_camera import SAMPLES, sampled_frames, still_camera, still_pictures
from tests.tracker.tracking_cases import MemoryVideo

ROOT = Path(__file__).parents[3]
SAMPLE_VIDEOS = ROOT / "sample_videos"
DATA = ROOT.parent / "shared" / "data"
FRAMES = 61
"""Of the sample film whose frames are moved about here."""

Grey = NDArray[np.uint8]
Warp = Callable[[int], NDArray[np.float64]]


@cache
def filmed() -> tuple[Grey, ...]:
    """Every frame of a real film that a standing camera took, grey, a quarter of its pixels."""
    with Video.open(SAMPLE_VIDEOS / "balance" / "balance.mp4") as video:
        frames = [rgb for _, rgb in video.frames(0, FRAMES) if rgb is not None]
    return tuple(cv2.pyrDown(cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY)) for rgb in frames)  # type: ignore[misc]


def moved(warp: Warp) -> list[Grey]:
    """The sampled frames as a camera sees them that moves: warp(frame) maps pixels (2, 3)."""
    size = filmed()[0].shape[::-1]
    return [
        np.asarray(
            cv2.warpAffine(
                filmed()[frame], warp(frame), size,
                flags=cv2.INTER_CUBIC, borderMode=cv2.BORDER_REFLECT,
            ),
            dtype=np.uint8,
        )
        for frame in sampled_frames(FRAMES)
    ]  # fmt: skip


def shifted(u: float, v: float) -> NDArray[np.float64]:
    return np.array([[1.0, 0.0, u], [0.0, 1.0, v]])


def scaled(by: float) -> NDArray[np.float64]:
    height, width = filmed()[0].shape
    return cv2.getRotationMatrix2D((width / 2, height / 2), 0.0, by)  # type: ignore[return-value]


def rolled(deg: float) -> NDArray[np.float64]:
    height, width = filmed()[0].shape
    return cv2.getRotationMatrix2D((width / 2, height / 2), deg, 1.0)  # type: ignore[return-value]


def shaken(frame: int) -> NDArray[np.float64]:
    return shifted(*np.random.default_rng(frame).normal(0.0, 1.0, 2))


MOVING: dict[str, Warp] = {
    "a pan of a pixel a frame": lambda frame: shifted(1.0 * frame, 0.0),
    "a slow drift of half a pixel in ten frames": lambda frame: shifted(0.05 * frame, 0.0),
    "a slow drift upward": lambda frame: shifted(0.0, -0.05 * frame),
    "a zoom of a tenth": lambda frame: scaled(1.0 + 0.1 * frame / FRAMES),
    "a slow zoom of a fiftieth": lambda frame: scaled(1.0 + 0.02 * frame / FRAMES),
    "shaking by a pixel": shaken,
    "a regular shake": lambda frame: shifted(1.5 * np.sin(2 * np.pi * frame / 7.5), 0.0),
    "a roll of one degree": lambda frame: rolled(1.0 * frame / FRAMES),
    "a jolt near the end": lambda frame: shifted(3.0 if frame > 55 else 0.0, 0.0),
}


@pytest.mark.parametrize("name", MOVING)
def test_a_real_film_is_not_called_still_under(name: str) -> None:
    found = still_pictures(moved(MOVING[name]))
    assert not found.still, found


def test_the_same_film_left_where_it_is_is_still() -> None:
    found = still_pictures(moved(lambda frame: shifted(0.0, 0.0)))
    assert found.still, found
    assert found.share > 0.8
    assert found.cells >= 10


def weakened(toward: int, weight: Callable[[int], float]) -> Callable[[Grey, int], Grey]:
    """Fades: the picture's own weight at each frame, the rest being one grey level."""
    return lambda grey, frame: np.asarray(
        np.rint(toward + (grey.astype(float) - toward) * np.clip(weight(frame), 0, 1)), np.uint8
    )


FADES: dict[str, Callable[[Grey, int], Grey]] = {
    "five black frames at first": weakened(0, lambda frame: float(frame >= 5)),
    "a short fade-in": weakened(0, lambda frame: frame / 20),
    "a fade-in all through": weakened(0, lambda frame: frame / (FRAMES - 1)),
    "a fade-out": weakened(0, lambda frame: (FRAMES - 1 - frame) / 30),
    "a fade-in from white": weakened(255, lambda frame: frame / 20),
    "a dip to black": weakened(0, lambda frame: abs(frame - 30) / 12),
    "flat grey in the middle": weakened(128, lambda frame: float(not 25 <= frame < 45)),
    "black at the end": weakened(0, lambda frame: float(frame < 45)),
}


@pytest.mark.parametrize("name", FADES)
def test_a_camera_that_stands_still_is_still_though_the_film_fades(name: str) -> None:
    fade, frames = FADES[name], sampled_frames(FRAMES)
    standing = [fade(filmed()[frame], frame) for frame in frames]
    assert still_pictures(standing).still, still_pictures(standing)
    for moves in ("a slow drift upward", "a slow zoom of a fiftieth", "a regular shake"):
        pictures = zip(moved(MOVING[moves]), frames, strict=True)
        assert not still_pictures([fade(p, frame) for p, frame in pictures]).still, moves


def test_a_title_card_before_the_film_does_not_make_its_camera_move() -> None:
    card = np.zeros_like(filmed()[0])
    cv2.putText(card, "A FILM", (40, 200), cv2.FONT_HERSHEY_SIMPLEX, 1.5, (255,), 3)
    pictures = [card if frame < 20 else filmed()[frame] for frame in sampled_frames(FRAMES)]
    assert still_pictures(pictures).still


def test_a_camera_that_pans_to_the_sky_does_not_stand_still() -> None:
    height, width = filmed()[0].shape
    sky = np.tile(np.linspace(215, 180, height)[:, None], (1, width))
    shown = [filmed()[frame] for frame in sampled_frames(FRAMES)]
    assert not still_pictures([*shown[:6], *(noisy(sky, seed) for seed in range(3))]).still


def test_a_camera_that_trembles_less_than_a_tenth_of_a_pixel_is_still() -> None:
    assert still_pictures(moved(lambda frame: shifted(0.08 * (-1) ** frame, 0.0))).still


@pytest.mark.parametrize("sample", ["balance/balance.mp4", "person/person.mp4", "box/box.mp4"])
def test_the_sample_films_are_still(sample: str) -> None:
    with Video.open(SAMPLE_VIDEOS / sample) as video:
        assert still_camera(video).still


REAL = {"walk": True, "person": True, "arms": True, "cube": False}
"""Whether the camera of each film stands still; the cube's is held by hand."""


@pytest.mark.parametrize("name", REAL)
def test_of_a_real_film_the_camera_is_reported(name: str) -> None:
    films = sorted((DATA / name).glob("*.mp4"))
    if not films:
        pytest.skip(f"the film of {name!r} is not beside this checkout")
    with Video.open(films[0]) as video:
        found = still_camera(video)
    assert found.still == REAL[name], found


def noisy(picture: NDArray[Any], seed: int) -> Grey:
    noise = np.random.default_rng(seed).normal(0.0, 1.5, picture.shape)
    return np.clip(np.rint(picture + noise), 0, 255).astype(np.uint8)


def test_an_empty_wall_shows_nothing_and_is_not_called_still() -> None:
    found = still_pictures([noisy(np.full((240, 320), 120.0), k) for k in range(SAMPLES)])
    assert not found.still


def soft_scene(u: float) -> NDArray[np.float64]:
    """Broad gradients without a corner, u pixels along."""
    x, y = np.meshgrid(np.arange(320) + u, np.arange(240))
    return np.asarray(120 + 60 * np.sin(x / 25) * np.sin(y / 25))


def lettered(picture: NDArray[np.float64]) -> NDArray[np.float64]:
    """With captions on nearly every cell, which no camera moves."""
    lettering = np.rint(picture).astype(np.uint8)
    for row in range(20, 240, 24):
        for column in range(10, 320, 32):
            cv2.putText(lettering, "K", (column, row), cv2.FONT_HERSHEY_SIMPLEX, 0.3, (255,))
    return lettering.astype(float)


def test_a_soft_scene_that_pans_behind_captions_is_not_called_still() -> None:
    """All corners are the captions', and they stand still; the gradients do not."""
    stands = still_pictures([noisy(lettered(soft_scene(0.0)), k) for k in range(SAMPLES)])
    pans = still_pictures([noisy(lettered(soft_scene(0.75 * k)), k) for k in range(SAMPLES)])
    assert stands.still, stands
    assert not pans.still, pans


def test_where_most_of_the_picture_moves_nothing_is_called_still() -> None:
    rng = np.random.default_rng(0)
    pictures = [rng.integers(0, 256, (240, 320)).astype(np.uint8) for _ in range(SAMPLES)]
    assert not still_pictures(pictures).still


def film(count: int, missing: tuple[int, ...] = ()) -> Any:
    rgb = np.stack([np.repeat(grey[..., None], 3, axis=-1) for grey in filmed()[:count]])
    return MemoryVideo(rgb, missing)


def test_damaged_frames_are_passed_over() -> None:
    lost = tuple(sampled_frames(FRAMES)[3:5])
    found = still_camera(film(FRAMES, lost))
    assert found.still
    assert found.samples == SAMPLES - len(lost)


def test_too_few_frames_are_never_called_still() -> None:
    assert not still_camera(film(1)).still
    assert not still_camera(film(2)).still
    assert not still_camera(film(FRAMES, tuple(range(2, FRAMES)))).still


def test_the_same_film_gives_the_same_answer() -> None:
    assert still_camera(film(FRAMES)) == still_camera(film(FRAMES))


@pytest.mark.parametrize("count", [1, 2, 5, 9, 61, 108_000, 100_000_000])
def test_no_film_is_so_long_that_more_of_it_is_read(count: int) -> None:
    frames = sampled_frames(count)
    assert len(frames) <= SAMPLES
    assert frames == sorted(set(frames))
    assert frames[0] == 0
    assert frames[-1] == count - 1
