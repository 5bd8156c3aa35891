"""Find limbs that lie far beside sure keypoints, and bridge them from the poses before and after.

Where the keypoints of a limb jump to another thing, or its pose turns over, the pose cannot follow
within a frame: a body bends its way by degrees a frame. So at both ends of such a run, or all
through it, joints lie far beside their keypoints, which in films that are drafted right they hardly
ever do.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.fitting.draft.observed import POINTS, Joints, Limb, Observed, unit
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import JOINTS
from keypose.tracker.keypoints.on_body import height_px
from keypose.tracker.solver.projection import image_points
from keypose.tracker.solver.sigmas import keypoint_blur

FAR: Final = 0.1
"""Share of the body's height by which a joint lies beside a sure keypoint only where one of the two
is wrong: 14 standard deviations."""
AGREES: Final = 0.03
"""Share of the height within which a keypoint bears out a pose that was found without it."""
BETWEEN: Final = 16
"""Frames between two that are far, at most, which belong to one run: where a limb turns over, and
where it turns back."""
LONGEST: Final = 24
"""Frames that are bridged at most: what happens in more nobody knows."""
TURNED_DEG: Final = 40.0
"""By which a bone is turned away from where the poses before and after have it, somewhere in a run
in which it is flipped."""
ACROSS_DEG: Final = 90.0
"""By which a bone may turn from before to after a run that is bridged."""
AT_END: Final = 12
"""Frames from an end of the stretch within which a limb that turns over may stay so."""
BESIDE: Final = 3
"""Frames beside a run in which poses are still drawn to what is wrong in it."""
MOST_LIMBS: Final = 2
"""Where more are wrong at once, the whole body may be."""


@dataclass(frozen=True)
class LimbRun:
    """A limb, its place among those of `Joints`, over some rows of a stretch, first and last."""

    limb: int
    first: int
    last: int

    def __len__(self) -> int:
        return self.last - self.first + 1

    @property
    def rows(self) -> slice:
        return slice(self.first, self.last + 1)

    def overlaps(self, limb_run: LimbRun) -> bool:
        """Whether both have rows in common."""
        return self.first <= limb_run.last and limb_run.first <= self.last


def flipped_runs(
    joints: Joints, camera: Camera, observed: Observed, motion: Trajectory
) -> tuple[LimbRun, ...]:
    """The limbs of a motion that lie far beside keypoints that are believed, for long or turned
    away from the poses before and after: where a pose stays on its way, a keypoint alone is wrong.

    camera: ideal.
    """
    away = misses(joints, camera, observed, motion)
    far = {
        k: np.nan_to_num(away[:, _outer(limb)]).max(axis=1) > FAR
        for k, limb in enumerate(joints.limbs)
    }
    limb_runs = [LimbRun(k, first, last) for k in far for first, last in _runs(far[k])]
    flipped = []
    for run in limb_runs:
        is_far = far[run.limb][run.rows].sum() > LONGEST // 2
        for tried in (run, _to_the_end(run, len(motion))):
            if is_far or _turned_deg(joints, motion, tried) > TURNED_DEG:
                flipped.append(tried)
                break
    return tuple(flipped)


def _to_the_end(run: LimbRun, count: int) -> LimbRun:
    """A run near an end of the stretch as far as there: a limb that turns over shortly before does
    not turn back."""
    if run.first <= AT_END:
        return replace(run, first=0)
    return replace(run, last=count - 1) if run.last >= count - 1 - AT_END else run


def misses(joints: Joints, camera: Camera, observed: Observed, motion: Trajectory) -> Array:
    """(N, 12) how far joints lie beside their keypoints, as a share of the body's height, the less
    the less sure these are; NaN where unknown."""
    skeleton, every = joints.skeleton, slice(len(JOINTS))
    uv = image_points(camera, joints.seen.at(motion.transforms(skeleton)))
    frames = range(motion.first_frame, motion.last_frame + 1)
    heights = np.array([height_px(skeleton, camera, motion.pose(frame)) for frame in frames])
    away = np.linalg.norm(uv - observed.uv[:, every], axis=-1) / heights[:, None]
    is_known = observed.known[:, every] & observed.usable[:, None]
    return np.where(is_known, away / keypoint_blur(observed.visibility[:, every]), np.nan)


def _runs(far: NDArray[np.bool_]) -> Iterator[tuple[int, int]]:
    """First and last of rows that belong together, at most `LONGEST` of them."""
    first = last = -1
    for row in np.flatnonzero(far).tolist():
        if first < 0 or row - last > BETWEEN or row - first >= LONGEST:
            if first >= 0:
                yield first, last
            first = row
        last = row
    if first >= 0:
        yield first, last


def _outer(limb: Limb) -> list[int]:
    """The joints of a limb that it can carry elsewhere."""
    return [limb.upper.far, limb.lower.far]


def keypoints_of(joints: Joints, runs: Sequence[LimbRun], count: int) -> NDArray[np.bool_]:
    """(count, K) the keypoints of limbs in their runs, with those of feet."""
    out = np.zeros((count, len(POINTS)), np.bool_)
    for run in runs:
        limb = joints.limbs[run.limb]
        columns = _outer(limb)
        side, _, joint = JOINTS[limb.lower.far].partition("_")
        if joint == "ankle":
            columns += [POINTS.index(f"{side}_{end}") for end in ("heel", "foot_index")]
        out[run.rows, columns] = True
    return out


def bridged(joints: Joints, motion: Trajectory, runs: Sequence[LimbRun]) -> Trajectory:
    """The motion with limbs that turn in their runs evenly from the pose before to that after; as
    before, or as after, at an end of the stretch."""
    R, t = motion.writable()
    for run in runs:
        before, after = run.first - 1, run.last + 1
        sides = [row for row in (before, after) if 0 <= row < len(R)]
        limb = joints.limbs[run.limb]
        for part in (limb.upper.part, limb.lower.part):
            if len(sides) == 1:
                R[run.rows, part] = R[sides[0], part]
            elif sides:
                turn = Slerp(sides, Rotation.from_matrix(R[sides, part]))
                R[run.rows, part] = turn(np.arange(run.first, run.last + 1)).as_matrix()
    return Trajectory(motion.first_frame, R, t)


def can_be_bridged(
    joints: Joints, motion: Trajectory, runs: Sequence[LimbRun]
) -> tuple[LimbRun, ...]:
    """The runs over which poses before and after say what a limb does in between: within the
    stretch, of no more than two limbs at once, and alike on both sides."""
    return tuple(
        run
        for run in runs
        if run.first > 0
        and run.last < len(motion) - 1
        and sum(run.overlaps(limb_run) for limb_run in runs) <= MOST_LIMBS
        and _across_deg(joints, motion, run) < ACROSS_DEG
    )


def _turned_deg(joints: Joints, motion: Trajectory, run: LimbRun) -> float:
    """The most by which a bone of the limb is turned in its run from the middle way."""
    along, before, after = _beside(joints, motion, run)
    rows = np.arange(run.first, run.last + 1)
    share = (rows - before) / max(after - before, 1)
    if run.first == 0 or run.last == len(motion) - 1:  # one side alone says how it was
        share = np.full(len(rows), float(run.first == 0))
    between = along[before] + share[:, None, None] * (along[after] - along[before])
    return float(_angles_deg(along[run.rows], between).max())


def _across_deg(joints: Joints, motion: Trajectory, run: LimbRun) -> float:
    """The most by which a bone of the limb turns from before to after its run."""
    along, before, after = _beside(joints, motion, run)
    return float(_angles_deg(along[before], along[after]).max())


def _beside(joints: Joints, motion: Trajectory, run: LimbRun) -> tuple[Array, int, int]:
    """(N, 2, 3) along both bones of the limb, and the rows before and after its run."""
    p = joints.points.at(motion.transforms(joints.skeleton))
    limb = joints.limbs[run.limb]
    along = np.stack([p[:, bone.far] - p[:, bone.near] for bone in (limb.upper, limb.lower)], 1)
    return unit(along), max(run.first - BESIDE, 0), min(run.last + BESIDE, len(motion) - 1)


def _angles_deg(a: Array, b: Array) -> Array:
    """Between directions."""
    return np.asarray(np.degrees(np.arccos(np.clip((unit(a) * unit(b)).sum(-1), -1.0, 1.0))))
