"""Edit which bodies a session has, and choose which of them is posed."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import StringConstraints

from keypose.app.editor.documents import ActionRefused
from keypose.app.editor.message import Edit, Look
from keypose.app.editor.state import EditorState
from keypose.app.editor.update import end_stroke, still_there
from keypose.tracker.body.body import preset
from keypose.tracker.body.preset_names import PRESETS
from keypose.tracker.session.bodies import TrackedBody
from keypose.tracker.session.schema import Session
from keypose.tracker.session.settings import SceneId

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
        return still_there(state.with_doc(state.doc.about(self.body)))


class AddBody(Edit):
    """A body of the shelf, which nobody has posed yet; it is the one that is posed from then on."""

    do: Literal["add_body"] = "add_body"
    verb = "add a body"
    preset: str

    def apply(self, state: EditorState) -> Session:
        if self.preset not in PRESETS:
            raise ActionRefused("There is no body of that name.")
        doc, added = state.doc.with_new_body(preset(self.preset), self.preset)
        return doc.about(added.id)


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
        require_body(state.doc, self.body)
        return state.doc.without_body(self.body)


MESSAGES = (PoseBody, AddBody, CallBody, RemoveBody)


def require_body(doc: Session, body_id: str) -> TrackedBody:
    """A body by its id; refused where there is none."""
    for body in doc.bodies:
        if body.id == body_id:
            return body
    raise ActionRefused("This body is not in the session any more.")
