"""Where a pose and what moves in the picture disagree, for bodies drawn where they are known."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.body.body import preset
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.raster import BodyMesh, raster
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.geometry.view import ViewCamera
from keypose.tracker.kernels.layout import STEPS
from keypose.tracker.keypoints.keypoints import JOINTS, Keypoints
from keypose.tracker.keypoints.region import Region
from keypose.tracker.tracking.cues.silhouette import outlines_of, silhouette_mismatch
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.video.clip_loader import ClipLoader, WorkingSize
from keypose.tracker.video.pyramid import IGNORED, TARGET_ONLY, USABLE, Clip
from tests.tracker.keypoints.keypoint_cases import disc
from tests.tracker.tracking_cases import MemoryVideo, clip_of

CAMERA = Camera(width=320, height=240, fx=400.0, fy=400.0, cx=159.5, cy=119.5)
SKELETON = Skeleton.of(preset("adult_male"))
PARTS = SKELETON.body.names
COUNT = 25
ELBOW_DEG = 70.0


def walking() -> Trajectory:
    """A standing figure that is carried from left to right."""
    rest = Pose.rest(SKELETON, (0.0, 0.0, 4.5))
    places = np.stack([np.linspace(-1.1, 1.1, COUNT), np.zeros(COUNT), np.full(COUNT, 4.5)], axis=1)
    return Trajectory(0, np.tile(rest.Rs_parent_part, (COUNT, 1, 1, 1)), places)


def turned(motion: Trajectory, part: str, deg: float, frames: slice = slice(None)) -> Trajectory:
    """The same with a part turned in the plane of the picture, away from the trunk."""
    outward = -deg if part.startswith("left") else deg
    Rs = motion.Rs_parent_part.copy()
    Rs[frames, PARTS.index(part)] = Rs[frames, PARTS.index(part)] @ exp_rotation(
        np.array([0.0, 0.0, np.radians(outward)])
    )
    return Trajectory(motion.first_frame, Rs, motion.ps_camera_root)


def shifted(motion: Trajectory, x_m: float) -> Trajectory:
    move = np.array([x_m, 0.0, 0.0])
    return Trajectory(motion.first_frame, motion.Rs_parent_part, motion.ps_camera_root + move)


TRUTH = walking()
SCENE = Scene.of(SKELETON, CAMERA, [TRUTH.pose(0), TRUTH.pose(COUNT - 1)])


def covered(motion: Trajectory, camera: Camera = CAMERA) -> NDArray[np.bool_]:
    """(N, H, W) which pixels the body covers."""
    mesh, view = BodyMesh.of(SKELETON), ViewCamera.of(camera)
    return np.stack([raster(mesh, T, view).part >= 0 for T in motion.transforms(SKELETON)])


def clip_with(moving: NDArray[np.bool_], first_frame: int = 0) -> Clip:
    """A prepared clip in which exactly these pixels move, bright before what is dark."""
    level = np.zeros((*moving.shape, 4), np.int16)
    level[..., 0] = STEPS * np.where(moving, 200, 50)
    level[..., 3] = np.where(moving, USABLE, TARGET_ONLY)
    return Clip(first_frame, (level,))


CLIP = clip_with(covered(TRUTH))


def clip_of_a_moving_camera() -> Clip:
    """The same brightness, and nothing said of what moves."""
    level = CLIP.levels[0].copy()
    level[..., 3] = USABLE
    return Clip(CLIP.first_frame, (level,))


def filmed(camera: Camera = CAMERA) -> Clip:
    """The figure before a patterned wall, loaded as the film of a camera that stands still."""
    rng = np.random.default_rng(0)
    wall = rng.integers(60, 140, (camera.height, camera.width, 3)).astype(np.uint8)
    pictures = np.repeat(wall[None], COUNT, axis=0)
    pictures[covered(TRUTH, camera)] = (230, 220, 240)
    video: Any = MemoryVideo(pictures)
    return ClipLoader(video, camera, WorkingSize(0), static_camera=True).load(0, COUNT - 1)


def test_a_body_at_its_true_pose_has_no_mismatch() -> None:
    found = silhouette_mismatch(SCENE, CLIP, TRUTH)
    assert found.by_part.shape == (COUNT, len(PARTS))
    assert found.total.shape == (COUNT,)
    assert found.total.max() == 0.0


def test_a_filmed_body_at_its_true_pose_has_next_to_none() -> None:
    clip = filmed()
    at_truth = silhouette_mismatch(SCENE, clip, TRUTH)
    assert at_truth.total.max() < 0.03
    wrong = silhouette_mismatch(SCENE, clip, turned(TRUTH, "left_upper_arm", ELBOW_DEG))
    assert wrong.total.min() > 2 * at_truth.total.max()


def test_where_a_person_is_counts_as_what_moves_does() -> None:
    clip, person = clip_of_a_moving_camera(), covered(TRUTH)
    for motion in (TRUTH, turned(TRUTH, "left_upper_arm", ELBOW_DEG, slice(8, 16))):
        by_outline = silhouette_mismatch(SCENE, clip, motion, lambda frame: person[frame])
        np.testing.assert_array_equal(
            by_outline.by_part, silhouette_mismatch(SCENE, CLIP, motion).by_part
        )
    assert np.isnan(silhouette_mismatch(SCENE, clip, TRUTH).total).all()


def test_what_is_ignored_stays_so_and_where_nobody_is_seen_nothing_is_known() -> None:
    clip, person = clip_of_a_moving_camera(), covered(TRUTH)
    clip.levels[0][5, ..., 3] = IGNORED

    def outlines(frame: int) -> NDArray[np.bool_] | None:
        return None if frame == 7 else person[frame]

    total = silhouette_mismatch(SCENE, clip, TRUTH, outlines).total
    assert np.flatnonzero(np.isnan(total)).tolist() == [5, 7]


BENT = CAMERA.model_copy(update={"distortion": (-0.2, 0.05, 0.0, 0.0, 0.0)})


@pytest.mark.parametrize("camera", [CAMERA, BENT], ids=["ideal", "bent"])
@pytest.mark.parametrize("halvings", [0, 1])
def test_a_mask_lies_in_a_clip_where_the_picture_does(camera: Camera, halvings: int) -> None:
    size, region = WorkingSize(halvings), Region(90.0, 110.0, 120.0, 0.3)
    mask = disc(region)
    nowhere = np.full((2, 12, 2), np.nan)
    seen = Keypoints(3, JOINTS, nowhere, np.zeros((2, 12)), masks=(mask, None))
    outlines = outlines_of(seen, camera, size)
    filmed = np.round(255 * mask.in_picture(camera.width, camera.height)).astype(np.uint8)
    white = size.picture(camera.rectify(filmed)) > 127
    found = outlines(3)
    assert found is not None
    assert 1500 < white.sum() * 4**halvings < 4000
    assert np.array_equal(found, white)
    assert outlines(4) is None
    assert outlines_of(None, camera, size)(3) is None


def test_a_large_body_is_compared_as_a_small_one_is() -> None:
    large = Camera(width=960, height=720, fx=1200.0, fy=1200.0, cx=479.5, cy=359.5)
    scene = Scene.of(SKELETON, large, [TRUTH.pose(0), TRUTH.pose(COUNT - 1)])
    clip, wrong = filmed(large), turned(TRUTH, "left_upper_arm", ELBOW_DEG)
    assert silhouette_mismatch(scene, clip, TRUTH).total.max() < 0.03
    at_large = silhouette_mismatch(scene, clip, wrong).total
    at_small = silhouette_mismatch(SCENE, filmed(), wrong).total
    np.testing.assert_allclose(at_large.mean(), at_small.mean(), rtol=0.3)


@pytest.mark.parametrize("part", ["left_forearm", "right_shin", "left_upper_arm", "right_thigh"])
def test_a_limb_that_is_moved_away_raises_its_own_parts_and_no_others(part: str) -> None:
    found = silhouette_mismatch(SCENE, CLIP, turned(TRUTH, part, ELBOW_DEG))
    unmoved = found.unmoved_by_part.mean(axis=0)
    limb = carried_by(part)
    assert unmoved[limb].sum() > 0.005
    assert unmoved[np.setdiff1d(np.arange(len(PARTS)), limb)].max() == 0.0
    assert found.uncovered.mean() > 0.005


def carried_by(part: str) -> NDArray[np.int64]:
    """A part and all that hangs on it."""
    limb = {PARTS.index(part)}
    for i, parent in enumerate(SKELETON.parents):
        if parent in limb:
            limb.add(i)
    return np.array(sorted(limb))


def test_what_moves_and_is_not_covered_goes_to_the_part_that_lies_nearest() -> None:
    """The figure's true forearm is turned outward; the pose has it hang."""
    clip = clip_with(covered(turned(TRUTH, "left_forearm", 40.0)))
    found = silhouette_mismatch(SCENE, clip, TRUTH).uncovered_by_part.mean(axis=0)
    arm = carried_by("left_upper_arm")
    assert found[arm].sum() > 0.005
    assert found[arm].sum() > 0.9 * found.sum()


def test_only_the_frames_in_which_a_limb_is_wrong_are_raised() -> None:
    wrong = slice(8, 16)
    total = silhouette_mismatch(SCENE, CLIP, turned(TRUTH, "left_thigh", 50.0, wrong)).total
    right = np.delete(total, np.arange(COUNT)[wrong])
    assert total[wrong].min() > 0.02
    assert right.max() == 0.0


def test_the_further_a_body_is_off_the_larger_is_the_mismatch() -> None:
    offs = [
        silhouette_mismatch(SCENE, CLIP, shifted(TRUTH, x)).total[10] for x in (0, 0.05, 0.1, 0.2)
    ]
    assert offs == sorted(offs)
    assert offs[-1] > 0.3


def test_what_moves_far_from_the_body_does_not_count() -> None:
    moving = covered(TRUTH)
    moving[12, 5:60, 250:310] = True
    assert silhouette_mismatch(SCENE, clip_with(moving), TRUTH).total[12] == 0.0


def test_where_the_whole_picture_changes_nothing_is_known() -> None:
    moving = covered(TRUTH)
    moving[12, :, 180:] = True  # a third of what is around the body
    moving[15] |= np.indices(moving[15].shape).sum(axis=0) % 3 == 0
    total = silhouette_mismatch(SCENE, clip_with(moving), TRUTH).total
    assert np.flatnonzero(np.isnan(total)).tolist() == [12, 15]


def test_still_pixels_as_bright_as_the_part_say_nothing_against_it() -> None:
    wrong = turned(TRUTH, "left_thigh", 50.0, slice(8, 16))
    clear = silhouette_mismatch(SCENE, CLIP, wrong)
    level = CLIP.levels[0].copy()
    level[..., 0] = 200 * STEPS
    alike = silhouette_mismatch(SCENE, Clip(0, (level,)), wrong)
    assert clear.unmoved[8:16].min() > 0.02
    assert alike.unmoved.max() == 0.0
    np.testing.assert_array_equal(alike.uncovered, clear.uncovered)


def test_ignored_pixels_do_not_count() -> None:
    wrong = turned(TRUTH, "left_upper_arm", ELBOW_DEG)
    level = CLIP.levels[0].copy()
    level[..., 3][covered(wrong) | covered(TRUTH)] = IGNORED
    level[..., 3][covered(wrong) & covered(TRUTH)] = USABLE
    assert silhouette_mismatch(SCENE, Clip(0, (level,)), wrong).total.max() == 0.0


def test_without_a_background_nothing_is_known() -> None:
    pictures = np.full((COUNT, CAMERA.height, CAMERA.width, 3), 90, np.uint8)
    found = silhouette_mismatch(SCENE, clip_of(pictures), TRUTH)
    assert np.isnan(found.total).all()
    assert np.isnan(found.by_part).all()


def test_a_frame_that_is_missing_is_unknown_and_the_others_are_not() -> None:
    level = CLIP.levels[0].copy()
    level[7] = IGNORED
    total = silhouette_mismatch(SCENE, Clip(0, (level,)), TRUTH).total
    assert np.flatnonzero(np.isnan(total)).tolist() == [7]


def test_a_body_outside_the_picture_is_unknown_and_one_half_outside_is_not() -> None:
    away = silhouette_mismatch(SCENE, CLIP, shifted(TRUTH, 30.0))
    assert np.isnan(away.total).all()
    cut = shifted(TRUTH, 0.7)
    assert silhouette_mismatch(SCENE, clip_with(covered(cut)), cut).total[-1] == 0.0


def test_a_motion_is_compared_with_its_own_frames_of_a_longer_clip() -> None:
    wrong = turned(TRUTH, "left_thigh", 50.0, slice(8, 16))
    part = Trajectory(8, wrong.Rs_parent_part[8:14], wrong.ps_camera_root[8:14])
    whole = silhouette_mismatch(SCENE, CLIP, wrong).by_part
    np.testing.assert_array_equal(silhouette_mismatch(SCENE, CLIP, part).by_part, whole[8:14])
    with pytest.raises(IndexError, match="not all in the clip"):
        silhouette_mismatch(SCENE, CLIP, Trajectory(20, wrong.Rs_parent_part, wrong.ps_camera_root))


def test_beside_its_keyframes_a_motion_has_what_it_has_more() -> None:
    rising = [turned(TRUTH, "left_thigh", 40.0, slice(8, 16)), turned(TRUTH, "left_thigh", 40.0)]
    wrong, throughout = (silhouette_mismatch(SCENE, CLIP, motion) for motion in rising)
    assert wrong.excess[8:16].min() > 0.02
    np.testing.assert_allclose(throughout.excess[[0, -1]], 0.0, atol=1e-12)


def test_without_a_background_no_motion_has_more_than_another() -> None:
    level = np.full((COUNT, CAMERA.height, CAMERA.width, 4), USABLE, np.int16)
    found = silhouette_mismatch(SCENE, Clip(0, (level,)), shifted(TRUTH, 0.2))
    assert not found.excess.any()
