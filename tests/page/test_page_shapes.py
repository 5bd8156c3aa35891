"""The shapes that the page declares are those of what the program sends."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest

import static
from app.document.library import Library
from app.store.sections import Sections
from app.store.state import AppState, FitOutcome
from tests.app import surface_cases
from tests.app.editor.desk import after, desk
from tests.app.store.test_sections import expecting, seen, some_errors

(SHAPES,) = Path(static.__file__).parent.rglob("shapes.js")
FIELD = re.compile(r"^ \* @property \{(.*)\} \[?(\w+)\]?", re.MULTILINE)


def declared() -> dict[str, dict[str, str]]:
    """The fields of every shape, with their types in JSDoc."""
    text = SHAPES.read_text("utf-8")
    blocks = re.findall(r"@typedef \{object\} (\w+)(.*?)\*/", text, re.DOTALL)
    shapes = {name: {field: kind for kind, field in FIELD.findall(body)} for name, body in blocks}
    for fields, name in re.findall(r"@typedef \{\{ (.*) \}\} (\w+)", text):
        shapes[name] = _fields(fields)
    return shapes


def _fields(inside: str) -> dict[str, str]:
    return {name: kind for name, kind in re.findall(r"(\w+): ([^,]*(?:\[[^\]]*\])?[^,]*)", inside)}


def differences(value: Any, kind: str, shapes: Mapping[str, Any], where: str) -> Iterator[str]:
    """Where a value has other fields than its type declares."""
    if isinstance(value, list):
        for one in value:
            yield from differences(one, kind, shapes, where)
        return
    name = re.match(r"\w+", kind)
    shape = shapes.get(name[0]) if name and not kind.startswith("Record") else None
    if not isinstance(value, dict) or shape is None:
        return
    if value.keys() != shape.keys():
        yield f"{where}: {sorted(value.keys() ^ shape.keys())}"
    for field in value.keys() & shape.keys():
        yield from differences(value[field], shape[field], shapes, f"{where}.{field}")


DRAG = {
    "do": "drag",
    "view": "main",
    "handle": {"kind": "end", "name": "left_hand"},
    "from": [300, 200],
    "at": [310, 190],
    "stroke": "drag",
}


def outlooks() -> dict[str, AppState]:
    masked = after(
        desk(),
        {"do": "add_mask", "polygon": [[0, 0], [50, 0], [0, 50]], "first": 0, "last": 10},
        {"do": "select", "part": "head"},
    )
    surfaces = surface_cases.session()
    fit = FitOutcome(3, "Fitted", masked.doc, masked.doc, (("head", "turned", "1°", "2°"),))  # type: ignore[arg-type]
    return {
        "film": seen(),
        "expecting": expecting(some_errors()),
        "dragged": AppState(edit=after(desk(), DRAG)),
        "masked": AppState(edit=masked, fit=fit),
        "surfaces": AppState(edit=desk().with_doc(surfaces)),
    }


@pytest.mark.parametrize("name", ["film", "expecting", "dragged", "masked", "surfaces"])
def test_every_section_has_the_fields_that_the_page_declares(name: str) -> None:
    shapes, sections = declared(), Sections().changed(outlooks()[name])
    assert sections.keys() | {"done", "ack"} == shapes["Sections"].keys()
    found = [
        words
        for section, value in sections.items()
        for words in differences(value, shapes["Sections"][section], shapes, section)
    ]
    assert found == []


def test_what_can_be_opened_has_the_fields_that_the_page_declares(tmp_path: Path) -> None:
    (tmp_path / "a.mp4").write_bytes(b"film")
    contents = Library(tmp_path / "work", [tmp_path]).contents()
    assert contents["files"]
    assert contents["samples"]
    shapes = declared()
    assert list(differences(contents, "Library", shapes, "library")) == []
