"""A roughly posed keyframe improved from the picture itself.

A person poses to about 3° at a joint and 1.5 cm at the hips. What the picture shows better than
that is moved; what it cannot tell, such as a hidden limb or depth, stays as it was posed. It is a
suggestion: whoever asks for it can take it back.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from tracker.body.pose import Pose, moved
from tracker.body.skeleton import Skeleton
from tracker.body.trajectory import Trajectory
from tracker.fitting.pose.inputs import (
    FitInputs,
    align_textures,
    fit_to_outlines,
    keyframes_near,
    textures_near,
)
from tracker.fitting.pose.likeness import Likeness, Texture, visible_points
from tracker.fitting.pose.outline import Outline, gain
from tracker.fitting.pose.settling import Settled, decided_share, settle
from tracker.fitting.pose.words import Moves, describe_moves
from tracker.geometry.camera import Camera
from tracker.geometry.rotations import Array
from tracker.session.settings import IgnoreMask
from tracker.tracking.pool import never
from tracker.video import Video
from tracker.video.pyramid import IGNORED

Way = Literal["neighbours", "outline", "nothing"]

OTHER_STARTS = 4
"""Poses about the hand's from which the search is begun as well."""
START_SHARE = 0.8
AGREEING = 0.6
"""Share of the difference to neighbouring keyframes below which they are as exact as can be."""
BETTER_TIDIED, OTHER_OUTLINE = 0.9, 0.06
"""What must be gained for neighbouring keyframes to be taken otherwise than they were posed: share
of the difference that may remain, or nats for each pixel of the outline."""
BETTER_LIKENESS, BETTER_OUTLINE = 0.9, 0.02
"""What must be gained for a pose to be moved: share of the difference to the neighbours that may
remain, and nats for each pixel of the outline."""
PRIOR_SHARE = 0.03
"""What one σ² of distance from the hand costs when poses are chosen by likeness."""
HIDDEN = 0.06
"""Share of a part's surface, all sides, that must be seen; half of it is the most there is."""


@dataclass(frozen=True, eq=False)
class Fitted:
    """A pose as the picture shows it.

    moved_px: (P,) how far each part moved in the picture, pixels of the video.
    decided: (P,) share of a part's pose that the picture decided, 0 (all as posed) to 1.
    way: what decided: frames beside it, the body's outline, or nothing (the pose is unchanged).
    words: one or two sentences for a person.
    """

    pose: Pose
    moved_px: Array
    decided: Array
    way: Way
    words: str


def fit_here(
    video: Video,
    camera: Camera,
    skeleton: Skeleton,
    frame: int,
    pose: Pose,
    keyposes: Mapping[int, Pose],
    tracked: Mapping[int, Pose],
    masks: Sequence[IgnoreMask] = (),
    cancelled: Callable[[], bool] = never,
) -> Fitted:
    """The pose of `frame` laid onto what the picture shows.

    keyposes: the other keyframes; tracked: tracked poses of frames near, maybe none. The pose comes
    back unchanged, with words saying why, where nothing tells or where it is cancelled.
    """
    unchanged = _unchanged(skeleton, pose)
    if not skeleton.dof_count:
        return unchanged("No motion of this body is tracked: the pose is unchanged.")
    inputs = FitInputs.of(video, camera, skeleton, frame, pose, masks)
    if not (inputs.pictures[0][..., 3] != IGNORED).any():
        return unchanged("Nothing of this frame may be used: the pose is unchanged.")
    outline = inputs.outline()
    found = _found(inputs, outline, keyframes_near(inputs, keyposes), tracked, cancelled)
    if cancelled():
        return unchanged("Stopped: the pose is unchanged.")
    if found is None:
        return unchanged(
            "No other keyframe is near, and colour does not part the body from what is behind it: "
            "the pose is unchanged."
        )
    if not _is_better(inputs, found.likeness, outline, found.settled.pose):
        return unchanged("The picture shows nothing that fits better: the pose is unchanged.")
    return _fitted(inputs, found.settled, "outline" if found.likeness is None else "neighbours")


@dataclass(frozen=True, eq=False)
class _Found:
    """A settled pose, the textures it was settled on, and what it costs to believe it."""

    settled: Settled
    likeness: Likeness | None
    cost: float


def _found(
    inputs: FitInputs,
    outline: Outline | None,
    near: Mapping[int, Pose],
    tracked: Mapping[int, Pose],
    cancelled: Callable[[], bool],
) -> _Found | None:
    """The best pose; None where nothing tells.

    The keyframes near were posed by hand too. Where this frame does not agree with them as they
    are, each is laid into its own outline first, then they and this frame are settled on one
    another once; that counts where this frame then fits them clearly better.
    """
    outlined = (
        None if outline is None else settle(inputs.hand, inputs.hand.pose, None, outline, cancelled)
    )
    textures = textures_near(inputs, near, tracked)
    if not textures:
        return None if outlined is None else _Found(outlined, None, 0.0)
    given = _on(inputs, outline, outlined, textures, tracked, cancelled)
    if outline is None or outlined is None or not near or _agree(inputs, outline, outlined, given):
        return given
    tidy = fit_to_outlines(inputs, near, cancelled)
    tidied = _on(
        inputs, outline, outlined, textures_near(inputs, tidy, tracked), tracked, cancelled
    )
    drawn_better = gain(outline, given.settled.pose, tidied.settled.pose) > OTHER_OUTLINE
    if tidied.cost > (1.0 if drawn_better else BETTER_TIDIED) * given.cost:
        return given
    tidy = align_textures(inputs, near, tidy, tidied.settled.pose, cancelled)
    likeness = Likeness(inputs.scene, inputs.pictures, textures_near(inputs, tidy, tracked))
    settled = settle(inputs.hand, tidied.settled.pose, likeness, outline, cancelled, coarsest=0)
    return _Found(settled, likeness, _cost(inputs, likeness, settled.pose))


def _agree(inputs: FitInputs, outline: Outline, outlined: Settled, given: _Found) -> bool:
    """Whether a pose fits the frames beside it so well that their poses are beyond doubt, and the
    outline does not gainsay it."""
    if given.cost > AGREEING * _cost(inputs, given.likeness, inputs.hand.pose):
        return False
    return gain(outline, given.settled.pose, outlined.pose) < OTHER_OUTLINE


def _on(
    inputs: FitInputs,
    outline: Outline | None,
    outlined: Settled | None,
    textures: Sequence[Texture],
    tracked: Mapping[int, Pose],
    cancelled: Callable[[], bool],
) -> _Found:
    """The best pose on these textures and the outline.

    Textures have many wrong places close by: the search begins at several.
    """
    likeness = Likeness(inputs.scene, inputs.pictures, textures)
    starts = _starts(inputs, tracked) + ([] if outlined is None else [outlined.pose])
    alone = [settle(inputs.hand, start, likeness, None, cancelled).pose for start in starts]
    starts = [min(alone, key=lambda pose: _cost(inputs, likeness, pose))]
    starts += [] if outlined is None else [outlined.pose]
    found = [settle(inputs.hand, s, likeness, outline, cancelled, coarsest=1) for s in starts]
    costs = [_cost(inputs, likeness, settled.pose) for settled in found]
    least = int(np.argmin(costs))
    return _Found(found[least], likeness, costs[least])


def _starts(inputs: FitInputs, tracked: Mapping[int, Pose]) -> list[Pose]:
    """The tracked pose, as far as it may move the hand's, and some poses about the hand's."""
    hand, rng = inputs.hand, np.random.default_rng(inputs.frame)
    motions = [hand.away(tracked[inputs.frame])] if inputs.frame in tracked else []
    spread = START_SHARE * hand.precision**-0.5
    motions += [rng.normal(0.0, 1.0, len(spread)) * spread for _ in range(OTHER_STARTS)]
    return [hand.pose, *(moved(inputs.scene.skeleton, hand.pose, motion) for motion in motions)]


def _cost(inputs: FitInputs, likeness: Likeness | None, pose: Pose) -> float:
    """By which one of several settled poses is chosen; lower is better."""
    away = inputs.hand.away(pose) ** 2 @ inputs.hand.precision
    if likeness is None:
        return float(away)
    likeness.look(inputs.hand.pose)
    return likeness.score(pose) * (1.0 + PRIOR_SHARE * float(away) / len(inputs.hand.precision))


def _is_better(
    inputs: FitInputs, likeness: Likeness | None, outline: Outline | None, pose: Pose
) -> bool:
    """Whether a pose fits the picture clearly better than the hand's, on the same pixels."""
    if likeness is not None:
        likeness.look(inputs.hand.pose)
        before, after = (likeness.score(p) for p in (inputs.hand.pose, pose))
        if after < BETTER_LIKENESS * before:
            return True
        if after > before:
            return False
    if outline is None:
        return False
    return gain(outline, inputs.hand.pose, pose) > BETTER_OUTLINE


def _fitted(inputs: FitInputs, settled: Settled, way: Way) -> Fitted:
    skeleton, hand = inputs.scene.skeleton, inputs.hand.pose
    share = decided_share(inputs.hand, settled)
    turned = np.where(share[:, None, None] > 0, settled.pose.Rs_parent_part, hand.Rs_parent_part)
    pose = Pose(turned, settled.pose.p_camera_root)  # what is not told stays to the last digit
    moved_px = _moved_px(inputs, pose)
    tracked = np.isin(np.arange(skeleton.part_count), skeleton.dof_part)
    words = describe_moves(
        Moves(skeleton.body.names, moved_px, share, tracked, _hidden(inputs, pose))
    )
    return Fitted(pose, moved_px, share, way, words)


def _moved_px(inputs: FitInputs, pose: Pose) -> Array:
    """(P,) mean distance in the video's picture that the marks of each part have moved."""
    scene = inputs.scene
    poses = (inputs.hand.pose, pose)
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
    return np.asarray(mean * 2.0**inputs.loader.size.halvings)


def _hidden(inputs: FitInputs, pose: Pose) -> NDArray[np.bool_]:
    """(P,) parts of which the pose shows hardly anything."""
    height, width = inputs.pictures[0].shape[:2]
    seen = visible_points(inputs.scene, (height, width), pose)[0]
    starts = inputs.scene.points.starts
    shown = np.add.reduceat(seen.astype(np.int64), starts[:-1])
    return np.asarray(shown < HIDDEN * np.diff(starts))


def _unchanged(skeleton: Skeleton, pose: Pose) -> Callable[[str], Fitted]:
    nothing = np.zeros(skeleton.part_count)
    return lambda words: Fitted(pose, nothing, nothing, "nothing", words)
