"""How well every draft agrees with its keypoints, and what may be wrong with it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tracker.body.skeleton import Skeleton
from tracker.body.trajectory import Trajectory
from tracker.fitting.draft.flips import flip_odds
from tracker.fitting.draft.limbs import Joints
from tracker.fitting.draft.observed import Observed
from tracker.fitting.draft.proposals import Proposal, Reason, proposed
from tracker.geometry.camera import Camera
from tracker.geometry.rotations import Array
from tracker.solver.posed import image_points
from tracker.tracking.cues.anchors import height_px

POOR = 0.10
"""A pose whose joints miss their keypoints by this share of the body's height in the median is no
draft."""
NEAREST_M = 0.06
"""Every joint of a draft lies so far before the camera."""
JUMP = 0.25
"""Of the body's height: a person moves less from frame to frame."""


@dataclass(frozen=True, eq=False)
class Judged:
    """F frames with a draft, and four limbs, left arm first, then right arm and both legs.

    frames (F,): of the video, ascending.  ends: first and last of every stretch.
    parts: the upper part of each limb.
    residual (F, 4): mean distance of a limb's joints from their keypoints, as a share of the
    body's height.  hidden (F, 4): 1 less the visibility.  flips (F, 4): odds that it points the
    other way, toward the camera or away, from 0 to 1.  jump (F, 1): of the body's middle from the
    frame before beyond what it moved before, as a share of its height, over JUMP.
    """

    frames: tuple[int, ...]
    ends: tuple[tuple[int, int], ...]
    parts: tuple[str, ...]
    residual: Array
    hidden: Array
    flips: Array
    jump: Array

    def proposals(self) -> tuple[Proposal, ...]:
        """The drafts to confirm."""
        doubts: dict[Reason, Array] = {
            "residual": self.residual, "hidden": self.hidden, "flip": self.flips,
            "person": np.repeat(self.jump, len(self.parts), axis=1),
        }  # fmt: skip
        return proposed(list(self.frames), list(self.ends), doubts, self.parts)


def judged(skeleton: Skeleton, camera: Camera, pieces: list[tuple[Observed, Trajectory]]) -> Judged:
    """Of stretches of frames with their motions; camera without distortion."""
    joints = Joints.of(skeleton)
    names = tuple(skeleton.body.names[limb.upper.part] for limb in joints.limbs)
    found = [_piece(joints, camera, seen, motion) for seen, motion in pieces]
    found = [piece for piece in found if piece.frames]
    return Judged(
        tuple(frame for piece in found for frame in piece.frames),
        tuple(end for piece in found for end in piece.ends),
        names,
        *(
            np.concatenate([getattr(piece, name) for piece in found]) if found else np.zeros((0, k))
            for name, k in (("residual", 4), ("hidden", 4), ("flips", 4), ("jump", 1))
        ),
    )


def _piece(joints: Joints, camera: Camera, seen: Observed, motion: Trajectory) -> Judged:
    skeleton = joints.skeleton
    Ts = motion.transforms(skeleton)
    uv = image_points(camera, joints.points.at(Ts))
    frames = range(motion.first_frame, motion.last_frame + 1)
    heights = np.array([height_px(skeleton, camera, motion.pose(frame)) for frame in frames])
    away = np.linalg.norm(uv - seen.uv, axis=-1) / heights[:, None]
    away = np.where(seen.known, away, np.nan)
    good = seen.usable & (Ts[:, :, 2, 3].min(axis=1) > NEAREST_M)
    good[good] &= np.nanmedian(away[good], axis=1) < POOR
    rows = np.flatnonzero(good)
    limbs = [[limb.upper.near, limb.upper.far, limb.lower.far] for limb in joints.limbs]
    own = np.stack([_mean(away[:, limb]) for limb in limbs], axis=1)
    hidden = np.stack([1 - seen.visibility[:, limb].min(axis=1) for limb in limbs], axis=1)
    flips = flip_odds(joints, camera, seen, motion)
    jump = _jumps(seen, heights)
    numbers = tuple((rows + motion.first_frame).tolist())
    ends = ((numbers[0], numbers[-1]),) if numbers else ()
    return Judged(numbers, ends, (), own[rows], hidden[rows], flips[rows], jump[rows, None])


def _mean(away: Array) -> Array:
    known = np.isfinite(away)
    return np.asarray(np.where(known, away, 0.0).sum(-1) / np.maximum(known.sum(-1), 1))


def _jumps(seen: Observed, heights: Array) -> Array:
    """(N,) of the body's middle, over what is likely."""
    known = np.maximum(seen.known.sum(1), 1)[:, None]
    middle = np.where(seen.known[..., None], seen.uv, 0.0).sum(1) / known
    out = np.zeros(len(seen))
    both = seen.usable[1:] & seen.usable[:-1]
    step = np.linalg.norm(np.diff(middle, axis=0), axis=-1) / heights[1:]
    out[1:] = np.where(both, step / JUMP, 0.0)
    return out
