"""Moving parts of the body with handles, fields and buttons."""

from __future__ import annotations

from typing import Literal, TypeAlias

from keypose.app.editor.actions.message import Degrees, Edit, Metres
from keypose.app.editor.actions.poses import PastePose
from keypose.app.posing import Gesture, Way
from keypose.tracker.body.body import Name
from keypose.tracker.session.settings import FrameIndex


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
