"""The outcome of a run that tracked or fitted: saved and printed."""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from keypose.app.cli.arguments import note
from keypose.app.cli.exit_codes import DONE, INTERRUPTED, NOT_ALL_DONE
from keypose.app.cli.follow import Run, follow
from keypose.app.cli.json_output import print_json, verdict_fields
from keypose.app.cli.long_work import warm_tracker
from keypose.app.document.folder_lock import locked
from keypose.app.jobs.progress import Wanted, reaching
from keypose.app.jobs.rerun import all_segments, save_found, save_tracks_beside, with_repeats
from keypose.tracker.errors import SessionError, listed, readable
from keypose.tracker.keypoints.on_body import is_persons
from keypose.tracker.session import Results, Session
from keypose.tracker.storage.atomic import make_folder, require_absent, require_folder, write_file
from keypose.tracker.storage.files import open_video_of, session_json, with_present_fingerprints
from keypose.tracker.storage.fingerprints import present_keys, segment_keys, shows_background
from keypose.tracker.storage.results import Span
from keypose.tracker.storage.sidecars import carry_beside


def track_and_save(
    session: Session,
    asked: Session,
    arguments: argparse.Namespace,
    frames: Span | None = None,
) -> int:
    """Track the session as it was asked for, save what was found and print it; the exit code.

    session: as its file is to stand.  arguments: session, out, overwrite, workers, json.
    frames: first and last frame to track between; None for all.
    """
    require_place(arguments)
    ends = _ends(_wanted(asked, frames))
    with open_video_of(asked, arguments.session) as video, locked_place(arguments):
        session, asked = (
            with_present_fingerprints(s, arguments.session, video) for s in (session, asked)
        )
        session, asked = (with_repeats(s, video, *ends) for s in (session, asked))
        wanted = _wanted(asked, frames)  # by keys that know the present fingerprints
        warm_tracker(asked)
        _say_what_was_found(asked)
        _say_what_is_left_out(asked, arguments)
        place = arguments.session
        run = follow(asked, place, video, wanted, arguments.workers, arguments.json)
        if run.error is not None and not run.found:
            raise run.error
        summary = _save_found(session, asked, run, arguments)
        summary["segments_of"] = len(wanted)
    _print_summary(summary, arguments.json)
    if run.error is not None:
        raise run.error
    if run.interrupted:
        return INTERRUPTED
    return NOT_ALL_DONE if summary["lost"] else DONE


def _ends(wanted: Sequence[Wanted]) -> Span:
    """First and last frame of some segments, in their order."""
    return wanted[0][0], wanted[-1][1]


def _wanted(session: Session, frames: Span | None) -> list[Wanted]:
    """The segments to track; SessionError where none reaches between these frames."""
    wanted = reaching(all_segments(session), frames)
    if frames is not None and not wanted:
        first, last = session.spans[0][0], session.spans[-1][1]
        raise SessionError(
            f"No segment reaches between frames {frames[0]} and {frames[1]}: they go from "
            f"{first} to {last}."
        )
    return wanted


def _say_what_was_found(session: Session) -> None:
    """Say what nobody chose, with how to choose otherwise."""
    if session.settings.static_camera is None and session.has_static_camera:
        words = "The camera stands still: found by itself. --static-camera no tracks without that."
        print(words, file=sys.stderr, flush=True)


def _say_what_is_left_out(session: Session, arguments: argparse.Namespace) -> None:
    """Say what was asked for in this run and cannot be had."""
    shown = shows_background(session) or is_persons(session.subject.body)
    if "silhouette" in (getattr(arguments, "cues", None) or ()) and not shown:
        words = (
            "No background is known and the body is no person's: the silhouette is left out. "
            "--static-camera yes says that the camera stands still, and `keypose camera` finds how "
            "one turns; then --cues brightness,silhouette has a background."
        )
        print(words, file=sys.stderr, flush=True)


def require_place(arguments: argparse.Namespace) -> None:
    """Require before the work, not after, that the results can be written."""
    folder = arguments.session.parent if arguments.out is None else arguments.out
    if arguments.out is not None and not arguments.overwrite:
        require_absent([_session_path_to_write(arguments)], error=SessionError)
    require_folder(folder, error=SessionError)


@contextmanager
def locked_place(arguments: argparse.Namespace) -> Iterator[Path]:
    """The session file to write, while nobody else writes it."""
    copy = "add --out DIR to track a copy" if arguments.out is None else "choose another --out"
    place = _session_path_to_write(arguments)
    with locked(place, f"close it there, or {copy}"):
        yield place


def _session_path_to_write(arguments: argparse.Namespace) -> Path:
    """The session file to write."""
    out: Path | None = arguments.out
    session_path: Path = arguments.session
    return session_path if out is None else out / "session.json"


def _save_found(
    session: Session, asked: Session, run: Run, arguments: argparse.Namespace
) -> dict[str, Any]:
    """Write what was found for the session as it was asked for, if anything; the summary of it."""
    summary: dict[str, Any] = {"interrupted": run.interrupted, "session": None, "tracks": None}
    summary |= {"segments": [], "lost": False}
    summary["error"] = None if run.error is None else str(run.error)

    results = _write(session, asked, run, arguments)
    if results is None:
        return summary
    spans = {track.span for track in run.found}
    note(_own_settings_words(session.changed({"results": results}), asked, spans))
    mine = [s for s in results.segments if (s.first_frame, s.last_frame) in spans]
    summary |= {
        "session": str(_session_path_to_write(arguments)),
        "tracks": str(_session_path_to_write(arguments).with_name(results.tracks)),
        "segments": [
            {**segment.model_dump(), **verdict_fields(segment.verdict)} for segment in mine
        ],
        "lost": any(segment.verdict.kind == "lost" for segment in mine),
    }
    findings = [finding for stretch in results.space for finding in stretch.findings]
    if findings:
        from keypose.app.words.problems import space_sentence  # which loads posing

        rows = [
            {**space_finding.model_dump(), "words": space_sentence(space_finding)}
            for space_finding in findings
        ]
        summary["in_space"] = rows
    return summary


def _own_settings_words(session: Session, asked: Session, spans: Collection[Span]) -> str | None:
    """Say where what was asked for in this run alone makes the motion out of date as soon as it is
    written; None where it does not."""
    keys, asked_keys = present_keys(session), segment_keys(asked)
    if all(keys.get(span) == asked_keys.get(span) for span in spans):
        return None
    own, run_alone = session.settings.model_dump(), asked.settings.model_dump()
    names = [readable(name) for name in own if own[name] != run_alone[name]]
    return (
        f"the session keeps its own {listed(names or ['settings'])}: for these the motion is out "
        "of date already. Set in the session what this run was asked for, to keep it."
    )


def _write(
    session: Session, asked: Session, run: Run, arguments: argparse.Namespace
) -> Results | None:
    if arguments.out is None or not run.found:
        return save_found(asked, arguments.session, run.found)
    make_folder(arguments.out, error=SessionError)

    def refer(results: Results | None) -> None:
        write_copy(session.changed({"results": results}), arguments)

    return save_tracks_beside(asked, _session_path_to_write(arguments), run.found, refer)


def write_copy(session: Session, arguments: argparse.Namespace) -> None:
    """The session in the folder --out, with all that belongs to it but its motion."""
    from keypose.app.document.open import with_paths_from  # which loads the page's edits

    make_folder(arguments.out, error=SessionError)
    carry_beside(session, arguments.session.parent, arguments.out)
    there = with_paths_from(session, arguments.session, arguments.out)
    write_file(
        _session_path_to_write(arguments),
        session_json(there),
        overwrite=arguments.overwrite,
        keep_previous=True,
        error=SessionError,
    )


def _print_summary(summary: dict[str, Any], as_json: bool) -> None:
    if as_json:
        print_json({"event": "finished", **summary})
        return
    for segment in summary["segments"]:
        print(f"frames {segment['first_frame']}–{segment['last_frame']}: {segment['words']}")
        for words in segment["notes"]:
            print(f"  {words}")
    for finding in summary.get("in_space", ()):
        print(f"in space: {finding['words']}")
    if summary["session"] is not None:
        print(f"Written: {summary['tracks']}")
        print(f"Written: {summary['session']}")
        _hint(summary["session"])
    if summary["interrupted"]:
        print(f"Interrupted: {_interruption_message(summary)}", file=sys.stderr)


def _interruption_message(summary: dict[str, Any]) -> str:
    """What is there of a run that was interrupted."""
    segments = summary["segments"]
    parts = sum(segment.get("missing", 0) > 0 for segment in segments)
    whole = f"{len(segments) - parts} of {summary['segments_of']} segments are"
    return f"{whole} finished, {parts} more kept in part." if parts else f"{whole} kept."


def _hint(session: str) -> None:
    """Hint at what to do next, for a person at a terminal."""
    if sys.stdout.isatty():
        place = shlex.quote(session)
        print(f"Next: keypose shot {place} --frame N --view all --out FILE.png")
        print(f"      keypose export {place} --format bvh --out DIR")
