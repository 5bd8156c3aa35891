"""Edits of what the tracker is given: ignored regions and settings."""

from __future__ import annotations

from pydantic import ValidationError

from keypose.app.editor import actions as do
from keypose.app.editor.refusal import Refused
from keypose.app.editor.state import EditorState
from keypose.tracker.errors import one_sentence
from keypose.tracker.session.schema import Session
from keypose.tracker.session.settings import IgnoreMask, TrackSettings


def add_mask(state: EditorState, action: do.AddMask) -> Session:
    """One more ignored region."""
    mask = _mask(state, action.polygon, action.first, action.last, "")
    return _with_masks(state, (*state.doc.ignore_masks, mask))


def change_mask(state: EditorState, action: do.ChangeMask) -> Session:
    """Another outline, range or note; what is left out stays."""
    old = _require(state, action.index)
    new = _mask(
        state,
        old.polygon if action.polygon is None else action.polygon,
        old.first_frame if action.first is None else action.first,
        old.last_frame if action.last is None else action.last,
        old.note if action.note is None else action.note,
    )
    masks = list(state.doc.ignore_masks)
    masks[action.index] = new
    return _with_masks(state, tuple(masks))


def delete_mask(state: EditorState, action: do.DeleteMask) -> Session:
    """One ignored region fewer."""
    _require(state, action.index)
    masks = list(state.doc.ignore_masks)
    del masks[action.index]
    return _with_masks(state, tuple(masks))


def set_settings(state: EditorState, action: do.Settings) -> Session:
    """Settings; only the fields that were named change."""
    named = action.model_dump(include=action.model_fields_set - {"do", "stroke"})
    settings = TrackSettings.model_validate({**state.doc.settings.model_dump(), **named})
    return state.doc.model_copy(update={"settings": settings})


def _mask(
    state: EditorState, polygon: tuple[do.Spot, ...], first: int, last: int, note: str
) -> IgnoreMask:
    last = min(last, state.frame_count - 1)
    try:
        return IgnoreMask(polygon=polygon, first_frame=first, last_frame=last, note=note)
    except ValidationError as error:
        raise Refused(one_sentence(error)) from None


def _require(state: EditorState, index: int) -> IgnoreMask:
    if index >= len(state.doc.ignore_masks):
        raise Refused("This mask no longer exists.")
    return state.doc.ignore_masks[index]


def _with_masks(state: EditorState, masks: tuple[IgnoreMask, ...]) -> Session:
    return state.doc.model_copy(update={"ignore_masks": masks})
