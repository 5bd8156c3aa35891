"""Draft an animal's pose at every frame of a clip, from a box around it on one of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from keypose.tracker.body.body import Body
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.errors import KeypointError
from keypose.tracker.fitting.draft.animal_sizes import with_animal_proportions
from keypose.tracker.fitting.draft.animals import AnimalFit, animal_points
from keypose.tracker.fitting.draft.clip import ClipDraft, DraftProgress
from keypose.tracker.fitting.draft.judged import NEAREST_M, POOR, JudgedDrafts
from keypose.tracker.fitting.draft.observed import FEWEST_SEEN, SEEN, Observed, jumps
from keypose.tracker.fitting.draft.proposals import FrameRange
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.geometry.steady import SteadyCamera
from keypose.tracker.keypoints.detect import ANIMAL, Detector, Frame, Kept, Progress, Seed, detect
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.keypoints.on_animal import ANIMAL_POINTS
from keypose.tracker.session.annotations import Reason
from keypose.tracker.solver.projection import image_points

CAMERAS_UP = (0.0, -1.0, 0.0)
"""What is up where nobody knows: the camera is held level."""
GUESSED = 0.15
"""Visibility below which a keypoint may be anywhere: networks of joints always answer something."""
LEGS = tuple(
    (f"{side}_{leg}", tuple(ANIMAL_POINTS.index(f"{side}_{joint}") for joint in joints))
    for side in ("left", "right")
    for leg, joints in (
        ("front_upper_leg", ("shoulder", "elbow", "front_paw")),
        ("hind_upper_leg", ("hip", "knee", "back_paw")),
    )
)
"""By the upper part of each leg its keypoints."""


def draft_animal(
    frame: Frame,
    frames: tuple[int, int],
    seed: Seed,
    camera: Camera,
    body: Body,
    network: Detector,
    *,
    proportions: bool = True,
    up_world: ArrayLike | None = None,
    path: CameraPath | None = None,
    report: Callable[[DraftProgress], None] = lambda progress: None,
    film: str = "",
    kept: Kept | None = None,
) -> ClipDraft:
    """Drafts of all frames from the first to the last, of the animal at a seed.

    network: what sees `ANIMAL_POINTS`.  All else is as of `draft_clip`.
    """

    def looked(progress: Progress) -> None:
        report(DraftProgress("keypoints", progress.done, progress.expected))

    keypoints = detect(
        frame, frames, [seed], network, report=looked, film=film, kept=kept, subject=ANIMAL
    )
    return draft_from_animal_keypoints(
        keypoints,
        camera,
        body,
        proportions=proportions,
        up_world=up_world,
        path=path,
        report=report,
    )


def draft_from_animal_keypoints(
    keypoints: Keypoints,
    camera: Camera,
    body: Body,
    *,
    proportions: bool = True,
    up_world: ArrayLike | None = None,
    path: CameraPath | None = None,
    report: Callable[[DraftProgress], None] = lambda progress: None,
) -> ClipDraft:
    """Drafts from keypoints in the picture; KeypointError where they show no animal well enough.

    proportions: whether the body's parts may be sized to the animal's.
    up_world: (3,) what is up, where it is known.  path: of a camera that moves.
    """
    keypoints = Keypoints(keypoints.first_frame, ANIMAL_POINTS, keypoints.uv, keypoints.visibility)
    steadied = keypoints
    if path is not None and path.zooms:
        steadied = keypoints.steadied(SteadyCamera.at_one_focal(camera, path))
    observed, ideal = _observed(steadied, camera), camera.without_distortion()
    up = _ups(observed, up_world, path)
    expected = int(observed.usable.sum())
    runs = observed.runs()

    def fit_of(rows: slice) -> AnimalFit:
        return AnimalFit.of(Skeleton.of(body), ideal, observed.rows(rows), up[rows])

    if proportions and runs:
        longest = max(runs, key=lambda rows: rows.stop - rows.start)
        step = partial(report, DraftProgress("poses", 0, expected))
        sized = with_animal_proportions(*fit_of(longest).solved(step))
        body = _with_tail(sized, body)
    pieces: list[tuple[Observed, Trajectory]] = []
    for rows in runs:
        done = sum(len(run) for run, _ in pieces)
        step = partial(report, DraftProgress("poses", min(done, expected), expected))
        fit, motion = fit_of(rows).solved(step)
        pieces.append((fit.observed, motion))
    report(DraftProgress("poses", expected, expected))
    return _draft(body, ideal, keypoints, pieces)


def _observed(keypoints: Keypoints, camera: Camera) -> Observed:
    """The keypoints as an ideal lens would have them; nothing is known of their depth."""
    uv = camera.without_distortion().project(camera.back_project(keypoints.uv, 1.0))
    is_known = np.asarray(np.isfinite(uv).all(axis=-1) & (keypoints.visibility >= GUESSED))
    visibility = np.where(is_known, keypoints.visibility, 0.0)
    usable = np.asarray((visibility >= SEEN).sum(axis=1) >= FEWEST_SEEN)
    uv = np.where(is_known[..., None], uv, 0.0)
    return Observed(
        first_frame=keypoints.first_frame,
        uv=uv,
        known=is_known,
        visibility=visibility,
        p_hips=np.full((*uv.shape[:2], 3), np.nan),
        usable=usable,
        jumped=jumps(uv, is_known, usable),
        depth_sigma_m=np.full(uv.shape[:2], np.nan),
    )


def _ups(observed: Observed, up_world: ArrayLike | None, path: CameraPath | None) -> Array:
    """(N, 3) what is up before the camera at each frame."""
    if up_world is None or path is None:
        up = np.asarray(CAMERAS_UP if up_world is None else up_world, dtype=np.float64)
        return np.broadcast_to(up, (len(observed), 3))
    first = observed.first_frame
    R = path.Ts_camera_world[first : first + len(observed), :3, :3]
    return np.asarray(R @ np.asarray(up_world, dtype=np.float64))


def _with_tail(sized: Body, body: Body) -> Body:
    """A body that was sized, free to move as it was."""
    parts = (
        part.model_copy(update={"tracked": before.tracked})
        for part, before in zip(sized.parts, body.parts, strict=True)
    )
    return sized.replaced(parts)


def _draft(
    body: Body, camera: Camera, keypoints: Keypoints, pieces: Sequence[tuple[Observed, Trajectory]]
) -> ClipDraft:
    skeleton = Skeleton.of(body)
    judgements = [_judged(skeleton, camera, *piece) for piece in pieces]
    judgements = [each for each in judgements if each.frames]
    if not judgements:
        raise KeypointError(
            "The animal is nowhere seen well enough for a draft: draw the box in a frame that "
            "shows the whole body from the side."
        )
    judged = _joined(judgements)
    motions = {
        n: motion for _, motion in pieces for n in range(motion.first_frame, motion.last_frame + 1)
    }
    poses = {n: motions[n].pose(n) for n in judged.frames}
    return ClipDraft(body, poses, keypoints, judged.proposals(), judged)


def _judged(
    skeleton: Skeleton, camera: Camera, observed: Observed, motion: Trajectory
) -> JudgedDrafts:
    """How well the drafts of a run agree with the keypoints."""
    p = animal_points(skeleton).at(motion.transforms(skeleton))
    uv = image_points(camera, p)
    size = np.ptp(uv, axis=1).max(axis=1)[:, None]
    away = np.where(observed.known, np.linalg.norm(uv - observed.uv, axis=-1) / size, np.nan)
    good = observed.usable & (p[..., 2].min(axis=1) > NEAREST_M)
    good[good] &= np.nanmedian(away[good], axis=1) < POOR
    rows = np.flatnonzero(good)
    legs = [list(columns) for _, columns in LEGS]
    residual = np.stack([np.nan_to_num(away[:, leg]).mean(axis=1) for leg in legs], axis=1)
    hidden = np.stack([1 - observed.visibility[:, leg].min(axis=1) for leg in legs], axis=1)
    numbers = tuple((rows + motion.first_frame).tolist())
    begins: Reason = "person" if observed.jumped[0] else "start"
    length = np.linalg.norm(p[0, 3] - p[0, 4])
    return JudgedDrafts(
        frames=numbers,
        stretches=(FrameRange(numbers[0], numbers[-1], begins),) if numbers else (),
        parts=tuple(part for part, _ in LEGS),
        residual=residual[rows],
        hidden=hidden[rows],
        flips=np.zeros((len(rows), len(LEGS))),
        joints=(p[rows] - p[rows].mean(axis=1, keepdims=True)) / length,
        flipped=np.zeros((len(rows), len(LEGS)), np.bool_),
    )


def _joined(judgements: Sequence[JudgedDrafts]) -> JudgedDrafts:
    return JudgedDrafts(
        frames=tuple(n for each in judgements for n in each.frames),
        stretches=tuple(stretch for each in judgements for stretch in each.stretches),
        parts=judgements[0].parts,
        residual=np.concatenate([each.residual for each in judgements]),
        hidden=np.concatenate([each.hidden for each in judgements]),
        flips=np.concatenate([each.flips for each in judgements]),
        joints=np.concatenate([each.joints for each in judgements]),
        flipped=np.concatenate([each.flipped for each in judgements]),
    )
