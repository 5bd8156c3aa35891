"""Give masks, settings, saving, history, notes and the guide as JSON."""

from __future__ import annotations

import math

from keypose.app.editor.drafted import frame_runs, frames_of, missing_frames
from keypose.app.editor.shown import counts, places_to_confirm
from keypose.app.posing import part_label
from keypose.app.state.app_state import AppState
from keypose.app.store.sections.json_value import Json, doc_of
from keypose.tracker.body.modify import height
from keypose.tracker.session.schema import Session
from keypose.tracker.session.settings import TrackSettings

MOST_LISTED = 200
"""Steps on either side of the present one; further ones are listed once one has gone there."""


def history(app_state: AppState) -> Json:
    """The steps around the present one, oldest first. done: how many are done, of `total`; first:
    how many stand before those that are listed. made: seconds since 1970, null where not kept."""
    edit = app_state.edit
    if edit is None:
        return None
    past, future = edit.history.past, tuple(reversed(edit.history.future))
    first = max(0, len(past) - MOST_LISTED)
    listed = (*past[first:], *future[:MOST_LISTED])
    return {
        "done": len(past),
        "total": edit.history.total,
        "first": first,
        "steps": [
            {"label": step.label, "frame": step.frame, "made": step.made_s} for step in listed
        ],
    }


def notes(app_state: AppState) -> Json:
    """The notes, by frame."""
    doc = doc_of(app_state)
    return [{"frame": note.frame, "text": note.text} for note in (doc.notes if doc else ())]


def masks(app_state: AppState) -> Json:
    """The ignored regions."""
    doc = doc_of(app_state)
    return [
        {
            "polygon": [list(spot) for spot in mask.polygon],
            "first": mask.first_frame,
            "last": mask.last_frame,
            "note": mask.note,
        }
        for mask in (doc.view.ignore_masks if doc else ())
    ]


def settings(app_state: AppState) -> Json:
    """How to track."""
    doc = doc_of(app_state)
    track_settings = doc.settings if doc else TrackSettings()
    source = doc.subject.first_motion.source if doc and doc.subject.first_motion else None
    stands_still = doc.view.video.stands_still if doc else None
    return {
        **track_settings.model_dump(include={"method", "quality", "static_camera"}),
        "found_still": stands_still,
        "imported": source,
        "smooth": bool(track_settings.smooth),
        "cues": list(track_settings.cues_used),
    }


def saved(app_state: AppState) -> Json:
    """Whether the session is on disk."""
    state = app_state.saved
    return {"state": state.state, "at": state.at_s, "words": state.words}


def undo(app_state: AppState) -> Json:
    """What undo and redo would do."""
    edit = app_state.edit
    past, future = (edit.history.past, edit.history.future) if edit else ((), ())
    under_way = edit.stroke.label if edit and edit.stroke else None
    return {
        "undo": under_way or (past[-1].label if past else None),
        "redo": future[-1].label if future and not under_way else None,
    }


def clipboard(app_state: AppState) -> Json:
    """Whether a pose can be pasted."""
    return app_state.edit is not None and app_state.edit.clipboard is not None


def fit(app_state: AppState) -> Json:
    """What the last fit did, until something else is edited."""
    fit_outcome = app_state.fit
    if fit_outcome is None:
        return None
    return {
        "frame": fit_outcome.frame,
        "words": fit_outcome.words,
        "looking_back": fit_outcome.looking_back,
    }


def sizes_preview(app_state: AppState) -> Json:
    """New sizes that wait to be applied or discarded."""
    preview, edit = app_state.preview, app_state.edit
    if preview is None or edit is None:
        return None
    chosen = preview.proposal
    before, after = (100 * height(body) for body in (preview.before.subject.body, chosen.body))
    poses = preview.found.with_poses
    return {
        "words": preview.found.message,
        "note": preview.found.note,
        "keyframes": len(preview.before.subject.keyframes),
        "error": _outline_error(preview.found.error_px, chosen.error_px),
        "height": {"before": before, "after": after},
        "changes": [
            {"part": part_label(part), "what": kind, "pair": _has_sides(preview.before, part)}
            | {"before": was, "after": is_now}
            for part, kind, was, is_now in chosen.changes
        ],
        "unseen": [part_label(part) for part in preview.found.unseen],
        "poses": preview.poses,
        "choice": preview.alone is not None and preview.with_poses is not None,
        "turns": [
            {"frame": frame, "parts": [{"part": part_label(p), "deg": deg} for p, deg in turned]}
            for frame, turned in (poses.turns.items() if poses else ())
        ],
        "outdated": len(edit.results.fitting(preview.before)),
        "looking_back": preview.looking_back,
    }


def _outline_error(before_px: float, after_px: float) -> Json:
    """None where no picture shows the outline."""
    if not (math.isfinite(before_px) and math.isfinite(after_px)):
        return None
    return {"before": before_px, "after": after_px}


def reduction(app_state: AppState) -> Json:
    """Keyframes of a reduction that wait to be applied or discarded."""
    reduction_preview, edit = app_state.reduction, app_state.edit
    if reduction_preview is None or edit is None:
        return None
    asked, motion, result = (
        reduction_preview.asked,
        reduction_preview.found.motion,
        reduction_preview.reduction,
    )
    posed = (
        edit.doc.subject.keyframes
        if reduction_preview.found.parts is None
        else edit.doc.subject.part_keyframes
    )
    frames = () if result is None else result.frames
    own = {keyframe.frame for keyframe in posed}
    return {
        "first": motion.first_frame,
        "last": motion.last_frame,
        "from": asked.first,
        "to": asked.last,
        "goal": asked.every,
        "cm": asked.cm,
        "px": asked.px,
        "limbs": list(asked.limbs),
        "replacing": asked.replacing,
        "source": reduction_preview.found.source,
        "busy": reduction_preview.busy,
        "frames": list(frames),
        "kept": len(own.intersection(frames)),
        "every": 0.0 if result is None else result.frames_per_keyframe,
        "off_cm": _finite(None if result is None else 100 * result.worst_m),
        "off_px": _finite(None if result is None else result.worst_px),
        "gaps": 0 if result is None else len(result.misses) - result.known_count,
    }


def _finite(figure: float | None) -> float | None:
    return figure if figure is not None and math.isfinite(figure) else None


def _has_sides(doc: Session, part: str) -> bool:
    """Whether a kind of part is there on both sides."""
    return part not in doc.subject.body.names


def is_latest_draft(app_state: AppState) -> bool:
    """Whether nothing was edited since the clip was drafted."""
    doc = doc_of(app_state)
    return doc is not None and doc is app_state.draft


def draft(app_state: AppState) -> Json:
    """What the last draft of the clip found, until none of its drafts is left: the frames
    where nobody was found and nothing is posed or tracked yet, and the drafts that should be
    confirmed as keyframes, are shown, and of which nobody has said that the picture does not show
    it. first, last: of the frames drafted last; drafted: how many of them were; behind: of how many
    of these the tracked pose is shown instead.  rest: runs of frames that it was cancelled before.
    """
    edit, doc = app_state.edit, doc_of(app_state)
    if edit is None or doc is None or doc.subject.drafted is None:
        return None
    drafted, waiting = doc.subject.drafted, {draft.frame for draft in doc.subject.drafts}
    if not waiting:
        return None
    left = set() if drafted.rest is None else {*frames_of(drafted.rest.frames)}
    asked = [f for f in range(drafted.first_frame, drafted.last_frame + 1) if f not in left]
    lacking = missing_frames(drafted)
    hidden = {draft.frame for draft in doc.subject.drafts if not counts(edit, draft)}
    tracked = {frame for frame in lacking if edit.tracked(frame) is not None}
    posed = {*waiting, *tracked, *(k.frame for k in doc.subject.keyframes)}
    return {
        "latest": is_latest_draft(app_state),
        "first": drafted.first_frame,
        "last": drafted.last_frame,
        "drafted": len(asked) - len({*lacking}.intersection(asked)),
        "behind": len(hidden.intersection(asked)),
        "missing": [
            [run.first_frame, run.last_frame]
            for run in frame_runs(frame for frame in lacking if frame not in posed)
        ],
        "rest": [
            [run.first_frame, run.last_frame]
            for run in (drafted.rest.frames if drafted.rest is not None else ())
        ],
        "proposals": [
            {
                "frame": place.frame,
                "reason": place.reason,
                "parts": [part_label(part) for part in place.parts],
            }
            for place in places_to_confirm(edit)
        ],
    }


def people(app_state: AppState) -> Json:
    """Who was found in the picture of the present frame, the tallest first; None where
    nobody has looked. boxes: null where that was not done to the end."""
    edit = app_state.edit
    if edit is None or edit.frame not in app_state.people:
        return None
    boxes = app_state.people[edit.frame]
    return {"frame": edit.frame, "boxes": None if boxes is None else [list(box) for box in boxes]}


def guide(app_state: AppState) -> Json:
    """The first pose's steps."""
    first_pose = app_state.guide
    steps = ("hips", "height", "facing", "limbs", "depth", "key")
    first = first_pose.first and "key" not in first_pose.done
    return {"first": first, "done": {step: step in first_pose.done for step in steps}}
