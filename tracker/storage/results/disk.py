"""Results from a session's tracks file, and the fitting ones back into one."""

from __future__ import annotations

import hashlib
import re
import time
from contextlib import suppress
from pathlib import Path

import numpy as np

from tracker.body.skeleton import Skeleton
from tracker.body.trajectory import Trajectory
from tracker.files import read_regular
from tracker.geometry.rotations import Array
from tracker.session import SegmentSummary, Session
from tracker.session.settings import Quality
from tracker.storage.files import LARGEST_SESSION_BYTES
from tracker.storage.fingerprints import setup_hash
from tracker.storage.outdated import KEYFRAME_TOLERANCE
from tracker.storage.results.collection import Results
from tracker.storage.results.keys import Span, segment_keys
from tracker.storage.results.track import RANK, SegmentTrack
from tracker.storage.tracks import Tracks, load_tracks, save_result
from tracker.tracking.pool import SegmentResult, TrackResult

YOUNG_SECONDS = 60
TRACKS_NAME = re.compile(r"tracks-[0-9a-f]{12}\.npz")


def load_results(session: Session, session_path: Path) -> Results:
    """The segments in the session's tracks file, none when it has not been tracked yet.

    Those that were tracked for other poses, another body and so on are kept but do not fit.
    SessionError in one sentence when the file is missing or damaged.
    """
    results = Results()
    if session.results is None:
        return results
    tracks = load_tracks(session, session_path)
    keys = _present_keys(session)
    for summary in session.results.segments:
        span = (summary.first_frame, summary.last_frame)
        frames = slice(span[0] - tracks.first_frame, span[1] - tracks.first_frame + 1)
        path = _path(tracks, span, frames, summary.unreached)
        if path is None:
            continue
        key = summary.key or _key(session, keys, path)
        track = _load(session, tracks, summary, frames, path, key)
        results = results.with_track(track, keep=results.tracks)
    return results


def save_results(session: Session, session_path: Path, results: Results) -> Session:
    """Write the finished results that fit, beside the session file; the session that refers to
    them, not yet saved. Where none fits, the session stays as it is.

    SessionError when the disk refuses.
    """
    kept = [track for track in results.fitting(session).values() if track.finished]
    if not kept:
        return session
    lowest = min((track.quality for track in kept), key=RANK.__getitem__)
    settings = session.settings.model_copy(update={"quality": lowest})
    segments = tuple(_segment_result(track) for track in kept)
    result = TrackResult(Skeleton.of(session.body), settings, segments)
    saved = save_result(session, session_path, result).results
    assert saved is not None
    summaries = tuple(
        summary.model_copy(update={"key": track.key, "quality": track.quality})
        for summary, track in zip(saved.segments, kept, strict=True)
    )
    return session.model_copy(update={"results": saved.model_copy(update={"segments": summaries})})


def tidy_tracks(folder: Path) -> None:
    """Remove tracks files that no session in the folder speaks of any more.

    The file before the last save counts, too: `session.json.previous` can be put back. Young files
    stay: another program may be about to name them in its session.
    """
    told = b"".join(_content(file) for file in folder.glob("*.json*"))
    for file in folder.glob("tracks-*.npz"):
        if TRACKS_NAME.fullmatch(file.name) and file.name.encode() not in told:
            with suppress(OSError):  # then it stays, and does no harm
                if time.time() - file.stat().st_mtime > YOUNG_SECONDS:
                    file.unlink()


def _content(file: Path) -> bytes:
    try:
        return read_regular(file, LARGEST_SESSION_BYTES)
    except OSError:
        return b""


def _present_keys(session: Session) -> dict[Span, str]:
    """Keys of the present segments if they were tracked by the method of the session's results.

    None where body, camera or masks are known to be others now.
    """
    assert session.results is not None
    if session.results.tracked_for not in (None, setup_hash(session)):
        return {}
    settings = session.results.settings_used(session.settings)
    return segment_keys(session.model_copy(update={"settings": settings}))


def _key(session: Session, keys: dict[Span, str], path: Trajectory) -> str:
    """The key of a result that does not say it, by what it goes through."""
    span = (path.first_frame, path.last_frame)
    if span in keys and _goes_through(session, path):
        return keys[span]
    content = hashlib.sha256(repr(span).encode() + path.Rs_parent_part.tobytes())
    return f"unknown-{content.hexdigest()[:32]}"


def _goes_through(session: Session, path: Trajectory) -> bool:
    """Whether the keyframes are where the motion ends; an open end is nobody's."""
    skeleton = Skeleton.of(session.body)
    at = {keyframe.frame: keyframe for keyframe in session.keyframes}
    for frame in (path.first_frame, path.last_frame):
        if frame not in at:
            continue
        keyed, found = at[frame].pose(skeleton), path.pose(frame)
        turn = np.abs(keyed.Rs_parent_part - found.Rs_parent_part).max()
        shift = np.abs(keyed.p_camera_root - found.p_camera_root).max()
        if max(turn, shift) > KEYFRAME_TOLERANCE:
            return False
    return True


def _path(tracks: Tracks, span: Span, frames: slice, unreached: Span | None) -> Trajectory | None:
    """The motion of a segment, the nearest pose where it was not reached; None where the file does
    not hold all the rest."""
    count = span[1] - span[0] + 1
    if frames.start < 0 or count < 2:
        return None
    there = np.flatnonzero(tracks.tracked[frames])
    beyond = 0 if unreached is None else unreached[1] - unreached[0] + 1
    if not len(there) or len(there) + beyond != count:
        return None
    nearest = there[np.maximum(np.searchsorted(there, np.arange(count), "right") - 1, 0)]
    rows = frames.start + nearest
    return Trajectory(span[0], tracks.Rs_parent_part[rows], tracks.ps_camera_root[rows])


def _load(
    session: Session, tracks: Tracks, summary: SegmentSummary, frames: slice, path: Trajectory,
    key: str,
) -> SegmentTrack:  # fmt: skip
    steps = slice(frames.start, frames.stop - 1)
    rank = tracks.rank[steps]
    return SegmentTrack(
        path.first_frame, path.last_frame, key, _quality(session, summary), path,
        summary.verdict, tuple(_number(score) for score in summary.scores), (),
        summary.best_pass, _number(summary.closing_error), rank, tracks.singular_values[steps],
        tracks.observability[steps], tracks.residual[steps], _need(tracks, frames),
        summary.notes, summary.missing, summary.unreached,
    )  # fmt: skip


def _need(tracks: Tracks, frames: slice) -> Array | None:
    """What keyframes would mend in a segment; None where the file does not tell."""
    if tracks.need is None or not np.isfinite(tracks.need[frames]).all():
        return None
    return tracks.need[frames]


def _quality(session: Session, summary: SegmentSummary) -> Quality:
    assert session.results is not None
    return summary.quality or session.results.quality


def _number(value: float | None) -> float:
    return np.nan if value is None else value


def _segment_result(track: SegmentTrack) -> SegmentResult:
    assert track.verdict is not None
    return SegmentResult(
        trajectory=track.trajectory,
        scores=track.scores,
        steps=track.steps,
        best_pass=track.best_pass,
        closing_error=track.closing_error,
        verdict=track.verdict,
        rank=track.rank,
        singular_values=track.singular_values,
        observability=track.observability,
        residual=track.residual,
        need=track.need,
        notes=track.notes,
        missing=track.missing,
        unreached=track.unreached,
    )
