"""What a person says in the review, and of keypoints."""

from __future__ import annotations

from typing import Literal, TypeAlias

from keypose.app.editor.actions.message import Edit, Spot
from keypose.tracker.body.body import Name
from keypose.tracker.session.settings import FrameIndex


class AcceptPlace(Edit):
    """The motion is right at this place to review: of a part, or of the whole body."""

    do: Literal["accept_place"] = "accept_place"
    frame: FrameIndex
    part: Name | None = None


class CannotTell(Edit):
    """Whether it is right there nobody can tell from the picture."""

    do: Literal["cannot_tell"] = "cannot_tell"
    frame: FrameIndex
    part: Name | None = None


class CorrectKeypoint(Edit):
    """Where a joint is seen in a frame. at: pixels of the main view."""

    do: Literal["correct_keypoint"] = "correct_keypoint"
    frame: FrameIndex
    joint: Name
    at: Spot


class IgnoreKeypoint(Edit):
    """What was found of a joint in a frame does not count."""

    do: Literal["ignore_keypoint"] = "ignore_keypoint"
    frame: FrameIndex
    joint: Name


class RestoreKeypoint(Edit):
    """A joint is where it was found in a frame."""

    do: Literal["restore_keypoint"] = "restore_keypoint"
    frame: FrameIndex
    joint: Name


Reviewing: TypeAlias = AcceptPlace | CannotTell
Seeing: TypeAlias = CorrectKeypoint | IgnoreKeypoint | RestoreKeypoint
