"""How far tracking ahead came, and why no farther, in words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Final

from keypose.tracker.errors import readable
from keypose.tracker.session.annotations import Ahead, Stop, StopCause

if TYPE_CHECKING:
    from keypose.tracker.tracking.ahead.follow import FoundAhead

_WHY: Final[Mapping[StopCause, str]] = {
    "uncertain": "{Part} may be wrong from there",
    "not_seen": "{Part} may be wrong from there, {hidden}",
    "left_picture": "The body leaves the picture there",
    "damaged": "The next frames are damaged in the video",
    "cut": "Another scene begins after it",
    "keyframe": "The next keyframe follows",
    "clip_end": "The video {ends} there",
    "limit": "Set a keyframe there and track on",
    "cancelled": "Cancelled there",
}
_WHY_NOT: Final[Mapping[StopCause, str]] = {
    "uncertain": "{part} may be wrong right after it",
    "not_seen": "{part} may be wrong right after it, {hidden}",
    "left_picture": "the body is hardly in the picture",
    "damaged": "the next frame is damaged in the video",
    "cut": "another scene begins after it",
    "cancelled": "it was cancelled",
}


def why_stopped(record: Ahead) -> str:
    """What is not known of the frames beyond: "Right forearm may be wrong from there, hidden behind
    the chest"."""
    return _WHY[record.stop.cause].format(**_named(record.stop, record.is_forward))


def tracked_to(record: Ahead) -> str:
    """ "Tracked ahead to 47"."""
    return f"Tracked {'ahead' if record.is_forward else 'back'} to {record.to_frame}"


def found_sentence(found: FoundAhead) -> str:
    """What is said when it ends."""
    if found.to_frame == found.frame:
        why = _WHY_NOT.get(found.stop.cause, "nothing leads on")
        named = _named(found.stop, found.direction == "forward")
        nothing = f"Nothing tracked from {found.frame}: {why.format(**named)}."
        return f"{nothing} Pose the next keyframe by hand."
    record = Ahead(from_frame=found.frame, to_frame=found.to_frame, stop=found.stop)
    return f"{tracked_to(record)}. {why_stopped(record)}."


def _named(stop: Stop, forward: bool) -> dict[str, str]:
    part = readable(stop.part or "the body")
    hidden = f"hidden behind the {readable(stop.behind)}" if stop.behind else "out of the picture"
    capital = part[:1].upper() + part[1:]
    return {
        "part": part, "Part": capital, "hidden": hidden, "ends": "ends" if forward else "begins"
    }  # fmt: skip
