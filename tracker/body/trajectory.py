"""A pose for every frame of a range of a video, plain interpolation, and runs of frames."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.pose import Pose, joint_positions, part_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array, frozen, rotation_between, transpose


def runs(flags: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First and last index of every run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(int)))
    return [(int(a), int(b) - 1) for a, b in zip(edges[::2], edges[1::2], strict=True)]


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Poses of N consecutive frames.

    first_frame:     index of the first pose's video frame.
    Rs_parent_part:  (N, P, 3, 3) rotations in the parents' frames.
    ps_camera_root:  (N, 3) root positions in the camera frame, metres.
    """

    first_frame: int
    Rs_parent_part: Array
    ps_camera_root: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "Rs_parent_part", frozen(self.Rs_parent_part))
        object.__setattr__(self, "ps_camera_root", frozen(self.ps_camera_root))

    def __len__(self) -> int:
        return len(self.ps_camera_root)

    def writable(self) -> tuple[Array, Array]:
        """Writable copies of both arrays: the loops are compiled for that kind only."""
        return self.Rs_parent_part.copy(), self.ps_camera_root.copy()

    @property
    def last_frame(self) -> int:
        return self.first_frame + len(self) - 1

    def pose(self, frame: int) -> Pose:
        """The pose at a video frame inside the trajectory."""
        i = frame - self.first_frame
        if not 0 <= i < len(self):
            raise IndexError(f"frame {frame} is not in {self.first_frame}..{self.last_frame}")
        return Pose(self.Rs_parent_part[i], self.ps_camera_root[i])

    def carried(self, Ts: Array) -> Trajectory:
        """The motion in another frame: Ts (N, 4, 4) of that frame and this one at every pose."""
        return Trajectory(self.first_frame, *carried(self.Rs_parent_part, self.ps_camera_root, Ts))

    def transforms(self, skeleton: Skeleton) -> Array:
        """Ts_camera_part (N, P, 4, 4)."""
        return part_transforms(skeleton, self.Rs_parent_part, self.ps_camera_root)

    def joints(self, skeleton: Skeleton) -> Array:
        """Joints and landmarks (N, J, 3) in the camera frame, metres."""
        return joint_positions(skeleton, self.transforms(skeleton))


def carried(Rs_parent_part: Array, ps_root: Array, Ts: Array) -> tuple[Array, Array]:
    """Rotations (N, P, 3, 3) and root positions (N, 3) in another frame, by Ts (N, 4, 4) of that
    frame and theirs."""
    Rs = Rs_parent_part.copy()
    Rs[:, 0] = Ts[:, :3, :3] @ Rs[:, 0]
    return Rs, (Ts[:, :3, :3] @ ps_root[..., None])[..., 0] + Ts[:, :3, 3]


@dataclass(frozen=True, eq=False)
class Pass:
    """An intermediate trajectory and its score (within one segment, lower is better).

    what: "interpolation", "both ways", "templates", "import", "pass" or "refinement"; of observed
        surfaces "fit".
    score: None where not judged.
    """

    what: str
    trajectory: Trajectory
    score: float | None

    @property
    def score_or_nan(self) -> float:
        """The score as a number; NaN where not judged."""
        return np.nan if self.score is None else self.score


def interpolate(start: Pose, end: Pose, first_frame: int, last_frame: int) -> Trajectory:
    """Each part's one-axis rotation and the root's straight line, divided evenly.  DRIFT §2.2"""
    return Trajectory(first_frame, *blended(start, end, _shares(first_frame, last_frame)))


def _shares(first_frame: int, last_frame: int) -> Array:
    return np.arange(last_frame - first_frame + 1) / (last_frame - first_frame)


def blended(start: Pose, end: Pose, shares: Array) -> tuple[Array, Array]:
    """Rotations (S, P, 3, 3) and root positions (S, 3) at shares (S,) of the way from one pose to
    the other; both poses themselves at 0 and 1."""
    Rs = rotation_between(start.Rs_parent_part, end.Rs_parent_part, shares)
    ps = start.p_camera_root + shares[:, None] * (end.p_camera_root - start.p_camera_root)
    for share, pose in ((0, start), (1, end)):
        Rs[shares == share], ps[shares == share] = pose.Rs_parent_part, pose.p_camera_root
    return Rs, ps


def displaced(motion: Trajectory, start: Pose, end: Pose, first: int, last: int) -> Trajectory:
    """A motion from `first` to `last`, made to meet two poses there and as it was between.

    What it misses either pose by is added to it, turns in the parts' frames: all of it at that end,
    none at the other, and it comes and goes without a kink, at rest at both ends, so that the
    motion is as smooth beyond them as it was. A motion that has both poses stays as it is.
    """
    rows = slice(first - motion.first_frame, last - motion.first_frame + 1)
    Rs, ps = motion.Rs_parent_part[rows], motion.ps_camera_root[rows]
    misses = [
        Pose(transpose(Rs[n]) @ pose.Rs_parent_part, pose.p_camera_root - ps[n])
        for n, pose in ((0, start), (-1, end))
    ]
    shares = _shares(first, last)
    turns, steps = blended(misses[0], misses[1], shares**2 * (3 - 2 * shares))
    R, p = Rs @ turns, ps + steps
    R[0], R[-1] = start.Rs_parent_part, end.Rs_parent_part
    p[0], p[-1] = start.p_camera_root, end.p_camera_root
    return Trajectory(first, R, p)


def joined(pieces: list[Trajectory]) -> Trajectory:
    """One trajectory of consecutive ones that share their border frames."""
    for before, after in pairwise(pieces):
        if before.last_frame != after.first_frame:
            raise ValueError("trajectories must meet at a shared frame")
    heads = [(p.Rs_parent_part[:-1], p.ps_camera_root[:-1]) for p in pieces[:-1]]
    heads.append((pieces[-1].Rs_parent_part, pieces[-1].ps_camera_root))
    Rs, ps = (np.concatenate([head[k] for head in heads]) for k in range(2))
    return Trajectory(pieces[0].first_frame, Rs, ps)
