"""Sessions: opened, saved, named, copied and deleted."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import Field

from keypose.app.editor.actions.message import Edit, Message
from keypose.tracker.session.schema import Title

SessionId: TypeAlias = Annotated[str, Field(pattern=r"^[0-9a-f]{16}$")]
"""Of a session among the recent ones, or of one in the trash."""


class SaveAgain(Message):
    do: Literal["save_again"] = "save_again"


class Rename(Edit):
    """What a person calls the open session; empty: as its folder is called."""

    do: Literal["rename"] = "rename"
    title: Title


class RenameSession(Message):
    """The same of any recent session."""

    do: Literal["rename_session"] = "rename_session"
    id: SessionId
    title: Title


class DuplicateSession(Message):
    """A copy beside it; its video is not copied."""

    do: Literal["duplicate_session"] = "duplicate_session"
    id: SessionId


class DeleteSession(Message):
    """To the trash of the workspace; its video stays where it is."""

    do: Literal["delete_session"] = "delete_session"
    id: SessionId


class RestoreSession(Message):
    """Back from the trash; `open` where it was deleted while it was open."""

    do: Literal["restore_session"] = "restore_session"
    id: SessionId
    open: bool = False


class Close(Message):
    do: Literal["close"] = "close"


class Open(Message):
    do: Literal["open"] = "open"
    kind: Literal["recent", "file", "sample", "upload"]
    id: Annotated[str, Field(min_length=1, max_length=4096)]
    video: Annotated[str, Field(min_length=1, max_length=4096)] | None = Field(
        default=None, description="For a recent session whose video was moved: the file it is now."
    )


Shelving: TypeAlias = RenameSession | DuplicateSession | DeleteSession | RestoreSession
