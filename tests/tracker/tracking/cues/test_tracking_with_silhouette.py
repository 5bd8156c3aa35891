"""What moves before a camera that stands still, or a person's mask before another, judges a motion,
and is never a must."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import cv2
import numpy as np
import pytest

from keypose.tracker.body.raster import BodyMesh, raster
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.errors import KeypointError
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.geometry.view import ViewCamera
from keypose.tracker.kernels.layout import STEPS
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.keypoints.person_mask import MASK_SIDE, PersonMask
from keypose.tracker.keypoints.region import Region
from keypose.tracker.session.settings import ALL_CUES, TrackSettings
from keypose.tracker.tracking.cues.sources import GivenKeypoints
from keypose.tracker.tracking.result import SegmentResult
from keypose.tracker.tracking.tracker import Tracker
from keypose.tracker.video.clip_loader import ClipLoader
from keypose.tracker.video.pyramid import TARGET_ONLY, USABLE, Clip
from tests.tracker.tracking.cues.people import CAMERA, SKELETON, Filmed, moving
from tests.tracker.tracking_cases import tracked

FILM = Filmed(moving())
BOTH = ("brightness", "keypoints")


def with_arms_raised(truth: Trajectory) -> Trajectory:
    """Between the keyframes both arms are somewhere else."""
    Rs, bump = truth.Rs_parent_part.copy(), np.sin(np.pi * np.linspace(0.0, 1.0, len(truth)))
    for arm, angle in (("left_upper_arm", 1.2), ("right_upper_arm", -1.2)):
        turn = np.zeros((len(truth), 3))
        turn[:, 2] = angle * bump
        part = SKELETON.body.index(arm)
        Rs[:, part] = Rs[:, part] @ exp_rotation(turn)
    return Trajectory(truth.first_frame, Rs, truth.ps_camera_root)


def clip_that_shows(motion: Trajectory) -> Clip:
    """Pictures without gradients in which exactly the pixels of the body move, and are bright."""
    mesh, view = BodyMesh.of(SKELETON), ViewCamera.of(CAMERA)
    shown = np.stack([raster(mesh, T, view).part >= 0 for T in motion.transforms(SKELETON)])
    levels = []
    for level in FILM.segment.clip.levels:
        step = shown.shape[1] // level.shape[1]
        body = shown[:, ::step, ::step]
        grey, use = np.where(body, 200 * STEPS, level[..., 0]), np.where(body, USABLE, TARGET_ONLY)
        both = [grey[..., None], level[..., 1:3], use[..., None]]
        levels.append(np.concatenate(both, axis=-1, dtype=np.int16, casting="unsafe"))
    return Clip(motion.first_frame, tuple(levels))


def before_a_moving_camera(clip: Clip) -> Clip:
    """The same brightness, with nothing said of what moves."""
    levels = [level.copy() for level in clip.levels]
    for level in levels:
        level[..., 3] = USABLE
    return Clip(clip.first_frame, tuple(levels))


SQUARE = Region((CAMERA.width - 1) / 2, (CAMERA.height - 1) / 2, CAMERA.width)
"""Around the whole picture."""


def people_seen(motion: Trajectory) -> GivenKeypoints:
    """What sees a person exactly where the body is."""
    mesh, view = BodyMesh.of(SKELETON), ViewCamera.of(CAMERA)
    to_square = cv2.invertAffineTransform(SQUARE.to_picture(MASK_SIDE))
    masks = tuple(
        PersonMask.of(
            SQUARE,
            cv2.warpAffine(
                (raster(mesh, T, view).part >= 0).astype(np.float32), to_square, (MASK_SIDE,) * 2
            ),
        )
        for T in motion.transforms(SKELETON)
    )
    return GivenKeypoints(replace(FILM.keypoints, masks=masks))


def result(
    motion_shown: Trajectory,
    monkeypatch: pytest.MonkeyPatch,
    still: bool,
    people: GivenKeypoints | None = None,
    **settings: object,
) -> SegmentResult:
    clip = clip_that_shows(motion_shown)
    clip = before_a_moving_camera(clip) if people else clip
    monkeypatch.setattr(ClipLoader, "load", lambda *_: clip)
    segment = FILM.segment
    poses = {segment.first_frame: segment.start, segment.last_frame: segment.end}
    source = GivenKeypoints(FILM.keypoints)
    video: Any = None
    tracker = Tracker(
        video, CAMERA, SKELETON, poses, static_camera=still, keypoints=source, people=people
    )
    (found,) = tracked(tracker, **settings)
    return found


def test_a_body_beside_what_moves_is_to_be_checked(monkeypatch: pytest.MonkeyPatch) -> None:
    shown = with_arms_raised(FILM.truth)
    found = result(shown, monkeypatch, True, cues=ALL_CUES, quality="preview")
    assert found.verdict is not None
    assert found.verdict.cause == "moves_beside_body"
    assert found.verdict.go is not None
    assert abs(found.verdict.go - (FILM.truth.first_frame + FILM.truth.last_frame) / 2) <= 3
    covered = result(FILM.truth, monkeypatch, True, cues=ALL_CUES, quality="preview")
    assert covered.verdict is not None
    assert covered.verdict.cause != "moves_beside_body"


def test_before_a_camera_that_moves_a_body_beside_the_person_is_to_be_checked(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    shown, tracked = with_arms_raised(FILM.truth), {"cues": ALL_CUES, "quality": "preview"}
    found = result(shown, monkeypatch, False, people_seen(shown), **tracked)
    without = result(shown, monkeypatch, False, people_seen(shown), quality="preview", cues=BOTH)
    assert found.verdict is not None
    assert found.verdict.cause == "moves_beside_body"
    assert without.verdict is not None
    assert without.verdict.cause != "moves_beside_body"
    np.testing.assert_array_equal(  # it judges the motion and does not change it
        found.trajectory.Rs_parent_part, without.trajectory.Rs_parent_part
    )
    covered = result(FILM.truth, monkeypatch, False, people_seen(FILM.truth), **tracked)
    assert covered.verdict is not None
    assert covered.verdict.cause != "moves_beside_body"


def test_without_the_network_that_sees_the_person_nothing_is_tracked_in_vain(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    class Absent(GivenKeypoints):
        def over(self, *_: object) -> Keypoints:
            raise KeypointError("The network is not installed.")

    def worked(*_: object) -> None:
        pytest.fail("it was tracked before")

    monkeypatch.setattr(Tracker, "_work", worked)
    with pytest.raises(KeypointError, match="not installed"):
        result(FILM.truth, monkeypatch, False, Absent(FILM.keypoints), cues=ALL_CUES)


@pytest.mark.parametrize(
    ("still", "settings"),
    [
        (True, {"cues": BOTH}),  # named by nobody
        (False, {"cues": ALL_CUES}),  # a camera that moves, and nothing that sees a person
    ],
)
def test_where_it_is_not_named_or_cannot_be_had_all_is_as_without(
    still: bool, settings: dict[str, object], monkeypatch: pytest.MonkeyPatch
) -> None:
    shown = with_arms_raised(FILM.truth)
    found = result(shown, monkeypatch, still, quality="preview", **settings)
    without = result(shown, monkeypatch, False, quality="preview", cues=BOTH)
    np.testing.assert_array_equal(
        found.trajectory.Rs_parent_part, without.trajectory.Rs_parent_part
    )
    np.testing.assert_array_equal(
        found.trajectory.ps_camera_root, without.trajectory.ps_camera_root
    )
    assert found.verdict == without.verdict


def test_the_papers_method_does_without(monkeypatch: pytest.MonkeyPatch) -> None:
    shown = with_arms_raised(FILM.truth)
    found, without = (
        result(shown, monkeypatch, True, method="paper", passes=1, cues=cues)
        for cues in (ALL_CUES, ("brightness",))
    )
    np.testing.assert_array_equal(
        found.trajectory.Rs_parent_part, without.trajectory.Rs_parent_part
    )
    assert found.verdict == without.verdict


def test_alone_it_is_no_way_to_find_a_motion() -> None:
    with pytest.raises(ValueError, match="add brightness or keypoints"):
        TrackSettings(cues=("silhouette",))
