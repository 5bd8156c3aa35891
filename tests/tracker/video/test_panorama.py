"""The empty scene of a camera that turns."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import pytest

from keypose.tracker.geometry.rotations import (
    Array,
)
from keypose.tracker.video import panorama
from keypose.tracker.video.clip_loader import ClipLoader, WorkingSize
from keypose.tracker.video.panorama import Shown, exposure_of, panorama_of, sampled
from keypose.tracker.video.pyramid import TARGET_ONLY, USABLE
from keypose.tracker.video.still_camera import smooth
from tests.tracker.camera_cases import SMALL, rendered, turned
from tests.tracker.tracking_cases import MemoryVideo

FRAMES = 40
SIDE = 30
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
    return ClipLoader(video, SMALL, WorkingSize(0), turns=Rs)


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


def test_as_many_frames_are_taken_of_a_quick_pan_as_of_a_long_look() -> None:
    way = np.concatenate([np.zeros(300), np.linspace(0, 90, 30), np.full(300, 90.0)])
    Rs = np.stack([turned(degrees) for degrees in way])
    frames = np.array(sampled(Rs, 81))
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
