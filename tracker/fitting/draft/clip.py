"""Draft poses of a whole clip: a box round a person on one frame, and every frame gets a pose.

What is assumed. A picture shows size and distance only together: the body keeps its height, and its
distance follows from that and from the lens. The person is one, and seen by a camera that the
session describes. Which way a limb points, toward the camera or away, is the network's word, freed
of what it is off by all the time, where the poses agree.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from keypose.tracker.body.body import Body
from keypose.tracker.body.modify import has_clavicles, height, with_clavicles, without_clavicles
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.errors import KeypointError
from keypose.tracker.fitting.draft.balance import balanced
from keypose.tracker.fitting.draft.depth_signs import consistent_sides, pointing, turned
from keypose.tracker.fitting.draft.first_poses import first_pose, with_proportions
from keypose.tracker.fitting.draft.flips import (
    AGREES,
    LimbRun,
    bridged,
    can_be_bridged,
    flipped_runs,
    keypoints_of,
    misses,
)
from keypose.tracker.fitting.draft.judged import JudgedDrafts, Piece, judged
from keypose.tracker.fitting.draft.observed import Joints, Observed, turning_ends, unit
from keypose.tracker.fitting.draft.proposals import Proposal
from keypose.tracker.fitting.draft.whole import Whole
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.steady import SteadyCamera
from keypose.tracker.keypoints.crossings import coincidences
from keypose.tracker.keypoints.detect import Detector, Frame, Kept, Progress, Seed
from keypose.tracker.keypoints.keypoints import JOINTS, Keypoints
from keypose.tracker.keypoints.lifted_depth import DepthLifter
from keypose.tracker.keypoints.on_body import height_px
from keypose.tracker.keypoints.people import detect_people, people_changes
from keypose.tracker.keypoints.region import Box
from keypose.tracker.session.annotations import FlippedDrafts
from keypose.tracker.tracking.cues.anchors import with_free_joints
from keypose.tracker.tracking.scene import Scene

WORSE = 1.1
"""Limbs stay as drafted where turning them in depth costs so many times more: what limits and the
picture do not bear. Less than that decides nothing: both sides look the same."""
ROUNDS = 2
"""In which limbs that lie far beside their keypoints are bridged: one may have hidden another."""
FEW_POINTS = 0.1
"""Density of points on the body's surface, none of which is looked at here."""


@dataclass(frozen=True)
class DraftProgress:
    """How far the work is: frames looked at by the network, or posed after that."""

    stage: Literal["keypoints", "poses"]
    done: int
    expected: int


@dataclass(frozen=True, eq=False)
class ClipDraft:
    """The drafts of a clip.

    body: with the person's proportions.  poses: by frame, of that body; none where nobody is seen
    well enough.  keypoints: those of all frames looked at, as the network found them.
    proposals: the drafts to confirm as keyframes.  flipped: drafts of which a limb is wrong, none
    of them proposed.  judged: what both were decided by.
    """

    body: Body
    poses: Mapping[int, Pose]
    keypoints: Keypoints
    proposals: tuple[Proposal, ...]
    judged: JudgedDrafts
    flipped: tuple[FlippedDrafts, ...] = ()


def draft_clip(
    frame: Frame,
    frames: tuple[int, int],
    at: int,
    box: Box,
    camera: Camera,
    body: Body,
    network: Detector,
    *,
    again: Detector | None = None,
    proportions: bool = True,
    up_world: ArrayLike | None = None,
    path: CameraPath | None = None,
    lifter: DepthLifter | None = None,
    report: Callable[[DraftProgress], None] = lambda progress: None,
    film: str = "",
    kept: Kept | None = None,
    every_second: bool = False,
) -> ClipDraft:
    """Drafts of all frames from the first to the last, of the person in a box on one of them.

    frame: a picture by its number.  at, box: the frame of the box, and left, top, right, bottom in
    pixels of the video.  camera: of the video, with its distortion.
    again: what looks for other people on the way, the network where it is left out.
    report: called again and again; what it raises ends the work within a frame.
    proportions: whether the body's limbs may be scaled to the person's.
    up_world: (3,) what is up; None where nobody knows.  path: of a camera that moves.
    lifter: as of `draft_from_keypoints`.
    every_second: as of `detect`.
    KeypointError in one sentence for a box that is none, or without a person in it.
    """

    (draft,) = draft_people(
        frame,
        frames,
        at,
        [box],
        camera,
        body,
        network,
        again=again,
        proportions=proportions,
        up_world=up_world,
        path=path,
        lifter=lifter,
        report=report,
        film=film,
        kept=kept,
        every_second=every_second,
    )
    return draft


def draft_people(
    frame: Frame,
    frames: tuple[int, int],
    at: int,
    boxes: Sequence[Box],
    camera: Camera,
    body: Body,
    network: Detector,
    *,
    again: Detector | None = None,
    proportions: bool = True,
    up_world: ArrayLike | None = None,
    path: CameraPath | None = None,
    lifter: DepthLifter | None = None,
    report: Callable[[DraftProgress], None] = lambda progress: None,
    film: str = "",
    kept: Kept | None = None,
    every_second: bool = False,
) -> list[ClipDraft]:
    """Drafts of several people in boxes on one frame, who are followed together; all else is as of
    `draft_clip`."""

    def looked(progress: Progress) -> None:
        report(DraftProgress("keypoints", progress.done, progress.expected))

    seeds = [[Seed.of_box(at, box, camera.width, camera.height)] for box in boxes]
    people = detect_people(
        frame,
        frames,
        seeds,
        network,
        report=looked,
        film=film,
        kept=kept,
        every_second=every_second,
    )
    count = len(boxes) * (frames[1] - frames[0] + 1)

    def looked_again(done: int, expected: int) -> None:
        report(DraftProgress("keypoints", count + done, count + expected))

    plain = again or network
    changes = [
        {*followed, *coinciding}
        for followed, coinciding in zip(
            people_changes(frame, people, [at], plain, looked_again, every_second=every_second),
            coincidences(people),
            strict=True,
        )
    ]

    def posing(index: int, progress: DraftProgress) -> None:
        """Of all people, one after another."""
        done = index * progress.expected + progress.done
        report(DraftProgress(progress.stage, done, len(boxes) * progress.expected))

    return [
        draft_from_keypoints(
            keypoints,
            camera,
            body,
            changes=own_changes,
            proportions=proportions,
            up_world=up_world,
            path=path,
            lifter=lifter,
            report=partial(posing, index),
        )
        for index, (keypoints, own_changes) in enumerate(zip(people, changes, strict=True))
    ]


def draft_from_keypoints(
    keypoints: Keypoints,
    camera: Camera,
    body: Body,
    *,
    changes: Collection[int] = (),
    proportions: bool = True,
    up_world: ArrayLike | None = None,
    path: CameraPath | None = None,
    lifter: DepthLifter | None = None,
    report: Callable[[DraftProgress], None] = lambda progress: None,
) -> ClipDraft:
    """Drafts from keypoints with depth; KeypointError where they show nobody well enough.

    changes: frames from which on they may be another person's than before.
    up_world: (3,) what is up, where it is known: in the mean the person is in balance then.
    path: of a camera that moves.  lifter: what gives keypoints their depth; None where they keep
    that of the network that found them.

    Clavicles stay at rest: a few centimetres of a shoulder are within what keypoints are off by.
    """
    if has_clavicles(body):
        plain = without_clavicles(body)
        draft = draft_from_keypoints(
            keypoints,
            camera,
            plain,
            changes=changes,
            proportions=proportions,
            up_world=up_world,
            path=path,
            lifter=lifter,
            report=report,
        )
        return _with_clavicles(draft, body if draft.body == plain else with_clavicles(draft.body))
    steadied = keypoints
    if path is not None and path.zooms:
        steadied = keypoints.steadied(SteadyCamera.at_one_focal(camera, path))
    observed, ideal = Observed.of(steadied, camera, changes), camera.without_distortion()
    Joints.of(Skeleton.of(body))
    if proportions and observed.usable.any():
        body = with_proportions(body, observed)
    if lifter is not None:
        observed = Observed.of(lifter.of(steadied, body), camera, changes)

    def in_balance(landmarks: Observed) -> Observed:
        if up_world is None:
            return landmarks
        up = unit(np.asarray(up_world, dtype=np.float64))
        if path is not None:
            Ts = path.Ts_camera_world[
                landmarks.first_frame : landmarks.first_frame + len(landmarks)
            ]
            up = Ts[:, :3, :3] @ up
        return balanced(landmarks, ideal, up)

    def lifted(landmarks: Observed) -> Observed:
        if lifter is None:
            return landmarks
        lifted_keypoints = replace(lifter, camera=ideal).of(landmarks.keypoints(), body)
        return landmarks.with_depth_of(in_balance(Observed.of(lifted_keypoints, ideal)))

    observed = in_balance(observed)
    runs = observed.runs()
    if not runs:
        raise _nowhere()
    work = _DraftRun(Skeleton.of(body), ideal, lifted, report, int(observed.usable.sum()))
    pieces = [work.run(observed.rows(run)) for run in runs]
    return _draft(work, body, keypoints, pieces)


def _with_clavicles(draft: ClipDraft, body: Body) -> ClipDraft:
    """The same drafts of a body that has clavicles, too."""
    at = [body.index(name) for name in draft.body.names]

    def posed(pose: Pose) -> Pose:
        Rs = np.tile(np.eye(3), (len(body.parts), 1, 1))
        Rs[at] = pose.Rs_parent_part
        return Pose(Rs, pose.p_camera_root)

    poses = {frame: posed(pose) for frame, pose in draft.poses.items()}
    return replace(draft, body=body, poses=poses)


@dataclass(eq=False)
class _DraftRun:
    """Runs of frames, one after the other."""

    skeleton: Skeleton
    camera: Camera
    lifted: Callable[[Observed], Observed]
    report: Callable[[DraftProgress], None]
    expected: int
    done: int = 0
    reported: int = 0

    def run(self, observed: Observed) -> Piece:
        """The poses of a stretch of frames, and what they were found from: left and right as
        found, or as consistent over time, whichever all terms together agree with better.

        Lifted depths know by what was seen around a frame which way a bone points. Where the whole
        stretch was asked besides, thighs of people who squat were turned: by then 80 mm off markers
        instead of 60.
        """
        solved = self._solved(observed)
        pixels = height_px(self.skeleton, self.camera, middle(solved.motion))
        sides_swapped = consistent_sides(observed, pixels, height(self.skeleton.body))
        if sides_swapped is not None:
            solved = min(
                solved,
                self._solved(self.lifted(sides_swapped)),
                key=lambda candidate: candidate.cost,
            )
        depth = solved.problem.depth
        if not solved.seen.is_lifted:
            solved = self._turned(solved)
        solved, flipped = self._without_flips(solved)
        motion = self._with_ends(solved)
        self.done += int(observed.usable.sum())
        return Piece(solved.seen, motion, depth, flipped)

    def _without_flips(self, draft: _Solved) -> tuple[_Solved, tuple[LimbRun, ...]]:
        """Draft flipped limbs again from the poses before and after, and say which are wrong still.

        Where keypoints are right, poses that begin on the way from before to after come to lie on
        them. Where these still do not, the limb's keypoints are not believed there, but for those
        that the poses then found without them agree with.
        """
        joints = Joints.of(with_free_joints(self.skeleton))

        def flipped(solved: _Solved) -> tuple[LimbRun, ...]:
            return flipped_runs(joints, self.camera, solved.believed, solved.motion)

        runs = flipped(draft)
        if not runs:
            return draft, ()
        draft = min(draft, self._solved(draft.seen, runs), key=lambda candidate: candidate.cost)
        wrong: list[LimbRun] = []
        for _ in range(ROUNDS):
            runs = can_be_bridged(joints, draft.motion, flipped(draft))
            if not runs:
                break
            wrong += runs
            draft = self._solved(draft.seen, wrong, keypoints_of(joints, wrong, len(draft.seen)))
        if wrong:
            away = misses(joints, self.camera, draft.seen, draft.motion)
            disbelieved = keypoints_of(joints, wrong, len(draft.seen))
            disbelieved[:, : len(JOINTS)] &= ~(away < AGREES)
            draft = self._solved(draft.seen, wrong, disbelieved)
        return draft, flipped(draft)

    def _turned(self, draft: _Solved) -> _Solved:
        """Turn bones in depth where the whole stretch says so, unless all terms together agree with
        that clearly worse: then limb by limb, so that none holds another back.
        """
        joints = Joints.of(with_free_joints(self.skeleton))
        p_hips = draft.seen.bridged(joints.rest)
        direction = pointing(joints, self.camera, p_hips, draft.motion)

        def with_limbs(limbs: Sequence[int]) -> _Solved | None:
            observed = turned(joints, draft.seen, p_hips, direction.of_limbs(limbs))
            again = None if observed is None else self._solved(observed)
            return again if again is not None and again.cost < WORSE * draft.cost else None

        limbs = direction.limbs_against
        if len(limbs) > 1 and (again := with_limbs(limbs)):
            return again
        alone = {limb: again for limb in limbs if (again := with_limbs([limb]))}
        together = with_limbs(list(alone)) if 1 < len(alone) < len(limbs) else None
        return together or min(alone.values(), key=lambda solved: solved.cost, default=draft)

    def _solved(
        self,
        observed: Observed,
        bridge: Sequence[LimbRun] = (),
        disbelieved: NDArray[np.bool_] | None = None,
    ) -> _Solved:
        """The poses nearest to all keypoints but those that jump or are not believed, which neither
        depth nor the first poses follow.

        bridge: limbs that begin on the way from the pose before to the one after.
        """
        joints = Joints.of(with_free_joints(self.skeleton))
        believed = observed if disbelieved is None else observed.without(disbelieved)
        first = self._first(joints, believed)
        believed = self._without_jumps(believed, first)
        if (believed.known != observed.known).any():
            anew = self.lifted(believed)
            observed, believed = observed.with_depth_of(anew), believed.with_depth_of(anew)
            first = self._first(joints, believed)
        first = bridged(joints, first, bridge)
        scene = self._scene(joints.skeleton, first)
        motion = Whole.of_joints(scene, joints, believed, first).solve(self._report)
        return _Solved(observed, believed, Whole.of_joints(scene, joints, observed, first), motion)

    def _without_jumps(self, observed: Observed, motion: Trajectory) -> Observed:
        """What poses are found from: without keypoints that jump."""
        return observed.without_jumps(height_px(self.skeleton, self.camera, middle(motion)))

    def _with_ends(self, solved: _Solved) -> Trajectory:
        """Turn head and feet; where limbs are, their keypoints do not say."""
        skeleton = turning_ends(Joints.of(self.skeleton))
        joints = Joints.of(skeleton)
        if not len(joints.ends[0]):
            return solved.motion
        scene = self._scene(skeleton, solved.motion)
        observed = self._without_jumps(solved.believed, solved.motion)
        problem = Whole.of_ends(scene, joints, observed, solved.motion)
        return problem.solve_turns(lambda done: self._report(int(solved.seen.usable.sum())))

    def _scene(self, skeleton: Skeleton, motion: Trajectory) -> Scene:
        return Scene.of(skeleton, self.camera, [middle(motion)], FEW_POINTS)

    def _first(self, joints: Joints, observed: Observed) -> Trajectory:
        poses: list[Pose | None] = []
        joint, p_hips = slice(len(JOINTS)), observed.bridged(joints.rest)
        if not observed.is_lifted:  # which are at the joints
            p_hips = joints.on_joints(p_hips)
        for n in range(len(observed)):
            self._report(0)
            poses.append(
                first_pose(
                    joints,
                    self.camera,
                    observed.uv[n, joint],
                    observed.visibility[n, joint],
                    p_hips[n],
                )
                if observed.usable[n]
                else None
            )
        return filled(observed.first_frame, poses)

    def _report(self, more: int) -> None:
        """Report that so many more frames are done; a stretch solved a second time does not go
        back.
        """
        self.reported = max(self.reported, min(self.done + more, self.expected))
        self.report(DraftProgress("poses", self.reported, self.expected))


@dataclass(frozen=True, eq=False)
class _Solved:
    """A stretch with its poses.

    believed: what poses were found from.
    problem: everything that is seen there, also what jumps and no pose was found from.
    """

    seen: Observed
    believed: Observed
    problem: Whole
    motion: Trajectory

    @cached_property
    def cost(self) -> float:
        return self.problem.cost(self.motion)


def middle(motion: Trajectory) -> Pose:
    """The pose in its middle."""
    return motion.pose(motion.first_frame + len(motion) // 2)


def filled(first_frame: int, poses: list[Pose | None]) -> Trajectory:
    """Fill a frame without a pose with the pose before it. The first has one."""
    every: list[Pose] = []
    for pose in poses:
        every.append(pose if pose is not None else every[-1])
    R = np.stack([pose.Rs_parent_part for pose in every])
    return Trajectory(first_frame, R, np.stack([pose.p_camera_root for pose in every]))


def _nowhere() -> KeypointError:
    return KeypointError(
        "The person is nowhere seen well enough for a draft: draw the box in a frame that shows "
        "the whole body."
    )


def _draft(work: _DraftRun, body: Body, keypoints: Keypoints, pieces: list[Piece]) -> ClipDraft:
    judged_drafts = judged(work.skeleton, work.camera, pieces)
    if not judged_drafts.frames:
        raise _nowhere()
    motions = {
        frame: piece.motion
        for piece in pieces
        for frame in range(piece.motion.first_frame, piece.motion.last_frame + 1)
    }
    poses = {frame: motions[frame].pose(frame) for frame in judged_drafts.frames}
    return ClipDraft(
        body,
        poses,
        keypoints,
        judged_drafts.proposals(),
        judged_drafts,
        judged_drafts.flipped_drafts(),
    )
