"""A body of the scene: how a person posed it, and the motion that was found."""

from __future__ import annotations

import operator
import re
import unicodedata
from collections.abc import Sequence
from itertools import chain, count
from typing import Any, Final

from pydantic import Field, model_validator

from keypose.tracker.body.body import Body
from keypose.tracker.errors import SessionError, listed
from keypose.tracker.session.annotations import (
    Ahead,
    Drafted,
    KeypointCorrection,
    ReviewedList,
)
from keypose.tracker.session.counts import few
from keypose.tracker.session.keyframe import Keyframe, PartKeyframe
from keypose.tracker.session.pins import PinList
from keypose.tracker.session.references import FirstMotion, KeypointFile
from keypose.tracker.session.results import Results
from keypose.tracker.session.settings import Plain, SceneId, Title


class ViewKeypoints(Plain):
    """The keypoints of one body in the film of one view, and what a person set right of them."""

    keypoints: KeypointFile | None = None
    keypoint_corrections: tuple[KeypointCorrection, ...] = Field(
        default=(), exclude_if=operator.not_
    )


LONGEST_STEM: Final = 32
"""Letters of an id that a number may follow."""


class TrackedBody(Plain):
    """A body, how a person posed it, and the motion that was found. Its poses are in the frame of
    the first view's camera."""

    id: SceneId = "body"
    called: Title = Field(
        default="",
        exclude_if=operator.not_,
        description="What a person calls it; left out where it is called as its kind.",
    )
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
    keypoints_by_view: dict[SceneId, ViewKeypoints] = Field(
        default={},
        exclude_if=operator.not_,
        description="Its keypoints by the id of the view that shows them; left out for the body "
        "that is posed, whose keypoints stand in the views, and where there are none.",
    )

    @property
    def posed(self) -> tuple[Keyframe, ...]:
        """All that has a pose: keyframes, also of parts, and drafts."""
        return (*self.keyframes, *self.part_keyframes, *self.drafts)

    @model_validator(mode="before")
    @classmethod
    def _is_of_usable_size(cls, data: Any) -> Any:
        return few(data)


def body_called(bodies: Sequence[TrackedBody], name: str) -> TrackedBody:
    """The body of an id, or else the only one of a name; SessionError says which there are."""
    by_id = [body for body in bodies if body.id == name]
    named = [body for body in bodies if body.called == name]
    matching = by_id or named or [body for body in bodies if body.body.name == name]
    if len(matching) == 1:
        return matching[0]
    fault = f"{len(matching)} bodies are" if matching else "No body is"
    raise SessionError(f"{fault} called {name[:60]!r}: choose by id from {bodies_words(bodies)}.")


def bodies_words(bodies: Sequence[TrackedBody]) -> str:
    """Such as "body (adult_male) and ball": ids, and names that differ from them."""
    return listed([id_and_name(body) for body in bodies])


def id_and_name(body: TrackedBody) -> str:
    """Such as "body (Anna)", or "ball" where id and name are the same."""
    name = body.called or body.body.name
    return body.id if body.id == name else f"{body.id} ({name})"


def free_id(wish: str, bodies: Sequence[TrackedBody]) -> str:
    """An id that none of the bodies has: the wish in what ids may have, and a number where it is
    taken; such as "left-shoe-2" of "Left shoe"."""
    plain = unicodedata.normalize("NFKD", wish.lower()).encode("ascii", "ignore").decode()
    stem = re.sub(r"[^a-z0-9_]+", "-", plain).strip("-")[:LONGEST_STEM] or "body"
    taken = {body.id for body in bodies}
    numbered = (f"{stem}-{number}" for number in count(2))
    return next(each for each in chain([stem], numbered) if each not in taken)
