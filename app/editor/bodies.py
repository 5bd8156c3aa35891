"""Edit which bodies a session has, and choose which of them is posed."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import StringConstraints

from keypose.app.editor.documents import ActionRefused
from keypose.app.editor.message import Edit, Look
from keypose.app.editor.state import EditorState
from keypose.app.editor.update import end_stroke, still_there
from keypose.tracker.body.body import PRESETS, preset
from keypose.tracker.session.bodies import TrackedBody
from keypose.tracker.session.schema import MOST_BODIES, Session
from keypose.tracker.session.settings import SceneId

NUMBERED = "body-"
BodyName: TypeAlias = Annotated[
    str, StringConstraints(strip_whitespace=True, max_length=60, pattern=r"^[^\x00-\x1f]*$")
]


class PoseBody(Look):
    """Another body is the one that is posed, tracked and shown whole."""

    do: Literal["pose_body"] = "pose_body"
    body: SceneId

    def after(self, state: EditorState) -> EditorState:
        require_body(state.doc, self.body)
        state = end_stroke(state)
        return still_there(state.with_doc(state.doc.posing(self.body)))


class AddBody(Edit):
    """A body of the shelf, which nobody has posed yet; it is the one that is posed from then on."""

    do: Literal["add_body"] = "add_body"
    verb = "add a body"
    preset: str

    def apply(self, state: EditorState) -> Session:
        doc = state.doc
        if self.preset not in PRESETS:
            raise ActionRefused("There is no body of that name.")
        if len(doc.bodies) >= MOST_BODIES:
            raise ActionRefused(f"The session has {MOST_BODIES} bodies already, the most it can.")
        ids = {body.id for body in doc.bodies}
        number = next(n for n in range(2, MOST_BODIES + 2) if f"{NUMBERED}{n}" not in ids)
        added = TrackedBody(id=f"{NUMBERED}{number}", body=preset(self.preset))
        return doc.model_copy(update={"bodies": (*doc.bodies, added)}).posing(added.id)


class CallBody(Edit):
    """What a body is called; empty: as its kind."""

    do: Literal["call_body"] = "call_body"
    verb = "call a body"
    body: SceneId
    name: BodyName

    def apply(self, state: EditorState) -> Session:
        chosen = require_body(state.doc, self.body)
        return state.doc.with_body(chosen.model_copy(update={"called": self.name}))


class RemoveBody(Edit):
    """A body is not in the session any more; nor are its keyframes."""

    do: Literal["remove_body"] = "remove_body"
    verb = "remove a body"
    body: SceneId

    def apply(self, state: EditorState) -> Session:
        doc = state.doc
        removed = require_body(doc, self.body)
        if len(doc.bodies) == 1:
            raise ActionRefused("A session has one body at least.")
        rest = tuple(body for body in doc.bodies if body is not removed)
        if removed is doc.subject:
            doc = doc.posing(rest[0].id)
        return without_body(doc, removed.id)


MESSAGES = (PoseBody, AddBody, CallBody, RemoveBody)


def require_body(doc: Session, body_id: str) -> TrackedBody:
    """A body by its id; refused where there is none."""
    for body in doc.bodies:
        if body.id == body_id:
            return body
    raise ActionRefused("This body is not in the session any more.")


def without_body(doc: Session, body_id: str) -> Session:
    """The session without one of its bodies that is not posed."""
    bodies = tuple(body for body in doc.bodies if body.id != body_id)
    posed_body = None if doc.subject.id == bodies[0].id else doc.subject.id
    return doc.model_copy(update={"bodies": bodies, "posed_body": posed_body})
