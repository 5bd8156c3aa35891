"""What a message is, what becomes of it, and the numbers and words in it: checked where they enter.

An edit with a `stroke` is part of one gesture: the gesture is applied to the document as it was
before, so moves that are lost or merged do no harm. Frames are video frame numbers; angles degrees,
sizes centimetres, places pixels of the main view, as on the page.
"""

from __future__ import annotations

from abc import abstractmethod
from functools import cache
from typing import (
    TYPE_CHECKING,
    Annotated,
    Any,
    ClassVar,
    TypeAlias,
    get_args,
    get_type_hints,
)

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, StringConstraints

from keypose.app.posing import part_label
from keypose.tracker.session.settings import FrameIndex

if TYPE_CHECKING:
    from keypose.app.editor.state import EditorState
    from keypose.app.posing import Readout
    from keypose.tracker.session.schema import Session

Degrees: TypeAlias = Annotated[FiniteFloat, Field(ge=-1080, le=1080)]
Frames: TypeAlias = Annotated[tuple[FrameIndex, ...], Field(min_length=1, max_length=10_000)]
StrokeName: TypeAlias = Annotated[str, Field(min_length=1, max_length=60)]
PoseName: TypeAlias = Annotated[
    str,
    StringConstraints(
        strip_whitespace=True, min_length=1, max_length=60, pattern=r"^[^\x00-\x1f]+$"
    ),
]
PoseId: TypeAlias = Annotated[str, Field(pattern=r"^[0-9a-f]{12}$")]


class Message(BaseModel):
    """One message; fields it does not know are refused."""

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)


class Edit(Message):
    """An action that changes the document; those of one stroke are one undo step.

    verb: what undo calls it.  target: the field that names what it is done to.
    """

    verb: ClassVar[str]
    target: ClassVar[str | None] = None
    stroke: StrokeName | None = None

    @property
    def frames_named(self) -> tuple[int, ...]:
        """The frames of the video that it names, all of them checked before it is applied."""
        values = (getattr(self, name) for name in _frame_fields(type(self)))
        return tuple(
            frame
            for value in values
            for frame in (value if isinstance(value, tuple) else (value,))
            if frame is not None
        )

    @abstractmethod
    def apply(self, state: EditorState) -> Session:
        """The document after it; KeyposeError, in one sentence, when it cannot be done."""

    def change(self, state: EditorState, before: EditorState) -> tuple[Session, Readout | None]:
        """The document after it, and what a gesture that began in `before` shows meanwhile."""
        return self.apply(before), None

    def label(self, state: EditorState) -> str:
        """What undo offers to undo: "turn right forearm"."""
        target = getattr(self, self.target) if self.target else None
        if target is None:
            return self.verb
        return f"{self.verb} {part_label(target).lower() if isinstance(target, str) else target}"


@cache
def _frame_fields(kind: type[Message]) -> tuple[str, ...]:
    """The names of the fields that hold a frame, or several."""
    hints = get_type_hints(kind, include_extras=True)
    return tuple(name for name in kind.model_fields if _names_frames(hints[name]))


def _names_frames(hint: Any) -> bool:
    return hint == FrameIndex or any(map(_names_frames, get_args(hint)))


class Look(Message):
    """An action that changes what is shown or in hand, and nothing of the document."""

    @abstractmethod
    def after(self, state: EditorState) -> EditorState:
        """The state after it; KeyposeError, in one sentence, when it cannot be done."""


class Rewind(Message):
    """An action that goes through what has been edited."""

    @abstractmethod
    def after(self, state: EditorState) -> EditorState:
        """As of `Look`."""


Editing: TypeAlias = Edit | Look | Rewind
"""What `keypose.app.editor.update` knows to apply."""
