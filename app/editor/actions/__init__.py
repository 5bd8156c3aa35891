"""List what a person can do, each as a small frozen message, as the page sends it.

Every value is checked here, where it enters. An action with a `stroke` is part of one gesture: the
gesture is applied to the document as it was before, so moves that are lost or merged do no harm.
Frames are video frame numbers; angles degrees, sizes centimetres, as on the page.
"""

from __future__ import annotations

from typing import Annotated, TypeAlias

from pydantic import Field, TypeAdapter

from keypose.app.editor.actions.body import *
from keypose.app.editor.actions.jobs import *
from keypose.app.editor.actions.keyframes import *
from keypose.app.editor.actions.message import *
from keypose.app.editor.actions.posing import *
from keypose.app.editor.actions.program import *

Editing: TypeAlias = (
    Looking
    | Posing
    | Keying
    | Noting
    | Pinning
    | Reviewing
    | Shaping
    | Filming
    | Choosing
    | Seeing
    | Rename
    | Rewinding
)
"""What `keypose.app.editor.update` knows to apply."""

Running: TypeAlias = Track | Fitting | Reducing | Cancel | SaveAgain | Close | Open | Shelving
"""What the store does: jobs and files."""

Action: TypeAlias = Annotated[
    Editing | Running | PoseKeeping | InsertPose, Field(discriminator="do")
]
ACTIONS: TypeAdapter[Action] = TypeAdapter(Action)
