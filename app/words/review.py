"""Word a place to review, and the answers to places."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Final

from keypose.app.posing import part_label
from keypose.app.words.problems import reason_of, size_of
from keypose.tracker.errors import readable
from keypose.tracker.review.places import Place, Review
from keypose.tracker.review.problems import Problem
from keypose.tracker.session.annotations import Reason, Reviewed
from keypose.tracker.session.results import SpaceFinding

WHOLE_BODY: Final = "Whole body"

_DRAFTS: Final[Mapping[Reason, str]] = {
    "start": "first frame of the draft",
    "end": "last frame of the draft",
    "pose": "extreme pose of the motion",
    "residual": "{part} may be off",
    "hidden": "{part} hidden",
    "flip": "{part} may point the other way",
    "wrong": "{part} {is_are} wrong: correct {it}",
    "person": "may be another person from here on",
}


_IN_SPACE: Final[Mapping[str, Callable[[float], str]]] = {
    "off_floor": lambda metres: f"leaves the floor by {100 * metres:.0f} cm",
    "pulled": lambda px: f"its pin moves it by {px:.0f} px",
    "bent": lambda rad: f"its pin bends the knee by {math.degrees(rad):.0f}°",
}


def label_of_place(place: Place) -> str:
    """The part that it is about: "Right forearm"."""
    return WHOLE_BODY if place.part is None else part_label(place.part)


def reason_of_place(place: Place) -> str:
    """Why it should be looked at: "hidden behind the head, 83–92"."""
    if isinstance(place.why, Problem):
        return reason_of(place.why)
    if isinstance(place.why, SpaceFinding):
        return _IN_SPACE[place.why.kind](abs(place.why.amount))
    return draft_reason(place.why.reason, [] if place.part is None else [place.part])


def draft_reason(reason: Reason, parts: Sequence[str]) -> str:
    """Why a draft should be confirmed: "right forearm hidden". parts: names of those it is about,
    of the whole body without any."""
    is_many = len(parts) > 1
    return _DRAFTS[reason].format(
        part=", ".join(map(readable, parts)) if parts else "the body",
        is_are="are" if is_many else "is",
        it="them" if is_many else "it",
    )


def row_of_place(place: Place) -> tuple[str, str, str, str]:
    """Frame, part, expected error and reason, as a table has them."""
    size = size_of(place.px, place.cm) or "–"
    return str(place.frame), label_of_place(place), size, reason_of_place(place)


def remaining_words(count: int, goal_px: float) -> str:
    """ "Nothing left above 5 px", "3 places left above 5 px"."""
    if not count:
        return f"Nothing left above {goal_px:g} px"
    return f"{count} place{'s' if count > 1 else ''} left above {goal_px:g} px"


def noise_floor_words(review: Review, goal_px: float) -> str:
    """Why a goal cannot be promised, to be put after `remaining_words`; mostly empty."""
    if review.right_px is None or review.right_px <= goal_px:
        return ""
    return f", but a joint that is right is off by {size_of(review.right_px, None)} in this video"


def answers_words(answered: Sequence[Reviewed]) -> str:
    """ "4 places reviewed, 3 accepted. Nobody can tell: right thigh at 49."; empty without one."""
    if not answered:
        return ""
    unclear = [reviewed for reviewed in answered if reviewed.answer == "unclear"]
    count = len(answered)
    counted = f"{count} place{'s' if count > 1 else ''} reviewed, {count - len(unclear)} accepted."
    if not unclear:
        return counted
    places = ", ".join(f"{readable(reviewed.part)} at {reviewed.frame}" for reviewed in unclear)
    return f"{counted} Nobody can tell: {places}."
