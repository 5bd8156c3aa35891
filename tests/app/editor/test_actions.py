"""What the page may send: numbers have limits, and what is left out has a meaning."""

from __future__ import annotations

import inspect
import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from keypose import static
from keypose.app.editor.actions import ACTIONS, MESSAGES
from keypose.app.editor.message import Edit, Look, Message, Rewind
from keypose.tracker.errors import KeyposeError
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.session.camera_motion import CameraMotion
from tests.app.editor.desk import after, desk

ANGLES = {"do": "angles", "part": "head"}
MASK = {"do": "add_mask", "polygon": [[0, 0], [1, 0], [0, 1]], "first": 0, "last": 1}
BEYOND = 73
"""The sample has frames 0 to 72."""
CORNERS = [[0, 0], [1, 0], [0, 1]]

NUMBERS: list[tuple[dict[str, Any], str, float, float, float]] = [
    # a message, its field, the least and the most it may be, and how far beyond is too far
    ({"do": "field_of_view"}, "deg", 1, 170, 0.01),
    ({"do": "display"}, "opacity", 0, 1, 0.01),
    *((ANGLES, axis, -1080, 1080, 0.01) for axis in "xyz"),
    ({"do": "key_angle", "frame": 1, "part": "head", "axis": "x"}, "deg", -1080, 1080, 0.01),
    *(({"do": "root"}, axis, -1e4, 1e4, 0.01) for axis in "xyz"),
    ({"do": "size", "part": "head", "key": "length"}, "cm", -1e6, 1e6, 0.1),
    *(({"do": "joint", "part": "head"}, axis, -1e6, 1e6, 0.1) for axis in "xyz"),
    ({"do": "height"}, "cm", -1e6, 1e6, 0.1),
    ({"do": "change_mask"}, "index", 0, 10_000, 1),
    ({"do": "delete_mask"}, "index", 0, 10_000, 1),
    ({"do": "observe"}, "fps", 0.001, 10_000, 0.001),
]


def names(value: Any) -> str:
    if isinstance(value, dict):
        return str(value.get("do", ""))
    return value[:20] if isinstance(value, str) else ""


def refused(message: dict[str, Any]) -> bool:
    try:
        ACTIONS.validate_python(message)
    except ValidationError:
        return True
    return False


@pytest.mark.parametrize(("message", "name", "least", "most", "beyond"), NUMBERS, ids=names)
def test_a_number_is_taken_up_to_its_limits_and_not_beyond(
    message: dict[str, Any], name: str, least: float, most: float, beyond: float
) -> None:
    for value in (least, most):
        assert getattr(ACTIONS.validate_python({**message, name: value}), name) == value
    for value in (least - beyond, most + beyond, math.inf, -math.inf, math.nan, "wide"):
        assert refused({**message, name: value})


LENGTHS: list[tuple[dict[str, Any], str, Any, int, int]] = [
    # a message, its field, what the field is made of, the least and the most of it
    (ANGLES, "stroke", "s", 1, 60),
    ({"do": "end_stroke"}, "stroke", "s", 1, 60),
    ({"do": "size", "part": "head", "cm": 1}, "key", "k", 0, 40),
    ({"do": "shape", "part": "head"}, "kind", "k", 0, 40),
    ({"do": "change_mask", "index": 0}, "note", "n", 0, 200),
    ({"do": "add_mask", "first": 0, "last": 1}, "polygon", [[0, 0]], 3, 500),
    ({"do": "tracked", "part": "head"}, "dofs", ["rx"], 0, 6),
    ({"do": "open", "kind": "file"}, "id", "i", 1, 4096),
    ({"do": "open", "kind": "recent", "id": "i"}, "video", "v", 1, 4096),
]


@pytest.mark.parametrize(("message", "name", "piece", "least", "most"), LENGTHS, ids=names)
def test_words_and_lists_are_taken_up_to_their_lengths_and_not_beyond(
    message: dict[str, Any], name: str, piece: Any, least: int, most: int
) -> None:
    for count in (least, most):
        assert (
            len(getattr(ACTIONS.validate_python({**message, name: piece * count}), name)) == count
        )
    assert refused({**message, name: piece * (most + 1)})
    assert least == 0 or refused({**message, name: piece * (least - 1)})


@pytest.mark.parametrize("value", [-1e6 - 1, 1e6 + 1, math.nan])
def test_a_spot_beyond_any_picture_is_refused(value: float) -> None:
    assert not refused({"do": "vertical", "a": [-1e6, 1e6], "b": [0, 0]})
    assert refused({"do": "vertical", "a": [value, 0], "b": [0, 0]})
    assert refused({"do": "vertical", "a": [0, 0], "b": [0, value]})
    assert refused({**MASK, "polygon": [*CORNERS, [value, 0]]})
    assert refused({"do": "vertical", "a": [0, 0, 0], "b": [0, 0]})


@pytest.mark.parametrize(
    ("message", "expected"),
    [
        (ANGLES, {"free": False, "x": None, "y": None, "z": None, "stroke": None}),
        ({"do": "paste_pose"}, {"mirrored": False}),
        ({"do": "fit_sizes"}, {"focal": False}),
        ({"do": "track"}, {"what": "changed"}),
        ({"do": "observe"}, {"about": (0.0, 0.0, 0.0), "units": None, "model_frame": None}),
        ({"do": "select"}, {"part": None}),
        ({"do": "open", "kind": "file", "id": "i"}, {"video": None}),
    ],
    ids=names,
)
def test_what_is_left_out_has_a_meaning(message: dict[str, Any], expected: dict[str, Any]) -> None:
    found = ACTIONS.validate_python(message)
    assert {name: getattr(found, name) for name in expected} == expected


def test_a_message_is_never_changed_and_has_no_field_too_many() -> None:
    action = ACTIONS.validate_python({"do": "go", "frame": 3})
    with pytest.raises(ValidationError):
        action.frame = 4  # type: ignore[union-attr, misc]
    assert refused({"do": "go", "frame": 3, "fast": True})
    assert refused({"do": "go", "frame": -1})


def test_the_page_sends_every_action_by_its_word_and_no_other() -> None:
    page = "".join(file.read_text("utf-8") for file in Path(static.__file__).parent.rglob("*.js"))
    known = set(ACTIONS.json_schema()["discriminator"]["mapping"])
    assert set(re.findall(r"\bdo: ?'(\w+)'", page)) <= known
    assert known <= set(re.findall(r"'(\w+)'", page))


def kinds_below(kind: type[Message]) -> Iterator[type[Message]]:
    """Every message of a kind that the page may send."""
    for below in kind.__subclasses__():
        if "do" in below.model_fields:
            yield below
        yield from kinds_below(below)


@pytest.mark.parametrize("kind", [Edit, Look, Rewind])
def test_every_action_is_named_by_its_file_and_says_what_it_does(kind: type[Message]) -> None:
    assert set(kinds_below(kind)) == {each for each in MESSAGES if issubclass(each, kind)}
    assert not any(inspect.isabstract(each) for each in kinds_below(kind))


def test_undo_has_a_name_for_every_edit() -> None:
    edits = [kind for kind in MESSAGES if issubclass(kind, Edit)]
    unnamed = [kind for kind in edits if kind.label is Edit.label and not hasattr(kind, "verb")]
    assert unnamed == []
    assert all(kind.target is None or kind.target in kind.model_fields for kind in edits)


SPOT = {"at": [1.0, 1.0]}
FOOT = {"do": "set_pin", "part": "left_foot"}
MARKED = {"here": [[1, 1], [9, 9]], "there": [[1, 1], [9, 9]]}
OF_FRAMES: list[dict[str, Any]] = [
    {"do": "add_key"}, {"do": "delete_key"}, {"do": "move_key", "to": 3}, {"do": "delete_draft"},
    {"do": "move_key", "frame": 24, "to": BEYOND},
    {"do": "duplicate_key", "frame": 24, "to": BEYOND},
    {"do": "set_note", "text": "here"}, {"do": "move_note", "to": 3}, {"do": "delete_note"},
    {"do": "key_parts"}, {"do": "unkey_parts", "parts": ["head"]}, {"do": "exact_key"},
    {"do": "correct_keypoint", "joint": "left_hand", **SPOT},
    {"do": "restore_keypoint", "joint": "left_hand"},
    {"do": "ignore_keypoint", "joint": "left_hand"}, {"do": "cannot_tell"}, {"do": "accept_place"},
    FOOT, {**FOOT, "corner": [1, 1]}, {**FOOT, "frame": 3, "last": BEYOND},
    {"do": "split_pin", "index": 0}, {"do": "delete_keys", "frames": [24, BEYOND]},
    {"do": "retime_keys", "frames": [24], "to": [BEYOND]},
    {"do": "soften_keys", "frames": [BEYOND]}, {**MASK, "last": BEYOND},
    {"do": "camera_match", "other": BEYOND, **MARKED}, {"do": "delete_camera_key"},
    {"do": "key_angle", "part": "head", "axis": "x", "deg": 3},
]  # fmt: skip


@pytest.mark.parametrize("message", OF_FRAMES, ids=lambda message: message["do"])
def test_an_edit_that_names_a_frame_beyond_the_film_is_refused_however_the_camera_moves(
    message: dict[str, Any],
) -> None:
    kind = next(k for k in MESSAGES if k.model_fields["do"].default == message["do"])
    if "frame" in kind.model_fields and "frame" not in message:
        message = {**message, "frame": BEYOND}
    panned = desk().with_doc(desk().doc.changed({"camera_motion": turning()}))
    for state in (desk(), panned):
        with pytest.raises(KeyposeError, match="The video has frames 0 to 72"):
            after(state, message)


def turning() -> CameraMotion:
    """A camera that turns to the right."""
    Ts = np.tile(np.eye(4), (73, 1, 1))
    Ts[:, :3, :3] = [exp_rotation([0.0, 0.002 * frame, 0.0]) for frame in range(73)]
    return CameraMotion.of("turns", CameraPath(Ts, np.ones(73)), np.full(73, 0.1))
