"""Move parts of the body; copy, paste and keep poses."""

from __future__ import annotations

from typing import Annotated, Literal, TypeAlias

from pydantic import Field, StringConstraints

from keypose.app.editor.actions.message import Degrees, Edit, Message, Metres
from keypose.app.editor.copied import Copied
from keypose.app.posing import Gesture, Way
from keypose.tracker.body.body import Name
from keypose.tracker.session.settings import FrameIndex

PoseName: TypeAlias = Annotated[
    str,
    StringConstraints(
        strip_whitespace=True, min_length=1, max_length=60, pattern=r"^[^\x00-\x1f]+$"
    ),
]
PoseId: TypeAlias = Annotated[str, Field(pattern=r"^[0-9a-f]{12}$")]


class CopyPose(Message):
    """These keyframes, or the pose shown at the present frame."""

    do: Literal["copy_pose"] = "copy_pose"
    frames: Annotated[tuple[FrameIndex, ...], Field(max_length=10_000)] = ()


class PastePose(Edit):
    """What was copied: a pose here, keyframes from here on.

    copied: from elsewhere; left out, what was copied in this session.  onto_body: the first pose
    stands where the body does, not where it was copied.  replace: keyframes that are in the way.
    name: of a pose of the library.
    """

    do: Literal["paste_pose"] = "paste_pose"
    mirrored: bool = False
    copied: Copied | None = None
    onto_body: bool = False
    replace: bool = False
    name: PoseName | None = None


class KeepPose(Message):
    """The pose shown here is kept under a name, for every session."""

    do: Literal["keep_pose"] = "keep_pose"
    name: PoseName


class RenamePose(Message):
    do: Literal["rename_pose"] = "rename_pose"
    id: PoseId
    name: PoseName


class DeletePose(Message):
    """A kept pose is deleted; RestorePose has it back."""

    do: Literal["delete_pose"] = "delete_pose"
    id: PoseId


class RestorePose(Message):
    do: Literal["restore_pose"] = "restore_pose"
    id: PoseId


class InsertPose(Message):
    """A kept pose becomes that of the present frame, where the body stands."""

    do: Literal["insert_pose"] = "insert_pose"
    id: PoseId
    mirrored: bool = False


PoseKeeping: TypeAlias = KeepPose | RenamePose | DeletePose | RestorePose
"""What the store does with the kept poses."""


class Drag(Edit, Gesture):
    """partial: the limbs it moves become a part keyframe of the present frame."""

    do: Literal["drag"] = "drag"
    partial: bool = False


class Angles(Edit):
    """Some angles of a part; `free` where its joint limits have been lifted."""

    do: Literal["angles"] = "angles"
    part: Name
    free: bool = False
    x: Degrees | None = None
    y: Degrees | None = None
    z: Degrees | None = None


class Root(Edit):
    do: Literal["root"] = "root"
    x: Metres | None = None
    y: Metres | None = None
    z: Metres | None = None


class Face(Edit):
    """The whole body turned about what is up, to face a way as seen in the picture."""

    do: Literal["face"] = "face"
    way: Way


class ResetPart(Edit):
    do: Literal["reset_part"] = "reset_part"
    part: Name


class ResetPose(Edit):
    do: Literal["reset_pose"] = "reset_pose"


class Exchange(Edit):
    """Left and right exchanged, where they are seen."""

    do: Literal["exchange"] = "exchange"


class TurnInDepth(Edit):
    """What points toward the camera points away from it, seen where it was: of a part and what
    hangs on it, or of the whole body. partial: as of `Drag`."""

    do: Literal["turn_in_depth"] = "turn_in_depth"
    part: Name | None = None
    partial: bool = False


class Untwist(Edit):
    """A limb turned back about its own length, its elbow and, as near as it can be, its hand where
    they are."""

    do: Literal["untwist"] = "untwist"
    part: Name


class CopyKey(Edit):
    """The pose of another keyframe, here."""

    do: Literal["copy_key"] = "copy_key"
    from_frame: FrameIndex


class TakeTracked(Edit):
    do: Literal["take_tracked"] = "take_tracked"


Posing: TypeAlias = (
    Drag
    | Angles
    | Root
    | Face
    | ResetPart
    | ResetPose
    | Exchange
    | TurnInDepth
    | Untwist
    | PastePose
    | CopyKey
    | TakeTracked
)
