"""Interlaced films: a progressive picture of every frame, the same however it is reached."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from keypose.app.cli.main import main
from keypose.tracker.video import Video
from tests.tracker.damage_cases import moving_pictures
from tests.tracker.video_cases import Picture, damage_packet, write_clip

COUNT = 16
SPEED = 4
"""Pixels a frame: the two fields of one lie half as much apart."""


def half_frames() -> list[Picture]:
    """What a camera sees at every field's time."""
    (wide,) = moving_pictures(352 + SPEED * COUNT, 192, 1)
    grey = np.repeat(wide[..., :1], 3, axis=2)
    return [grey[:, shift : shift + 352] for shift in range(0, SPEED * COUNT, SPEED // 2)]


def write_interlaced(path: Path, options: str = "tff=1:keyint=6:bframes=2") -> Path:
    """A film whose lower field, that of the odd lines, comes first."""
    seen = half_frames()
    woven = [picture.copy() for picture in seen[::2]]
    for picture, later in zip(woven, seen[1::2], strict=True):
        picture[::2] = later[::2]
    return write_clip(path, woven, rate=25, options={"x264-params": options, "crf": "10"})


def all_of(video: Video) -> list[Picture | None]:
    return [picture for _, picture in video.frames(0, video.info.frame_count)]


def error(picture: Picture | None, truth: Picture) -> float:
    assert picture is not None
    return float(np.abs(picture.astype(float) - truth).mean())


def test_an_interlaced_film_is_deinterlaced_frame_by_frame(tmp_path: Path) -> None:
    film = write_interlaced(tmp_path / "camcorder.mp4")
    with Video.open(film) as video, Video.open(film, deinterlace=False) as woven:
        assert (video.info.interlaced, video.info.deinterlaced) == (True, True)
        assert (woven.info.interlaced, woven.info.deinterlaced) == (True, False)
        np.testing.assert_array_equal(video.info.pts, woven.info.pts)
        pairs = list(zip(all_of(video), all_of(woven), half_frames()[::2], strict=True))
        video.deinterlace(False)
        np.testing.assert_array_equal(video.frame(7), woven.frame(7))
    for made, kept, truth in pairs:
        assert error(made, truth) < 0.3 * error(kept, truth)


@pytest.mark.parametrize("name", ["camcorder.mp4", "broadcast.ts", "bare.h264"])
def test_a_deinterlaced_frame_is_the_same_however_it_is_reached(tmp_path: Path, name: str) -> None:
    film = write_interlaced(tmp_path / name)
    with Video.open(film) as video:
        forward = all_of(video)
    mixed = [*np.random.default_rng(0).permutation(COUNT), *range(COUNT - 1, -1, -1)]
    for cache_bytes in (0, 400_000, 100_000_000):
        with Video.open(film, cache_bytes) as video:
            for number in mixed:
                np.testing.assert_array_equal(video.frame(int(number)), forward[number])


def test_beside_a_lost_frame_the_others_are_deinterlaced_all_the_same(tmp_path: Path) -> None:
    film = write_interlaced(tmp_path / "camcorder.mp4", "tff=1:keyint=1")
    damage_packet(film, 5)
    with Video.open(film) as video:
        forward = all_of(video)
        assert video.missing == (5,)
    with Video.open(film, cache_bytes=0) as video:
        for number in (6, 4, 15, 0, 6):
            np.testing.assert_array_equal(video.frame(number), forward[number])


def test_a_progressive_film_stays_as_it_is(tmp_path: Path) -> None:
    film = write_clip(tmp_path / "phone.mp4", half_frames()[::2])
    with Video.open(film) as video, Video.open(film, deinterlace=False) as as_stored:
        assert not video.info.deinterlaced
        np.testing.assert_array_equal(video.frame(3), as_stored.frame(3))


def test_info_says_that_a_film_is_interlaced(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["info", str(write_interlaced(tmp_path / "camcorder.mp4"))]) == 0
    assert "interlaced: frames are deinterlaced as they are read" in capsys.readouterr().out
