"""What the page may send: numbers have limits, and what is left out has a meaning."""

from __future__ import annotations

import inspect
import math
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from pydantic import ValidationError

from keypose import static
from keypose.app.editor.actions import ACTIONS, MESSAGES
from keypose.app.editor.message import Edit, Look, Message, Rewind

ANGLES = {"do": "angles", "part": "head"}
MASK = {"do": "add_mask", "polygon": [[0, 0], [1, 0], [0, 1]], "first": 0, "last": 1}
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
