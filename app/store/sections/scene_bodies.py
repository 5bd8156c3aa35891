"""Give the bodies of a session as JSON, and where those that are not posed stand."""

from __future__ import annotations

from keypose.app.editor.drafted import frames_of
from keypose.app.editor.shown import places_to_confirm, transforms_beside
from keypose.app.editor.state import EditorState
from keypose.app.posing import part_label
from keypose.app.render.palette import body_colour
from keypose.app.state.app_state import AppState
from keypose.app.store.sections.json_value import Json
from keypose.app.store.sections.space_values import solids_of
from keypose.app.words.bodies import body_names
from keypose.tracker.session.bodies import TrackedBody
from keypose.tracker.session.verdict import VERDICT_KINDS, worst_of


def bodies(app_state: AppState) -> Json:
    """Every body: what it is called, its keyframes and segments, the verdict on the worst of these,
    how many have none; how many drafts it has, and how many frames are left to draft; and the
    places of a draft to confirm, of those that are not posed."""
    edit = app_state.edit
    if edit is None:
        return []
    doc = edit.settled
    names, posed = body_names(doc), edit.doc.subject.id
    return [
        {
            "id": body.id,
            "name": names[body.id],
            "called": body.called,
            "posed": body.id == posed,
            "colour": _hex(place),
            "keys": [keyframe.frame for keyframe in body.keyframes],
            "drafts": len(body.drafts),
            "rest": _left_to_draft(body),
            "parts": [{"name": name, "label": part_label(name)} for name in body.body.names],
            "places": [] if body.id == posed else _places(edit.about(body.id)),
            **_tracked(edit.about(body.id)),
        }
        for place, body in enumerate(doc.bodies)
    ]


def _left_to_draft(body: TrackedBody) -> int:
    rest = None if body.drafted is None else body.drafted.rest
    return 0 if rest is None else len(frames_of(rest.frames))


def _places(alone: EditorState) -> list[int]:
    return [place.frame for place in places_to_confirm(alone)]


def _tracked(alone: EditorState) -> dict[str, Json]:
    states = alone.results.states(alone.settled)
    kinds = [kind for kind in states.values() if kind in VERDICT_KINDS]
    return {
        "segments": [
            {"first": first, "last": last, "state": state}
            for (first, last), state in states.items()
        ],
        "worst": worst_of(kinds),
        "open": len(states) - len(kinds),
    }


def solids_beside(app_state: AppState) -> Json:
    """What the parts of each body that is not posed are drawn from, by the body's id."""
    edit = app_state.edit
    if edit is None:
        return {}
    posed = edit.doc.subject.id
    return {body.id: solids_of(body.body) for body in edit.doc.bodies if body.id != posed}


def poses_beside(app_state: AppState) -> Json:
    """Where the parts of each body that is not posed are at the present frame, by its id."""
    edit = app_state.edit
    if edit is None:
        return {}
    names = {body.id: body.body.names for body in edit.doc.bodies}
    return {
        body_id: dict(zip(names[body_id], Ts[:, :3].reshape(-1, 12).round(5).tolist(), strict=True))
        for body_id, Ts in transforms_beside(edit).items()
    }


def _hex(place: int) -> str:
    return "#{:02x}{:02x}{:02x}".format(*body_colour(place))
