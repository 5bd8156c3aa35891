"""How well every draft agrees with its keypoints, and what may be wrong with it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.fitting.draft.flips import flip_doubts
from keypose.tracker.fitting.draft.limbs import Joints
from keypose.tracker.fitting.draft.observed import Observed
from keypose.tracker.fitting.draft.proposals import Proposal, Stretch, proposed
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import JOINTS
from keypose.tracker.session.annotations import Reason
from keypose.tracker.solver.posed import image_points
from keypose.tracker.tracking.cues.anchors import height_px

POOR = 0.06
"""A pose whose joints miss their keypoints by this share of the body's height in the median is no
draft."""
NEAREST_M = 0.06
"""Every joint of a draft lies so far before the camera."""


@dataclass(frozen=True, eq=False)
class Judged:
    """F frames with a draft, and four limbs, left arm first, then right arm and both legs.

    frames (F,): of the video, ascending.  stretches: of frames that show one person.
    parts: the upper part of each limb.
    residual (F, 4): mean distance of a limb's joints from their keypoints, as a share of the
    body's height.  hidden (F, 4): 1 less the visibility of its worst joint.
    flips (F, 4): doubt that it points the right way, toward the camera or away, from 0 to 1.
    """

    frames: tuple[int, ...]
    stretches: tuple[Stretch, ...]
    parts: tuple[str, ...]
    residual: Array
    hidden: Array
    flips: Array

    def proposals(self) -> tuple[Proposal, ...]:
        """The drafts to confirm."""
        doubts: dict[Reason, Array] = {
            "residual": self.residual, "hidden": self.hidden, "flip": self.flips
        }  # fmt: skip
        return proposed(list(self.frames), self.stretches, doubts, self.parts)


class Piece(NamedTuple):
    """A stretch of N frames with its poses.

    depth_m (N, 12): how much farther than the root the network sees each joint.
    """

    seen: Observed
    motion: Trajectory
    depth_m: Array


def judged(skeleton: Skeleton, camera: Camera, pieces: Sequence[Piece]) -> Judged:
    """Of stretches of frames with their motions; camera without distortion."""
    joints = Joints.of(skeleton)
    names = tuple(skeleton.body.names[limb.upper.part] for limb in joints.limbs)
    found = [_piece(joints, camera, piece) for piece in pieces]
    found = [piece for piece in found if piece.frames]
    return Judged(
        tuple(frame for piece in found for frame in piece.frames),
        tuple(stretch for piece in found for stretch in piece.stretches),
        names,
        *(
            np.concatenate([np.zeros((0, 4)), *(getattr(piece, name) for piece in found)])
            for name in ("residual", "hidden", "flips")
        ),
    )


def _piece(joints: Joints, camera: Camera, piece: Piece) -> Judged:
    skeleton, (seen, motion, depth_m) = joints.skeleton, piece
    Ts = motion.transforms(skeleton)
    uv = image_points(camera, joints.seen.at(Ts))
    frames = range(motion.first_frame, motion.last_frame + 1)
    heights = np.array([height_px(skeleton, camera, motion.pose(frame)) for frame in frames])
    joint = slice(len(JOINTS))
    away = np.linalg.norm(uv - seen.uv[:, joint], axis=-1) / heights[:, None]
    away = np.where(seen.known[:, joint], away, np.nan)
    good = seen.usable & (Ts[:, :, 2, 3].min(axis=1) > NEAREST_M)
    good[good] &= np.nanmedian(away[good], axis=1) < POOR
    rows = np.flatnonzero(good)
    limbs = [[limb.upper.near, limb.upper.far, limb.lower.far] for limb in joints.limbs]
    own = np.stack([_mean(away[:, limb]) for limb in limbs], axis=1)
    hidden = np.stack([1 - seen.visibility[:, limb].min(axis=1) for limb in limbs], axis=1)
    flips = flip_doubts(joints, camera, depth_m, motion)
    numbers = tuple((rows + motion.first_frame).tolist())
    begins: Reason = "person" if seen.jumped[0] else "start"
    whole = (Stretch(numbers[0], numbers[-1], begins),) if numbers else ()
    return Judged(numbers, whole, (), own[rows], hidden[rows], flips[rows])


def _mean(away: Array) -> Array:
    known = np.isfinite(away)
    return np.asarray(np.where(known, away, 0.0).sum(-1) / np.maximum(known.sum(-1), 1))
