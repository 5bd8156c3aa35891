"""The tracked motion on disk: `tracks-<hash>.npz` beside the session, written once, never changed.

The file is a plain NumPy archive. Its bytes depend on its content alone (no clock, no compression),
and its name on its bytes, so the same result is the same file. Frames run from the first tracked to
the last. Where a segment between them was not tracked, poses and diagnostics are NaN and ranks −1.
A preview measures nothing: its diagnostics are NaN and its ranks −1 where it was tracked, too.
Only `Tracks.tracked` says which frames have a pose.

    first_frame      ()              index of the first pose's video frame
    part_names       (P,)            text
    Rs_parent_part   (N, P, 3, 3)    rotations in the parents' frames
    ps_camera_root   (N, 3)          metres
    rank             (N−1,)          of the step from frame j to j + 1, as are the next three
    singular_values  (N−1, D)
    observability    (N−1, P)        0 to 1, NaN where nothing is tracked
    residual         (N−1, P)        grey levels, NaN where unseen
    need             (N,)            see `expected_gain`; NaN if unknown, absent from older files
    before_space_Rs_parent_part, before_space_ps_camera_root
                                     the poses as tracked, where the others are those of the last
                                     solve in space; absent where there was none
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.pose import Pose
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.errors import SessionError
from keypose.tracker.files import read_own, read_regular
from keypose.tracker.geometry.rotations import Array, frozen, transpose
from keypose.tracker.session.results import Results, SegmentSummary, SpaceSummary
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.archive import archive_arrays, archive_bytes
from keypose.tracker.storage.atomic import write_file
from keypose.tracker.storage.fingerprints import open_ends, setup_hash
from keypose.tracker.tracking.result import COLUMNS, Diagnostics, side_by_side

LARGEST_TRACKS_BYTES = 2**30
"""Hours of film; a larger file is not ours."""

if TYPE_CHECKING:
    from keypose.tracker.body.skeleton import Skeleton
    from keypose.tracker.space.result import SpaceResult
    from keypose.tracker.tracking.result import SegmentResult, TrackResult

_POSES = ("Rs_parent_part", "ps_camera_root")
_BEFORE = "before_space_"


@dataclass(frozen=True, eq=False)
class Tracks:
    """The motion of N frames, as far as it is known: the content of a tracks file.

    first_frame: index of the first pose's video frame.
    Rs_parent_part: (N, P, 3, 3), ps_camera_root: (N, 3) as in the module's table, read-only.
    before_space: the same two as tracked, where a last solve in space followed.
    """

    first_frame: int
    part_names: tuple[str, ...]
    Rs_parent_part: Array
    ps_camera_root: Array
    diagnostics: Diagnostics
    before_space: tuple[Array, Array] | None = None

    def __post_init__(self) -> None:
        for name in _POSES:
            object.__setattr__(self, name, frozen(getattr(self, name)))
        if self.before_space is not None:
            R, p = self.before_space
            object.__setattr__(self, "before_space", (frozen(R), frozen(p)))

    @classmethod
    def of(cls, segments: Sequence[SegmentResult], skeleton: Skeleton) -> Tracks:
        """Finished segments side by side, with gaps where some are missing."""
        first = min(segment.first for segment in segments)
        count = max(segment.last for segment in segments) - first + 1
        parts, dofs = skeleton.part_count, skeleton.dof_count
        Rs, ps = _poses(segments, first, count, parts)
        solved = any(segment.before_space is not None for segment in segments)
        before = _poses([s.as_tracked for s in segments], first, count, parts) if solved else None
        pieces = [(s.first - first, s.diagnostics) for s in segments]
        return cls(
            first,
            skeleton.body.names,
            Rs,
            ps,
            Diagnostics.side_by_side(pieces, count, parts, dofs),
            before,
        )

    @property
    def as_tracked(self) -> Tracks:
        """Before the last solve in space."""
        if self.before_space is None:
            return self
        R, p = self.before_space
        return Tracks(self.first_frame, self.part_names, R, p, self.diagnostics)

    def in_world(self, session: Session) -> Tracks:
        """The motion in the world; itself where the session's camera stands still."""
        if session.camera_path is None:
            return self
        in_camera = Trajectory(self.first_frame, self.Rs_parent_part, self.ps_camera_root)
        here = session.film_camera.motion_to_world(in_camera)
        return replace(
            self,
            Rs_parent_part=here.Rs_parent_part,
            ps_camera_root=here.ps_camera_root,
            before_space=None,
        )

    def between(self, first: int, last: int) -> Tracks:
        """The frames first to last: fewer than these, or more, which have no poses."""
        at, count = self.first_frame - first, last - first + 1
        return Tracks(
            first,
            self.part_names,
            side_by_side([(at, self.Rs_parent_part)], count, self.Rs_parent_part.shape[1:]),
            side_by_side([(at, self.ps_camera_root)], count, (3,)),
            self.diagnostics.between(-at, count - 1 - at),
        )

    @property
    def tracked(self) -> NDArray[np.bool_]:
        """(N,) True for the frames that have a pose."""
        return np.asarray(np.isfinite(self.ps_camera_root).all(axis=1))

    def runs(self, tracked: bool = True) -> str:
        """The frames that are tracked, or those that are not, in words: "0 to 4, 9 to 12"."""
        frames = np.flatnonzero(self.tracked == tracked) + self.first_frame
        runs = np.split(frames, np.flatnonzero(np.diff(frames) > 1) + 1)
        return ", ".join(f"{run[0]} to {run[-1]}" if len(run) > 1 else str(run[0]) for run in runs)

    def pose(self, frame: int) -> Pose | None:
        """The pose at a frame, None where it is not tracked."""
        i = frame - self.first_frame
        if not 0 <= i < len(self.ps_camera_root) or not self.tracked[i]:
            return None
        return Pose(self.Rs_parent_part[i], self.ps_camera_root[i])

    @classmethod
    def from_bytes(cls, content: bytes) -> Tracks:
        """The content of a file's bytes; ValueError when they are not such a file."""
        arrays = archive_arrays(content)
        try:
            names = tuple(str(name) for name in arrays.pop("part_names"))
            first_frame = int(arrays.pop("first_frame"))
            Rs, ps = (arrays.pop(name) for name in _POSES)
            before = [arrays.pop(f"{_BEFORE}{name}", None) for name in _POSES]
            named = {column.stored_as: column.name for column in COLUMNS}
            columns = {named[name]: values for name, values in arrays.items()}
            solved = None if before[0] is None or before[1] is None else (before[0], before[1])
            tracks = cls(first_frame, names, Rs, ps, Diagnostics(**columns), solved)
            tracks._check()
        except (TypeError, KeyError, IndexError):  # missing, unknown, or without a shape
            raise ValueError("its entries are not those of a tracks file") from None
        return tracks

    def _check(self) -> None:
        """ValueError unless all arrays have the shapes of the table and the rotations are such."""
        frames, parts = len(self.ps_camera_root), len(self.part_names)
        dofs = self.diagnostics.singular_values.shape[-1]
        shapes = {"Rs_parent_part": (frames, parts, 3, 3), "ps_camera_root": (frames, 3)}
        shape_of = {name: getattr(self, name).shape for name in _POSES}
        if self.before_space is not None:
            shapes |= {f"{_BEFORE}{name}": shapes[name] for name in _POSES}
            both = zip(_POSES, self.before_space, strict=True)
            shape_of |= {f"{_BEFORE}{name}": rows.shape for name, rows in both}
        for column, rows in self.diagnostics.arrays():
            shapes[column.stored_as] = column.shape(frames, parts, dofs)
            shape_of[column.stored_as] = rows.shape
        for name, shape in shapes.items():
            if shape_of[name] != shape:
                raise ValueError(f"{name} has the shape {shape_of[name]} instead of {shape}")
        if self.before_space is not None:
            self.as_tracked._require_rotations()
        self._require_rotations()

    def _require_rotations(self) -> None:
        Rs = self.Rs_parent_part[self.tracked]
        if not np.allclose(Rs @ transpose(Rs), np.eye(3), atol=1e-6):
            raise ValueError("Rs_parent_part holds matrices that are no rotations")

    def to_bytes(self) -> bytes:
        """The file's bytes."""
        arrays: dict[str, NDArray[Any]] = {
            "first_frame": np.array(self.first_frame, dtype="<i8"),
            "part_names": np.array(self.part_names, dtype=np.str_),
            **{name: getattr(self, name).astype("<f8") for name in _POSES},
        }
        if self.before_space is not None:
            both = zip(_POSES, self.before_space, strict=True)
            arrays |= {f"{_BEFORE}{name}": rows.astype("<f8") for name, rows in both}
        for column, rows in self.diagnostics.arrays():
            if not column.optional or np.isfinite(rows).any():
                arrays[column.stored_as] = rows.astype(column.dtype)
        return archive_bytes(arrays)


def _poses(
    segments: Sequence[SegmentResult], first: int, count: int, parts: int
) -> tuple[Array, Array]:
    """Join the poses of segments side by side, NaN between them."""
    Rs = [(s.first - first, s.where_tracked(s.trajectory.Rs_parent_part)) for s in segments]
    ps = [(s.first - first, s.where_tracked(s.trajectory.ps_camera_root)) for s in segments]
    return side_by_side(Rs, count, (parts, 3, 3)), side_by_side(ps, count, (3,))


def save_result(
    session: Session, session_path: Path, result: TrackResult, space: Sequence[SpaceResult] = ()
) -> Session:
    """Write the tracks file beside the session file; the session that refers to it, not yet saved.

    The session is the one that was tracked; its results remember body, camera and masks.
    SessionError when there is no segment to write or the disk refuses.
    """
    if not result.segments:
        raise SessionError("There is no tracked segment to save.")
    segments = sorted(result.segments, key=lambda segment: segment.first)
    content = Tracks.of(segments, result.skeleton).to_bytes()
    name = tracks_name(content)
    place = session_path.parent / name
    if not _holds(place, content):
        write_file(place, content, overwrite=True, error=SessionError)
    results = Results(
        tracks=name,
        method=result.settings.method,
        quality=result.settings.quality,
        initial=result.settings.initial,
        left_out=result.settings.left_out,
        segments=tuple(_summary(segment, session) for segment in segments),
        space=tuple(_in_space(stretch) for stretch in space),
        tracked_for=setup_hash(session),
    )
    return session.changed({"results": results})


def load_tracks(session: Session, session_path: Path) -> Tracks:
    """The session's tracks file. SessionError in one sentence when it is missing or damaged."""
    done, again = _how_tracked(session, session_path)
    if session.subject.results is None:
        subject = session.subject_in(session_path.name)
        raise SessionError(f"{subject} has not been {done} yet: {again}.")
    path = session_path.parent / session.subject.results.tracks
    tracks = _read(path)
    if tracks.part_names != session.subject.body.names:
        raise SessionError(
            f"{path.name} was {done} with other parts than the session's body has: {again} again."
        )
    return tracks


def load_trajectory(session: Session, session_path: Path) -> Trajectory:
    """The tracked motion. SessionError when there is none, or when frames inside it are missing."""
    tracks = load_tracks(session, session_path)
    if not tracks.tracked.all():
        done, again = _how_tracked(session, session_path)
        subject = session.subject_in(session_path.name)
        raise SessionError(
            f"{subject} has not been {done} yet at frames {tracks.runs(False)}: {again}."
        )
    return Trajectory(tracks.first_frame, tracks.Rs_parent_part, tracks.ps_camera_root)


def _how_tracked(session: Session, session_path: Path) -> tuple[str, str]:
    """Such as "tracked", and the command that does it."""
    words = session.evidence.words
    return words.done, f"run `{words.command_line(session_path)}`"


def _summary(segment: SegmentResult, session: Session) -> SegmentSummary:
    """What the session's file says of a segment: the fields that both have."""
    fields = {
        name: _finite(getattr(segment, name))
        for name in SegmentSummary.model_fields
        if hasattr(segment, name)
    }
    return SegmentSummary(
        first_frame=segment.first,
        last_frame=segment.last,
        open_ends=tuple(frame for frame in segment.span if frame in open_ends(session)),
        **{**fields, "key": segment.key or None},
    )


def _in_space(stretch: SpaceResult) -> SpaceSummary:
    first, last = stretch.span
    return SpaceSummary(
        first_frame=first,
        last_frame=last,
        key=stretch.key,
        pins=stretch.pins,
        proposed=stretch.proposed,
        findings=stretch.findings,
        floor_m=stretch.floor_m,
    )


def _finite(value: Any) -> Any:
    """JSON has no NaN and no infinity."""
    if isinstance(value, tuple):
        return tuple(_finite(entry) for entry in value)
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    return value


def tracks_name(content: bytes) -> str:
    """The name of a tracks file with these bytes."""
    return f"tracks-{hashlib.sha256(content).hexdigest()[:12]}.npz"


def _holds(path: Path, content: bytes) -> bool:
    try:
        return read_own(path, LARGEST_TRACKS_BYTES) == content
    except OSError:
        return False


def _read(path: Path) -> Tracks:
    try:
        content = read_regular(path, LARGEST_TRACKS_BYTES)
    except OSError as error:
        raise SessionError(
            f"The tracks file {str(path)!r} cannot be read: {error.strerror or error}."
        ) from None
    try:
        if path.name != tracks_name(content):
            raise ValueError("its content does not fit its name")
        return Tracks.from_bytes(content)
    except ValueError as error:
        raise SessionError(f"The tracks file {str(path)!r} is damaged: {error}.") from None
