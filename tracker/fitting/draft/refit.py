"""Solve drafts anew with what posed frames show of their keypoints.

A network puts an elbow beside where the arm bends, mostly one way throughout a film. A posed frame
is not exact itself: what is learned from one is believed by half, from several by more.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.body import Body
from keypose.tracker.body.modify import height
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.fitting.draft.clip import FEW_POINTS, filled, middle
from keypose.tracker.fitting.draft.depth_signs import consistent_sides
from keypose.tracker.fitting.draft.judged import NEAREST_M
from keypose.tracker.fitting.draft.observed import Joints, Observed, turning_ends
from keypose.tracker.fitting.draft.whole import Whole, in_camera
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import JOINTS, Keypoints
from keypose.tracker.keypoints.on_body import height_px
from keypose.tracker.session.annotations import LEARN_FRAMES
from keypose.tracker.solver.posed import BodyPoints
from keypose.tracker.solver.projection import image_jacobian, image_points
from keypose.tracker.solver.sigmas import (
    HELD,
    LEARNED_DEPTH_M,
    LEARNED_ON_PART_M,
    POSED_DEPTH_M,
    POSED_PX,
    SHAKES_M,
)
from keypose.tracker.tracking.cues.anchors import with_free_joints
from keypose.tracker.tracking.scene import Scene


def learned_place(slopes: Array, missed_px: Array, pixel_m: Array) -> Array:
    """(3,) where on its part a keypoint is beside its joint, metres.

    slopes (R, 2, 3): pixels by metre in the part's axes, in R posed frames.  missed_px (R, 2): from
    the joint to the keypoint.  pixel_m (R,): metres there.
    """
    precision = 1 / ((SHAKES_M / pixel_m) ** 2 + POSED_PX**2)
    weighted = np.swapaxes(slopes, -1, -2) * precision[:, None, None]
    A = np.eye(3) / LEARNED_ON_PART_M**2 + (weighted @ slopes).sum(axis=0)
    return np.asarray(np.linalg.solve(A, (weighted @ missed_px[..., None]).sum(axis=0)[:, 0]))


def learned_depth(missed_m: Array) -> float:
    """What a keypoint's depth lacks, metres; missed_m (R,): in R posed frames."""
    return float(missed_m.sum() / (len(missed_m) + (POSED_DEPTH_M / LEARNED_DEPTH_M) ** 2))


SEEN = 0.2
"""Visibility from which a keypoint of a posed frame counts."""


def refit_drafts(
    keypoints: Keypoints,
    camera: Camera,
    body: Body,
    drafts: Mapping[int, Pose],
    posed: Mapping[int, Pose],
    around: Collection[int],
    changes: Collection[int] = (),
) -> dict[int, Pose]:
    """The drafts of the frames near some, solved for anew; those that cannot be are left out.

    keypoints: those that the drafts were found from.  camera: of the video, with its distortion.
    drafts, posed: by frame, of this body; posed ones stay, and show where the network puts joints
    and what their depths lack.  around: the posed frames that are new.
    changes: frames from which on the keypoints may be another person's than before.
    KeypointError for keypoints without depth and for a body that is no person's.
    """
    observed, poses = Observed.of(keypoints, camera, changes), {**drafts, **posed}
    skeleton = _free(Skeleton.of(body))
    refitted: dict[int, Pose] = {}
    for frames in _stretches(observed, poses, around):
        if any(frame in drafts for frame in frames) and any(frame in posed for frame in frames):
            rows = slice(frames.start - observed.first_frame, frames.stop - observed.first_frame)
            work = _PosedRun(skeleton, camera.without_distortion(), observed.rows(rows), poses)
            motion = work.solved([frame for frame in frames if frame in posed])
            refitted |= {frame: motion.pose(frame) for frame in frames if frame in drafts}
    return {
        frame: pose
        for frame, pose in refitted.items()
        if frame not in posed and _is_before_camera(skeleton, pose)
    }


def _free(skeleton: Skeleton) -> Skeleton:
    """Free the joints that keypoints determine; clavicles stay as they are, as in every draft."""
    body = with_free_joints(skeleton).body
    parts = (
        part.model_copy(update={"tracked": ()}) if part.name.endswith("_clavicle") else part
        for part in body.parts
    )
    return Skeleton.of(body.replaced(parts))


def _stretches(
    observed: Observed, poses: Mapping[int, Pose], around: Collection[int]
) -> Iterator[range]:
    """Frames that show one person, from one with a pose to another, around those that are new."""
    for run in observed.runs():
        own = range(observed.first_frame + run.start, observed.first_frame + run.stop)
        new = [frame for frame in around if frame in own]
        if new:
            near = range(min(new) - LEARN_FRAMES, max(new) + LEARN_FRAMES + 1)
            frames = [frame for frame in own if frame in near and frame in poses]
            if len(frames) > 1:
                yield range(frames[0], frames[-1] + 1)


def _is_before_camera(skeleton: Skeleton, pose: Pose) -> bool:
    return bool(pose_transforms(skeleton, pose)[:, 2, 3].min() > NEAREST_M)


@dataclass(frozen=True, eq=False)
class _PosedRun:
    """N frames that show one person, and the poses that they have."""

    skeleton: Skeleton
    camera: Camera
    seen: Observed
    known: Mapping[int, Pose]

    def solved(self, posed: Sequence[int]) -> Trajectory:
        """All poses but the posed ones, and the first and the last where the film goes on there."""
        frames = range(self.seen.first_frame, self.seen.first_frame + len(self.seen))
        first = filled(frames.start, [self.known.get(frame) for frame in frames])
        posed_rows = [frame - frames.start for frame in posed]
        ends = {0: frames.start - 1, len(frames) - 1: frames.stop}
        stay = {*posed_rows, *(row for row, beyond in ends.items() if beyond in self.known)}
        joints = Joints.of(self.skeleton)
        observed = self._without_jumps(joints, first)
        motion = self._limbs(joints, observed, first, posed_rows, stay).solve(_ignored)
        turning = Joints.of(turning_ends(joints))
        if not len(turning.ends[0]):
            return motion
        return self._ends(turning, observed, first, motion, posed_rows, stay).solve_turns(_ignored)

    def _without_jumps(self, joints: Joints, first: Trajectory) -> Observed:
        """Left and right as the poses have them, without keypoints that jump."""
        pixels = height_px(self.skeleton, self.camera, middle(first))
        ways = [self.seen]
        sides_swapped = consistent_sides(self.seen, pixels, height(self.skeleton.body))
        if sides_swapped is not None:
            ways.append(sides_swapped)
        scene = self._scene(self.skeleton, first)
        costs = [Whole.of_joints(scene, joints, observed, first).cost(first) for observed in ways]
        return ways[int(np.argmin(costs))].without_jumps(pixels)

    def _limbs(
        self,
        joints: Joints,
        observed: Observed,
        first: Trajectory,
        posed_rows: list[int],
        stay: set[int],
    ) -> Whole:
        columns = np.arange(len(JOINTS))
        observed = self._corrected(observed, columns, joints.seen, first, posed_rows)
        scene = self._scene(joints.skeleton, first)
        depth = self._depth(observed, joints.seen, first, posed_rows)
        plain = Whole.of_joints(scene, joints, observed, first)
        depth_scale = np.where(np.isfinite(depth), plain.depth_scale, 0.0)
        return replace(
            plain,
            depth=np.nan_to_num(depth),
            depth_scale=depth_scale,
            keep=_held(scene, plain.keep, len(first), stay),
        )

    def _ends(
        self,
        joints: Joints,
        observed: Observed,
        first: Trajectory,
        motion: Trajectory,
        posed_rows: list[int],
        stay: set[int],
    ) -> Whole:
        """Head and feet; what was posed says where on them the network sees points."""
        columns, points = joints.ends
        observed = self._corrected(observed, columns, points, first, posed_rows)
        scene = self._scene(joints.skeleton, motion)
        plain = Whole.of_ends(scene, joints, observed, motion)
        return replace(plain, keep=_held(scene, plain.keep, len(motion), stay))

    def _scene(self, skeleton: Skeleton, motion: Trajectory) -> Scene:
        return Scene.of(skeleton, self.camera, [middle(motion)], FEW_POINTS)

    def _corrected(
        self,
        observed: Observed,
        columns: NDArray[np.int64],
        points: BodyPoints,
        first: Trajectory,
        posed_rows: list[int],
    ) -> Observed:
        """Move these keypoints to where they would be without what was learned that they
        are off.
        """
        Ts = first.transforms(self.skeleton)
        p, uv = points.at(Ts), observed.uv.copy()
        at = image_points(self.camera, p)
        for k, column in enumerate(columns.tolist()):
            rows = [n for n in posed_rows if observed.known[n, column]]
            rows = [n for n in rows if observed.visibility[n, column] > SEEN]
            if not rows:
                continue
            ((part, _),) = points.points[k]
            axes = np.swapaxes(Ts[:, part, :3, :3], -1, -2)
            slopes = np.swapaxes(image_jacobian(self.camera, p[:, k], axes), -1, -2)
            pixel_m = self.camera.depth(p[rows, k]) / self.camera.fy
            missed = observed.uv[rows, column] - at[rows, k]
            uv[:, column] -= slopes @ learned_place(slopes[rows], missed, pixel_m)
        return replace(observed, uv=uv)

    def _depth(
        self, observed: Observed, points: BodyPoints, first: Trajectory, posed_rows: list[int]
    ) -> Array:
        """(N, 12) metres farther than the root; NaN where nothing shows it."""
        own = points.at(first.transforms(self.skeleton))[..., 2] - first.ps_camera_root[:, 2:]
        p = in_camera(self.camera, observed) if observed.is_lifted else observed.p_hips
        depth = p[:, : len(JOINTS), 2].copy()
        for k in range(len(JOINTS)):
            rows = [
                n
                for n in posed_rows
                if np.isfinite(depth[n, k]) and observed.visibility[n, k] > SEEN
            ]
            if rows:
                depth[:, k] += learned_depth(own[rows, k] - depth[rows, k])
            else:
                depth[:, k] = own[:, k]
        return depth


def _held(scene: Scene, keep: Array, count: int, stay: set[int]) -> Array:
    """(N, D) 1/σ² by which poses are kept, some of them as they are."""
    every = np.tile(keep, (count, 1))
    every[sorted(stay)] = scene.precision(HELD)
    return every


def _ignored(done: int) -> None:
    """Nobody waits for it."""
