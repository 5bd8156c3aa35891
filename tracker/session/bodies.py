"""A body of the scene: how a person posed it, and the motion that was found."""

from __future__ import annotations

import operator
from typing import Any

from pydantic import Field, model_validator

from keypose.tracker.body.body import Body
from keypose.tracker.session.annotations import Ahead, Drafted, ReviewedList
from keypose.tracker.session.counts import few
from keypose.tracker.session.keyframe import Keyframe, PartKeyframe
from keypose.tracker.session.pins import PinList
from keypose.tracker.session.references import FirstMotion
from keypose.tracker.session.results import Results
from keypose.tracker.session.settings import Plain, SceneId


class TrackedBody(Plain):
    """A body, how a person posed it, and the motion that was found. Its poses are in the frame of
    the first view's camera."""

    id: SceneId = "body"
    body: Body
    keyframes: tuple[Keyframe, ...] = ()
    part_keyframes: tuple[PartKeyframe, ...] = Field(
        default=(),
        exclude_if=operator.not_,
        description="Keyframes of some parts alone, at frames that are no keyframes; left out "
        "where there are none.",
    )
    drafts: tuple[Keyframe, ...] = Field(
        default=(), description="Poses begun at frames that are no keyframes yet; not tracked."
    )
    pins: PinList = ()
    first_motion: FirstMotion | None = Field(
        default=None, description="An imported motion that tracking may start from."
    )
    drafted: Drafted | None = Field(
        default=None,
        exclude_if=operator.not_,
        description="What drafting the film found besides the drafts; left out where nobody did.",
    )
    reviewed: ReviewedList = ()
    ahead: tuple[Ahead, ...] = Field(
        default=(),
        exclude_if=operator.not_,
        description="How far the body was followed from keyframes, and why no farther; left out "
        "where it was not.",
    )
    results: Results | None = None

    @property
    def posed(self) -> tuple[Keyframe, ...]:
        """All that has a pose: keyframes, also of parts, and drafts."""
        return (*self.keyframes, *self.part_keyframes, *self.drafts)

    @model_validator(mode="before")
    @classmethod
    def _is_of_usable_size(cls, data: Any) -> Any:
        return few(data)
