"""`keypose track`: find the motion between the keyframes and keep it beside the session."""

from __future__ import annotations

import argparse
import os
import shlex
import sys
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.commands.arguments import (
    Subcommands,
    add_command,
    add_overwrite,
    add_session,
    file_name,
    whole_number,
)
from app.commands.json_output import print_json
from app.commands.preparing import prepare_loops
from tracker.errors import SessionError

if TYPE_CHECKING:
    from app.commands.follow import Run
    from tracker.session import Results, Session

DONE, LOST, INTERRUPTED = 0, 1, 130

_EXAMPLES = """\
  keypose track session.json
  keypose track session.json --quality preview --workers 2 --out try
  keypose track session.json --json > events.jsonl
  keypose track session.json --method paper --initial templates --leave-out right_hand
"""


def add(commands: Subcommands) -> None:
    text = (
        "Track the motion between the keyframes. Results are written beside the session, which "
        "then refers to them; with --out, a copy of the session and the results go to that folder "
        "and the session stays as it is. Ctrl+C keeps the segments that are finished. A session "
        "that is open in the page is left alone. The exit code is 1 when tracking was lost "
        "somewhere."
    )
    command = add_command(commands, "track", run, text, _EXAMPLES)
    add_session(command)
    of_session = "; the session's own when left out"
    command.add_argument("--method", choices=("keypose", "paper"), help=f"how{of_session}")
    qualities = ("full", "fast", "preview")
    command.add_argument("--quality", choices=qualities, help=f"how much work{of_session}")
    starts = ("auto", "linear", "templates", "both-ways", "import")
    command.add_argument(
        "--initial",
        choices=starts,
        help="where every segment starts from: interpolation, head, hands and feet followed by "
        "what they look like, the body followed from both keyframes, or an imported motion"
        f"{of_session}",
    )
    command.add_argument(
        "--leave-out",
        metavar="PART",
        action="append",
        help=f"a part whose limb is not followed by its looks; may be given again{of_session}",
    )
    command.add_argument(
        "--out", metavar="DIR", type=file_name, help="folder for session and results"
    )
    command.add_argument(
        "--workers", metavar="N", type=whole_number(1), default=1, help="segments at a time"
    )
    command.add_argument(
        "--json", action="store_true", help="print JSON lines: events, the summary last"
    )
    add_overwrite(command)


def run(arguments: argparse.Namespace) -> int:
    from app.commands.follow import follow
    from app.locking import locked
    from app.rerun import demand_trackable, with_settings
    from tracker.session.files import load_session, open_video_of

    session = load_session(arguments.session)
    demand_trackable(session, arguments.session)
    _demand_place(arguments)
    asked = with_settings(
        session, arguments.method, arguments.quality, arguments.initial, arguments.leave_out
    )
    copy = "add --out DIR to track a copy" if arguments.out is None else "choose another --out"
    lock = locked(_place(arguments), f"close it there, or {copy}")
    with open_video_of(session, arguments.session) as video, lock:
        prepare_loops()
        found = follow(asked, arguments.session, video, arguments.workers, arguments.json)
        if found.error is not None and not found.found:
            raise found.error
        summary = _keep(session, asked, found, arguments)
    _tell(summary, arguments.json)
    if found.error is not None:
        raise found.error
    if found.interrupted:
        return INTERRUPTED
    return LOST if summary["lost"] else DONE


def _demand_place(arguments: argparse.Namespace) -> None:
    """Whether the results can be written is asked before the work, not after."""
    from tracker.session.atomic import demand_absent, demand_folder

    folder = arguments.session.parent if arguments.out is None else arguments.out
    if arguments.out is not None and not arguments.overwrite:
        demand_absent([_place(arguments)], error=SessionError)
    demand_folder(folder, error=SessionError)


def _place(arguments: argparse.Namespace) -> Path:
    """The session file to write."""
    out: Path | None = arguments.out
    session_path: Path = arguments.session
    return session_path if out is None else out / "session.json"


def _keep(
    session: Session, asked: Session, found: Run, arguments: argparse.Namespace
) -> dict[str, Any]:
    """Write what was found for the session as it was asked for, if anything; the summary of it."""
    summary: dict[str, Any] = {"interrupted": found.interrupted, "session": None, "tracks": None}
    summary |= {"segments_of": len(asked.keyframes) - 1, "segments": [], "lost": False}
    summary["error"] = None if found.error is None else str(found.error)
    results = _write(session, asked, found, arguments)
    if results is None:
        return summary
    spans = {track.span for track in found.found}
    mine = [s for s in results.segments if (s.first_frame, s.last_frame) in spans]
    summary |= {
        "session": str(_place(arguments)),
        "tracks": str(_place(arguments).with_name(results.tracks)),
        "segments": [segment.model_dump() for segment in mine],
        "lost": any(segment.verdict == "lost" for segment in mine),
    }
    return summary


def _write(
    session: Session, asked: Session, found: Run, arguments: argparse.Namespace
) -> Results | None:
    from app.rerun import keep, keep_elsewhere
    from tracker.session.atomic import make_folder, write_file
    from tracker.session.files import session_json
    from tracker.session.first_motion import carry_first_motion

    if arguments.out is None or not found.found:
        return keep(asked, arguments.session, found.found)
    make_folder(arguments.out, error=SessionError)
    carry_first_motion(session, arguments.session.parent, arguments.out)
    place = _place(arguments)
    results = keep_elsewhere(asked, place, found.found)
    write_file(
        place,
        session_json(_moved(session, arguments).model_copy(update={"results": results})),
        overwrite=arguments.overwrite,
        keep_previous=True,
        error=SessionError,
    )
    return results


def _moved(session: Session, arguments: argparse.Namespace) -> Session:
    """The session as it reads in another folder: its video's path starts from there."""
    from tracker.session.files import video_path

    path = str(video_path(session, arguments.session))
    if not Path(session.video.path).is_absolute():
        with suppress(ValueError):  # on another drive only the absolute path leads there
            path = Path(os.path.relpath(path, arguments.out.absolute())).as_posix()
    video = session.video.model_copy(update={"path": path})
    return session.model_copy(update={"video": video})


def _tell(summary: dict[str, Any], as_json: bool) -> None:
    if as_json:
        print_json({"event": "finished", **summary})
        return
    for segment in summary["segments"]:
        print(f"frames {segment['first_frame']}–{segment['last_frame']}: {segment['words']}")
        for note in segment["notes"]:
            print(f"  {note}")
    if summary["session"] is not None:
        print(f"Written: {summary['tracks']}")
        print(f"Written: {summary['session']}")
        _hint(summary["session"])
    if summary["interrupted"]:
        done, all_of_them = len(summary["segments"]), summary["segments_of"]
        print(f"Interrupted: {done} of {all_of_them} segments are kept.", file=sys.stderr)


def _hint(session: str) -> None:
    """What to do next, for a person at a terminal."""
    if sys.stdout.isatty():
        place = shlex.quote(session)
        print(f"Next: keypose shot {place} --frame N --view all --out FILE.png")
        print(f"      keypose export {place} --format bvh --out DIR")
