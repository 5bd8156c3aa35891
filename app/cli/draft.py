"""`keypose draft`: every frame of a film gets a draft pose, of the person in a box or found."""

from __future__ import annotations

import argparse
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from keypose.app.cli.arguments import film_orders_of, is_session_named, session_file
from keypose.app.cli.exit_codes import DONE, INTERRUPTED
from keypose.app.cli.json_output import print_json
from keypose.app.cli.long_work import set_when_interrupted
from keypose.app.document.folder_lock import locked
from keypose.app.editor.drafted import flipped_drafts, proposed_frames, with_accepted
from keypose.app.jobs.draft import Drafted, drafted
from keypose.app.jobs.film_session import (
    WhoIsDrafted,
    begun_session,
    frames_to_draft,
    opened_film,
    who_is_drafted,
    with_draft_kept,
)
from keypose.app.jobs.find_up import with_up_unseen
from keypose.app.jobs.rerun import with_repeats
from keypose.app.orders.film import FilmToDraft
from keypose.app.words.jobs import about_words
from keypose.app.words.people import accepted_words, flipped_words, found_person_words
from keypose.app.words.review import draft_reason
from keypose.tracker.errors import SessionError
from keypose.tracker.fitting.draft import ClipDraft, DraftProgress
from keypose.tracker.keypoints.model_files import find_model
from keypose.tracker.session import Session
from keypose.tracker.storage.atomic import make_folder, require_absent, require_folder, write_file
from keypose.tracker.storage.files import load_session, save_session, session_json
from keypose.tracker.storage.fingerprints import needs_masks
from keypose.tracker.storage.pace import known_or_measured
from keypose.tracker.tracking.pool import Cancelled
from keypose.tracker.video import Video


def run(arguments: argparse.Namespace) -> int:
    if is_session_named(arguments.video):
        return _accept_drafts(arguments)
    if arguments.out is None:
        raise SessionError("The folder for the session is missing: --out DIR.")
    film = FilmToDraft(arguments.video, **film_orders_of(arguments))
    place = arguments.out / "session.json"
    if not arguments.overwrite:
        require_absent([place], error=SessionError)
    require_folder(arguments.out, error=SessionError)
    with opened_film(film) as video:
        session = begun_session(film, video, place)
        frames = frames_to_draft(film.order, session)
        try:
            who = _who(film, session, video, arguments.json)
            session, up = with_up_unseen(session, video)
            session = with_repeats(session, video, *frames)
            _say_how_long(session, frames, video.info.fps, arguments.json)
            drafts = _drafted(session, video, who, frames, arguments.json)
        except Cancelled:
            print("Interrupted: nothing was written.", file=sys.stderr)
            return INTERRUPTED
        make_folder(arguments.out, error=SessionError)
        with locked(place, "close it there, or choose another --out"):
            session = with_draft_kept(session, video, place, who, frames, drafts)
            accepted = proposed_frames(session) if arguments.accept else ()
            _write(with_accepted(session, accepted), place, arguments.overwrite)
    if not arguments.json:
        print(up, end="\n" if up else "")
    _print(drafts.draft, frames, drafts.detected or frames, session, place, accepted, arguments)
    if drafts.detected is None:
        return DONE
    words = "the same command with --overwrite goes on from there"
    first, last = drafts.detected
    print(f"Interrupted: frames {first}–{last} are drafted; {words}.", file=sys.stderr)
    return INTERRUPTED


def _accept_drafts(arguments: argparse.Namespace) -> int:
    """Take the proposed drafts of a session that is there as its keyframes."""
    if not arguments.accept or arguments.out is not None:
        raise SessionError("This is a session: its drafts are accepted with --accept alone.")
    path = session_file(str(arguments.video))
    with locked(path, "close it there first"):
        session = load_session(path)
        accepted, flipped = proposed_frames(session), flipped_drafts(session)
        if not accepted:
            raise SessionError(f"{path.name} has no drafts to accept: draft its film first.")
        save_session(with_accepted(session, accepted), path)
    if arguments.json:
        wrong = [run.model_dump() for run in flipped]
        finished = {"event": "finished", "accepted": list(accepted), "flipped": wrong}
        print_json({**finished, "session": str(path)})
        return DONE
    print(accepted_words(accepted))
    if flipped:
        print(flipped_words(flipped))
    print(f"Written: {path}")
    return DONE


def _who(film: FilmToDraft, session: Session, video: Video, as_json: bool) -> WhoIsDrafted:
    """Who is drafted; the person is looked for where no box was drawn, and that is said."""
    stop = threading.Event()

    def report(_: float) -> None:
        if stop.is_set():
            raise Cancelled

    with set_when_interrupted(stop):
        who = who_is_drafted(film.order, session, video, report)
    if who.found is not None and not as_json:
        print(found_person_words(who.found), file=sys.stderr, flush=True)
    return who


def _say_how_long(session: Session, frames: tuple[int, int], fps: float, as_json: bool) -> None:
    """Say what a draft will take, where it takes long: as known of this computer, else measured."""
    if as_json:
        return
    count = frames[1] - frames[0] + 1
    network = session.settings.network_used
    seconds = count * known_or_measured(network)
    if not needs_masks(session) and find_model(network).skips_frames_at(fps):
        seconds /= 2
    if words := about_words(seconds):
        print(f"Drafting {count} frames takes {words}.", file=sys.stderr, flush=True)


def _drafted(
    session: Session, video: Video, who: WhoIsDrafted, frames: tuple[int, int], as_json: bool
) -> Drafted:
    stop = threading.Event()
    with set_when_interrupted(stop), _reporter(as_json) as report:
        return drafted(
            session,
            video,
            who.frame,
            who.box,
            frames,
            proportions=True,
            report=report,
            cancelled=stop.is_set,
        )


def _write(session: Session, place: Path, overwrite: bool) -> None:
    content = session_json(session)
    write_file(place, content, overwrite=overwrite, keep_previous=True, error=SessionError)


# --- what is printed


@contextmanager
def _reporter(as_json: bool) -> Iterator[Callable[[DraftProgress], None]]:
    """JSON lines, a bar at a terminal, or nothing: a log needs no progress."""
    if as_json:
        yield _print_progress
    elif sys.stderr.isatty():
        with _bar() as report:
            yield report
    else:
        yield lambda progress: None


def _print_progress(progress: DraftProgress) -> None:
    event = {"event": "progress", "stage": progress.stage}
    print_json({**event, "done": progress.done, "expected": progress.expected})


@contextmanager
def _bar() -> Iterator[Callable[[DraftProgress], None]]:
    """A bar that counts frames, of the network first and then of the poses."""
    from tqdm import tqdm

    words = {"keypoints": "Looking for the person", "poses": "Posing"}
    with tqdm(unit="frame", file=sys.stderr, dynamic_ncols=True) as bar:

        def report(progress: DraftProgress) -> None:
            bar.set_description(words[progress.stage], refresh=False)
            bar.n, bar.total = progress.done, progress.expected
            bar.refresh()

        yield report


def _print(
    draft: ClipDraft,
    frames: tuple[int, int],
    detected: tuple[int, int],
    session: Session,
    place: Path,
    accepted: Sequence[int],
    arguments: argparse.Namespace,
) -> None:
    assert session.view.keypoints is not None
    keypoints = place.with_name(session.view.keypoints.file)
    if arguments.json:
        facts = _facts(draft, frames, detected)
        written = {"session": str(place), "keypoints": str(keypoints)}
        world = session.world
        up = {
            "up_world": world.up_world,
            "up_from": list(world.up_from),
            "up_sigma_rad": world.up_sigma_rad,
        }
        print_json({**facts, **up, "accepted": list(accepted), **written})
        return
    count = frames[1] - frames[0] + 1
    print(f"Drafts at {len(draft.poses)} of {count} frames.")
    if accepted:
        print(accepted_words(accepted))
    else:
        print("Confirm these first:")
    for proposal in draft.proposals:
        print(f"  frame {proposal.frame}: {draft_reason(proposal.reason, proposal.parts)}")
    if draft.flipped:
        print(flipped_words(draft.flipped))
    for path in (keypoints, place):
        print(f"Written: {path}")


def _facts(draft: ClipDraft, frames: tuple[int, int], detected: tuple[int, int]) -> dict[str, Any]:
    detected_frames = set(range(detected[0], detected[1] + 1))
    missing, left = (
        sorted(detected_frames - set(draft.poses)),
        set(range(frames[0], frames[1] + 1)) - detected_frames,
    )
    proposals = [
        {"frame": p.frame, "reason": p.reason, "parts": list(p.parts)} for p in draft.proposals
    ]
    return {
        "event": "finished",
        "drafts": len(draft.poses),
        "missing": missing,
        "left": sorted(left),
        "proposals": proposals,
        "flipped": [run.model_dump() for run in draft.flipped],
    }
