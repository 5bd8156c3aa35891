"""Migrate session files of older versions to the present one, in memory.

Version 2 keeps fields it does not know, has a journal beside it, and may name a first motion.
Version 3 has verdicts as facts, where version 2 had a kind and a sentence, `"verdict": "check",
"words": "check frames 31–36: right hand not seen"`. An unknown sentence is kept as the text of a
verdict with the cause "other".
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final, TypeAlias

from pydantic import ValidationError

from keypose.tracker.errors import SessionError
from keypose.tracker.session.verdict import GOOD, Cause, Kind, Verdict

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


def migrate_to_3(data: dict[str, Any]) -> dict[str, Any]:
    """A session's JSON with the sentences of its results as verdicts.

    Results of another form stay as they are: validation reports what is wrong.
    """
    results = data.get("results")
    if not isinstance(results, dict) or not isinstance(results.get("segments"), list):
        return data
    names = _part_names(data)
    segments = [_segment(segment, names) for segment in results["segments"]]
    return {**data, "results": {**results, "segments": segments}}


def verdict_of(kind: Kind, sentence: str, span: tuple[int, int], names: Sequence[str]) -> Verdict:
    """The verdict in a sentence about a segment.

    span: the segment's keyframes.  names: of the body's parts; the sentence has spaces where
    they have underscores.
    """
    try:
        return _read(kind, sentence, span, names) or _unread(kind, sentence)
    except ValidationError:  # numbers that are no frames
        return _unread(kind, sentence)


def _unread(kind: Kind, sentence: str) -> Verdict:
    return Verdict(kind=kind, cause="other", text=sentence)


def _read(kind: Kind, sentence: str, span: tuple[int, int], names: Sequence[str]) -> Verdict | None:
    if (kind, sentence) == ("good", "good"):
        return GOOD
    if kind == "check" and (match := _CHECK.fullmatch(sentence)):
        return _check(match, names)
    if kind == "lost" and (match := _NOT_FOLLOWED.fullmatch(sentence)):
        return Verdict.not_followed(int(match[1]))
    if kind == "lost" and (match := _CONTRADICTION.fullmatch(sentence)):
        return Verdict.contradiction(int(match[1]), int(match[2]))
    if (kind, sentence) == ("lost", _NOTHING_SEEN):
        return Verdict.nothing_seen(*span)
    return None


def _check(match: re.Match[str], names: Sequence[str]) -> Verdict | None:
    frames, reason = (int(match[1]), int(match[2] or match[1])), match[3]
    if reason in _REASONS:
        return Verdict.check(_REASONS[reason], frames)
    for ending, cause in _REASONS_OF_PARTS.items():
        if reason.endswith(ending):
            return Verdict.check(cause, frames, _part(reason.removesuffix(ending), names))
    return Verdict(
        kind="check", cause="other", frames=frames, go=sum(frames, 1) // 2, text=match[0]
    )


def _part(words: str, names: Sequence[str]) -> str:
    """The part's name; the text itself where the body no longer has the part."""
    return next((name for name in names if name.replace("_", " ") == words), words)


def _segment(segment: Any, names: Sequence[str]) -> Any:
    if not isinstance(segment, dict):
        return segment
    kind, sentence = segment.get("verdict"), segment.get("words")
    first, last = segment.get("first_frame"), segment.get("last_frame")
    if kind not in ("good", "check", "lost") or not isinstance(sentence, str):
        return segment
    if not isinstance(first, int) or not isinstance(last, int):
        return segment
    verdict = verdict_of(kind, sentence, (first, last), names)
    rest = {name: value for name, value in segment.items() if name != "words"}
    return {**rest, "verdict": verdict.model_dump(mode="json")}


def _part_names(data: Mapping[str, Any]) -> list[str]:
    body = data.get("body")
    parts = body.get("parts") if isinstance(body, dict) else None
    if not isinstance(parts, list):
        return []
    names = [part.get("name") for part in parts if isinstance(part, dict)]
    return [name for name in names if isinstance(name, str)]


_OF_VIEW: Final = (
    "video",
    "camera",
    "lens_source",
    "ignore_masks",
    "keypoints",
    "keypoint_corrections",
    "surface",
)
_OF_BODY: Final = (
    "body",
    "keyframes",
    "part_keyframes",
    "drafts",
    "pins",
    "first_motion",
    "drafted",
    "reviewed",
    "ahead",
    "results",
)
_OF_WORLD: Final = {"up_camera": "up_world", "up_from_feet": "up_from_feet", "floor_m": "floor_m"}
"""Fields of the flat session of version 3, and what of it they are from version 4 on."""


def migrate_to_4(data: dict[str, Any]) -> dict[str, Any]:
    """A session's JSON with its one view, its one body and its world apart."""
    moved = {*_OF_VIEW, *_OF_BODY, *_OF_WORLD}
    return {
        **{name: value for name, value in data.items() if name not in moved},
        "views": [{name: data[name] for name in _OF_VIEW if name in data}],
        "bodies": [{name: data[name] for name in _OF_BODY if name in data}],
        "world": {now: data[name] for name, now in _OF_WORLD.items() if name in data},
    }


PRESENT: Final = 4

Data: TypeAlias = dict[str, Any]

_NUMBER = re.compile(rb'"schema_version"\s*:\s*(\d{1,9})\s*[,}]')
_HEAD_BYTES = 4096


def _from_1(data: Data) -> Data:
    """Everything in version 1 still means the same."""
    return data


STEPS: Mapping[int, Callable[[Data], Data]] = {1: _from_1, 2: migrate_to_3, 3: migrate_to_4}
"""From each older version to the one after it."""


def migrate(data: Any, name: str) -> Data:
    """A session's JSON as one of the present version; a newer one stays as it is.

    Checked first: another version's fields would give misleading errors.
    SessionError, with the file's name, where it is not a session.
    """
    if not isinstance(data, dict):
        raise SessionError(f"{name} is not a session: its JSON is not an object.")
    if "schema_version" not in data:
        raise SessionError(
            f"{name}: schema_version is missing; a session of this Keypose says {PRESENT}."
        )
    version = data["schema_version"]
    if type(version) is not int or not 1 <= version <= 10**9:
        raise SessionError(f"{name}: schema_version must be a number from 1 to {PRESENT}.")
    present: Data = data
    while version < PRESENT:
        present = STEPS[version](present)
        version += 1
        present = {**present, "schema_version": version}
    return present


def version_in(content: bytes) -> int | None:
    """The version named in the first bytes of a file; None where there is none."""
    match = _NUMBER.search(content[:_HEAD_BYTES])
    return None if match is None else int(match[1])
