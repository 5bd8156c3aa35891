"""Results from a session's tracks file, and the fitting ones back into one."""

from __future__ import annotations

import hashlib
import re
import time
from contextlib import suppress
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.errors import SessionError
from keypose.tracker.files import read_regular
from keypose.tracker.session import Results as FileResults
from keypose.tracker.session import SegmentSummary, Session
from keypose.tracker.session.results import SpaceSummary
from keypose.tracker.space.result import SpaceResult
from keypose.tracker.storage.files import LARGEST_SESSION_BYTES
from keypose.tracker.storage.fingerprints import Span, present_keys, setup_hash
from keypose.tracker.storage.outdated import KEYFRAME_TOLERANCE
from keypose.tracker.storage.results.collection import CARE, Results
from keypose.tracker.storage.tracks import Tracks, load_tracks, save_result
from keypose.tracker.tracking.result import SegmentResult, TrackResult

YOUNG_SECONDS = 60
TRACKS_NAME = re.compile(r"tracks-[0-9a-f]{12}\.npz")


def load_results(session: Session, session_path: Path) -> Results:
    """The results of the body that is posed, and those of the bodies that bonds join to it, beside
    which its motion in space is solved for; of these what cannot be read is left out.

    SessionError in one sentence when the body's own file is missing or damaged.
    """
    results = _own_results(session, session_path)
    for body_id in session.bonded if session.subject.results is not None else ():
        with suppress(SessionError):
            results = results.beside(_own_results(session.about(body_id), session_path))
    return results


def _own_results(session: Session, session_path: Path) -> Results:
    """The segments in the session's tracks file, none when it has not been tracked yet.

    Those that were tracked for other poses, another body and so on are kept but do not fit.
    SessionError in one sentence when the file is missing or damaged.
    """
    results = Results()
    if session.subject.results is None:
        return results
    tracks = load_tracks(session, session_path)
    is_current = session.subject.results.tracked_for in (None, setup_hash(session))
    keys = present_keys(session) if is_current else {}
    for summary in session.subject.results.segments:
        path = _path(tracks.as_tracked, summary, summary.unreached)
        if path is not None:
            key = summary.key or _key(session, keys, path)
            segment_result = _result(session.subject.results, summary, tracks, path, key)
            own = replace(segment_result, body=session.subject.id)
            results = results.with_result(own, keep=results.by_key)
    for stretch in session.subject.results.space:
        path = _path(tracks, stretch, None)
        if path is not None:
            solved = SpaceResult(
                stretch.key, path, stretch.pins, stretch.proposed, stretch.findings, stretch.floor_m
            )
            results = results.with_space(solved)
    return results


def load_all_results(session: Session, session_path: Path) -> tuple[Results, str]:
    """The same of all bodies, and why those of a body could not be read, a sentence; the others'
    are there even so. What fits a body is found by what it was made from."""
    by_key: dict[str, SegmentResult] = {}
    in_space: dict[str, SpaceResult] = {}
    problem = ""
    for body in session.bodies:
        try:
            results = _own_results(session.about(body.id), session_path)
        except SessionError as error:
            problem = problem or str(error)
        else:
            by_key |= results.by_key
            in_space |= results.in_space
    return Results(by_key, in_space), problem


def save_all_results(session: Session, session_path: Path, results: Results) -> Session:
    """The same of all bodies."""
    for body in session.bodies:
        saved = save_results(session.about(body.id), session_path, results)
        kept = body.model_copy(update={"results": saved.subject.results})
        session = session.with_body(kept)
    return session


def save_results(session: Session, session_path: Path, results: Results) -> Session:
    """Write the finished results that fit, beside the session file; the session that refers to
    them, not yet saved. Where none fits, the session stays as it is.

    SessionError when the disk refuses.
    """
    kept = [
        segment_result
        for segment_result in results.fitting(session).values()
        if segment_result.finished
    ]
    if not kept:
        return session
    lowest = min((kept_result.quality for kept_result in kept), key=CARE.__getitem__)
    settings = session.settings.model_copy(update={"quality": lowest})
    result = TrackResult(Skeleton.of(session.subject.body), settings, tuple(kept))
    return save_result(session, session_path, result, results.space(session))


def tidy_tracks(folder: Path, young_seconds: float = YOUNG_SECONDS) -> None:
    """Remove tracks files that no session in the folder refers to any more.

    The file before the last save counts, too: `session.json.previous` can be put back. Young files
    stay: another program may be about to name them in its session.
    """
    named = b"".join(_content(file) for file in folder.glob("*.json*"))
    for file in folder.glob("tracks-*.npz"):
        if TRACKS_NAME.fullmatch(file.name) and file.name.encode() not in named:
            with suppress(OSError):  # then it stays, and does no harm
                if time.time() - file.stat().st_mtime >= young_seconds:
                    file.unlink()


def _content(file: Path) -> bytes:
    try:
        return read_regular(file, LARGEST_SESSION_BYTES)
    except OSError:
        return b""


def _key(session: Session, keys: dict[Span, str], path: Trajectory) -> str:
    """The key of a result that has none, from the keyframes it goes through."""
    span = (path.first_frame, path.last_frame)
    if span in keys and _goes_through(session, path):
        return keys[span]
    content = hashlib.sha256(repr(span).encode() + path.Rs_parent_part.tobytes())
    return f"unknown-{content.hexdigest()[:32]}"


def _goes_through(session: Session, path: Trajectory) -> bool:
    """Whether the motion ends at the keyframes' poses; open ends always fit."""
    skeleton = Skeleton.of(session.subject.body)
    at = {keyframe.frame: keyframe for keyframe in session.subject.keyframes}
    for frame in (path.first_frame, path.last_frame):
        if frame not in at:
            continue
        keyed, pose = at[frame].pose(skeleton), path.pose(frame)
        turn = np.abs(keyed.Rs_parent_part - pose.Rs_parent_part).max()
        shift = np.abs(keyed.p_camera_root - pose.p_camera_root).max()
        if max(turn, shift) > KEYFRAME_TOLERANCE:
            return False
    return True


def _path(
    tracks: Tracks, summary: SegmentSummary | SpaceSummary, unreached: Span | None
) -> Trajectory | None:
    """The motion of a segment or a stretch, the nearest pose where it was not reached; None where
    the file does not hold all the rest."""
    first, last = summary.first_frame, summary.last_frame
    count, start = last - first + 1, first - tracks.first_frame
    if start < 0 or count < 2:
        return None
    there = np.flatnonzero(tracks.tracked[start : start + count])
    beyond = 0 if unreached is None else unreached[1] - unreached[0] + 1
    if not len(there) or len(there) + beyond != count:
        return None
    nearest = there[np.maximum(np.searchsorted(there, np.arange(count), "right") - 1, 0)]
    rows = start + nearest
    return Trajectory(first, tracks.Rs_parent_part[rows], tracks.ps_camera_root[rows])


def _result(
    saved: FileResults, summary: SegmentSummary, tracks: Tracks, path: Trajectory, key: str
) -> SegmentResult:
    """A segment from its summary, whose fields have the names of the result's, and its frames."""
    first, last = (frame - tracks.first_frame for frame in (path.first_frame, path.last_frame))
    facts = {
        field.name: _numbers(getattr(summary, field.name), str(field.type))
        for field in fields(SegmentResult)
        if field.name in SegmentSummary.model_fields
    }
    values = {**facts, "key": key, "quality": summary.quality or saved.quality}
    diagnostics = tracks.diagnostics.between(first, last).complete()
    return SegmentResult(trajectory=path, diagnostics=diagnostics, **values)


def _numbers(value: Any, annotation: str) -> Any:
    """A field of a result: null in the file is NaN here."""
    if annotation == "float" and value is None:
        return np.nan
    if annotation == "tuple[float, ...]":
        return tuple(np.nan if number is None else number for number in value)
    return value
