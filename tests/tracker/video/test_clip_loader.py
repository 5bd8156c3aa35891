"""From video to clips: size, masks, missing frames, background, and the memory they may take."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.errors import SessionError, VideoError
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.kernels.layout import STEPS
from keypose.tracker.session.settings import IgnoreMask
from keypose.tracker.video.clip_loader import (
    LONGEST_SEGMENT,
    ONCE,
    PROCESS_BYTES,
    WORKING_PIXELS,
    ClipLoader,
    Memory,
    WorkingSize,
)
from keypose.tracker.video.pyramid import (
    ALIGNED,
    IGNORED,
    LEVELS,
    TARGET_ONLY,
    USABLE,
    Window,
)
from tests.tracker.tracking_cases import MemoryVideo

WIDTH = 80
HEIGHT = 60
CAMERA = Camera(width=WIDTH, height=HEIGHT, fx=70.0, fy=72.0, cx=40.5, cy=29.25)
LARGE = Camera(width=251, height=187, fx=230.0, fy=230.0, cx=125.0, cy=93.0)
Pictures = NDArray[np.uint8]


def noise(count: int, width: int = WIDTH, height: int = HEIGHT) -> Pictures:
    rng = np.random.default_rng(0)
    return rng.integers(0, 256, (count, height, width, 3)).astype(np.uint8)


def loader(
    pictures: Pictures, camera: Camera = CAMERA, halvings: int = 0, missing: tuple[int, ...] = (),
    **more: Any,
) -> ClipLoader:  # fmt: skip
    video: Any = MemoryVideo(pictures, missing)
    return ClipLoader(video, camera, WorkingSize(halvings), **more)


def square(low: float, high: float, first: int = 0, last: int = 99) -> IgnoreMask:
    corners = ((low, low), (high, low), (high, high), (low, high))
    return IgnoreMask(polygon=corners, first_frame=first, last_frame=last)


def test_a_clip_holds_its_frames_in_order_at_every_level() -> None:
    pictures = np.broadcast_to(
        (10 * np.arange(9, dtype=np.uint8))[:, None, None, None], (9, HEIGHT, WIDTH, 3)
    )
    clip = loader(np.ascontiguousarray(pictures)).load(3, 7)
    assert (clip.first_frame, len(clip), len(clip.levels)) == (3, 5, LEVELS)
    for level in clip.levels:
        for k in range(5):
            np.testing.assert_array_equal(level[k, ..., 0], 10 * (3 + k) * STEPS)
        assert (level[..., 3] == USABLE).all()


def test_a_missing_frame_is_ignored_everywhere_and_the_others_are_not() -> None:
    for level in loader(noise(5), missing=(2,)).load(0, 4).levels:
        assert (level[2, ..., 3] == IGNORED).all()
        assert (level[2, ..., :3] == 0).all()
        assert (level[[0, 1, 3, 4], ..., 3] == USABLE).all()


def test_a_mask_holds_on_its_frames_and_inside_its_polygon() -> None:
    clip = loader(noise(6), masks=(square(20, 30, 1, 3), square(50, 55, 3, 5))).load(0, 5)
    use = clip.levels[0][..., 3]
    assert (use[[1, 2, 3], 20:31, 20:31] == IGNORED).all()
    assert (use[[0, 4, 5], 20:31, 20:31] == USABLE).all()
    assert (use[[3, 4, 5], 50:56, 50:56] == IGNORED).all()
    assert (use[:3, 50:56, 50:56] == USABLE).all()
    assert (use[1] == IGNORED).sum() <= 21**2  # the square of 11 pixels and its rim
    assert (use[:, :14, :14] == USABLE).all()


def test_a_mask_drawn_on_a_distorted_picture_covers_what_was_meant() -> None:
    bent = CAMERA.model_copy(update={"distortion": (-0.3, 0.08, 0.0, 0.0, 0.0)})
    pictures = np.full((1, HEIGHT, WIDTH, 3), 100, np.uint8)
    pictures[0, 5:16, 5:16] = 250
    clip = loader(pictures, bent, masks=(square(3, 17),)).load(0, 0)
    E, use = clip.levels[0][0, ..., 0] / STEPS, clip.levels[0][0, ..., 3]
    inside = E > 150
    assert inside.sum() > 60
    assert (use[inside] == IGNORED).all()


def test_what_rectifying_leaves_empty_is_ignored() -> None:
    pincushion = CAMERA.model_copy(update={"distortion": (0.3, 0.0, 0.0, 0.0, 0.0)})
    pictures = np.full((1, HEIGHT, WIDTH, 3), 200, np.uint8)
    level = loader(pictures, pincushion).load(0, 0).levels[0][0]
    empty = level[..., 0] < 50 * STEPS
    assert empty.any()
    assert (level[empty, 3] == IGNORED).all()


def test_a_mask_may_reach_far_out_of_the_picture() -> None:
    corners = ((-1e10, -1e10), (1e10, -1e10), (1e10, 30.0), (-1e10, 30.0))
    mask = IgnoreMask(polygon=corners, first_frame=0, last_frame=0)
    use = loader(noise(1), masks=(mask,)).load(0, 0).levels[0][0, ..., 3]
    assert (use[:30] == IGNORED).all()
    assert (use[40:] == USABLE).all()


@pytest.mark.parametrize("halvings", [0, 1, 2])
def test_the_working_size_keeps_points_on_their_pixels(halvings: int) -> None:
    rows, columns = np.mgrid[0:HEIGHT, 0:WIDTH]
    size = WorkingSize(halvings)
    working = size.camera(CAMERA)
    for p in np.array([[0.1, -0.05, 1.0], [-0.2, 0.12, 1.0]]):
        u, v = CAMERA.project(p)
        spot = 250 * np.exp(-((columns - u) ** 2 + (rows - v) ** 2) / (2 * 4.0**2))
        small = size.picture(spot.astype(np.uint8)).astype(float)
        assert small.shape == (working.height, working.width)
        y, x = np.mgrid[0 : working.height, 0 : working.width]
        middle = np.array([(small * x).sum(), (small * y).sum()]) / small.sum()
        np.testing.assert_allclose(middle, working.project(p), atol=0.12)


def test_the_working_camera_is_undistorted_and_keeps_its_other_properties() -> None:
    changes = {"distortion": (0.1, 0, 0, 0, 0), "projection": "telephoto"}
    camera = CAMERA.model_copy(update={**changes, "telephoto_distance_m": 4.0})
    working = WorkingSize(1).camera(camera)
    assert not working.is_distorted
    assert working.telephoto_distance_m == 4.0
    assert (working.width, working.height) == (40, 30)
    odd = WorkingSize(2).camera(camera.model_copy(update={"width": 77, "height": 59}))
    assert (odd.width, odd.height) == (20, 15)


@pytest.mark.parametrize(("width", "halvings"), [(320, 0), (854, 0), (1920, 1), (3840, 2)])
def test_large_pictures_are_worked_on_smaller(width: int, halvings: int) -> None:
    camera = Camera.guess(width, round(width * 9 / 16))
    size = WorkingSize.for_camera(camera, longest=10)
    assert size.halvings == halvings
    working = size.camera(camera)
    assert working.width * working.height <= 1.02 * WORKING_PIXELS


def test_a_long_segment_is_made_to_fit_the_memory() -> None:
    camera = Camera.guess(640, 360)
    for memory in (1_000_000, 30_000_000, 400_000_000):
        size = WorkingSize.for_camera(camera, longest=60, memory=Memory(memory))
        small = size.camera(camera)
        if memory == 30_000_000:
            pictures = np.zeros((60, 360, 640, 3), np.uint8)
            clip = loader(pictures, camera, size.halvings).load(0, 59)
            assert sum(level.nbytes for level in clip.levels) <= memory
        assert small.width * small.height * 21 * 60 <= 1.1 * memory


class Counting(MemoryVideo):
    """Remembers which frames were asked for."""

    def __init__(self, *shown: Any, **more: Any) -> None:
        super().__init__(*shown, **more)
        self.asked: list[int] = []

    def frames(self, first: int, stop: int) -> Any:
        self.asked += range(first, stop)
        return super().frames(first, stop)


def test_of_the_clips_those_used_last_stay_as_far_as_the_memory_goes() -> None:
    one = 3 * WIDTH * HEIGHT * 8
    kept = []
    for memory in (10, *(PROCESS_BYTES + one * k for k in range(1, 30)), 10**9):
        video: Any = Counting(noise(12))
        clips = ClipLoader(
            video, CAMERA, WorkingSize(0), memory=Memory(int(memory), int(memory) // 10)
        )
        kept.append([_is_ready(clips, video, first) for first in (0, 2, 0, 4, 0, 2)][2:])
    assert kept[0] == [False, False, False, False]  # a new clip alone, whatever the memory
    assert [True, False, True, False] in kept
    assert kept[-1] == [True, False, True, True]
    assert not any(later and not earlier for *_, earlier, later in kept)


def _is_ready(clips: ClipLoader, video: Counting, first: int) -> bool:
    """Whether three frames could be loaded without the video."""
    asked = len(video.asked)
    clips.load(first, first + 2)
    return len(video.asked) == asked


def test_a_clip_in_use_is_shared_even_where_none_are_kept() -> None:
    video: Any = Counting(noise(12))
    clips = ClipLoader(video, CAMERA, WorkingSize(0), memory=ONCE)
    first, second = clips.load(0, 2), clips.load(2, 4)
    assert clips.load(0, 2) is first
    assert clips.load(2, 4) is second
    assert video.asked == [0, 1, 2, 3, 4]
    first = clips.load(4, 6)
    clips.load(0, 2)
    assert video.asked == [0, 1, 2, 3, 4, 5, 6, 0, 1]


def test_frames_that_are_ready_are_not_prepared_again() -> None:
    video: Any = Counting(noise(12), missing=(3,))
    clips = ClipLoader(video, CAMERA, WorkingSize(0), masks=(square(20, 30, 2, 6),))
    left, right = clips.load(1, 4), clips.load(4, 6)
    assert clips.load(2, 3) is left
    assert clips.load(5, 6) is right
    whole = clips.load(0, 8)
    assert clips.load(4, 6) is whole
    assert video.asked == [1, 2, 3, 4, 5, 6, 0, 7, 8]
    afresh = ClipLoader(video, CAMERA, WorkingSize(0), masks=(square(20, 30, 2, 6),)).load(0, 8)
    for mine, other in zip(whole.levels, afresh.levels, strict=True):
        np.testing.assert_array_equal(mine, other)


def test_a_segment_larger_than_the_memory_is_still_loaded() -> None:
    tight = loader(noise(4), memory=Memory(10))
    assert len(tight.load(0, 3)) == 4


def test_keyframes_too_far_apart_are_refused_in_one_sentence() -> None:
    with pytest.raises(SessionError, match=r"Keyframes 0 and 5000 lie 5000 frames apart; .*add a"):
        loader(noise(1)).load(0, 5000)
    assert LONGEST_SEGMENT == 2000


def test_before_a_static_camera_the_background_is_no_source() -> None:
    wall = noise(1)[0] // 2 + 40
    pictures = np.repeat(cv2.GaussianBlur(wall, (0, 0), 1.0)[None], 12, axis=0)
    for k in range(12):
        pictures[k, 20:40, 6 * k : 6 * k + 10] = 250
    clip = loader(pictures, static_camera=True).load(0, 11)
    use = clip.levels[0][..., 3]
    for k in range(12):
        assert (use[k, 23:37, 6 * k + 2 : 6 * k + 8] == USABLE).all()
        away = np.ones((HEIGHT, WIDTH), bool)
        away[15:45, max(0, 6 * k - 5) : 6 * k + 15] = False
        assert (use[k][away] == TARGET_ONLY).all()
    moving_camera = loader(pictures).load(0, 11)
    assert (moving_camera.levels[0][..., 3] == USABLE).all()


def test_the_background_is_found_although_frames_are_missing() -> None:
    pictures = np.full((9, HEIGHT, WIDTH, 3), 90, np.uint8)
    pictures[4, 10:30, 10:30] = 220
    clip = loader(pictures, missing=(0, 8), static_camera=True).load(3, 5)
    assert (clip.levels[0][1, 14:26, 14:26, 3] == USABLE).all()
    assert (clip.levels[0][0, ..., 3] == TARGET_ONLY).all()


def test_a_video_that_ends_early_is_refused_instead_of_shown_as_noise() -> None:
    class Shrinking(MemoryVideo):
        def frames(self, first: int, stop: int) -> Any:
            yield from MemoryVideo.frames(self, first, min(stop, 4))

    video: Any = Shrinking(noise(8))
    short = ClipLoader(video, CAMERA, WorkingSize(0))
    assert len(short.load(0, 3)) == 4
    with pytest.raises(VideoError, match=r"no frame 6: it holds fewer frames than it says"):
        short.load(2, 6)


SCENES: dict[str, dict[str, Any]] = {
    "plain": {},
    "masked": {"masks": (square(60, 90, 1, 2),)},
    "static": {"static_camera": True},
    "bent": {"camera": LARGE.model_copy(update={"distortion": (0.2, -0.05, 0.0, 0.0, 0.0)})},
    "halved": {"halvings": 1},
    "damaged": {"missing": (1,)},
}
WINDOWS = {
    "inside": Window(101, 67, 189, 163),
    "at an edge": Window(-40, 100, 75, 500),
    "at a corner": Window(130, 90, 900, 900),
}


@pytest.mark.parametrize("window", WINDOWS.values(), ids=WINDOWS)
@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_a_window_has_the_very_numbers_of_the_whole_picture_and_is_no_larger(
    scene: dict[str, Any], window: Window
) -> None:
    pictures = noise(4, LARGE.width, LARGE.height)
    window = window.halved(scene.get("halvings", 0))
    whole, part = (
        loader(pictures, **{"camera": LARGE, **scene}).load(0, 3, w) for w in (None, window)
    )
    placed, everything = part.shown.window, whole.shown.window
    assert placed is not None
    assert everything is not None
    assert placed.holds(window.within(everything))
    for k, (level, picture) in enumerate(zip(part.levels, whole.levels, strict=True)):
        for mine, its in zip(level, picture, strict=True):
            np.testing.assert_array_equal(mine, placed.halved(k).of(its))
    kept = window.within(everything).grown(ALIGNED).aligned(ALIGNED)
    area = (kept.right - kept.left) * (kept.bottom - kept.top)
    assert (
        sum(level.nbytes for level in part.levels) <= 1.4 * 4 * area * 4 * part.levels[0].itemsize
    )
    for mine, its in zip(part.overview, whole.overview, strict=True):
        np.testing.assert_array_equal(mine, its)
    assert part.damaged == whole.damaged


def test_a_window_that_is_widened_shows_what_it_would_have_shown_from_the_start() -> None:
    pictures = noise(4, LARGE.width, LARGE.height)
    clips = loader(pictures, LARGE)
    clip = clips.load(0, 3, Window(100, 60, 190, 150))
    before = clip.shown
    assert clip.cover(Window(100, 60, 180, 150)) is before
    wider = clip.cover(Window(150, 20, 210, 100), Window(140, 10, 220, 110))
    assert wider.holds(Window(100, 20, 210, 150))
    afresh = loader(pictures, LARGE).load(0, 3, wider.window)
    for mine, other in zip(wider.levels, afresh.levels, strict=True):
        np.testing.assert_array_equal(mine, other)
    assert clips.load(1, 2, Window(110, 70, 120, 80)) is clip
    whole = clip.cover(None)
    assert whole.levels[0].shape[1:3] == (LARGE.height, LARGE.width)
    assert clips.load(0, 3) is clip


def test_frames_are_taken_over_from_a_window_that_shows_enough_of_them() -> None:
    video: Any = Counting(noise(8, LARGE.width, LARGE.height))
    clips = ClipLoader(video, LARGE, WorkingSize(0))
    clips.load(0, 3, Window(60, 60, 200, 160))
    part = clips.load(2, 5, Window(80, 70, 180, 150))
    assert video.asked == [0, 1, 2, 3, 4, 5]
    clips.load(5, 7, Window(20, 70, 180, 150))
    assert video.asked == [0, 1, 2, 3, 4, 5, 5, 6, 7]
    afresh = ClipLoader(video, LARGE, WorkingSize(0)).load(2, 5, Window(80, 70, 180, 150))
    for mine, other in zip(
        (*part.levels, *part.overview), (*afresh.levels, *afresh.overview), strict=True
    ):
        np.testing.assert_array_equal(mine, other)


@pytest.mark.parametrize("window", [Window(-90, -90, -10, -10), Window(500, 0, 600, 90)])
def test_a_body_that_is_out_of_the_picture_has_a_little_of_it(window: Window) -> None:
    clip = loader(noise(2, LARGE.width, LARGE.height), LARGE).load(0, 1, window)
    height, width = clip.levels[0].shape[1:3]
    assert min(height, width) >= 32
    assert height * width < LARGE.height * LARGE.width / 4
