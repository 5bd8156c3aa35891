"""Masks, settings, saving, undo and the guide, as JSON."""

from __future__ import annotations

from app.posing import part_label
from app.store.sections.json_value import Json, doc_of
from app.store.state import AppState
from tracker.session.settings import TrackSettings
from tracker.tracking.method import method_of


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
        for mask in (doc.ignore_masks if doc else ())
    ]


def settings(app_state: AppState) -> Json:
    """How to track."""
    doc = doc_of(app_state)
    given = doc.settings if doc else TrackSettings()
    usual = method_of(given.model_copy(update={"passes": None})).passes
    source = doc.first_motion.source if doc and doc.first_motion else None
    found = doc.video.stands_still if doc else None
    cues = list(given.cues_used)
    known = {"cues": cues, "default_passes": usual, "imported": source, "found_still": found}
    return {**given.model_dump(), **known}


def saved(app_state: AppState) -> Json:
    """Whether the session is on disk."""
    given = app_state.saved
    return {"state": given.state, "at": given.at_s, "words": given.words}


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
    given = app_state.fit
    if given is None:
        return None
    return {
        "frame": given.frame,
        "words": given.words,
        "looking_back": given.looking_back,
        "changes": [
            {"part": part_label(part), "what": what, "before": before, "after": after}
            for part, what, before, after in given.changes
        ],
    }


def is_latest_draft(app_state: AppState) -> bool:
    """Whether nothing was edited since the clip was drafted."""
    given, doc = app_state.draft, doc_of(app_state)
    return given is not None and doc is given.after


def draft(app_state: AppState) -> Json:
    """What the last draft of the clip found, until none of its drafts is left: the frames
    without a draft, and the drafts that should be confirmed as keyframes and are none yet."""
    given, doc = app_state.draft, doc_of(app_state)
    waiting = {draft.frame for draft in doc.drafts} if doc else set()
    if given is None or not waiting.intersection(given.drafted):
        return None
    first, last = given.frames
    return {
        "latest": is_latest_draft(app_state),
        "first": first,
        "last": last,
        "missing": sorted(set(range(first, last + 1)) - set(given.drafted)),
        "proposals": [
            {
                "frame": proposal.frame,
                "reason": proposal.reason,
                "parts": [part_label(part) for part in proposal.parts],
            }
            for proposal in given.proposals
            if proposal.frame in waiting
        ],
    }


def guide(app_state: AppState) -> Json:
    """The first pose's steps."""
    given = app_state.guide
    steps = ("hips", "height", "facing", "limbs", "depth", "key")
    first = given.first and "key" not in given.done
    return {"first": first, "done": {step: step in given.done for step in steps}}
