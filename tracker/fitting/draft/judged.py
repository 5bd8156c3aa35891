"""Judge how well every draft agrees with its keypoints, and whether a limb may point the other way.

In the picture both look the same: the far joint of a bone lies on its ray, at either of the two
places as far from the near joint as the bone is long. `depth_signs` decides by the whole stretch;
the network's depths then say how far that is to be believed. A bone is doubted where the
network does not see it point clearly the way it was drafted, over the frames near by in which it
points the same way: a bone that is mirrored stays so until it passes through the picture's plane.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit

from keypose.tracker.body.modify import height
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.fitting.draft.depth_signs import PLANE, tilt
from keypose.tracker.fitting.draft.flips import LimbRun
from keypose.tracker.fitting.draft.observed import SIDES, Bone, Joints, Observed, place_of
from keypose.tracker.fitting.draft.proposals import FrameRange, Proposal, proposed
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import JOINTS
from keypose.tracker.keypoints.on_body import height_px
from keypose.tracker.session.annotations import FlippedDrafts, Reason
from keypose.tracker.solver.projection import image_points

NEAR_FRAMES = 10
"""Before and after a frame, in which a bone that points the same way is asked as well."""
BASE = -1.1
BY_ALONG = -16.3
BY_APART = 10.3
OF_LEG = -3.0
"""Logistic regression of mirrored bones, distances in metres: four cameras around a filmed man
whose joints in space are known, area under the curve 0.91, each camera judged by the other three.
Joint limits, visibility and distances from keypoints add nothing, nor does what the
network finds in turned and larger pictures. Solved for with a bone the other way, of 68 stretches
that were right 29 cost no more, of five that were mirrored four."""
HALF = 0.05
"""Probability at which a limb is doubted by half. On these cameras 75 of the 82 limbs that are
still mirrored are, and of seven limbs that are, one is mirrored."""


def flip_doubts(joints: Joints, camera: Camera, network_m: Array, motion: Trajectory) -> Array:
    """(N, 4) by limb how doubtful it is that it points the right way in depth, from 0 to 1.

    network_m (N, 12): how much farther than the root the network sees each joint of the N frames.
    camera: without distortion.
    """
    p = joints.seen.at(motion.transforms(joints.skeleton))
    doubts = [
        np.maximum(
            _mirrored(joints, limb.upper, camera, p, network_m, is_leg=k > 1),
            _mirrored(joints, limb.lower, camera, p, network_m, is_leg=k > 1),
        )
        for k, limb in enumerate(joints.limbs)
    ]
    mirrored = np.stack(doubts, axis=1)
    return np.asarray(mirrored / (mirrored + HALF))


def _mirrored(
    joints: Joints, bone: Bone, camera: Camera, p: Array, network_m: Array, *, is_leg: bool
) -> Array:
    """(N,) probability that a bone is mirrored; 0 where it is in the picture's plane."""
    length = joints.seen_length_m(bone)
    drafted = tilt(camera, p, bone)
    network = np.clip(network_m[:, bone.far] - network_m[:, bone.near], -length, length)
    along = _near_mean(np.sign(drafted) * network, drafted)
    apart = _near_mean(np.abs(length * drafted - network), drafted)
    odds = BASE + BY_ALONG * along + BY_APART * apart + OF_LEG * is_leg
    return np.where(np.abs(drafted) >= PLANE, expit(odds), 0.0)


def _near_mean(values: Array, drafted: Array) -> Array:
    """(N,) the mean over near frames in which the bone points the same way."""
    out = np.empty(len(values))
    for n, here in enumerate(drafted):
        rows = slice(max(0, n - NEAR_FRAMES), n + NEAR_FRAMES + 1)
        out[n] = values[rows][drafted[rows] * here >= 0].mean()
    return out


POOR = 0.06
"""A pose whose joints miss their keypoints by this share of the body's height in the median is no
draft."""
NEAREST_M = 0.06
"""Every joint of a draft lies so far before the camera."""


@dataclass(frozen=True, eq=False)
class JudgedDrafts:
    """F frames with a draft, and four limbs, left arm first, then right arm and both legs.

    frames (F,): of the video, ascending.  stretches: of frames that show one person.
    parts: the upper part of each limb.
    residual (F, 4): mean distance of a limb's joints from their keypoints, as a share of the
    body's height.  hidden (F, 4): 1 less the visibility of its worst joint.
    flips (F, 4): doubt that it points the right way, toward the camera or away, from 0 to 1.
    joints (F, 12, 3): seen from the middle of the hips, as shares of the body's height.
    flipped (F, 4): limbs that are wrong: they neither lie on their keypoints nor follow from the
    drafts before and after.
    """

    frames: tuple[int, ...]
    stretches: tuple[FrameRange, ...]
    parts: tuple[str, ...]
    residual: Array
    hidden: Array
    flips: Array
    joints: Array
    flipped: NDArray[np.bool_]

    def proposals(self) -> tuple[Proposal, ...]:
        """The drafts to confirm, and one to correct of each run that is known to be wrong."""
        sound = np.flatnonzero(~self.flipped.any(axis=1))
        frames = [self.frames[n] for n in sound]
        doubts: dict[Reason, Array] = {
            "residual": self.residual[sound],
            "hidden": self.hidden[sound],
            "flip": self.flips[sound],
        }
        stretches = [
            sound_part for s in self.stretches if (sound_part := _sound_part(s, frames)) is not None
        ]
        confirmations = proposed(frames, stretches, doubts, self.parts, self.joints[sound])
        return tuple(
            sorted((*confirmations, *self._to_correct()), key=lambda proposal: proposal.frame)
        )

    def _to_correct(self) -> Iterator[Proposal]:
        for run in self.flipped_drafts():
            yield Proposal((run.first_frame + run.last_frame) // 2, "wrong", run.parts)

    def flipped_drafts(self) -> tuple[FlippedDrafts, ...]:
        """Runs of frames in which the same limbs are wrong."""
        out: list[FlippedDrafts] = []
        for frame, wrong in zip(self.frames, self.flipped, strict=True):
            parts = tuple(p for p, is_wrong in zip(self.parts, wrong, strict=True) if is_wrong)
            if not parts:
                continue
            first = frame
            if out and (out[-1].last_frame, out[-1].parts) == (frame - 1, parts):
                first = out.pop().first_frame
            out.append(FlippedDrafts(first_frame=first, last_frame=frame, parts=parts))
        return tuple(out)


def _sound_part(stretch: FrameRange, sound: Sequence[int]) -> FrameRange | None:
    """A stretch from its first to its last frame that is sound; None where none is."""
    inside = [frame for frame in sound if stretch.first <= frame <= stretch.last]
    return FrameRange(inside[0], inside[-1], stretch.begins) if inside else None


class Piece(NamedTuple):
    """A stretch of N frames with its poses.

    depth_m (N, 12): how much farther than the root the network sees each joint.
    flipped: limbs that neither lie on their keypoints nor follow from the poses before and after.
    """

    seen: Observed
    motion: Trajectory
    depth_m: Array
    flipped: tuple[LimbRun, ...] = ()


def judged(skeleton: Skeleton, camera: Camera, pieces: Sequence[Piece]) -> JudgedDrafts:
    """Judge stretches of frames with their motions; camera without distortion."""
    joints = Joints.of(skeleton)
    names = tuple(skeleton.body.names[limb.upper.part] for limb in joints.limbs)
    drafts = [_piece(joints, camera, piece) for piece in pieces]
    drafts = [piece for piece in drafts if piece.frames]
    return JudgedDrafts(
        tuple(frame for piece in drafts for frame in piece.frames),
        tuple(stretch for piece in drafts for stretch in piece.stretches),
        names,
        *(
            np.concatenate(
                [np.zeros((0, *shape), kind), *(getattr(piece, name) for piece in drafts)]
            )
            for name, (shape, kind) in _SHAPES.items()
        ),
    )


_SHAPES: Final = {
    "residual": ((4,), np.float64),
    "hidden": ((4,), np.float64),
    "flips": ((4,), np.float64),
    "joints": ((len(JOINTS), 3), np.float64),
    "flipped": ((4,), np.bool_),
}
"""Of what is known of every frame."""


def _piece(joints: Joints, camera: Camera, piece: Piece) -> JudgedDrafts:
    skeleton, (observed, motion, depth_m, flipped) = joints.skeleton, piece
    Ts = motion.transforms(skeleton)
    p = joints.seen.at(Ts)
    uv = image_points(camera, p)
    frames = range(motion.first_frame, motion.last_frame + 1)
    heights = np.array([height_px(skeleton, camera, motion.pose(frame)) for frame in frames])
    joint = slice(len(JOINTS))
    away = np.linalg.norm(uv - observed.uv[:, joint], axis=-1) / heights[:, None]
    away = np.where(observed.known[:, joint], away, np.nan)
    good = observed.usable & (Ts[:, :, 2, 3].min(axis=1) > NEAREST_M)
    good[good] &= np.nanmedian(away[good], axis=1) < POOR
    rows = np.flatnonzero(good)
    limbs = [[limb.upper.near, limb.upper.far, limb.lower.far] for limb in joints.limbs]
    own = np.stack([_mean(away[:, limb]) for limb in limbs], axis=1)
    hidden = np.stack([1 - observed.visibility[:, limb].min(axis=1) for limb in limbs], axis=1)
    flips = flip_doubts(joints, camera, depth_m, motion)
    numbers = tuple((rows + motion.first_frame).tolist())
    begins: Reason = "person" if observed.jumped[0] else "start"
    whole = (FrameRange(numbers[0], numbers[-1], begins),) if numbers else ()
    hips = [place_of(side, "hip") for side in SIDES]
    from_hips = (p - p[:, hips].mean(axis=1, keepdims=True)) / height(skeleton.body)
    wrong = np.zeros(own.shape, np.bool_)
    for run in flipped:
        wrong[run.rows, run.limb] = True
    return JudgedDrafts(
        numbers, whole, (), own[rows], hidden[rows], flips[rows], from_hips[rows], wrong[rows]
    )


def _mean(away: Array) -> Array:
    is_known = np.isfinite(away)
    return np.asarray(np.where(is_known, away, 0.0).sum(-1) / np.maximum(is_known.sum(-1), 1))
