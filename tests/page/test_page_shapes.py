"""The shapes that the page declares are those of what the program sends."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from keypose import static
from keypose.app.document.library import Library
from keypose.app.editor.state import EditorState
from keypose.app.state.app_state import AppState, KnownKeypoints
from keypose.app.state.outcomes import FitOutcome
from keypose.app.state.previews import SizesPreview
from keypose.app.store.sections import Sections
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.camera_motion import FollowedPoints
from keypose.tracker.fitting.sizes import Proposal, SizesFitted
from keypose.tracker.keypoints.keypoints import JOINTS, Keypoints
from keypose.tracker.operations.find_camera import FoundCamera, keep_points
from keypose.tracker.session.annotations import Drafted
from keypose.tracker.session.camera_motion import CameraFinding, CameraMotion
from keypose.tracker.session.pins import Pin
from tests.app import surface_cases
from tests.app.editor.desk import after, desk
from tests.app.film_beside_cases import ID, with_film
from tests.app.store.test_sections import expecting, seen, some_errors
from tests.tracker import panned_cases

SHAPES = Path(static.__file__).parent / "store" / "shapes.js"
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


def previewed(edit: EditorState) -> SizesPreview:
    """New sizes with a choice."""
    doc, change = edit.doc, ("head", "length", 20.0, 21.0)
    poses = {key.frame: key.pose(edit.skeleton) for key in doc.subject.keyframes}
    turns = {frame: (("head", 2.0),) for frame in poses}
    proposal = Proposal(doc.subject.body, doc.view.camera, poses, (change,), 4.1, turns)
    found = SizesFitted("Head 5 % longer.", 6.2, proposal, proposal, ("neck",))
    return SizesPreview(found, doc, doc, doc, poses=True)


DRAG = {
    "do": "drag",
    "view": "main",
    "handle": {"kind": "end", "name": "left_hand"},
    "from": [300, 200],
    "at": [310, 190],
    "stroke": "drag",
}


def drafted() -> AppState:
    """A film with a draft, and keypoints at its frame."""
    pose = desk().doc.subject.keyframes[0]
    places = [{"frame": 1, "reason": "hidden", "parts": ["head"]}]
    found = {"first_frame": 0, "last_frame": 3, "places": places}
    missing = {"missing": [{"first_frame": 2, "last_frame": 3}]}
    left = {"frame": 1, "box": (1, 2, 30, 80), "frames": [{"first_frame": 4, "last_frame": 9}]}
    update = {
        "drafts": (pose.model_copy(update={"frame": 1}),),
        "drafted": Drafted.model_validate({**found, **missing, "rest": left}),
    }
    seen = Keypoints(0, JOINTS, np.full((1, 12, 2), 5.0), np.ones((1, 12)))
    edit = desk().with_doc(desk().doc.changed(update))
    return AppState(edit=edit, keypoints=KnownKeypoints(of_file=seen))


def two_films() -> AppState:
    """Two films of the motion, the keypoints of both known."""
    edit = desk().with_doc(with_film(desk().doc))
    over = Keypoints(0, JOINTS, np.full((100, 12, 2), 5.0), np.ones((100, 12)))
    return AppState(edit=edit, keypoints=KnownKeypoints(of_file=over, of_films={ID: over}))


def panned() -> AppState:
    """A film whose camera pans, corrected by a person, its background points shown and kept."""
    flawed = CameraFinding(kind="no_texture", first_frame=3, last_frame=5)
    errors = np.where(np.arange(panned_cases.FRAMES) == 4, np.nan, 0.1)
    motion = CameraMotion.of("turns", panned_cases.path(), errors, (flawed,))
    points = FollowedPoints(
        np.full((2 * panned_cases.FRAMES, 2), 9.0, np.float32),
        np.tile([True, False], panned_cases.FRAMES),
        np.arange(0, 2 * panned_cases.FRAMES + 1, 2),
    )
    keep_points(FoundCamera("turns", motion, points, (flawed,), None))
    doc = panned_cases.session(motion).with_up((0.0, -1.0, 0.0))
    edit = EditorState(
        doc=doc,
        skeleton=Skeleton.of(doc.subject.body),
        file_times_s=np.arange(panned_cases.FRAMES) / 25,
        opening=doc.subject.keyframes[0].pose(Skeleton.of(doc.subject.body)),
        frame=7,
    )
    horizon = {"do": "camera_horizon", "a": [0, 91], "b": [319, 90]}
    return AppState(edit=after(edit, {"do": "display", "background": True}, horizon))


def outlooks() -> dict[str, AppState]:
    masked = after(
        desk(),
        {"do": "add_mask", "polygon": [[0, 0], [50, 0], [0, 50]], "first": 0, "last": 10},
        {"do": "select", "part": "head"},
        {"do": "joint_angle", "joint": "knee"},
    )
    proposed = Pin(part="right_foot", first_frame=0, last_frame=9)
    pinned = after(desk(), {"do": "set_pin", "part": "left_foot", "frame": 24})
    surfaces = surface_cases.session()
    fit = FitOutcome(3, "Fitted", masked.doc, masked.doc)
    return {
        "film": seen(),
        "expecting": expecting(some_errors()),
        "dragged": AppState(edit=after(desk(), DRAG)),
        "pinned": AppState(edit=replace(pinned, proposed_pins=(proposed,))),
        "masked": AppState(edit=masked, fit=fit),
        "previewed": AppState(edit=masked, preview=previewed(masked)),
        "surfaces": AppState(edit=desk().with_doc(surfaces)),
        "drafted": drafted(),
        "panned": panned(),
        "two films": two_films(),
    }


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What is kept for this user is kept here."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


@pytest.mark.parametrize(
    "name",
    [
        *("film", "expecting", "dragged", "pinned", "masked", "surfaces", "drafted", "panned"),
        "two films",
    ],
)
def test_every_section_has_the_fields_that_the_page_declares(name: str) -> None:
    shapes, sections = declared(), Sections().changed(outlooks()[name])
    assert sections.keys() | {"done", "ack"} == shapes["Sections"].keys()
    found = [
        words
        for section, value in sections.items()
        for words in differences(value, shapes["Sections"][section], shapes, section)
    ]
    assert found == []
    if name == "two films":
        assert set(sections["films_seen"]["seen"]) == {"view", ID}
    if name == "panned":
        assert sections["camera_motion"]["keys"] == [7]
        assert sections["background"]["good"] == [True, False]


def test_what_can_be_opened_has_the_fields_that_the_page_declares(tmp_path: Path) -> None:
    (tmp_path / "a.mp4").write_bytes(b"film")
    contents = Library(tmp_path / "work", [tmp_path]).contents()
    assert contents["files"]
    assert contents["samples"]
    shapes = declared()
    assert list(differences(contents, "Library", shapes, "library")) == []
