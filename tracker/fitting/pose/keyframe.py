"""Refine a roughly posed keyframe on its picture, by texture, outline and detected joints.

It finds joints of any pose, but puts them a little elsewhere than a person does. So a pose is moved
by it only where it falls clearly: a right pose, whose joints are off by no more than the detector's
own error, stays.

A person poses to about 3° at a joint and 1.5 cm at the hips. What the picture shows better than
that is moved; what it does not show, such as a hidden limb or depth, stays as it was posed. The
result is a suggestion, which can be undone.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.pose import Pose, moved
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.fitting.pose.inputs import (
    FitInputs,
    align_textures,
    fit_to_outlines,
    keyframes_near,
    textures_near,
)
from keypose.tracker.fitting.pose.messages import Moves, describe_moves
from keypose.tracker.fitting.pose.outline import Outline, gain
from keypose.tracker.fitting.pose.refinement import (
    PosedKeyframe,
    RefinedPose,
    decided_share,
    refine,
)
from keypose.tracker.fitting.pose.texture import Texture, TextureMatch, visible_points
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.geometry.steady import SteadyCamera
from keypose.tracker.session.settings import IgnoreMask
from keypose.tracker.solver.least_squares import EXACT, least_squares
from keypose.tracker.solver.one_pose import OnePose
from keypose.tracker.solver.pose_terms import PointsInPicture
from keypose.tracker.solver.posed import Posed
from keypose.tracker.solver.robust import Cauchy
from keypose.tracker.solver.terms import Term
from keypose.tracker.tracking.cues.anchors import frame_anchors
from keypose.tracker.tracking.cues.sources import FrameSource
from keypose.tracker.tracking.pool import never
from keypose.tracker.video import Video
from keypose.tracker.video.pyramid import IGNORED


@dataclass(frozen=True, eq=False)
class Joints:
    """Joints of one keyframe as a detector sees them, and the most likely pose by them alone."""

    keyframe: PosedKeyframe
    term: PointsInPicture
    likely: Pose

    @classmethod
    def of(
        cls, inputs: FitInputs, source: FrameSource | None, near: Mapping[int, Pose]
    ) -> Joints | None:
        """None where there is no detector, or it sees somebody else.

        near: keyframes beside it, which show where on a part the detector puts a joint.
        """
        if source is None:
            return None
        scene, keyframe = inputs.scene, inputs.keyframe
        detected = source.at(inputs.frame, scene.skeleton, keyframe.pose)
        if detected is None:
            return None
        keyed = [
            (pose, keypoints)
            for frame, pose in near.items()
            if (keypoints := source.at(frame, scene.skeleton, pose)) is not None
        ]
        camera = inputs.loader.camera
        term = frame_anchors(scene, camera, detected, keyframe.pose, keyed, Cauchy())
        if term is None:
            return None
        terms: list[Term] = [term, keyframe.prior, keyframe.joint_limits]
        solution = least_squares(OnePose(scene.skeleton, terms), keyframe.pose, EXACT)
        return cls(keyframe, term, solution.state)

    def gain(self, pose: Pose) -> float:
        """By how much likelier a pose is than the one as set, nats."""
        before, after = (
            Posed.of(self.keyframe.scene.skeleton, each) for each in (self.keyframe.pose, pose)
        )
        return self.term.cost(before) - self.term.cost(after) - self.keyframe.prior.cost(after)


Way = Literal["joints", "neighbours", "outline", "nothing"]
CANCELLED = "Cancelled. Pose unchanged."
NOTHING_BETTER = "No better fit found. Pose unchanged."

OTHER_STARTS = 4
"""Poses about the one as set from which the search starts as well."""
START_SHARE = 0.8
AGREEING = 0.6
"""Share of the difference to neighbouring keyframes below which they are as exact as can be."""
BETTER_TIDIED = 0.9
OTHER_OUTLINE = 0.06
"""What must be gained for neighbouring keyframes to be taken otherwise than they were posed: share
of the difference that may remain, or nats for each pixel of the outline."""
BETTER_MATCH = 0.9
BETTER_OUTLINE = 0.02
"""What must be gained for a pose to be moved: share of the difference to the neighbours that may
remain, and nats for each pixel of the outline."""
CLEARLY = 16.0
CLEARLY_ALONE = 10.0
OUTLINE_PIXELS = 100.0
"""What a pose must gain on joints, less what it strays from the one as set, with what its outline
gains, or without one, to be moved by them: nats. The outline counts as so many pixels, since those
side by side err alike. Poses that were right gain up to 14, those off by 3° 18 and more, mostly."""
PRIOR_SHARE = 0.03
"""What one σ² of distance from the pose as set costs when poses are chosen by texture."""
HIDDEN = 0.06
"""Share of a part's surface, all sides, that must be seen; half of it is the most there is."""


@dataclass(frozen=True, eq=False)
class PictureFit:
    """A pose as the picture shows it.

    moved_px: (P,) how far each part moved in the picture, pixels of the video.
    decided: (P,) share of a part's pose that the picture decided, 0 (all as posed) to 1.
    way: what decided: a detector of joints, frames beside it, the body's outline, or nothing (the
    pose is unchanged).
    message: one or two sentences for a person.
    """

    pose: Pose
    moved_px: Array
    decided: Array
    way: Way
    message: str


def fit_pose_to_picture(
    video: Video,
    camera: Camera,
    skeleton: Skeleton,
    frame: int,
    pose: Pose,
    keyposes: Mapping[int, Pose],
    tracked: Mapping[int, Pose],
    masks: Sequence[IgnoreMask] = (),
    cancelled: Callable[[], bool] = never,
    source: FrameSource | None = None,
    steady: SteadyCamera | None = None,
) -> PictureFit:
    """The pose of `frame` fitted to what the picture shows.

    keyposes: the other keyframes; tracked: tracked poses of frames near, maybe none; source: of
    keypoints, where the body is a person's; steady: the camera at one focal length, of one that
    zooms, as which the source sees. The pose is unchanged, and the message says why, where nothing
    decides it or where it is cancelled.
    """
    unchanged = _unchanged(skeleton, pose)
    if not skeleton.dof_count:
        return unchanged("No motion of this body is tracked. Pose unchanged.")
    inputs = FitInputs.of(video, camera, skeleton, frame, pose, masks, steady)
    if not (inputs.pictures[0][..., 3] != IGNORED).any():
        return unchanged("Nothing of this frame may be used. Pose unchanged.")
    near = keyframes_near(inputs, keyposes)
    outline, joints = inputs.outline(), Joints.of(inputs, source, near)
    if joints is not None:
        by_joints = _clear_by_joints(inputs, outline, joints, cancelled)
        if cancelled():
            return unchanged(CANCELLED)
        if by_joints is None:
            return unchanged(NOTHING_BETTER)
        return _as_fitted(inputs, by_joints, "joints")
    candidate = _best_candidate(inputs, outline, near, tracked, cancelled)
    if cancelled():
        return unchanged(CANCELLED)
    if candidate is None:
        return unchanged(
            "No other keyframe is near, and the body’s colours are too close to the background’s. "
            "Pose unchanged."
        )
    if not _is_better(inputs, candidate.match, outline, candidate.refined.pose):
        return unchanged(NOTHING_BETTER)
    return _as_fitted(
        inputs, candidate.refined, "outline" if candidate.match is None else "neighbours"
    )


@dataclass(frozen=True, eq=False)
class _Candidate:
    """A refined pose, the texture match it was refined by, and its cost."""

    refined: RefinedPose
    match: TextureMatch | None
    cost: float


def _clear_by_joints(
    inputs: FitInputs, outline: Outline | None, joints: Joints, cancelled: Callable[[], bool]
) -> RefinedPose | None:
    """The pose by joints, which are found from afar, refined by the outline; None where they do not
    clearly speak against the pose as set.

    A detector misses right poses nearly as far as rough ones. Their outlines tell these apart.
    """
    refined = refine(
        inputs.keyframe, joints.likely, None, outline, cancelled, coarsest=1, joints=joints.term
    )
    gained = joints.gain(joints.likely)
    if outline is None:
        return refined if gained > CLEARLY_ALONE else None
    gained += OUTLINE_PIXELS * gain(outline, inputs.keyframe.pose, refined.pose)
    return refined if gained > CLEARLY else None


def _best_candidate(
    inputs: FitInputs,
    outline: Outline | None,
    near: Mapping[int, Pose],
    tracked: Mapping[int, Pose],
    cancelled: Callable[[], bool],
) -> _Candidate | None:
    """The best pose; None without textures and outline.

    The keyframes near were posed by eye too. Where this frame does not agree with them as they
    are, each is fitted to its own outline first, then they and this frame to one another once;
    that counts where this frame then fits them clearly better.
    """
    keyframe, outlined = inputs.keyframe, None
    if outline is not None:
        outlined = refine(keyframe, keyframe.pose, None, outline, cancelled)
    textures = textures_near(inputs, near, tracked)
    if not textures:
        return None if outlined is None else _Candidate(outlined, None, 0.0)
    as_posed = _fit_from_starts(inputs, outline, outlined, textures, tracked, cancelled)
    if outline is None or outlined is None or not near:
        return as_posed
    if _agree(inputs, outline, outlined, as_posed):
        return as_posed
    tidy = fit_to_outlines(inputs, near, cancelled)
    textures = textures_near(inputs, tidy, tracked)
    tidied = _fit_from_starts(inputs, outline, outlined, textures, tracked, cancelled)
    drawn_better = gain(outline, as_posed.refined.pose, tidied.refined.pose) > OTHER_OUTLINE
    if tidied.cost > (1.0 if drawn_better else BETTER_TIDIED) * as_posed.cost:
        return as_posed
    tidy = align_textures(inputs, near, tidy, tidied.refined.pose, cancelled)
    match = TextureMatch(inputs.scene, inputs.pictures, textures_near(inputs, tidy, tracked))
    refined = refine(keyframe, tidied.refined.pose, match, outline, cancelled, coarsest=0)
    return _Candidate(refined, match, _cost(inputs, match, refined.pose))


def _agree(
    inputs: FitInputs, outline: Outline, outlined: RefinedPose, as_posed: _Candidate
) -> bool:
    """Whether a pose fits the frames beside it so well that their poses are beyond doubt,
    and the outline agrees.
    """
    if as_posed.cost > AGREEING * _cost(inputs, as_posed.match, inputs.keyframe.pose):
        return False
    return gain(outline, as_posed.refined.pose, outlined.pose) < OTHER_OUTLINE


def _fit_from_starts(
    inputs: FitInputs,
    outline: Outline | None,
    outlined: RefinedPose | None,
    textures: Sequence[Texture],
    tracked: Mapping[int, Pose],
    cancelled: Callable[[], bool],
) -> _Candidate:
    """The best pose on these textures and the outline.

    Textures have many wrong places close by: the search begins at several.
    """
    match = TextureMatch(inputs.scene, inputs.pictures, textures)
    starts = _start_poses(inputs, tracked) + ([] if outlined is None else [outlined.pose])
    alone = [refine(inputs.keyframe, start, match, None, cancelled).pose for start in starts]
    starts = [min(alone, key=lambda pose: _cost(inputs, match, pose))]
    starts += [] if outlined is None else [outlined.pose]
    refined_poses = [
        refine(inputs.keyframe, s, match, outline, cancelled, coarsest=1) for s in starts
    ]
    costs = [_cost(inputs, match, refined.pose) for refined in refined_poses]
    least = int(np.argmin(costs))
    return _Candidate(refined_poses[least], match, costs[least])


def _start_poses(inputs: FitInputs, tracked: Mapping[int, Pose]) -> list[Pose]:
    """The pose as set, the tracked one, as far as its motions are tracked, and some random ones."""
    keyframe, skeleton = inputs.keyframe, inputs.scene.skeleton
    rng = np.random.default_rng(inputs.frame)
    motions = [keyframe.away(tracked[inputs.frame])] if inputs.frame in tracked else []
    spread = START_SHARE * keyframe.precision**-0.5
    motions += [rng.normal(0.0, 1.0, len(spread)) * spread for _ in range(OTHER_STARTS)]
    return [keyframe.pose, *(moved(skeleton, keyframe.pose, motion) for motion in motions)]


def _cost(inputs: FitInputs, match: TextureMatch | None, pose: Pose) -> float:
    """The cost by which one of several refined poses is chosen; lower is better."""
    away = inputs.keyframe.away(pose) ** 2 @ inputs.keyframe.precision
    if match is None:
        return float(away)
    match.update_visibility(inputs.keyframe.pose)
    return match.score(pose) * (1.0 + PRIOR_SHARE * float(away) / len(inputs.keyframe.precision))


def _is_better(
    inputs: FitInputs,
    match: TextureMatch | None,
    outline: Outline | None,
    pose: Pose,
) -> bool:
    """Whether a pose fits the picture clearly better than the one as set, on the same
    pixels.
    """
    if match is not None:
        match.update_visibility(inputs.keyframe.pose)
        before, after = (match.score(p) for p in (inputs.keyframe.pose, pose))
        if after < BETTER_MATCH * before:
            return True
        if after > before:
            return False
    return outline is not None and gain(outline, inputs.keyframe.pose, pose) > BETTER_OUTLINE


def _as_fitted(inputs: FitInputs, refined: RefinedPose, fit_way: Way) -> PictureFit:
    skeleton, posed = inputs.scene.skeleton, inputs.keyframe.pose
    share = decided_share(inputs.keyframe, refined)
    turned = np.where(share[:, None, None] > 0, refined.pose.Rs_parent_part, posed.Rs_parent_part)
    pose = Pose(turned, refined.pose.p_camera_root)  # what is not decided stays to the last digit
    moved_px = _moved_px(inputs, pose)
    tracked = np.isin(np.arange(skeleton.part_count), skeleton.dof_part)
    moves = Moves(skeleton.body.names, moved_px, share, tracked, _hidden_parts(inputs, pose))
    return PictureFit(pose, moved_px, share, fit_way, describe_moves(moves))


def _moved_px(inputs: FitInputs, pose: Pose) -> Array:
    """(P,) mean distance by which the marks of each part moved, pixels of the video."""
    scene = inputs.scene
    poses = (inputs.keyframe.pose, pose)
    both = Trajectory(
        inputs.frame,
        np.stack([p.Rs_parent_part for p in poses]),
        np.stack([p.p_camera_root for p in poses]),
    )
    before, after = scene.mark_pixels(both)
    px = np.nan_to_num(np.linalg.norm(after - before, axis=-1))
    parts, size = scene.marks[1], scene.skeleton.part_count
    total = np.bincount(parts, weights=px, minlength=size)
    mean = total / np.bincount(parts, minlength=size)
    steady = inputs.loader.steady
    zoom = 1.0 if steady is None else float(steady.zoom[inputs.frame])
    return np.asarray(mean * zoom * 2.0**inputs.loader.size.halvings)


def _hidden_parts(inputs: FitInputs, pose: Pose) -> NDArray[np.bool_]:
    """(P,) parts of which the pose shows hardly anything."""
    height, width = inputs.pictures[0].shape[:2]
    visible = visible_points(inputs.scene, (height, width), pose)[0]
    starts = inputs.scene.points.starts
    shown = np.add.reduceat(visible.astype(np.int64), starts[:-1])
    return np.asarray(shown < HIDDEN * np.diff(starts))


def _unchanged(skeleton: Skeleton, pose: Pose) -> Callable[[str], PictureFit]:
    nothing = np.zeros(skeleton.part_count)
    return lambda message: PictureFit(pose, nothing, nothing, "nothing", message)
