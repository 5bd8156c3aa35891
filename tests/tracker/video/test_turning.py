"""The empty scene of a camera that turns, and its pictures without tremble."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import cv2
import numpy as np
import pytest

from keypose.tracker.geometry.rotations import (
    Array,
    exp_rotation,
    log_rotation,
    transform,
    transpose,
)
from keypose.tracker.tracking.tracker import Tracker
from keypose.tracker.video import panorama
from keypose.tracker.video.clip_loader import ClipLoader, WorkingSize
from keypose.tracker.video.panorama import Shown, exposure_of, panorama_of
from keypose.tracker.video.pyramid import IGNORED, TARGET_ONLY, USABLE
from keypose.tracker.video.still_camera import smooth
from keypose.tracker.video.turning import TurningCamera
from tests.tracker.camera_cases import SMALL, rendered, turned
from tests.tracker.tracking_cases import Case, MemoryVideo, case, tracked

FRAMES, SIDE = 40, 30
RS = np.stack([turned(0.5 * k, 0.4 * np.sin(1.7 * k), 0.2 * np.sin(k)) for k in range(FRAMES)])
EMPTY = np.stack([rendered(SMALL, R) for R in RS])
GAINS = 1 + 0.15 * np.sin(np.arange(FRAMES) / 5)


def column(frame: int) -> int:
    """Where somebody stands at a frame, who walks against the pan."""
    return 240 - 5 * frame


def film() -> Array:
    """(N, H, W, 3) with a bright person in it, and an exposure that changes."""
    pictures = GAINS[:, None, None] * EMPTY
    for frame in range(FRAMES):
        pictures[frame, 60:150, column(frame) : column(frame) + SIDE] = 250
    grey = np.clip(pictures, 0, 255).astype(np.uint8)
    return np.repeat(grey[..., None], 3, axis=-1)


def loader(Rs: Array = RS) -> ClipLoader:
    video: Any = MemoryVideo(film())
    turning = TurningCamera(Rs, Rs)
    return ClipLoader(video, SMALL, WorkingSize(0), turning=turning)


def test_the_panorama_shows_what_is_behind_a_person_at_every_frame_and_exposure() -> None:
    around = loader().panorama()
    for frame in (0, 17, 39):
        plate, known = around.seen(RS[frame])
        assert known.mean() > 0.9
        gain = exposure_of(film()[frame, ..., 0], plate, known)
        assert gain / exposure_of(EMPTY[frame], plate, known) == pytest.approx(
            GAINS[frame], rel=0.03
        )
        off = smooth(plate) * gain - smooth(GAINS[frame] * EMPTY[frame].astype(np.float32))
        assert np.percentile(np.abs(off[known]), 98) < 8


def test_only_who_moves_is_no_background() -> None:
    clip = loader().load(0, FRAMES - 1)
    for frame in (3, 20, 36):
        use = clip.levels[0][frame, ..., 3]
        inside = np.zeros(use.shape, bool)
        inside[60:150, column(frame) : column(frame) + SIDE] = True
        assert (use[inside] == USABLE).mean() > 0.85
        away = cv2.dilate(inside.astype(np.uint8), np.ones((9, 9), np.uint8)) == 0
        assert (use[away] != USABLE).mean() > 0.9
        assert (use[away] == TARGET_ONLY).mean() > 0.7


def test_a_tremble_is_taken_out_and_a_pan_and_a_cut_stay() -> None:
    pan = np.stack([turned(0.5 * k if k < 25 else 40.0) for k in range(FRAMES)])
    shake = exp_rotation(0.005 * np.sin(1.7 * np.arange(FRAMES))[:, None] * (1.0, 0.3, 0.5))
    turning = TurningCamera.of(shake @ pan, (0, 25))
    off = np.linalg.norm(log_rotation(turning.Rs_steady_world @ transpose(pan)), axis=1)
    assert np.degrees(off[:25]).max() < 0.1
    assert np.degrees(off[25:]).max() < 0.5
    bends = np.diff(log_rotation(turning.Rs_steady_world[:25]), 2, axis=0)
    assert np.degrees(np.abs(bends)).max() < 0.1


def test_as_many_frames_are_taken_of_a_quick_pan_as_of_a_long_look() -> None:
    way = np.concatenate([np.zeros(300), np.linspace(0, 90, 30), np.full(300, 90.0)])
    Rs = np.stack([turned(degrees) for degrees in way])
    frames = np.array(TurningCamera(Rs, Rs).sampled(81))
    assert len(frames) <= 81
    assert ((frames >= 300) & (frames < 330)).sum() >= 25


def test_a_panorama_all_around_stays_within_its_size(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(panorama, "MOST_PIXELS", 400_000)
    whole = np.ones(EMPTY[0].shape, bool)
    Rs = [turned(4.0 * k) for k in range(90)]
    around = panorama_of(SMALL, [Shown(rendered(SMALL, R), whole, R) for R in Rs])
    assert around.picture.size < 410_000
    plate, known = around.seen(turned(180.0))
    assert known.mean() > 0.95
    off = smooth(plate) - smooth(rendered(SMALL, turned(180.0)))
    assert np.median(np.abs(off[known])) < 6


def trembling(shown: Case, Rs: Array) -> Case:
    """The same as filmed by a camera that turns."""
    K = shown.camera.K
    pictures = np.stack([
        cv2.warpPerspective(picture, K @ R @ np.linalg.inv(K), picture.shape[1::-1])
        for picture, R in zip(shown.pictures, Rs, strict=True)
    ])  # fmt: skip
    truth = shown.truth.carried(transform(Rs, np.zeros((len(Rs), 3))))
    return replace(shown, truth=truth, pictures=pictures)


def test_before_a_camera_that_trembles_a_motion_is_found_as_before_one_that_does_not() -> None:
    count = 25
    shake = 0.02 * np.sin(1.7 * np.arange(count))[:, None] * (1.0, 0.7, 0.5)
    Rs = exp_rotation(shake)
    shown = trembling(case("stride", 0, count - 1), Rs)
    turning = TurningCamera.of(Rs)

    def error_px(tracker: Tracker) -> float:
        (found,) = tracked(tracker, cues=("brightness",))
        for frame in (0, count - 1):
            mine, true = found.trajectory.pose(frame), shown.truth.pose(frame)
            np.testing.assert_allclose(mine.p_camera_root, true.p_camera_root, atol=1e-9)
        seen, true_uv = (
            shown.camera.project(motion.joints(shown.skeleton))
            for motion in (found.trajectory, shown.truth)
        )
        return float(np.linalg.norm(seen - true_uv, axis=-1).mean())

    alone, steadied = (
        error_px(shown.tracker(0, count - 1, turning=each)) for each in (None, turning)
    )
    assert alone > 5
    assert steadied < 0.5


def test_what_a_steadied_picture_does_not_show_is_ignored() -> None:
    aside = turned(3.0) @ RS
    video: Any = MemoryVideo(film())
    turning = TurningCamera(RS, aside)
    use = ClipLoader(video, SMALL, WorkingSize(0), turning=turning).load(0, 3).levels[0][..., 3]
    assert (use[:, :, :15] == IGNORED).all() or (use[:, :, -15:] == IGNORED).all()
