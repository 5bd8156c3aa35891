"""`keypose import`: recorded motion as a start for tracking, keypoints as first poses."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import numpy as np

from keypose.app.cli.arguments import (
    note,
    order_of,
    require_of,
)
from keypose.app.cli.import_camera import import_camera
from keypose.app.cli.json_output import print_json
from keypose.app.document.folder_lock import locked
from keypose.app.export.importing import (
    DraftImport,
    MotionImport,
    as_chosen,
    import_keypoints,
    import_motion,
    names_of,
)
from keypose.app.orders.imports import (
    IMPORTS,
    LEAST_TRACKED,
    ImportCamera,
    ImportKeypoints,
    ImportMotion,
)
from keypose.app.words.imports import note_words
from keypose.tracker.apart import reading_apart
from keypose.tracker.errors import FormatError
from keypose.tracker.formats.keypoint_files import read_people
from keypose.tracker.formats.reading import load_motion
from keypose.tracker.session import Session
from keypose.tracker.solver.fit_joints import POOR_M
from keypose.tracker.storage.files import load_session, open_video_of, save_session
from keypose.tracker.storage.sidecars import save_first_motion

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
        require_of(ImportCamera, IMPORTS, arguments, "--camera")
        with alone:
            import_camera(arguments)
        return 0
    if arguments.keypoints:
        require_of(ImportKeypoints, IMPORTS, arguments, "--keypoints")
    else:
        require_of(ImportMotion, IMPORTS, arguments, "motion")
    file: Path = arguments.file
    reader: Callable[..., Any] = read_people if arguments.keypoints else load_motion
    with reading_apart(reader) as read, alone:
        session = load_session(arguments.session)
        with open_video_of(session, arguments.session) as video:
            info = video.info
        if arguments.keypoints:
            chosen = order_of(ImportKeypoints, arguments)
            people = read(file, chosen.individual)
            drafts = import_keypoints(session, people, file.name, chosen, info)
            _keep_drafts(session, drafts, arguments)
        else:
            choices = order_of(ImportMotion, arguments)
            motion = as_chosen(file.name, read(file), choices)
            times_s = session.evidence.times_s(info.times_s)
            made = import_motion(session, motion, file.name, choices, times_s)
            if isinstance(made, DraftImport):
                _keep_drafts(session, made, arguments)
            else:
                _keep_motion(session, made, arguments)
    return 0


# --- motion


def _keep_motion(session: Session, made: MotionImport, arguments: argparse.Namespace) -> None:
    imported_motion, file = made.found, arguments.file.name
    motion = imported_motion.fit.trajectory
    saved = save_first_motion(session, arguments.session, motion, file, made.matched)
    save_session(saved, arguments.session)
    assert saved.subject.first_motion is not None
    written = arguments.session.parent / saved.subject.first_motion.file
    _print_motion(_facts(made, written), arguments.json)
    for words in note_words(imported_motion.notes):
        note(words)
    if imported_motion.scale == 1.0 and abs(imported_motion.size - 1.0) > UNLIKE:
        percent, word = (
            100 * abs(1 / imported_motion.size - 1),
            "larger" if imported_motion.size < 1 else "smaller",
        )
        note(f"its body is {percent:.0f} % {word} than the session's; --unit auto would scale it.")
    if len(session.subject.keyframes) < LEAST_TRACKED:
        note(
            f"keypose reduce {arguments.session} makes keyframes of it, to edit and to track from."
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


def _print_motion(facts: dict[str, Any], as_json: bool) -> None:
    if as_json:
        print_json(facts)
        return
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
    else:
        print("No keyframe overlaps: the motion is placed before the camera for now.")
    if facts["not_converged"]:
        note(f"the fit did not converge at {len(facts['not_converged'])} frames.")
    print(f"Written: {facts['written']}")


# --- keypoints


def _keep_drafts(
    session: Session, draft_import: DraftImport, arguments: argparse.Namespace
) -> None:
    if draft_import.drafts:
        save_session(draft_import.added_to(session), arguments.session)
    _print_drafts(session, draft_import, arguments)


def _print_drafts(
    session: Session, draft_import: DraftImport, arguments: argparse.Namespace
) -> None:
    drafts, frames, names = (
        draft_import.drafts,
        draft_import.frames,
        names_of(draft_import.known, draft_import.names),
    )
    made = {draft.keyframe.frame for draft in drafts}
    posed = {k.frame for k in (*session.subject.keyframes, *session.subject.drafts)}
    kept = [frame for frame in frames if frame in posed]
    empty = [frame for frame in frames if frame not in posed and frame not in made]
    if arguments.json:
        drafts_json = [
            {
                "frame": draft.keyframe.frame,
                "keypoints": draft.keypoints,
                "miss_px": draft.miss_px,
                "converged": draft.converged,
                "doubtful": draft.doubtful,
            }
            for draft in drafts
        ]
        notes = note_words(draft_import.notes)
        facts = {"drafts": drafts_json, "kept": kept, "without_keypoints": empty, "notes": notes}
        print_json({**names, **facts})
        return
    _print_names(names, "keypoints")
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
    if drafts:
        print(f"Written: {arguments.session}")


# --- names


def _print_names(facts: dict[str, Any], noun: str) -> None:
    matched = facts["matched"].items()
    pairs = ", ".join(f"{theirs[:LONGEST_NAME]} = {ours}" for theirs, ours in matched)
    print(f"Matched {len(facts['matched'])} {noun} ({facts['convention']}): {pairs}")
    if facts["left_out"]:
        count, more = len(facts["left_out"]), ", …" if len(facts["left_out"]) > MOST_NAMES else ""
        names = (name[:LONGEST_NAME] for name in facts["left_out"][:MOST_NAMES])
        print(f"Left out {count}: {', '.join(names)}{more}")
