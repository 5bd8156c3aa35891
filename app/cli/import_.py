"""`keypose import`: recorded motion as a start for tracking, keypoints as first poses."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from keypose.app.cli.arguments import (
    note,
    order_of,
    require_of,
)
from keypose.app.cli.bodies import about_one, by_body, heading
from keypose.app.cli.import_camera import import_camera
from keypose.app.cli.json_output import print_json
from keypose.app.document.folder_lock import locked
from keypose.app.export.import_keypoints import match_keypoints
from keypose.app.export.import_motion import LEAST_JOINTS, Placed
from keypose.app.export.importing import (
    DraftImport,
    MotionImport,
    as_chosen,
    import_keypoints,
    import_motion,
    names_of,
    video_facts,
)
from keypose.app.export.individuals import assigned, individuals_of
from keypose.app.orders.imports import (
    IMPORTS,
    LEAST_TRACKED,
    ImportCamera,
    ImportKeypoints,
    ImportMotion,
)
from keypose.app.words.bodies import after_id
from keypose.app.words.imports import note_words
from keypose.tracker.apart import reading_apart
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import ChoiceError, FormatError
from keypose.tracker.formats.joint_motion import JointMotion
from keypose.tracker.formats.joint_names import matched
from keypose.tracker.formats.keypoint_files import read_each
from keypose.tracker.formats.people import People, chosen_individual
from keypose.tracker.formats.reading import load_motion
from keypose.tracker.formats.reading_keypoints import keypoints_of, on_video
from keypose.tracker.session import Session
from keypose.tracker.session.bodies import TrackedBody
from keypose.tracker.solver.fit_joints import POOR_M
from keypose.tracker.storage.files import load_session, open_video_of, save_session
from keypose.tracker.storage.sidecars import save_first_motion
from keypose.tracker.video.info import VideoInfo

UNLIKE = 0.05
"""Share by which bodies differ in size before it is reported."""
MOST_NAMES = 12
LONGEST_NAME = 60
"""Names that are listed as left out, and letters of one; JSON has all of them."""


def run(arguments: argparse.Namespace) -> int:
    path: Path = arguments.session
    # Reading it reports one that is not there.
    alone = locked(path, "close it there first") if path.is_file() else nullcontext()
    if arguments.camera:
        if arguments.keypoints:
            raise FormatError("--keypoints is not for --camera.")
        if arguments.body is not None:
            raise FormatError("--body is not for --camera.")
        require_of(ImportCamera, IMPORTS, arguments, "--camera")
        with alone:
            import_camera(arguments)
        return 0
    if arguments.keypoints:
        require_of(ImportKeypoints, IMPORTS, arguments, "--keypoints")
    else:
        require_of(ImportMotion, IMPORTS, arguments, "motion")
    reader: Callable[..., Any] = read_each if arguments.keypoints else load_motion
    with reading_apart(reader) as read, alone:
        session = load_session(path)
        with open_video_of(session, path) as video:
            info = video.info
        shares = (_keypoint_shares if arguments.keypoints else _motion_shares)(
            session, read, info, arguments
        )
        taken = _every(shares, session)
        for each in taken:
            session = session.taking(each.session)
        if any(each.is_changed for each in taken):
            save_session(session, path)
    if arguments.json:
        print_json(by_body({each.session.subject.id: each.facts for each in taken}, session))
    for each in taken:
        if not arguments.json:
            for line in heading(each.session, session):
                print(line)
            each.show()
        for words in each.doubts:
            note(after_id(words, each.session.subject.id, session))
    return 0


@dataclass(frozen=True, eq=False)
class _Taken:
    """What one body took over.  session: about it, not yet saved.  facts: for --json.  show: prints
    it for a person.  doubts: what a person should know in either case."""

    session: Session
    is_changed: bool
    facts: Mapping[str, Any]
    show: Callable[[], None]
    doubts: tuple[str, ...] = ()


Share: TypeAlias = tuple[str, Callable[[], _Taken]]
"""A body's id, and what brings it an individual of the file."""


def _every(shares: Sequence[Share], session: Session) -> list[_Taken]:
    """What the bodies take over, with a note of each whose individual does not suit it; FormatError
    where none does."""
    taken, refused = list[_Taken](), list[str]()
    for body_id, take in shares:
        try:
            taken.append(take())
        except ChoiceError:
            raise
        except FormatError as error:
            refused.append(after_id(str(error), body_id, session))
    if not taken:
        raise FormatError(refused[0])
    for words in refused:
        note(f"{words} It was left out.")
    return taken


def _motion_shares(
    session: Session, read: Callable[..., Any], info: VideoInfo, arguments: argparse.Namespace
) -> list[Share]:
    order, file = order_of(ImportMotion, arguments), arguments.file.name
    motion: JointMotion = read(arguments.file)
    times_s = session.evidence.times_s(info.times_s)
    individuals = individuals_of(motion, session.bodies)

    def is_alike(body: TrackedBody) -> bool:
        names = motion.of_individual(file, individuals[0]).names
        count = len(matched(Skeleton.of(body.body), names, file).known)
        return bool(order.names or order.places) or count >= LEAST_JOINTS

    placed = dict[str, Placed]()

    def share(about: Session, individual: str | None) -> Share:
        own = replace(order, individual=individual)

        def take() -> _Taken:
            chosen = as_chosen(file, motion, own)
            first, beside = next(iter(placed.items()), ("", None))
            made = import_motion(about, chosen, file, own, times_s, beside=beside)
            if isinstance(made, DraftImport):
                return _with_drafts(about, made, session, arguments)
            if made.found.placed is not None:
                placed[about.subject.id] = made.found.placed
            return _with_motion(about, made, first, session, arguments)

        return about.subject.id, take

    pairs = _assigned(session, individuals, order.individual, is_alike, arguments)
    # Bodies that have keyframes say where the file's world lies, for those that have none.
    pairs.sort(key=lambda pair: not pair[0].subject.keyframes)
    return [share(about, individual) for about, individual in pairs]


def _keypoint_shares(
    session: Session, read: Callable[..., Any], info: VideoInfo, arguments: argparse.Namespace
) -> list[Share]:
    order, file = order_of(ImportKeypoints, arguments), arguments.file.name
    people: dict[str, People] = read(arguments.file, order.individual, len(session.bodies) > 1)
    individuals = tuple(people) if len(people) > 1 else ()
    first = next(iter(people.values()))
    if (
        len(session.bodies) > 1
        and not arguments.body
        and not order.individual
        and not individuals
        and first.most_at_once > 1
    ):
        raise FormatError(
            f"{file} shows up to {first.most_at_once} people in a frame and does not tell them "
            "apart. Choose a body with --body: it takes the surest of every frame."
        )

    def is_alike(body: TrackedBody) -> bool:
        facts = video_facts(session, info)
        shown, _ = on_video(file, first, facts, order.offset_frames or 0)
        try:
            keypoints = keypoints_of(file, shown, order.layout, facts)
            match_keypoints(session.about(body.id), keypoints, file, dict(order.places))
        except ChoiceError:
            raise
        except FormatError:
            return False
        return True

    def share(about: Session, individual: str | None) -> Share:
        own = people[individual or ""] if individual in people else first

        def take() -> _Taken:
            made = import_keypoints(about, own, file, order, info)
            return _with_drafts(about, made, session, arguments)

        return about.subject.id, take

    pairs = _assigned(session, individuals, order.individual, is_alike, arguments)
    return [share(about, individual) for about, individual in pairs]


def _assigned(
    session: Session,
    individuals: Sequence[str],
    individual: str | None,
    is_alike: Callable[[TrackedBody], bool],
    arguments: argparse.Namespace,
) -> list[tuple[Session, str | None]]:
    """Which body takes over which individual of the file, None where that is not said; which went
    where is said where there are several of both.

    individual: the one that is asked for.
    """
    file, several = arguments.file.name, len(session.bodies) > 1 and len(individuals) > 1
    if individual is not None and not arguments.body:
        called = assigned([individual], session.bodies, lambda _: False).individual_of
        if called and len(session.bodies) > 1:
            note(f"{file}: {individual} → {next(iter(called))}.")
            return [(session.about(next(iter(called))), individual)]
    if individual is not None or not several:
        return [(about_one(session, arguments), individual)]
    if arguments.body:
        about = session.about_called(arguments.body)
        called = assigned(individuals, (about.subject,), lambda _: False).individual_of
        own = called.get(about.subject.id)
        return [(about, chosen_individual(file, individuals, own))]
    assignment = assigned(individuals, session.bodies, is_alike)
    if not assignment.individual_of:  # reading it for the first body says what is wrong
        return [(session.about(session.subject.id), individuals[0])]
    for words in assignment.sentences(file):
        note(words)
    return [(session.about(body), own) for body, own in assignment.individual_of.items()]


# --- motion


def _with_motion(
    session: Session,
    made: MotionImport,
    first: str,
    whole: Session,
    arguments: argparse.Namespace,
) -> _Taken:
    """The motion is written beside the session, which refers to it.

    first: the body beside which it lies as in the file, where it has no keyframe; empty without.
    """
    imported_motion, file = made.found, arguments.file.name
    motion = imported_motion.fit.trajectory
    saved = save_first_motion(session, arguments.session, motion, file, made.matched)
    assert saved.subject.first_motion is not None
    written = arguments.session.parent / saved.subject.first_motion.file
    facts = _facts(made, written)
    doubts = tuple(_doubts(session, made, whole, arguments))
    return _Taken(saved, True, facts, lambda: _print_motion(facts, first), doubts)


def _doubts(
    session: Session, made: MotionImport, whole: Session, arguments: argparse.Namespace
) -> Iterator[str]:
    """What a person should know of a motion."""
    imported_motion = made.found
    yield from note_words(imported_motion.notes)
    if imported_motion.scale == 1.0 and abs(imported_motion.size - 1.0) > UNLIKE:
        percent, word = (
            100 * abs(1 / imported_motion.size - 1),
            "larger" if imported_motion.size < 1 else "smaller",
        )
        yield f"its body is {percent:.0f} % {word} than the session's; --unit auto would scale it."
    if len(session.subject.keyframes) < LEAST_TRACKED:
        named = f" --body {session.subject.id}" if len(whole.bodies) > 1 else ""
        yield (
            f"keypose reduce {arguments.session}{named} makes keyframes of it, to edit and to "
            "track from."
        )


def _facts(made: MotionImport, written: Path) -> dict[str, Any]:

    imported_motion = made.found
    fit, rms = imported_motion.fit, imported_motion.fit.rms_m
    worst = int(np.nanargmax(rms))
    return {
        "written": str(written),
        "first_frame": fit.trajectory.first_frame,
        "last_frame": fit.trajectory.last_frame,
        **names_of(imported_motion.matched, made.names),
        "size": imported_motion.size,
        "scale": imported_motion.scale,
        "rms_cm": float(100 * np.sqrt(np.nanmean(rms**2))),
        "worst_rms_cm": float(100 * rms[worst]),
        "worst_frame": fit.trajectory.first_frame + worst,
        "not_converged": [
            fit.trajectory.first_frame + int(n)
            for n in np.flatnonzero(~fit.converged & (rms > POOR_M))
        ],
        "keyframes": list(imported_motion.aligned),
        "from_keyframes_cm": 100 * imported_motion.keyframes_m,
        "notes": note_words(imported_motion.notes),
    }


def _print_motion(facts: dict[str, Any], first: str) -> None:
    print(f"Frames {facts['first_frame']}–{facts['last_frame']}.")
    _print_names(facts, "joints")
    if f"{facts['scale']:.3g}" != "1":
        print(f"Scaled to the body's size: × {facts['scale']:.4g}")
    print(
        f"Joint error {facts['rms_cm']:.2f} cm (rms), at most "
        f"{facts['worst_rms_cm']:.2f} cm at frame {facts['worst_frame']}."
    )
    if facts["keyframes"]:
        frames = ", ".join(str(frame) for frame in facts["keyframes"])
        print(f"Aligned with keyframes {frames}: {facts['from_keyframes_cm']:.1f} cm from them.")
    elif first:
        print(f"No keyframe overlaps: it lies beside {first} as in the file.")
    else:
        print("No keyframe overlaps: the motion is placed before the camera for now.")
    if facts["not_converged"]:
        note(f"the fit did not converge at {len(facts['not_converged'])} frames.")
    print(f"Written: {facts['written']}")


# --- keypoints


def _with_drafts(
    session: Session, draft_import: DraftImport, whole: Session, arguments: argparse.Namespace
) -> _Taken:
    drafts = draft_import.drafts
    made = {draft.keyframe.frame for draft in drafts}
    posed = {k.frame for k in (*session.subject.keyframes, *session.subject.drafts)}
    frames = draft_import.frames
    facts = {
        **names_of(draft_import.known, draft_import.names),
        "drafts": [
            {
                "frame": draft.keyframe.frame,
                "keypoints": draft.keypoints,
                "miss_px": draft.miss_px,
                "converged": draft.converged,
                "doubtful": draft.doubtful,
            }
            for draft in drafts
        ],
        "kept": [frame for frame in frames if frame in posed],
        "without_keypoints": [f for f in frames if f not in posed and f not in made],
        "notes": note_words(draft_import.notes),
    }
    return _Taken(
        draft_import.added_to(session) if drafts else session,
        bool(drafts),
        facts,
        lambda: _print_drafts(draft_import, facts, arguments),
        tuple(_of_unshown(session, whole, arguments)) if drafts else (),
    )


def _of_unshown(session: Session, whole: Session, arguments: argparse.Namespace) -> Iterator[str]:
    """What becomes of drafts of a body that the page does not show."""
    body_id = session.subject.id
    if body_id != whole.subject.id:
        yield (
            f"the page shows {whole.subject.id} alone; keypose reduce {arguments.session} --body "
            f"{body_id} --from drafts --every 1 makes keyframes of these drafts."
        )


def _print_drafts(
    draft_import: DraftImport, facts: dict[str, Any], arguments: argparse.Namespace
) -> None:
    drafts, kept, empty = draft_import.drafts, facts["kept"], facts["without_keypoints"]
    _print_names(facts, "keypoints")
    for draft in drafts:
        doubt = "; look at it closely" if draft.doubtful or not draft.converged else ""
        print(
            f"Draft at frame {draft.keyframe.frame}: {draft.keypoints} keypoints, missed by "
            f"{draft.miss_px:.1f} px on average{doubt}"
        )
    if kept:
        print(f"Left as posed: {', '.join(map(str, kept))}")
    if empty:
        print(f"Too few keypoints: {', '.join(map(str, empty))}")
    for words in note_words(draft_import.notes):
        note(words)
    print(f"Written: {arguments.session}" if drafts else "Nothing was changed.")


# --- names


def _print_names(facts: dict[str, Any], noun: str) -> None:
    matched = facts["matched"].items()
    pairs = ", ".join(f"{theirs[:LONGEST_NAME]} = {ours}" for theirs, ours in matched)
    print(f"Matched {len(facts['matched'])} {noun} ({facts['convention']}): {pairs}")
    if facts["left_out"]:
        count, more = len(facts["left_out"]), ", …" if len(facts["left_out"]) > MOST_NAMES else ""
        names = (name[:LONGEST_NAME] for name in facts["left_out"][:MOST_NAMES])
        print(f"Left out {count}: {', '.join(names)}{more}")
