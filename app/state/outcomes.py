"""What jobs found, shown until something else is edited."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.keypoints.region import Box
from keypose.tracker.session import Session

if TYPE_CHECKING:
    from keypose.tracker.geometry.up import UpEstimate, UpEvidence
    from keypose.tracker.video.upright_lines import UprightLines

Boxes: TypeAlias = tuple[Box, ...]
"""Around everybody in a picture, the tallest first."""


@dataclass(frozen=True, eq=False)
class Following:
    """The motion so far, from the keyframe at a frame."""

    frame: int
    motion: Trajectory


@dataclass(frozen=True, eq=False)
class FoundUp:
    """What was found of up, until something else is edited.

    estimate: in the world; None where nothing shows it.  lines: upright ones that agree, None where
    few do or nobody looked.  frame: in which these are seen, of a camera that moves; None where it
    stands still.  after: the document with it.  seen: what lines of the whole film show.
    """

    estimate: UpEstimate | None
    lines: UprightLines | None = None
    frame: int | None = None
    after: Session | None = None
    seen: UpEvidence | None = None


@dataclass(frozen=True, eq=False)
class FitOutcome:
    """What the last fit of a pose did, until something else is edited.

    frame: of the pose.
    before, after: the documents.  looking_back: `before` is shown just now.
    """

    frame: int
    words: str
    before: Session
    after: Session
    looking_back: bool = False
