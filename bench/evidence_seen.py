"""What tracking saw of each joint, and how far the joint is off, on filmed and rendered clips.

Filmed clips are tracked between keyframes posed on marks, rendered ones between true keyframes, all
disturbed a little. On rendered clips a limb is turned at a keyframe as well, or the body put beside
the person. Evidence is collected once and kept.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any
from unittest.mock import patch

import numpy as np
from numpy.typing import NDArray

from bench.calibration import without_marks
from bench.clips import clip
from bench.keeping import ROOT, Absent, digest, place_for
from bench.keyed import jittered, keyed
from bench.keypoints import SHORT
from bench.measures import TALL_PX
from bench.real import BOTH, NETWORK, Posed, with_settings
from bench.sequences import Sequence as Film
from bench.sequences import sequence
from bench.tracking import keyframes_every, track
from keypose.tracker.body.modify import height
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, exp_rotation
from keypose.tracker.keypoints.blazepose import NAMES
from keypose.tracker.keypoints.keypoints import JOINTS
from keypose.tracker.keypoints.model_files import find_model
from keypose.tracker.keypoints.on_body import height_px, points_on_body
from keypose.tracker.session.settings import TrackSettings
from keypose.tracker.solver.posed import BodyPoints
from keypose.tracker.tracking.cues.joint_evidence import NEAR, JointEvidence
from keypose.tracker.tracking.cues.sources import DetectedKeypoints
from keypose.tracker.tracking.diagnostics import judge
from keypose.tracker.tracking.result import SegmentResult
from keypose.tracker.tracking.tracker import Tracker
from keypose.tracker.video import Video

FILMED: dict[str, tuple[tuple[int, ...], ...]] = {
    "person": ((0, 15, 30, 45, 60, 75, 90), (0, 30, 60, 90), (15, 45, 75), (0, 45, 90), (0, 60),
               (30, 90), (0, 90)),
    "walk": ((30, 40, 50, 60, 70, 80, 90), (30, 50, 70, 90), (40, 60, 80), (30, 60, 90),
             (30, 70), (50, 90)),
    "arms": ((20, 40, 60), (20, 60), (20, 30, 50, 60)),
    "camera4": ((0, 30, 60, 90), (15, 45, 75), (0, 45, 90), (0, 60), (30, 90)),
}  # fmt: skip
"""By clip the sets of keyframes that are posed on their marks."""
RENDERED = {
    f"rendered {name}": name
    for name in (
        "walk",
        "jump",
        "wash",
        "pirouette",
        "jumping_jacks",
        "stride",
        "throw",
        "speech",
        "shelf",
        "crossing",
    )
}
INTERVALS = (20, 60)
DISTURBED = 40
"""Frames from one keyframe to the next, where one of them is wrong the second."""
MARK_PX = {"person": 3.5, "walk": 4.6, "arms": 3.8, "camera4": 3.0}
"""By which marks are off, on a person 400 px tall: 2 px of the picture across and down, or by how
much two people's differ. Keyframes are posed on the same marks, so that what all of a joint's
marks are off alike is no error here."""
TURNED_RAD = np.radians(30.0)
BESIDE = 0.2
"""A limb at a keyframe is turned by so much; a body lies by such a share of its height beside the
person."""
LIMBS = ("upper_arm", "forearm", "thigh", "shin")
EVERY = 3
"""Of frames of rendered clips one in so many is looked at: errors last longer than a frame."""
JOINT = (
    "wrong_by",
    "apart",
    "drift",
    "away",
    "distance",
    "visibility",
    "expected",
    "part",
)
"""Columns of a joint: what it is off by, the evidence, the error expected of it, and the part that
carries it."""


@dataclass(frozen=True, eq=False)
class Evidence:
    """What was seen of J joints in G segments.

    joints (J, 8): see JOINT, shares of the height.  of (J,): the segment each is of.
    clips (G,), kinds (G,): names, and verdicts.  part (G,): which the verdict names, −1 for none.
    off (G,): whether the body of one of its keyframes lies beside the person.
    """

    joints: Array
    of: NDArray[np.int64]
    clips: NDArray[np.str_]
    kinds: NDArray[np.str_]
    part: NDArray[np.int64]
    off: NDArray[np.bool_]

    def column(self, name: str) -> Array:
        return np.asarray(self.joints[:, JOINT.index(name)])

    @property
    def clip_of_joint(self) -> NDArray[np.str_]:
        return np.asarray(self.clips[self.of])

    @property
    def error(self) -> Array:
        """(J,) what joints are off by, without what their marks are."""
        mark = np.array([MARK_PX.get(name, 0.0) for name in self.clips]) / TALL_PX
        return without_marks(self.column("wrong_by"), mark[self.of])

    @property
    def predicted(self) -> NDArray[np.bool_]:
        """(J,) of which an error is expected: not where keypoints lie on another body."""
        return np.isfinite(self.column("expected"))

    def of_joints(self, rows: NDArray[np.bool_]) -> Evidence:
        """With some of the joints alone."""
        return Evidence(
            self.joints[rows], self.of[rows], self.clips, self.kinds, self.part, self.off
        )


def kept_evidence() -> Evidence:
    sources = [ROOT / "tracker" / name for name in ("keypoints", "solver", "tracking")]
    sources += [
        ROOT / "bench" / name for name in ("evidence_seen.py", "clips.py", "real_marks.json")
    ]
    kept = place_for("evidence", digest(*sources), ".npz")
    if not kept.is_file():
        found = [*_collected(FILMED, _of_filmed), *_collected(RENDERED, _of_rendered)]
        if not found:
            raise Absent("a clip")
        np.savez(
            kept,
            joints=np.concatenate([np.array(one.joints) for one in found]),
            of=np.repeat(np.arange(len(found)), [len(one.joints) for one in found]),
            clips=[one.clip for one in found],
            kinds=[one.kind for one in found],
            part=[one.part for one in found],
            off=[one.off for one in found],
        )
    with np.load(kept) as found:
        return Evidence(**found)


@dataclass(frozen=True, eq=False)
class _Seen:
    """One segment with known joints inside: see `Evidence`."""

    clip: str
    joints: list[tuple[float, ...]]
    kind: str
    part: int
    off: bool


def _collected(
    names: Mapping[str, Any] | Sequence[str], of: Callable[[str], Iterator[_Seen]]
) -> list[_Seen]:
    """All segments of clips that are here."""
    found: list[_Seen] = []
    for name in names:
        try:
            found += [one for one in of(name) if one.joints]
        except Absent:
            continue
    return found


def _of_filmed(name: str) -> Iterator[_Seen]:
    """Segments between keyframes that were posed on marks, disturbed a little."""
    shown, way = clip(name), with_settings(TrackSettings(cues=BOTH, network=NETWORK))
    for keyframes in FILMED[name]:
        hand = keyed(shown, keyframes)
        reference = shown.reference(hand.skeleton.body)
        order = [k for k, joint in enumerate(reference.names) if joint in SHORT]
        uv = np.full((int(reference.frames.max()) + 1, len(JOINTS), 2), np.nan)
        at = [JOINTS.index(SHORT[reference.names[k]]) for k in order]
        uv[reference.frames[:, None], at] = reference.positions[:, order]
        with Video.open(shown.video) as video:
            posed = Posed(shown, video, hand.skeleton, hand.poses)
            with _judged() as joints:
                segments = way(posed.disturbed(0)).segments
        for found in segments:
            yield _of_segment(name, found, joints, hand.skeleton, shown.camera, uv, off=False)


def _of_rendered(name: str) -> Iterator[_Seen]:
    """Segments between true keyframes: disturbed a little; with a limb turned; beside the body."""
    film = sequence(RENDERED[name])
    uv = _truth(film)
    uv[np.arange(len(uv)) % EVERY > 0] = np.nan
    video, model = film.video(), find_model(NETWORK)
    source = DetectedKeypoints(video, film.camera, model=model)
    for poses, beside in _disturbed(name, film):
        tracker = Tracker(video, film.camera, film.skeleton, poses, keypoints=source)
        with _judged() as joints:
            segments = track(tracker, cues=BOTH, network=NETWORK).segments
        for found in segments:
            off = beside in found.span
            yield _of_segment(name, found, joints, film.skeleton, film.camera, uv, off=off)


def _disturbed(name: str, film: Film) -> Iterator[tuple[dict[int, Pose], int | None]]:
    """Poses at keyframes, and the keyframe whose body lies beside the person."""
    last = len(film.grey) - 1
    for interval in INTERVALS:
        frames = keyframes_every(min(interval, last), 0, last)
        yield jittered(film.skeleton, film.keyposes(frames), interval), None
    rng = np.random.default_rng(list(name.encode()))
    frames = keyframes_every(min(DISTURBED, last), 0, last)
    poses, wrong = film.keyposes(frames), int(rng.choice(frames))
    limb = f"{rng.choice(['left', 'right'])}_{rng.choice(LIMBS)}"
    yield {**poses, wrong: _turned(film.skeleton, poses[wrong], limb)}, None
    aside = np.array([BESIDE * height(film.skeleton.body), 0.0, 0.0])
    moved = Pose(poses[wrong].Rs_parent_part, poses[wrong].p_camera_root + aside)
    yield {**poses, wrong: moved}, wrong


def _turned(skeleton: Skeleton, pose: Pose, part: str) -> Pose:
    """With a part turned, about an axis that shows in the picture whichever way it points."""
    Rs, index = pose.Rs_parent_part.copy(), skeleton.body.index(part)
    Rs[index] = Rs[index] @ exp_rotation(TURNED_RAD * np.array([1.0, 0.0, 1.0]) / np.sqrt(2))
    return Pose(Rs, pose.p_camera_root)


def _truth(film: Film) -> Array:
    """(F, 12, 2) where the joints are in every frame."""
    p = _joints(film.skeleton).at(film.truth.transforms(film.skeleton))
    return np.asarray(film.camera.project(p))


def _joints(skeleton: Skeleton) -> BodyPoints:
    """Where `JOINTS` lie on a body."""
    _, parts, points = points_on_body(skeleton.body, JOINTS)
    return BodyPoints.single(skeleton, parts, points)


def _of_segment(
    name: str,
    found: SegmentResult,
    judged: Mapping[int, JointEvidence],
    skeleton: Skeleton,
    camera: Camera,
    uv: Array,
    *,
    off: bool,
) -> _Seen:
    """What was seen of the joints that are known inside a segment."""
    verdict, path = found.verdict, found.trajectory
    assert verdict is not None
    body = skeleton.body
    seen, parts = judged.get(found.first), points_on_body(body, JOINTS).part
    on_body = [NAMES[index] for index in points_on_body(body, NAMES).indices.tolist()]
    tall = height_px(skeleton, camera, path.pose(found.first))
    ours = camera.project(_joints(skeleton).at(path.transforms(skeleton)))
    joints = []
    for row in range(1, min(len(path) - 1, len(uv) - found.first)):
        away = np.linalg.norm(ours[row] - uv[found.first + row], axis=-1) / tall
        for joint in np.flatnonzero(np.isfinite(away)).tolist():
            column = on_body.index(JOINTS[joint])
            what = (np.nan,) * 6 if seen is None else _evidence(seen, row, column)
            joints.append((float(away[joint]), *what, float(parts[joint])))
    part = -1 if verdict.part is None else body.index(verdict.part)
    return _Seen(name, joints, verdict.kind, part, off)


def _evidence(joints: JointEvidence, row: int, column: int) -> tuple[float, ...]:
    """All columns of a joint but the first and the last."""
    near = slice(max(row - NEAR, 0), row + NEAR + 1)
    distance = joints.distance[near, column]
    return (
        float(joints.apart[near, column].mean()),
        float(joints.drift[near, column].mean()),
        float(min(row, len(joints.distance) - 1 - row)),
        float(np.nanmax(distance)) if np.isfinite(distance).any() else np.nan,
        float(joints.visibility[near, column].mean()),
        float(joints.error[row, column]),
    )


@contextmanager
def _judged() -> Iterator[dict[int, JointEvidence]]:
    """By their first frames, the evidence of all segments that are judged by it meanwhile."""
    found: dict[int, JointEvidence] = {}
    before = judge._judge_joints

    def noting(scene: Any, segment: Any, joints: JointEvidence) -> Any:
        found[segment.first_frame] = joints
        return before(scene, segment, joints)

    with patch.object(judge, "_judge_joints", noting):
        yield found
