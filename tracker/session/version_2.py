"""What version 2 said of a segment, read once for version 3.

There the verdict was its kind and a sentence, `"verdict": "check", "words": "check frames 31–36:
right hand not seen"`; here it is facts. A sentence that is none of these is kept as it is, as the
text of a verdict with the cause "other".
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any, Final

from pydantic import ValidationError

from tracker.session.verdict import GOOD, Cause, Kind, Verdict

_CHECK = re.compile(r"check frames? ([0-9]{1,9})(?:–([0-9]{1,9}))?: (.+)")
_NOT_FOLLOWED = re.compile(r"lost: add a keyframe near ([0-9]{1,9})")
_CONTRADICTION = re.compile(
    r"lost: the keyframes at ([0-9]{1,9}) and ([0-9]{1,9}) contradict each other"
)
_NOTHING_SEEN: Final = "lost: nothing of the body is seen; check keyframes, camera and masks"
_REASONS: Final[Mapping[str, Cause]] = {
    "a pass diverged": "diverged",
    "damaged in the video": "damaged",
    "no surface that can be used": "no_surface",
    "not fitted yet": "not_fitted",
    "fitted from one keyframe only so far": "one_keyframe",
    "the keyframe lies off its surface": "keyframe_off_surface",
    "the body lies off the surface that moves with it": "body_off_surface",
}
_REASONS_OF_PARTS: Final[Mapping[str, Cause]] = {
    " not seen": "not_seen",
    " uncertain": "uncertain",
    " beyond its joint limits": "beyond_limits",
}


def brought_to_3(data: dict[str, Any]) -> dict[str, Any]:
    """A session's JSON with the sentences of its results as verdicts.

    What has not the form of such results stays: validation says what is wrong with it.
    """
    results = data.get("results")
    if not isinstance(results, dict) or not isinstance(results.get("segments"), list):
        return data
    names = _part_names(data)
    segments = [_segment(segment, names) for segment in results["segments"]]
    return {**data, "results": {**results, "segments": segments}}


def verdict_of(kind: Kind, words: str, span: tuple[int, int], names: Sequence[str]) -> Verdict:
    """What a sentence about a segment says.

    span: the segment's keyframes.  names: of the body's parts, for the sentence has spaces where
    they have underscores.
    """
    try:
        return _understood(kind, words, span, names) or _kept(kind, words)
    except ValidationError:  # numbers that are no frames
        return _kept(kind, words)


def _kept(kind: Kind, words: str) -> Verdict:
    return Verdict(kind=kind, cause="other", text=words)


def _understood(
    kind: Kind, words: str, span: tuple[int, int], names: Sequence[str]
) -> Verdict | None:
    if (kind, words) == ("good", "good"):
        return GOOD
    if kind == "check" and (match := _CHECK.fullmatch(words)):
        return _check(match, names)
    if kind == "lost" and (match := _NOT_FOLLOWED.fullmatch(words)):
        return Verdict.not_followed(int(match[1]))
    if kind == "lost" and (match := _CONTRADICTION.fullmatch(words)):
        return Verdict.contradiction(int(match[1]), int(match[2]))
    if (kind, words) == ("lost", _NOTHING_SEEN):
        return Verdict.nothing_seen(*span)
    return None


def _check(match: re.Match[str], names: Sequence[str]) -> Verdict | None:
    frames, reason = (int(match[1]), int(match[2] or match[1])), match[3]
    if reason in _REASONS:
        return Verdict.check(_REASONS[reason], frames)
    for ending, cause in _REASONS_OF_PARTS.items():
        if reason.endswith(ending):
            return Verdict.check(cause, frames, _part(reason.removesuffix(ending), names))
    return Verdict(kind="check", cause="other", frames=frames, go=sum(frames, 1) // 2,
                   text=match[0])  # fmt: skip


def _part(said: str, names: Sequence[str]) -> str:
    """The part's name; a part that the body has no more keeps the one it was said by."""
    return next((name for name in names if name.replace("_", " ") == said), said)


def _segment(segment: Any, names: Sequence[str]) -> Any:
    if not isinstance(segment, dict):
        return segment
    kind, words = segment.get("verdict"), segment.get("words")
    first, last = segment.get("first_frame"), segment.get("last_frame")
    if kind not in ("good", "check", "lost") or not isinstance(words, str):
        return segment
    if not isinstance(first, int) or not isinstance(last, int):
        return segment
    found = verdict_of(kind, words, (first, last), names)
    rest = {name: value for name, value in segment.items() if name != "words"}
    return {**rest, "verdict": found.model_dump(mode="json")}


def _part_names(data: Mapping[str, Any]) -> list[str]:
    body = data.get("body")
    parts = body.get("parts") if isinstance(body, dict) else None
    if not isinstance(parts, list):
        return []
    names = [part.get("name") for part in parts if isinstance(part, dict)]
    return [name for name in names if isinstance(name, str)]
