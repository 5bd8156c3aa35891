"""Judge every segment: good, check these frames, or lost: add a keyframe there; make its result.

The evidence is what tracking saw, never the truth: how far the chains from the two keyframes lie
apart, how much drift had to be corrected, which parts the picture did not decide, whether a pass
diverged. The thresholds were set where, on rendered sequences with known truth, they separate
correct segments from wrong ones.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

import numpy as np

from keypose.tracker.body.angle_errors import GUESSED_RAD, direction_errors
from keypose.tracker.body.modify import height
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import runs
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.verdict import GOOD, Cause, Verdict
from keypose.tracker.tracking.cues.joint_evidence import GOOD_FOOT, JointEvidence
from keypose.tracker.tracking.cues.silhouette import SilhouetteMismatch
from keypose.tracker.tracking.cycle import NOWHERE_PX, Outcome
from keypose.tracker.tracking.diagnostics.expected_gain import expected_gain
from keypose.tracker.tracking.diagnostics.observability import Observation, observe, unobserved
from keypose.tracker.tracking.drift import closing_error
from keypose.tracker.tracking.method import Method, Paper
from keypose.tracker.tracking.per_clip import PerClip
from keypose.tracker.tracking.result import SegmentResult
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.tracking.segment import Segment, extent_px
from keypose.tracker.video.pyramid import Clip

LOST_APART = 0.28
LOST_DRIFT = 0.23
CHECK_APART = 0.18
CHECK_DRIFT = 0.044
"""Shares of the body's extent in the picture. A segment is lost where both are exceeded."""
HIDDEN = 0.5
"""Mean visibility of a joint below which it counts as not seen."""
UNSEEN = 0.15
"""Observability below which a part's motion is a guess."""
LEAST_PX = 8.0
"""Extent of a body of which a picture shows anything."""
ALIKE_IN_TIME = 0.1
ALIKE_IN_SPACE = 0.7
"""Correlation of a picture with the next, and of a pixel with the one beside it, below which both
are noise. Filmed and rendered pictures have 0.9 and more of either, noise 0 and 0.45, and something
small that moves fast lacks only the first."""
SHORTEST_RUN = 3
"""Frames for which a part must stay unseen before it is reported."""
BESIDE_BODY = 0.08
BESIDE_FRAMES = 5
"""Share of the body's area by which what moves may disagree with the body more than at the
keyframes, in the median over so many frames. All 27 filmed frames above it, of 119, have a joint
that is more than 15 px off on a person 400 px tall, as 36 others do; by a person's mask all 36 of
90, as 20 others do. Which part it is, this does not show."""


@dataclass(frozen=True, eq=False)
class _Evidence:
    """Shares of the body's extent: apart (N, M) by mark, drift (N - 1, M) of every frame pair.

    At a keyframe the chain from the other side does not count, so `apart` is weighted by a frame's
    distance from the nearer keyframe.
    """

    apart: Array
    drift: Array

    @property
    def whole_drift(self) -> Array:
        """(M,) over the segment."""
        return np.asarray(self.drift.sum(axis=0))


def judge(scene: Scene, segment: Segment, outcome: Outcome, observation: Observation) -> Verdict:
    """The verdict on a tracked segment."""
    if extent_px(scene, outcome.trajectory) < LEAST_PX or _is_noise(segment):
        return Verdict.nothing_seen(segment.first_frame, segment.last_frame)
    verdict = _judge_body(scene, segment, outcome, observation)
    if verdict.kind == "good" and outcome.silhouette is not None:
        verdict = _judge_silhouette(segment, outcome.silhouette)
    return _judge_depth(scene, segment, outcome) if verdict.kind == "good" else verdict


def _is_noise(segment: Segment) -> bool:
    """Whether the pictures, in the median, show nothing but black or noise."""
    frames = segment.first_frame, segment.last_frame
    return _NOISE.get(segment.clip, frames, lambda: _show_noise(segment.clip, *frames))


_NOISE: Final[PerClip[bool]] = PerClip(most=8)


def _show_noise(clip: Clip, first: int, last: int) -> bool:
    frames = [n for n in range(first, last + 1) if n not in clip.damaged]
    if not clip.levels or len(frames) < 2:
        return False
    grey = clip.overview.grey[np.array(frames) - clip.first_frame].astype(np.float64)
    grey -= grey.mean(axis=(1, 2), keepdims=True)
    in_time = [_correlation(a, b) for a, b in pairwise(grey)]
    in_space = [_correlation(a[:, 1:], a[:, :-1]) for a in grey]
    return bool(np.median(in_time) < ALIKE_IN_TIME and np.median(in_space) < ALIKE_IN_SPACE)


def _correlation(a: Array, b: Array) -> float:
    """Correlate pictures about their mean; 0 where one is of one brightness."""
    scale = float(np.sqrt((a * a).sum() * (b * b).sum()))
    return float((a * b).sum()) / scale if scale > 0 else 0.0


def _judge_body(
    scene: Scene, segment: Segment, outcome: Outcome, observation: Observation
) -> Verdict:
    """Judge by all but the silhouette."""
    if outcome.joints is not None:
        return _judge_joints(scene, segment, outcome.joints)
    verdict = _judge_brightness(scene, segment, outcome, observation)
    if verdict.kind != "good" and outcome.off_person is not None:
        return Verdict.off_person(outcome.off_person)
    return verdict


def _judge_brightness(
    scene: Scene, segment: Segment, outcome: Outcome, observation: Observation
) -> Verdict:
    """Judge by what pictures alone say."""
    evidence = _evidence(scene, outcome)
    apart = evidence.apart.max(initial=0.0)
    drift = evidence.whole_drift.max(initial=0.0)
    gave_up = outcome.diverged and outcome.passes[outcome.best].what == "interpolation"
    if gave_up or not outcome.followed or (apart > LOST_APART and drift > LOST_DRIFT):
        return _lost(segment, evidence)
    if not observation.shown.any() and (observation.diagnostics.rank >= 0).any():
        return Verdict.nothing_seen(segment.first_frame, segment.last_frame)
    if outcome.diverged:
        return Verdict.check("diverged", (segment.first_frame, segment.last_frame))
    if segment.damaged:
        return Verdict.check("damaged", _longest_run(segment.damaged))
    unseen = _longest_unseen(scene, segment, observation)
    if unseen is not None:
        part, first, last = unseen
        return Verdict.check("not_seen", (first, last), part)
    if apart > CHECK_APART or drift > CHECK_DRIFT:
        index, first, last = _most_uncertain(scene, segment, evidence)
        is_hidden = _is_hidden(segment, observation, index, first, last)
        name = scene.skeleton.body.names[index]
        return Verdict.check("not_seen" if is_hidden else "uncertain", (first, last), name)
    return GOOD


def _judge_joints(scene: Scene, segment: Segment, joints: JointEvidence) -> Verdict:
    """Judge by how far each joint is expected to be off in each frame."""
    first, last = segment.first_frame, segment.last_frame
    if joints.is_lost:
        worst = first + int(joints.error.sum(axis=1).argmax())
        return Verdict.not_followed(min(max(worst, first + 1), last - 1))
    if segment.damaged:
        return Verdict.check("damaged", _longest_run(segment.damaged))
    if not joints.is_good:
        return _doubtful_joint(scene, first, joints)
    skeleton = scene.skeleton
    child_counts = np.bincount(skeleton.parents[1:], minlength=skeleton.part_count)
    keyed = joints.keyed_wrong(child_counts == 1)  # a trunk carries several parts, a head none
    if keyed is not None:
        frame, name = first + keyed[0], skeleton.body.names[int(joints.parts[keyed[1]])]
        return Verdict.check("keyframe_off_keypoints", (frame, frame), name)
    feet = np.nan_to_num(joints.expected_foot_error(skeleton.part_count))
    return _worst_run(skeleton, first, "uncertain", feet - GOOD_FOOT) or GOOD


def _judge_silhouette(segment: Segment, mismatch: SilhouetteMismatch) -> Verdict:
    """Judge by how far the body is from covering what moves, and nothing else."""
    from scipy.ndimage import median_filter  # scipy: loads longer than a page needs to start

    beside = median_filter(mismatch.excess, BESIDE_FRAMES, mode="nearest")
    beside[[0, -1]] = 0.0
    bad_runs = [run for run in runs(beside > BESIDE_BODY) if run[1] - run[0] + 1 >= SHORTEST_RUN]
    if not bad_runs:
        return GOOD
    start, end = max(bad_runs, key=lambda run: float(beside[run[0] : run[1] + 1].sum()))
    worst = start + int(beside[start : end + 1].argmax())
    first = segment.first_frame
    return Verdict(
        kind="check",
        cause="moves_beside_body",
        frames=(first + start, first + end),
        go=first + worst,
    )


def _judge_depth(scene: Scene, segment: Segment, outcome: Outcome) -> Verdict:
    """Judge by how far off parts are expected to point, where depth was lifted."""
    if outcome.joints is None:
        return GOOD
    count = scene.skeleton.part_count
    along_m = outcome.joints.expected_depth_m(count, segment.to_posed_s)
    if along_m is None:
        return GOOD
    across_m = outcome.joints.expected_error(count) * height(scene.skeleton.body)
    directions = direction_errors(scene.skeleton, outcome.trajectory, across_m, along_m)
    if directions is None:
        return GOOD
    guessed = np.nan_to_num(directions - GUESSED_RAD)
    guessed[[0, -1]] = 0.0  # a keyframe is what a person says
    return _worst_run(scene.skeleton, segment.first_frame, "depth", guessed) or GOOD


def _worst_run(skeleton: Skeleton, first: int, cause: Cause, beyond: Array) -> Verdict | None:
    """The part that is beyond what is good by most, in its worst run of frames; None where none is
    for long. beyond (N, P): over 0 where it is."""
    beyond = beyond.clip(0.0)
    bad_runs = [
        (float(column[start : end + 1].sum()), part, start, end)
        for part, column in enumerate(beyond.T)
        for start, end in runs(column > 0)
        if end - start + 1 >= SHORTEST_RUN
    ]
    if not bad_runs:
        return None
    _, part, start, end = max(bad_runs)
    return Verdict(
        kind="check",
        cause=cause,
        part=skeleton.body.names[part],
        frames=(first + start, first + end),
        go=first + start + int(beyond[start : end + 1, part].argmax()),
    )


def _doubtful_joint(scene: Scene, first: int, joints: JointEvidence) -> Verdict:
    """The joint that is expected to be off by most, where it is, and the worst of these frames."""
    error = joints.error
    joint = int(error.sum(axis=0).argmax())
    at = error[:, joint]
    rows = np.flatnonzero(at >= 0.5 * at.max())
    hidden = joints.visibility[rows, joint].mean() < HIDDEN
    return Verdict(
        kind="check",
        cause="not_seen" if hidden else "uncertain",
        part=scene.skeleton.body.names[int(joints.parts[joint])],
        frames=(first + int(rows[0]), first + int(rows[-1])),
        go=first + int(at.argmax()),
    )


def _longest_run(frames: Collection[int]) -> tuple[int, int]:
    """First and last of the longest run of consecutive frames."""
    start = min(frames)
    flags = np.isin(np.arange(start, max(frames) + 1), list(frames))
    first, last = max(runs(flags), key=lambda run: run[1] - run[0])
    return start + first, start + last


def _lost(segment: Segment, evidence: _Evidence) -> Verdict:
    first, last = segment.first_frame, segment.last_frame
    if last - first < 2:
        return Verdict.contradiction(first, last)
    return Verdict.not_followed(min(max(first + _best_keyframe(evidence), first + 1), last - 1))


def _evidence(scene: Scene, outcome: Outcome) -> _Evidence:
    extent = extent_px(scene, outcome.trajectory)
    share = np.linspace(0.0, 1.0, len(outcome.apart_px))
    weight = 4 * share * (1 - share)
    apart = np.nan_to_num(outcome.apart_px, nan=NOWHERE_PX) * weight[:, None]
    return _Evidence(apart / extent, np.nan_to_num(outcome.drift_px, nan=NOWHERE_PX) / extent)


def _best_keyframe(evidence: _Evidence) -> int:
    """The frame, from the segment's first, where a keyframe would help most."""
    n = len(evidence.apart) - 1
    share = np.linspace(0.0, 1.0, n + 1)
    drift = np.concatenate([evidence.drift, evidence.drift[-1:]]).mean(axis=1)
    need = evidence.apart.mean(axis=1) + n * drift * share * (1 - share)
    return int(np.argmax(need)) if need.max() > 0 else n // 2


def _most_uncertain(scene: Scene, segment: Segment, evidence: _Evidence) -> tuple[int, int, int]:
    """The part with the strongest evidence against it: its index, first and last frame."""
    drift = evidence.drift * len(evidence.drift)
    strength = np.maximum(evidence.apart[1:] / CHECK_APART, drift / CHECK_DRIFT)
    mark = int(strength.max(axis=0).argmax())
    doubtful = np.flatnonzero(strength[:, mark] >= 0.5 * strength[:, mark].max())
    first, last = int(doubtful[0]), int(doubtful[-1])
    part = _carrier(scene, int(scene.marks[1][mark]))
    start = segment.first_frame + 1
    last = max(first, min(last, segment.last_frame - 1 - start))
    return part, start + first, start + last


def _carrier(scene: Scene, part: int) -> int:
    """The part itself where it is tracked, else what carries it: of a hand the forearm."""
    skeleton = scene.skeleton
    tracked = set(skeleton.dof_part.tolist())
    at = part
    while at >= 0 and at not in tracked:
        at = int(skeleton.parents[at])
    return part if at < 0 else at


def _is_hidden(
    segment: Segment, observation: Observation, part: int, first: int, last: int
) -> bool:
    """Whether the part was tracked but not seen in most of these frames."""
    start = segment.first_frame + 1
    within = slice(first - start, last - start + 1)
    looked = observation.diagnostics.rank[within] >= 0
    unseen = (observation.diagnostics.observability[within, part] < UNSEEN) | (
        observation.shown[within, part] == 0
    )
    return bool(2 * (unseen & looked).sum() > looked.sum())


def _longest_unseen(
    scene: Scene, segment: Segment, observation: Observation
) -> tuple[str, int, int] | None:
    """The part that is unseen for the longest run of frames: name, first and last frame."""
    hidden_runs = []
    for i, name in enumerate(scene.skeleton.body.names):
        hidden = (
            observation.diagnostics.observability[:, i] < UNSEEN
        )  # NaN, not tracked, is never below
        hidden_runs += [(last - first, name, first, last) for first, last in runs(hidden)]
    hidden_runs = [run for run in hidden_runs if run[0] + 1 >= SHORTEST_RUN]
    if not hidden_runs:
        return None
    _, name, first, last = max(hidden_runs)
    start = segment.first_frame + 1
    return name, start + first, start + last


def segment_result(
    scene: Scene, segment: Segment, outcome: Outcome, method: Method, enlarged: float
) -> SegmentResult:
    """The result of an outcome, judged where the method asks for it.

    enlarged: pixels of the video to one of the pictures worked on.
    """
    judged = isinstance(method, Paper) or method.judged
    observation = (observe if judged else unobserved)(scene, segment.clip, outcome.trajectory)
    error = depth = None
    if outcome.joints is not None:
        depth = outcome.joints.expected_depth_m(scene.skeleton.part_count, segment.to_posed_s)
        by_part = outcome.joints.expected_error(scene.skeleton.part_count)
        feet = outcome.joints.expected_foot_error(scene.skeleton.part_count)
        error = np.fmax(by_part, feet) * outcome.joints.height_px * enlarged
    diagnostics = replace(
        observation.diagnostics,
        expected_gain=expected_gain(scene, outcome, observation),
        expected_error=error,
        expected_depth=depth,
    )
    return SegmentResult(
        trajectory=outcome.trajectory,
        scores=tuple(step.score_or_nan for step in outcome.passes),
        steps=tuple(step.what for step in outcome.passes),
        best_pass=outcome.best,
        closing_error=max(
            outcome.gap, closing_error(outcome.trajectory, segment.start, segment.end)
        ),
        verdict=judge(scene, segment, outcome, observation),
        diagnostics=diagnostics,
        notes=outcome.notes,
    )
