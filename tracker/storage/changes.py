"""What one edit changed in a session: small plain data, with which the edit can be made again.

Of keyframes, also those of parts, and of drafts only those that differ are listed. Results are not
an edit: no person made them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Final, TypeAlias, get_type_hints

from pydantic import Field, TypeAdapter, ValidationError

from keypose.tracker.errors import one_sentence
from keypose.tracker.session.bodies import TrackedBody
from keypose.tracker.session.counts import require_few
from keypose.tracker.session.keyframe import Keyframe, PartKeyframe
from keypose.tracker.session.schema import (
    MOST_BODIES,
    MOST_VIEWS,
    OWNERS,
    PART_OF,
    Session,
    require_fit,
)
from keypose.tracker.session.views import View

Changes: TypeAlias = dict[str, Any]
"""New values by the session's fields; of those listed: {"set": [...], "drop": [frames]}."""

_KEYFRAMES = TypeAdapter(tuple[Keyframe, ...])
LISTED: Mapping[str, TypeAdapter[Any]] = {
    "keyframes": _KEYFRAMES,
    "part_keyframes": TypeAdapter(tuple[PartKeyframe, ...]),
    "drafts": _KEYFRAMES,
}
"""What is listed by frame, and how it is read."""
_AS_NOW = {"up_camera": "up_world"}
"""What fields were called in journals of older versions, and what they are now."""
_NO_EDITS = ("schema_version", "results", "posed_body")
"""Fields that no edit changes, and which of the bodies is posed."""
FIELDS = tuple(name for name in PART_OF if name not in _NO_EDITS)

FILMS: Final = "films"
"""The views after the first, among changes: {"set": [those that differ], "ids": [of all]}."""
_FILMS = TypeAdapter(Annotated[tuple[View, ...], Field(max_length=MOST_VIEWS)])

POSED: Final = "posed"
"""The id of the body that is posed from now on, among changes; what else differs is of it."""

BODIES: Final = "bodies"
"""The bodies, among changes where those that are not posed differ: {"set": [those that differ],
"ids": [of all], "posed": the id of the one that is}; no fields of a body beside it."""
_BODIES = TypeAdapter(Annotated[tuple[TrackedBody, ...], Field(max_length=MOST_BODIES)])

_VALUES: dict[str, TypeAdapter[Any]] = {
    name: TypeAdapter(get_type_hints(OWNERS[PART_OF[name]], include_extras=True)[name])
    for name in FIELDS
    if name not in LISTED
}


def changes(before: Session, after: Session) -> Changes:
    """The changes that turn `before` into `after`."""
    changed_fields: Changes = {}
    if after.subject.id != before.subject.id and after.subject.id in _ids(before):
        before = before.about(after.subject.id)
        changed_fields[POSED] = after.subject.id
    changed_fields |= _changed_bodies(before, after)
    for name in FIELDS:
        if BODIES in changed_fields and PART_OF[name] == "subject":
            continue
        was, now = before.value(name), after.value(name)
        if now is was or now == was:
            continue
        changed_fields[name] = _listed(was, now) if name in LISTED else _plain(name, now)
    return {**changed_fields, **_changed_films(before, after)}


def apply_changes(before: Session, change: Mapping[str, Any]) -> Session:
    """The session with changes made; ValueError when one is malformed.

    Every value is validated by itself; whether all fit together is for the caller to check.
    """
    change = {_AS_NOW.get(name, name): value for name, value in change.items()}
    unknown = sorted(set(change) - {*FIELDS, FILMS, BODIES, POSED})
    if unknown:
        raise ValueError(f"a change of {unknown[0]!r}, which a session does not have")
    if POSED in change:
        before = _posing(before, change[POSED])
    if BODIES in change:
        before = _with_bodies(before, change[BODIES])
    new = {
        name: _apply(name, before.value(name), value)
        if name in LISTED
        else _VALUES[name].validate_python(value)
        for name, value in change.items()
        if name in FIELDS
    }
    after = before.changed(new) if new else before
    return _with_films(after, change[FILMS]) if FILMS in change else after


def require_sound(before: Session, after: Session) -> None:
    """ValueError, with a sentence that names the field, when `after` could not be read back.

    before: a valid session; only what differs from it is checked.
    """
    change = changes(before, after)
    for name, value in change.items():
        _require_valid(name, value)
    if not change:
        return
    if change.keys() & {BODIES, POSED}:
        for body in after.bodies:
            require_fit(after, body, body.posed)
        return
    posed = after.subject.posed
    if not change.keys() & {"video", "camera", "body"}:  # what every pose is checked against
        ids_before = {id(pose) for pose in before.subject.posed}
        posed = tuple(pose for pose in posed if id(pose) not in ids_before)
    require_fit(after, after.subject, posed)


def _require_valid(name: str, value: Any) -> None:
    try:
        if name in LISTED:
            LISTED[name].validate_python(value["set"])
        elif name == FILMS:
            _FILMS.validate_python(value["set"])
        elif name == BODIES:
            _BODIES.validate_python(value["set"])
        elif name == POSED:
            return
        else:
            _VALUES[name].validate_python(value)
    except ValidationError as error:
        sentence = one_sentence(error).rstrip(".")
        raise ValueError(f"{name}: {sentence[:1].lower()}{sentence[1:]}") from None


def _plain(name: str, value: Any) -> Any:
    return _VALUES[name].dump_python(value, mode="json")


def _changed_films(before: Session, after: Session) -> Changes:
    """What differs of the views after the first; empty where nothing does."""
    was, now = ({view.id: view for view in each.views[1:]} for each in (before, after))
    fresh = [view for id, view in now.items() if was.get(id) is not view and was.get(id) != view]
    if not fresh and list(was) == list(now):
        return {}
    return {FILMS: {"set": [view.model_dump(mode="json") for view in fresh], "ids": list(now)}}


def _changed_bodies(before: Session, after: Session) -> Changes:
    """What differs of the bodies; empty where at most the one that is posed does."""
    was, now = ({body.id: body for body in _without_motion(each)} for each in (before, after))
    posed = after.subject.id
    if list(was) == list(now) and all(was[id] == now[id] for id in now if id != posed):
        return {}
    fresh = [body.model_dump(mode="json") for body in now.values() if was.get(body.id) != body]
    return {BODIES: {"set": fresh, "ids": list(now), "posed": posed}}


def _without_motion(session: Session) -> tuple[TrackedBody, ...]:
    """Its bodies without what was tracked, which is no edit."""
    return tuple(
        body if body.results is None else body.model_copy(update={"results": None})
        for body in session.bodies
    )


def _with_bodies(session: Session, change: Any) -> Session:
    if not isinstance(change, dict) or change.keys() != {"set", "ids", "posed"}:
        raise ValueError("bodies that are not set by their ids")
    there = {body.id: body for body in session.bodies}
    there |= {body.id: body for body in _BODIES.validate_python(change["set"])}
    if not set(change["ids"]) <= set(there) or change["posed"] not in change["ids"]:
        raise ValueError("the id of a body that is not there")
    bodies = tuple(there[id] for id in change["ids"])
    posed_body = None if change["posed"] == bodies[0].id else change["posed"]
    return session.model_copy(update={"bodies": bodies, "posed_body": posed_body})


def _posing(session: Session, body_id: Any) -> Session:
    if body_id not in _ids(session):
        raise ValueError("the id of a body that is not there")
    return session.about(body_id)


def _ids(session: Session) -> list[str]:
    return [body.id for body in session.bodies]


def _with_films(session: Session, change: Any) -> Session:
    if not isinstance(change, dict) or change.keys() != {"set", "ids"}:
        raise ValueError("films that are not set by their ids")
    there = {view.id: view for view in session.views[1:]}
    there |= {view.id: view for view in _FILMS.validate_python(change["set"])}
    if not set(change["ids"]) <= set(there):
        raise ValueError("the id of a film that is not there")
    films = tuple(there[id] for id in change["ids"])
    return session.model_copy(update={"views": (session.view, *films)})


def _listed(was: Sequence[Keyframe], now: Sequence[Keyframe]) -> dict[str, Any]:
    keyframes = {keyframe.frame: keyframe for keyframe in was}
    frames = {keyframe.frame for keyframe in now}
    fresh = [
        each
        for each in now
        if keyframes.get(each.frame) is not each and keyframes.get(each.frame) != each
    ]
    return {
        "set": [keyframe.model_dump(mode="json") for keyframe in fresh],
        "drop": sorted(keyframes.keys() - frames),
    }


def _apply(name: str, was: Sequence[Keyframe], change: Any) -> tuple[Keyframe, ...]:
    if not isinstance(change, dict) or not change.keys() <= {"set", "drop"}:
        raise ValueError("keyframes that are neither set nor dropped")
    require_few({name: change.get("set", ())})
    left = {keyframe.frame: keyframe for keyframe in was}
    for frame in change.get("drop", ()):
        left.pop(frame, None)
    for keyframe in LISTED[name].validate_python(change.get("set", ())):
        left[keyframe.frame] = keyframe
    return tuple(left[frame] for frame in sorted(left))
