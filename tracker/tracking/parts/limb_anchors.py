"""The keypoints of a limb that was set right, as anchors between two frames at which it is known.

Where on its part a detector puts a joint the keyframes of the whole segment show alone. What it
misses the joint by beside that changes slowly from frame to frame: where a limb was set right this
is known, so near by it is taken off the keypoints, and keypoints that are elsewhere count for
little there. Far from there nothing of the limb is known that was not known before.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.posed import image_points
from keypose.tracker.solver.robust import Cauchy
from keypose.tracker.tracking.cues.anchors import Anchors
from keypose.tracker.tracking.parts.limb_segment import LimbSegment, other_side
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.tracking.segment import Segment

SIDES_MARGIN = 4.0
"""By how much more a frame's keypoints are contradicted, as a loss, to be taken for those of the
other side: as of one that lies two standard deviations off."""
FADES = 5.0
"""Frames over which what keypoints miss falls to 1/e."""
ELSEWHERE = 0.08
"""A keypoint farther than this share of the body's height from where the joint was set shows
something else."""


def limb_anchors(
    candidates: Sequence[Anchors], segment: LimbSegment, whole: Segment, scene: Scene
) -> Anchors:
    """The anchors of a limb's segment.

    candidates: those of the whole segment, which take left and right differently.
    """
    first = segment.first_frame - whole.first_frame
    rows = slice(first, first + len(segment.given))
    anchors = resolve_sides([each.of_rows(rows) for each in candidates], segment, scene)
    set_right = [frame - segment.first_frame for frame in segment.set_right(whole)]
    return _missing_as_near(anchors, segment, scene, set_right)


def _missing_as_near(
    anchors: Anchors, segment: LimbSegment, scene: Scene, set_right: Sequence[int]
) -> Anchors:
    """Without what the limb's keypoints miss it by at the rows where it was set right, fading from
    there."""
    p = anchors.where(segment.given.transforms(scene.skeleton))
    miss = (anchors.uv - image_points(scene.camera, p))[set_right]
    deeper = (anchors.depth - (p[..., 2] - segment.given.ps_camera_root[:, None, 2]))[set_right]
    own = np.isin(anchors.parts, segment.parts) & (anchors.scale[set_right] > 0)
    away = np.linalg.norm(miss, axis=-1) > ELSEWHERE * anchors.height_px
    near = _alike(np.arange(len(anchors.uv)), set_right)
    doubt = (near[:, :, None] * (own & away)).max(axis=1)
    share = np.linalg.solve(_alike(set_right, set_right), near.T)  # exact at each
    miss = np.where((own & ~away)[..., None], miss, 0.0)
    detected = (anchors.scale > 0)[..., None]
    return replace(
        anchors,
        uv=anchors.uv - detected * np.einsum("rn,rkc->nkc", share, miss),
        scale=anchors.scale * (1 - doubt),
        depth=anchors.depth - share.T @ (own * deeper),
    )


def _alike(rows: Sequence[int] | NDArray[np.int64], others: Sequence[int]) -> Array:
    """(N, R) correlation of what keypoints miss at rows and at others: a Markov process."""
    return np.asarray(np.exp(-np.abs(np.subtract.outer(rows, others)) / FADES))


def resolve_sides(candidates: Sequence[Anchors], segment: LimbSegment, scene: Scene) -> Anchors:
    """Of anchors that take left and right differently those that the rest of the body contradicts
    least; in frames where the limb of the other side contradicts them, the others: what is seen
    where that one was tracked is not this one."""
    against = np.stack([_contradiction(each, segment, scene) for each in candidates])  # (A, N, K)
    parts = candidates[0].parts
    rest = against[..., ~np.isin(parts, segment.parts)].sum(axis=(1, 2))
    best, *others = np.argsort(rest, kind="stable").tolist()
    chosen: Anchors = candidates[best]
    beside = np.isin(parts, other_side(scene.skeleton, segment.parts))
    for k in others:
        lacks = (against[best] - against[k])[:, beside].sum(axis=-1)
        chosen = chosen.in_rows(lacks > SIDES_MARGIN, candidates[k])
    return chosen


def _contradiction(anchors: Anchors, segment: LimbSegment, scene: Scene) -> Array:
    """(N, K) how far keypoints lie from where the body was tracked."""
    seen = image_points(scene.camera, anchors.where(segment.given.transforms(scene.skeleton)))
    return Cauchy().loss(np.linalg.norm(seen - anchors.uv, axis=-1) * anchors.scale)
