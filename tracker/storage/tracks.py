"""The tracked motion on disk: `tracks-<hash>.npz` beside the session, written once, never changed.

The file is a plain NumPy archive. Its bytes depend on its content alone (no clock, no compression),
and its name on its bytes, so the same result is the same file. Frames run from the first tracked to
the last. Where a segment between them was not tracked, poses and diagnostics are NaN and ranks −1.
A preview measures nothing: its diagnostics are NaN and its ranks −1 where it was tracked, too.
Which frames have a pose is told by `Tracks.tracked` alone.

    first_frame      ()              index of the first pose's video frame
    part_names       (P,)            text
    Rs_parent_part   (N, P, 3, 3)    rotations in the parents' frames
    ps_camera_root   (N, 3)          metres
    rank             (N−1,)          of the step from frame j to j + 1, as are the next three
    singular_values  (N−1, D)
    observability    (N−1, P)        0 to 1, NaN where nothing is tracked
    residual         (N−1, P)        grey levels, NaN where unseen
    need             (N,)            see `expected_gain`; NaN if unknown, absent from older files
"""

from __future__ import annotations

import hashlib
import math
import shlex
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from tracker.body.pose import Pose
from tracker.body.trajectory import Trajectory
from tracker.errors import SessionError
from tracker.files import read_own, read_regular
from tracker.geometry.rotations import Array, frozen, transpose
from tracker.session.results import Results, SegmentSummary
from tracker.session.schema import Session
from tracker.storage.archive import archive_arrays, archive_bytes
from tracker.storage.atomic import write_file
from tracker.storage.fingerprints import open_ends, setup_hash

LARGEST_TRACKS_BYTES = 2**30
"""Hours of film; what is larger was put there by somebody else."""

if TYPE_CHECKING:
    from tracker.tracking.pool import SegmentResult, TrackResult


_POSES = ("Rs_parent_part", "ps_camera_root")
_STEPS = ("singular_values", "observability", "residual")


@dataclass(frozen=True, eq=False)
class Tracks:
    """The content of a tracks file, its fields as in the module's table, arrays read-only."""

    first_frame: int
    part_names: tuple[str, ...]
    Rs_parent_part: Array
    ps_camera_root: Array
    rank: NDArray[np.int64]
    singular_values: Array
    observability: Array
    residual: Array
    need: Array | None = None

    def __post_init__(self) -> None:
        for name in (*_POSES, *_STEPS):
            object.__setattr__(self, name, frozen(getattr(self, name)))
        if self.need is not None:
            object.__setattr__(self, "need", frozen(self.need))
        rank = np.array(self.rank, dtype=np.int64)
        rank.setflags(write=False)
        object.__setattr__(self, "rank", rank)

    @classmethod
    def of(cls, result: TrackResult) -> Tracks:
        """The finished segments of a result side by side, with gaps where some are missing."""
        segments = sorted(result.segments, key=lambda s: s.trajectory.first_frame)
        first = segments[0].trajectory.first_frame
        count = max(s.trajectory.last_frame for s in segments) - first + 1
        dofs = segments[0].singular_values.shape[-1]
        shapes = _shapes(count, result.skeleton.part_count, dofs)
        arrays = {name: np.full(shape, np.nan) for name, shape in shapes.items()}
        rank, need = np.full(count - 1, -1), np.full(count, np.nan)
        for segment in segments:
            _lay(segment, segment.trajectory.first_frame - first, arrays, rank)
            if segment.need is not None:  # zero at the keyframes, where segments meet
                start = segment.trajectory.first_frame - first
                need[start : start + len(segment.need)] = segment.need
        known = need if np.isfinite(need).any() else None
        return cls(first, result.skeleton.body.names, rank=rank, need=known, **arrays)

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
            tracks = cls(first_frame, names, **arrays)
            tracks._check()
        except (TypeError, KeyError, IndexError):  # missing, unknown, or without a shape
            raise ValueError("its entries are not those of a tracks file") from None
        return tracks

    def _check(self) -> None:
        """ValueError unless all arrays have the shapes of the table and the rotations are such."""
        frames, dofs = len(self.ps_camera_root), self.singular_values.shape[-1]
        shapes = {**_shapes(frames, len(self.part_names), dofs), "rank": (frames - 1,)}
        for name, shape in shapes.items():
            found = getattr(self, name).shape
            if found != shape:
                raise ValueError(f"{name} has the shape {found} instead of {shape}")
        if self.need is not None and self.need.shape != (frames,):
            raise ValueError(f"need has the shape {self.need.shape} instead of {(frames,)}")
        Rs = self.Rs_parent_part[self.tracked]
        if not np.allclose(Rs @ transpose(Rs), np.eye(3), atol=1e-6):
            raise ValueError("Rs_parent_part holds matrices that are no rotations")

    def to_bytes(self) -> bytes:
        """The file's bytes."""
        arrays: dict[str, NDArray[Any]] = {
            "first_frame": np.array(self.first_frame, dtype="<i8"),
            "part_names": np.array(self.part_names, dtype=np.str_),
            "rank": self.rank.astype("<i8"),
            **{name: getattr(self, name).astype("<f8") for name in (*_POSES, *_STEPS)},
        }
        if self.need is not None:
            arrays["need"] = self.need.astype("<f8")
        return archive_bytes(arrays)


def save_result(session: Session, session_path: Path, result: TrackResult) -> Session:
    """Write the tracks file beside the session file; the session that refers to it, not yet saved.

    The session is the one that was tracked; its results remember body, camera and masks.
    SessionError when there is no segment to write or the disk refuses.
    """
    if not result.segments:
        raise SessionError("There is no tracked segment to save.")
    content = Tracks.of(result).to_bytes()
    name = tracks_name(content)
    place = session_path.parent / name
    if not _holds(place, content):
        write_file(place, content, overwrite=True, error=SessionError)
    segments = sorted(result.segments, key=lambda s: s.trajectory.first_frame)
    results = Results(
        tracks=name,
        method=result.settings.method,
        quality=result.settings.quality,
        initial=result.settings.initial,
        left_out=result.settings.left_out,
        segments=tuple(_summary(segment, session) for segment in segments),
        tracked_for=setup_hash(session),
    )
    return session.model_copy(update={"results": results})


def load_tracks(session: Session, session_path: Path) -> Tracks:
    """The session's tracks file. SessionError in one sentence when there is none or it is odd."""
    done, again = _work(session, session_path)
    if session.results is None:
        raise SessionError(f"{session_path.name} has not been {done} yet: {again}.")
    path = session_path.parent / session.results.tracks
    tracks = _read(path)
    if tracks.part_names != session.body.names:
        raise SessionError(
            f"{path.name} was {done} with other parts than the session's body has: {again} again."
        )
    return tracks


def load_trajectory(session: Session, session_path: Path) -> Trajectory:
    """The tracked motion. SessionError when there is none, or when frames inside it are missing."""
    tracks = load_tracks(session, session_path)
    if not tracks.tracked.all():
        done, again = _work(session, session_path)
        raise SessionError(
            f"{session_path.name} has not been {done} yet at frames {tracks.runs(False)}: {again}."
        )
    return Trajectory(tracks.first_frame, tracks.Rs_parent_part, tracks.ps_camera_root)


def _work(session: Session, session_path: Path) -> tuple[str, str]:
    """What is done to a session, and how it is done."""
    path = shlex.quote(str(session_path))
    if session.surface is not None:
        return "fitted", f"run `keypose fit --session {path}`"
    return "tracked", f"run `keypose track {path}`"


def _lay(
    segment: SegmentResult, start: int, arrays: Mapping[str, Array], rank: NDArray[np.int64]
) -> None:
    """Copy a segment's arrays to their place among all frames."""
    frames = slice(start, start + len(segment.trajectory))
    steps = slice(frames.start, frames.stop - 1)
    arrays["Rs_parent_part"][frames] = segment.trajectory.Rs_parent_part
    arrays["ps_camera_root"][frames] = segment.trajectory.ps_camera_root
    if segment.unreached is not None:
        shift = start - segment.trajectory.first_frame
        first, last = segment.unreached
        for name in _POSES:
            arrays[name][first + shift : last + 1 + shift] = np.nan
    for name in _STEPS:
        arrays[name][steps] = getattr(segment, name)
    rank[steps] = segment.rank


def _shapes(frames: int, parts: int, dofs: int) -> dict[str, tuple[int, ...]]:
    return {
        "Rs_parent_part": (frames, parts, 3, 3),
        "ps_camera_root": (frames, 3),
        "singular_values": (frames - 1, dofs),
        "observability": (frames - 1, parts),
        "residual": (frames - 1, parts),
    }


def _summary(segment: SegmentResult, session: Session) -> SegmentSummary:
    span = (segment.trajectory.first_frame, segment.trajectory.last_frame)
    return SegmentSummary(
        first_frame=span[0],
        last_frame=span[1],
        open_ends=tuple(frame for frame in span if frame in open_ends(session)),
        verdict=segment.verdict,
        scores=tuple(_finite(score) for score in segment.scores),
        best_pass=segment.best_pass,
        closing_error=_finite(segment.closing_error),
        notes=segment.notes,
        missing=segment.missing,
        unreached=segment.unreached,
    )


def _finite(value: float) -> float | None:
    """JSON has no NaN and no infinity."""
    return float(value) if math.isfinite(value) else None


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
