"""Collect the finished segments of a session, and what is needed to say what is wrong with them."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Final
from weakref import WeakKeyDictionary

import numpy as np

from keypose.tracker.body.angle_errors import angle_errors, direction_errors, in_metres
from keypose.tracker.body.body import Body
from keypose.tracker.body.film_camera import FilmCamera
from keypose.tracker.body.joint_angles import Joint
from keypose.tracker.body.limb_groups import limb_groups
from keypose.tracker.body.modify import height
from keypose.tracker.body.pose import part_transforms, pose_transforms
from keypose.tracker.body.ray_parts import parts_on_ray
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.geometry.view import NEAR_M
from keypose.tracker.review.segment_errors import depth_errors_m, gain
from keypose.tracker.session.annotations import Reviewed
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.by_id import ById
from keypose.tracker.storage.results import Results, Span
from keypose.tracker.tracking.result import SegmentResult

KEYED_FRAMES: Final = 8
"""What is expected to be mended in intervals up to this length is mostly the keyframes' own error,
which no keyframe more takes away."""
STILL_M: Final = 0.01
"""An answer counts as long as what was seen lies no farther from where it was."""


_DIRECTIONS: WeakKeyDictionary[SegmentResult, Array | None] = WeakKeyDictionary()
"""A result belongs to one body and one camera."""


@dataclass(frozen=True, eq=False)
class JudgedSegments:
    """tracks: by their spans.  parts: names.  reviewed: what a person said of the motion.

    skeleton, camera: None where only verdicts and gains are asked for.
    path: of the camera over the film; None where it stands still.
    guessed: whether the lens is a guess, so that nobody knows centimetres.
    halves: whether one keyframe more divides a segment, as it does in a film.
    """

    tracks: Mapping[Span, SegmentResult]
    parts: Sequence[str] = ()
    skeleton: Skeleton | None = None
    camera: Camera | None = None
    path: CameraPath | None = None
    guessed: bool = False
    reviewed: tuple[Reviewed, ...] = ()
    halves: bool = True

    @classmethod
    def of(cls, doc: Session, results: Results) -> JudgedSegments:
        """Judge a session; computed once for as long as nothing changes."""
        return _judged(ById(doc), ById(results))

    @classmethod
    def over(cls, doc: Session, fitting: Mapping[Span, SegmentResult]) -> JudgedSegments:
        """Judge a session whose present segments have these results, finished or not."""
        return cls(
            tracks={span: _keyed(doc, track) for span, track in fitting.items() if track.finished},
            parts=doc.subject.body.names,
            skeleton=Skeleton.of(doc.subject.body),
            camera=doc.view.camera,
            path=doc.camera_path,
            guessed=doc.view.lens_is_guess,
            reviewed=doc.subject.reviewed,
            halves=not doc.evidence.has_surface,
        )

    @cached_property
    def keyed_px(self) -> float:
        """What seems to be gained in short intervals: the keyframes' own error."""
        segment_results = [
            t for t in self.tracks.values() if t.diagnostics.expected_gain is not None
        ]
        short = [gain(t) for t in segment_results if t.last - t.first <= KEYED_FRAMES]
        return float(np.median(short)) if short else 0.0

    @cached_property
    def lengths(self) -> tuple[int, ...]:
        """The lengths of all segments, in frames."""
        return tuple(track.last - track.first for track in self.tracks.values())

    @cached_property
    def limbs(self) -> tuple[tuple[int, ...], ...]:
        """Indices of the parts that are looked at together."""
        if self.skeleton is None:
            return tuple((k,) for k in range(len(self.parts)))
        body = self.skeleton.body
        return tuple(tuple(body.index(name) for name in names) for _, names in limb_groups(body))

    def limb_of(self, part: str | None) -> tuple[int, ...]:
        """The parts looked at together with one; without one, with the root."""
        index = self.index(part)
        return next((limb for limb in self.limbs if index in limb), (index,))

    def index(self, part: str | None) -> int:
        """The index of a part, the root's where it is about the whole body, or about no part
        of it.
        """
        return 0 if part is None or part not in self.parts else list(self.parts).index(part)

    def name(self, index: int) -> str | None:
        """The name of a part; None where names are not known."""
        return self.parts[index] if index < len(self.parts) else None

    def in_world(self, track: SegmentResult) -> Trajectory:
        """The motion of a segment in the world."""
        if self.path is None:
            return track.trajectory
        over = self.path.between(track.first, track.last)
        return track.trajectory.carried(over.Ts_world_camera)

    def far_end_m(self, track: SegmentResult, frame: int, part: str | None) -> Array | None:
        """(3,) where the far end of a part lies, camera frame; None without a skeleton."""
        if self.skeleton is None:
            return None
        index = self.index(part)
        T = pose_transforms(self.skeleton, track.trajectory.pose(frame))[index]
        return np.asarray(T[:3, :3] @ far_end(self.skeleton.body, index) + T[:3, 3])

    def px_per_m(self, track: SegmentResult, frame: int, part: str | None) -> float | None:
        """Pixels that a metre across the line of sight spans where a part is; None where nobody
        knows."""
        if self.skeleton is None or self.camera is None:
            return None
        path, row = track.trajectory, frame - track.first
        Ts = part_transforms(self.skeleton, path.Rs_parent_part[row], path.ps_camera_root[row])
        depth = float(self.camera.depth(Ts[self.index(part), :3, 3]))
        return self.px_per_m_at(depth, frame) if depth > 0 else None

    def px_per_m_at(self, depth: float, frame: int) -> float:
        """Pixels that a metre across the line of sight spans at a depth, metres, at a frame."""
        assert self.camera is not None
        camera = FilmCamera(self.camera, self.path).at(frame)
        return math.sqrt(camera.fx * camera.fy) / depth

    def error_cm(
        self, track: SegmentResult, frame: int, part: str | None, px: float
    ) -> float | None:
        """Centimetres in space by which a part is expected to be off that is off by so many pixels
        in the picture; None where distances are a guess, or nobody knows."""
        scale = self.px_per_m(track, frame, part)
        if scale is None or self.guessed:
            return None
        return 100 * math.hypot(px / scale, self.depth_error_m(track, frame, part))

    def depth_error_m(self, track: SegmentResult, frame: int, part: str | None) -> float:
        """Metres along the view by which a part is expected to be off; 0 where nobody knows."""
        depths = depth_errors_m(track)
        return 0.0 if depths is None else float(depths[frame - track.first, self.index(part)])

    def direction_errors(self, track: SegmentResult) -> Array | None:
        """(n + 1, P) radians by which parts of a segment are expected to point elsewhere; None
        where no depth was lifted, or the body is not a person's. Found once for a segment."""
        if track not in _DIRECTIONS:
            observed = self._observed(track)
            if observed is None:
                return None
            _DIRECTIONS[track] = direction_errors(*observed)
        return _DIRECTIONS[track]

    def angle_errors(
        self, track: SegmentResult, joints: Collection[Joint]
    ) -> dict[Joint, Array] | None:
        """(n + 1, 3) radians by which the angles of these joints are expected to be off, the same
        way."""
        observed = self._observed(track)
        return None if observed is None else angle_errors(*observed, joints=joints)

    def _observed(self, track: SegmentResult) -> tuple[Skeleton, Trajectory, Array, Array] | None:
        """The body, its motion, and by how much joints are expected to be off, across the view and
        along it, metres."""
        diagnostics, motion = track.diagnostics, track.trajectory
        if self.skeleton is None or self.camera is None or not track.finished:
            return None
        if diagnostics.expected_error is None or diagnostics.expected_depth is None:
            return None
        zoom = 1.0 if self.path is None else self.path.between(track.first, track.last).zoom
        across_m = in_metres(diagnostics.expected_error, self.camera, motion.ps_camera_root, zoom)
        return self.skeleton, motion, across_m, diagnostics.expected_depth

    def height_px(self, track: SegmentResult) -> float | None:
        """How tall the body is in the picture in the middle of a segment; None where nobody
        knows."""
        if self.skeleton is None:
            return None
        scale = self.px_per_m(track, (track.first + track.last) // 2, None)
        return None if scale is None else scale * height(self.skeleton.body)

    def occluder(self, track: SegmentResult, frame: int, part: str) -> str | None:
        """The part of another limb that is seen in place of a part's far end; None where there is
        none, or nobody knows."""
        end = self.far_end_m(track, frame, part)
        if end is None or self.skeleton is None or self.camera is None or end[2] <= 0:
            return None
        origin, direction = self.camera.ray_to(end)
        pose, near = track.trajectory.pose(frame), NEAR_M / float(direction[2])
        parts_seen = parts_on_ray(self.skeleton, pose, origin, direction, near)
        limb = self.limb_of(part)
        return parts_seen[0] if parts_seen and self.index(parts_seen[0]) not in limb else None

    def answer(self, part: str | None, frame: int, span: Span | None = None) -> Reviewed | None:
        """What a person said of a part at a frame, where the motion is still that; the
        newest.

        span: of the segment that was looked at; neighbours share a keyframe.
        """
        limb = self.limb_of(part)
        for reviewed in reversed(self.reviewed):
            is_then = reviewed.first_frame <= frame <= reviewed.last_frame
            is_then = is_then and (span is None or span[0] <= reviewed.frame <= span[1])
            if is_then and self.index(reviewed.part) in limb and self.counts(reviewed):
                return reviewed
        return None

    def counts(self, reviewed: Reviewed) -> bool:
        """Whether the motion is still as it was when a person answered."""
        return reviewed.part in self.parts and self._is_as_seen(reviewed)

    def _is_as_seen(self, reviewed: Reviewed) -> bool:
        track = next((t for t in self.tracks.values() if t.first <= reviewed.frame <= t.last), None)
        end = None if track is None else self.far_end_m(track, reviewed.frame, reviewed.part)
        return end is not None and bool(np.linalg.norm(end - reviewed.seen_m) <= STILL_M)


def _keyed(doc: Session, track: SegmentResult) -> SegmentResult:
    """Without an expected error where a part was keyed by itself."""
    keys = [key for key in doc.subject.part_keyframes if track.first < key.frame < track.last]
    errors = track.diagnostics.expected_error
    if errors is None or not keys:
        return track
    errors = errors.copy()
    for key in keys:
        errors[key.frame - track.first, [doc.subject.body.index(name) for name in key.parts]] = 0.0
    return replace(track, diagnostics=replace(track.diagnostics, expected_error=errors))


def far_end(body: Body, index: int) -> tuple[float, float, float]:
    """A part's far end in its own frame, metres: where the next part begins, of several the middle
    one; of the last part of a limb the middle of its shape."""
    name = body.names[index]
    joints = [part.joint_m for part in body.parts if part.parent == name]
    if joints:
        return min(joints, key=lambda joint: abs(joint[0]))
    x, y, z = body.parts[index].shape.mesh().vertices.mean(axis=0)
    return float(x), float(y), float(z)


@lru_cache(maxsize=4)
def _judged(doc: ById, results: ById) -> JudgedSegments:
    session: Session = doc.it
    return JudgedSegments.over(session, results.it.fitting(session))
