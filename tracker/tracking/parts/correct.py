"""Correct a tracked segment where a person set limbs right between its keyframes.

The rest of the body stays exactly as it was tracked. Of each limb that was set right the frames
between two at which it is known are tracked anew, as a segment of their own in which nothing but
the limb can move: from its motion closed on both ends, and from following the body in the picture
from both ends, of which the limb's turns are taken. What is found of a limb depends on no other one
that was set right but its counterpart on the other side, which tells left from right: an arm that
is corrected changes nothing of a leg.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Generator, Sequence
from dataclasses import dataclass, replace
from threading import Lock
from typing import TypeAlias

import numpy as np

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Pass, Trajectory, joined
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.session.settings import Quality
from keypose.tracker.tracking.anchored_cycle import track_anchored
from keypose.tracker.tracking.cues.anchors import anchors_of
from keypose.tracker.tracking.cues.joint_evidence import JointEvidence
from keypose.tracker.tracking.cues.other_film import OtherFilm
from keypose.tracker.tracking.cycle import Outcome, Work, track_from
from keypose.tracker.tracking.frame_pair import capped_score
from keypose.tracker.tracking.initial.chains import Chain, blend_chains, follow_both
from keypose.tracker.tracking.initial.choose import Starts
from keypose.tracker.tracking.method import Keypose, Method
from keypose.tracker.tracking.parts.limb_keyframes import (
    KeyedLimb,
    KeyedParts,
    keyed_limbs,
    tracking_only,
)
from keypose.tracker.tracking.parts.limb_segment import (
    LimbSegment,
    closed_on,
    closed_pieces,
    limb_anchors,
    limb_film,
    other_side,
    with_limb,
    with_parts,
)
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.tracking.segment import Segment

Kind: TypeAlias = tuple[str, Quality, str]
"""What identifies an outcome: the segment's key without part keyframes, quality, all settings."""

MOST_FRAMES = 4000
"""Of all that is kept together; some 15 kB each."""


class KeptOutcomes:
    """Outcomes of segments as tracked, the latest ones; used by several threads."""

    def __init__(self) -> None:
        self._kept: OrderedDict[Kind, Outcome] = OrderedDict()
        self._lock = Lock()

    def get(self, kind: Kind) -> Outcome | None:
        """The outcome of this kind; of a preview also a better one of the same segment, so
        that nothing but a limb is seen to change while it is corrected.
        """
        key, quality, _ = kind
        with self._lock:
            better = [k for k in self._kept if k[0] == key and k[1] != "preview"]
            if kind not in self._kept and quality == "preview" and better:
                kind = better[-1]
            outcome = self._kept.get(kind)
            if outcome is not None:
                self._kept.move_to_end(kind)
            return outcome

    def keep(self, kind: Kind, outcome: Outcome) -> None:
        with self._lock:
            self._kept[kind] = outcome
            frames = sum(len(kept_outcome.trajectory) for kept_outcome in self._kept.values())
            while frames > MOST_FRAMES and len(self._kept) > 1:
                _, oldest = self._kept.popitem(last=False)
                frames -= len(oldest.trajectory)


@dataclass(frozen=True, eq=False)
class Evidence:
    """What a limb is tracked from: the pictures, and keypoints where there are any.

    scene, free: of the whole body, as it is tracked, and with free joints where keypoints count.
    camera: of the video, with its distortion.  films: what others show of the segment.
    """

    scene: Scene
    free: Scene | None = None
    camera: Camera | None = None
    keypoints: Keypoints | None = None
    brightness: bool = True
    films: Sequence[OtherFilm] = ()


def corrected(
    base: Outcome, segment: Segment, keyed: Sequence[KeyedParts], method: Method, evidence: Evidence
) -> Work:
    """The outcome of a segment with limbs where they were set right; yields what is found on the
    way. `base`: without them."""
    skeleton = evidence.scene.skeleton
    first = Pass("limbs", closed_on(skeleton, base.trajectory, tuple(keyed)), None)
    yield first
    if not isinstance(method, Keypose):
        return replace(base, passes=(*base.passes, first), best=len(base.passes))
    outcome = base
    for limb in keyed_limbs(skeleton, keyed):
        body = _beside(base.trajectory, outcome.trajectory, limb, skeleton)
        outcome = yield from _limb_corrected(outcome, body, segment, limb, method, evidence)
    return outcome


def _beside(base: Trajectory, now: Trajectory, limb: KeyedLimb, skeleton: Skeleton) -> Trajectory:
    """What a limb is tracked beside: the motion without corrections, but for its
    counterpart.
    """
    counterpart = np.array(other_side(skeleton, limb.parts), dtype=np.int64)
    return with_parts(base, now, counterpart)


def expected_limb_steps(skeleton: Skeleton, keyed: Sequence[KeyedParts], whole: int) -> int:
    """How many trajectories `corrected` is expected to yield, with so many of a whole
    segment.
    """
    limbs = keyed_limbs(skeleton, keyed)
    return 1 + sum((len(limb.keyed) + 1) * whole + 1 for limb in limbs)


def _limb_corrected(
    outcome: Outcome,
    body: Trajectory,
    segment: Segment,
    limb: KeyedLimb,
    method: Keypose,
    evidence: Evidence,
) -> Work:
    """outcome: with what was corrected before.  body: what the limb is tracked beside."""
    pieces = closed_pieces(evidence.scene.skeleton, body, limb)
    trajectories: list[Trajectory] = [piece for piece, _ in pieces]
    outcomes: list[Outcome | None] = []
    tried: list[Pass] = []
    for k, (piece, (start, end)) in enumerate(pieces):
        part = LimbSegment(
            piece.first_frame,
            piece.last_frame,
            start,
            end,
            segment.clip,
            given=piece,
            parts=limb.parts,
        )
        work = _tracked(part, segment, method, evidence)
        own = yield from _whole(work, trajectories, k, tried, outcome.trajectory, limb)
        outcomes.append(own)
        if own is not None:  # all but the limb as it was given, to the last digit
            trajectories[k] = with_limb(piece, own.trajectory, limb.parts, start, end)
    motion = with_parts(outcome.trajectory, joined(trajectories), limb.parts)
    last = Pass("limbs", motion, _score(segment, method, evidence, motion))
    tried.append(last)
    yield last
    return _together(outcome, tried, limb, outcomes, pieces_rows(trajectories), evidence.scene)


def _whole(
    work: Generator[Pass, None, Outcome | None],
    trajectories: Sequence[Trajectory],
    k: int,
    tried: list[Pass],
    rest: Trajectory,
    limb: KeyedLimb,
) -> Generator[Pass, None, Outcome | None]:
    """What is found of the kth piece as a motion of all pieces and the rest."""
    while True:
        try:
            step = next(work)
        except StopIteration as done:
            own: Outcome | None = done.value
            return own
        whole = joined([*trajectories[:k], step.trajectory, *trajectories[k + 1 :]])
        tried.append(Pass("limbs", with_parts(rest, whole, limb.parts), None))
        yield tried[-1]


def _tracked(
    segment: LimbSegment, whole: Segment, method: Keypose, evidence: Evidence
) -> Generator[Pass, None, Outcome | None]:
    """The limb between two frames at which it is known; None where nothing of it is tracked."""
    parts = tuple(segment.parts.tolist())
    scene = _only(evidence.scene, parts)
    if not scene.skeleton.dof_count or len(segment.given) < 3:
        return None
    begun = _starts(evidence.scene, segment, method)
    if evidence.keypoints is not None and evidence.free is not None and evidence.camera is not None:
        free = _only(evidence.free, parts)
        candidates = anchors_of(free, whole, evidence.camera, evidence.keypoints)
        if candidates:
            anchors = limb_anchors(candidates, segment, whole, free)
            by_brightness = begun if evidence.brightness else None
            shown = [limb_film(film, segment, whole, free.skeleton) for film in evidence.films]
            films = [film for film in shown if film is not None]
            work = track_anchored(
                *(scene, free, segment, method, [anchors], by_brightness),
                films=films,
                reach_far=False,
            )
            return (yield from work)
    return (yield from track_from(scene, segment, method, begun))


def _starts(scene: Scene, segment: LimbSegment, method: Keypose) -> Starts:
    """The limb followed from both ends, with the body that carries it, and its motion closed on
    them; the better first. scene: of the whole body."""
    closed = Pass("limbs", segment.given, None)
    chains = follow_both(scene, segment, method)
    if chains is None:
        return Starts((closed,))
    own = tuple(_limb_of(chain, segment) for chain in chains)
    both = Pass("both ways", _limb_of(blend_chains(scene, *chains), segment), None)
    ways = [both, closed]
    scored = [
        replace(start, score=capped_score(scene, segment.clip, start.trajectory, method.stride))
        for start in ways
    ]
    scored.sort(key=lambda start: start.score_or_nan)
    return Starts(tuple(scored), (own[0], own[1]))


def _limb_of(trajectory: Trajectory, segment: LimbSegment) -> Chain:
    """The given motion with the limb as it was found."""
    whole = with_parts(segment.given, trajectory, segment.parts)
    if isinstance(trajectory, Chain):
        R, t = whole.writable()
        return Chain(segment.first_frame, R, t, trajectory.doubt)
    return Chain.even(whole)


def _only(scene: Scene, parts: tuple[int, ...]) -> Scene:
    return scene.of_skeleton(tracking_only(scene.skeleton, parts))


def _score(
    segment: Segment, method: Keypose, evidence: Evidence, motion: Trajectory
) -> float | None:
    if not method.judged:
        return None
    return capped_score(evidence.scene, segment.clip, motion, method.stride)


def pieces_rows(pieces: Sequence[Trajectory]) -> list[slice]:
    """The rows of each in the motion that they make up."""
    first = pieces[0].first_frame
    return [slice(p.first_frame - first, p.last_frame - first + 1) for p in pieces]


def _together(
    base: Outcome,
    tried: Sequence[Pass],
    limb: KeyedLimb,
    own: Sequence[Outcome | None],
    rows: Sequence[slice],
    scene: Scene,
) -> Outcome:
    """The outcome with what is known of the limb put in."""
    marks = np.isin(scene.marks[1], limb.parts)
    apart, drift = base.apart_px.copy(), base.drift_px.copy()
    for outcome, piece in zip(own, rows, strict=True):
        steps = slice(piece.start, piece.stop - 1)
        apart[piece, marks] = 0.0 if outcome is None else outcome.apart_px[:, marks]
        drift[steps, marks] = 0.0 if outcome is None else outcome.drift_px[:, marks]
    return replace(
        base,
        passes=(*base.passes, *tried),
        best=len(base.passes) + len(tried) - 1,
        apart_px=apart,
        drift_px=drift,
        diverged=base.diverged or any(o is not None and o.diverged for o in own),
        joints=_joints(base.joints, limb, own, rows),
    )


def _joints(
    base: JointEvidence | None,
    limb: KeyedLimb,
    own: Sequence[Outcome | None],
    rows: Sequence[slice],
) -> JointEvidence | None:
    """Joints that the limb carries as they are now; where it was set right nothing is in doubt."""
    if base is None:
        return None
    of_limb = np.isin(base.parts, limb.parts)
    before = (base.distance, base.visibility, base.apart, base.drift)
    distance, visibility, apart, drift = (values.copy() for values in before)
    for outcome, piece in zip(own, rows, strict=True):
        if outcome is None or outcome.joints is None:
            continue
        joint_evidence = outcome.joints
        distance[piece, of_limb] = joint_evidence.distance[:, of_limb]
        visibility[piece, of_limb] = joint_evidence.visibility[:, of_limb]
        apart[piece, of_limb] = joint_evidence.apart[:, of_limb]
        drift[piece, of_limb] = joint_evidence.drift[:, of_limb]
    for piece in rows[1:]:
        for values in (distance, apart, drift):
            values[piece.start, of_limb] = 0.0
        visibility[piece.start, of_limb] = 1.0
    return replace(base, distance=distance, visibility=visibility, apart=apart, drift=drift)
