"""`keypose draft`: every frame of a film gets a draft pose, of the person in a box or found."""

from __future__ import annotations

import argparse
import sys
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from keypose.app.cli.arguments import film_orders_of, is_session_named, session_file
from keypose.app.cli.exit_codes import DONE, INTERRUPTED
from keypose.app.cli.json_output import print_json
from keypose.app.cli.long_work import set_when_interrupted
from keypose.app.document.folder_lock import locked
from keypose.app.editor.drafted import (
    drafting_model,
    flipped_drafts,
    proposed_frames,
    require_draftable,
    with_accepted,
)
from keypose.app.jobs.draft import Drafted, drafted_people
from keypose.app.jobs.film_session import (
    WhoIsDrafted,
    begun_session,
    frames_to_draft,
    opened_film,
    who_are_drafted,
    with_people_kept,
)
from keypose.app.jobs.find_up import with_up_unseen
from keypose.app.jobs.rerun import with_repeats
from keypose.app.orders.film import FilmToDraft
from keypose.app.words.jobs import about_words
from keypose.app.words.people import accepted_words, flipped_words, found_person_words
from keypose.app.words.review import draft_reason
from keypose.tracker.errors import SessionError
from keypose.tracker.fitting.draft import ClipDraft, DraftProgress
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
            people = _people(film, session, video, arguments)
            session, up = with_up_unseen(session, video)
            session = with_repeats(session, video, *frames)
            _say_how_long(session, frames, video.info.fps, len(people), arguments.json)
            drafts = _drafted(session, video, people, frames, arguments.json)
        except Cancelled:
            print("Interrupted: nothing was written.", file=sys.stderr)
            return INTERRUPTED
        make_folder(arguments.out, error=SessionError)
        with locked(place, "close it there, or choose another --out"):
            session = with_people_kept(session, video, place, people, frames, drafts)
            accepted = {body.id: _proposed(session, body.id) for body in session.bodies}
            if arguments.accept:
                session = _with_accepted(session, accepted)
            _write(session, place, arguments.overwrite)
    if not arguments.json:
        print(up, end="\n" if up else "")
    if not arguments.accept:
        accepted = dict.fromkeys(accepted, ())
    _print(drafts, frames, session, place, accepted, arguments.json)
    detected = drafts[0].detected
    if detected is None:
        return DONE
    words = "the same command with --overwrite goes on from there"
    print(f"Interrupted: frames {detected[0]}–{detected[1]} are drafted; {words}.", file=sys.stderr)
    return INTERRUPTED


def _proposed(session: Session, body_id: str) -> tuple[int, ...]:
    return proposed_frames(session.about(body_id))


def _with_accepted(session: Session, accepted: Mapping[str, Sequence[int]]) -> Session:
    """The session with the proposed drafts of each body as its keyframes."""
    posed = session.subject.id
    for body_id, frames in accepted.items():
        session = with_accepted(session.about(body_id), frames)
    return session.about(posed)


def _accept_drafts(arguments: argparse.Namespace) -> int:
    """Take the proposed drafts of a session that is there as its keyframes."""
    if not arguments.accept or arguments.out is not None:
        raise SessionError("This is a session: its drafts are accepted with --accept alone.")
    path = session_file(str(arguments.video))
    with locked(path, "close it there first"):
        session = load_session(path)
        accepted = {body.id: _proposed(session, body.id) for body in session.bodies}
        flipped = {body.id: flipped_drafts(session.about(body.id)) for body in session.bodies}
        if not any(accepted.values()):
            raise SessionError(_nothing_to_accept(session, path.name))
        save_session(_with_accepted(session, accepted), path)
    if arguments.json:
        facts = {
            body_id: {
                "accepted": list(frames),
                "flipped": [run.model_dump() for run in flipped[body_id]],
            }
            for body_id, frames in accepted.items()
        }
        print_json({"event": "finished", **_of_bodies(facts), "session": str(path)})
        return DONE
    for body_id, frames in accepted.items():
        _print_body(body_id, len(accepted))
        print(accepted_words(frames))
        if flipped[body_id]:
            print(flipped_words(flipped[body_id]))
    print(f"Written: {path}")
    return DONE


def _nothing_to_accept(session: Session, name: str) -> str:
    """Why there is nothing to accept: no drafts, or none of those proposed."""
    count = sum(len(body.drafts) for body in session.bodies)
    if not count:
        return f"{name} has no drafts to accept: draft its film first."
    drafts = "1 other draft" if count == 1 else f"{count} other drafts"
    return f"{name} has no proposed drafts left to accept; confirm its {drafts} in the page."


def _of_bodies(facts: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """Facts of the only body, or of each of several by its id."""
    if len(facts) == 1:
        return dict(next(iter(facts.values())))
    return {"bodies": [{"body": body_id, **own} for body_id, own in facts.items()]}


def _print_body(body_id: str, count: int) -> None:
    """Say which of several bodies the next lines are about."""
    if count > 1:
        print(f"{body_id}:")


def _people(
    film: FilmToDraft, session: Session, video: Video, arguments: argparse.Namespace
) -> list[WhoIsDrafted]:
    """Who are drafted: one for each box, or the person who is found."""
    people = _named_or_found(film, session, video, arguments.json)
    at, frames = people[0].frame, frames_to_draft(film.order, session)
    for box in arguments.more_box:
        require_draftable(session, at, box, frames)
    return [*people, *(WhoIsDrafted(at, box) for box in arguments.more_box)]


def _named_or_found(
    film: FilmToDraft, session: Session, video: Video, as_json: bool
) -> list[WhoIsDrafted]:
    """Who are drafted; people are looked for where no box was drawn, and that is said."""
    stop = threading.Event()

    def report(_: float) -> None:
        if stop.is_set():
            raise Cancelled

    with set_when_interrupted(stop):
        people = who_are_drafted(film.order, session, video, report)
    if people[0].found is not None and not as_json:
        print(found_person_words(people[0].found), file=sys.stderr, flush=True)
    return people


def _say_how_long(
    session: Session, frames: tuple[int, int], fps: float, people: int, as_json: bool
) -> None:
    """Say what a draft will take, where it takes long: as known of this computer, else measured."""
    if as_json:
        return
    count = frames[1] - frames[0] + 1
    model = drafting_model(session)
    seconds = people * count * known_or_measured(model.name)
    every_second = not needs_masks(session) and model.skips_frames_at(fps)
    if every_second and not model.of_animals:
        seconds /= 2
    if words := about_words(seconds):
        print(f"Drafting {count} frames takes {words}.", file=sys.stderr, flush=True)


def _drafted(
    session: Session,
    video: Video,
    people: Sequence[WhoIsDrafted],
    frames: tuple[int, int],
    as_json: bool,
) -> list[Drafted]:
    stop = threading.Event()
    with set_when_interrupted(stop), _reporter(as_json) as report:
        return drafted_people(
            session,
            video,
            people[0].frame,
            [who.box for who in people],
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
    drafts: Sequence[Drafted],
    frames: tuple[int, int],
    session: Session,
    place: Path,
    accepted: Mapping[str, Sequence[int]],
    as_json: bool,
) -> None:
    """What was drafted of each body, and the files."""
    files = [_keypoints_place(session.about(body.id), place) for body in session.bodies]
    draft_by_body = {body.id: own for body, own in zip(session.bodies, drafts, strict=True)}
    if as_json:
        world = session.world
        up = {
            "up_world": world.up_world,
            "up_from": list(world.up_from),
            "up_sigma_rad": world.up_sigma_rad,
        }
        facts = {
            body_id: {
                **_facts(own.draft, frames, own.detected or frames),
                "accepted": list(accepted[body_id]),
                "keypoints": str(keypoints),
            }
            for (body_id, own), keypoints in zip(draft_by_body.items(), files, strict=True)
        }
        print_json({"event": "finished", **_of_bodies(facts), **up, "session": str(place)})
        return
    for body_id, own in draft_by_body.items():
        _print_body(body_id, len(drafts))
        _print_draft(own.draft, frames, accepted[body_id])
    for path in (*files, place):
        print(f"Written: {path}")


def _keypoints_place(session: Session, place: Path) -> Path:
    assert session.view.keypoints is not None
    return place.with_name(session.view.keypoints.file)


def _print_draft(draft: ClipDraft, frames: tuple[int, int], accepted: Sequence[int]) -> None:
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
        "drafts": len(draft.poses),
        "missing": missing,
        "left": sorted(left),
        "proposals": proposals,
        "flipped": [run.model_dump() for run in draft.flipped],
    }
