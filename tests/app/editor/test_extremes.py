"""Whatever numbers an edit carries: what is accepted can be saved and read, the rest is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from keypose.app.editor.actions import ACTIONS
from keypose.app.editor.documents import ActionRefused, require_sound
from keypose.app.editor.state import EditorState
from keypose.app.editor.update import update
from keypose.tracker.errors import KeyposeError
from keypose.tracker.storage.files import load_session, save_session
from tests.app.editor.desk import after, desk

HUGE_AND_TINY = (0.0, 5e-324, 1e-308, 1e-12, 1e-3, 0.2, 1.0, 1e3, 1e4, 1e6, 1e7, 1e150, 1.7e308)
NUMBERS = st.one_of(
    st.sampled_from([*HUGE_AND_TINY, *(-number for number in HUGE_AND_TINY)]),
    st.floats(-1e4, 1e4),
    st.floats(),
)
SPOTS = st.tuples(NUMBERS, NUMBERS)
PARTS = st.sampled_from(["hips", "chest", "head", "left_thigh", "left_forearm", "right_hand"])
KINDS = ["cylinder", "capsule", "frustum", "box", "egg"]
KEYS = st.sampled_from(["length", "radius", "start_radius", "end_width", "start_depth", "whole"])
FRAMES = st.integers(0, 80)


def action(
    do: str, given: dict[str, st.SearchStrategy[Any]] | None = None, **maybe: st.SearchStrategy[Any]
) -> st.SearchStrategy[dict[str, Any]]:
    """A message with all that is given and some of the rest."""
    return st.fixed_dictionaries({"do": st.just(do), **(given or {})}, optional=maybe)


def handle(kind: str, **given: st.SearchStrategy[str]) -> st.SearchStrategy[dict[str, str]]:
    return st.fixed_dictionaries({"kind": st.just(kind), **given})


HANDLES = st.one_of(
    handle("root"),
    handle("ring", part=PARTS, axis=st.sampled_from("xyz")),
    handle("end", name=st.sampled_from(["left_hand", "head"])),
    handle("size", part=PARTS, key=KEYS),
)
XYZ = {axis: NUMBERS for axis in "xyz"}
LINE = {"a": SPOTS, "b": SPOTS}
WAY = {"handle": HANDLES, "from": SPOTS, "at": SPOTS}
EYES = st.fixed_dictionaries(
    {
        "azimuth_deg": NUMBERS,
        "elevation_deg": st.floats(-90, 90),
        "at_m": st.tuples(NUMBERS, NUMBERS, NUMBERS),
    }
)
POLYGONS = st.lists(SPOTS, min_size=3, max_size=4)
EDITS = st.one_of(
    action("camera", **{name: NUMBERS for name in ("fx", "fy", "cx", "cy")}),
    action("field_of_view", {"deg": NUMBERS}),
    action("distortion", **{name: NUMBERS for name in ("k1", "k2", "p1", "p2", "k3")}),
    action("vertical", LINE),
    action("horizon", LINE),
    action("size", {"part": PARTS, "key": KEYS, "cm": NUMBERS}),
    action("shape", {"part": PARTS, "kind": st.sampled_from(KINDS)}),
    action("joint", {"part": PARTS}, **XYZ),
    action("height", {"cm": NUMBERS}),
    action("root", **XYZ),
    action("angles", {"part": PARTS}, **XYZ),
    action("go", {"frame": FRAMES}),
    action("add_key", {"frame": FRAMES}),
    action("add_mask", {"polygon": POLYGONS, "first": FRAMES, "last": FRAMES}),
    action("drag", {"view": st.sampled_from(["main", "top", "side", "front"]), **WAY}),
    action("drag", {"view": st.just("free"), "eye": EYES, **WAY}),
    action("undo"),
)


def _behind(**handle: str) -> dict[str, Any]:
    """A drag of what the free view cannot show."""
    eye = {"azimuth_deg": 0.0, "elevation_deg": 0.0, "at_m": [0.0, 0.0, 9000.0]}
    way = {"handle": handle, "from": [0, 0], "at": [9, 9]}
    return {"do": "drag", "view": "free", "eye": eye, **way}


BEHIND = [
    _behind(kind="root"),
    _behind(kind="ring", part="right_shin", axis="x"),
    _behind(kind="size", part="left_thigh", key="joint"),
]


def _tried(state: EditorState, message: dict[str, Any]) -> EditorState:
    """The state after the message, the same where it is refused."""
    try:
        return update(state, ACTIONS.validate_python(message))  # type: ignore[arg-type]
    except (ValidationError, KeyposeError):
        return state


@settings(max_examples=100)
@example(
    edits=[{"do": "camera", "fx": 1e-308}, {"do": "vertical", "a": [300, 300], "b": [310, 100]}]
)
@example(edits=BEHIND)
@given(edits=st.lists(EDITS, min_size=1, max_size=6))
def test_no_sequence_of_accepted_edits_makes_a_session_that_cannot_be_read(
    tmp_path_factory: pytest.TempPathFactory, edits: list[dict[str, Any]]
) -> None:
    state = desk()
    for edit in edits:
        state = _tried(state, edit)
    path = tmp_path_factory.mktemp("extremes") / "session.json"
    save_session(state.doc, path)
    assert load_session(path) == state.doc


@pytest.mark.parametrize(
    "edit",
    [
        {"do": "camera", "fx": 1e-308},
        {"do": "camera", "fy": 0.5},
        {"do": "height", "cm": 0.001},
        {"do": "size", "part": "left_thigh", "key": "length", "cm": 1e-9},
    ],
)
def test_a_size_or_lens_too_small_to_be_meant_is_refused(edit: dict[str, Any]) -> None:
    with pytest.raises(KeyposeError):
        after(desk(), edit)


@pytest.mark.parametrize("edit", BEHIND)
def test_what_lies_behind_a_view_cannot_be_dragged_there(edit: dict[str, Any]) -> None:
    with pytest.raises(KeyposeError, match="lies behind this view: orbit or zoom out first"):
        after(desk(), edit)


def test_a_document_that_could_not_be_read_back_is_refused_by_the_name_of_its_action() -> None:
    doc = desk().doc
    nowhere = doc.changed({"up_world": (float("nan"), 0.0, 0.0)})
    with pytest.raises(ActionRefused, match=r"^Up direction: not possible \(up_world: .*finite"):
        require_sound(doc, nowhere, "up direction")


def test_poses_that_were_not_touched_are_held_against_a_body_that_was() -> None:
    doc = desk().doc
    part = doc.subject.body.parts[1]
    far = doc.subject.body.with_part(part.model_copy(update={"joint_m": (0.0, 0.0, -90.0)}))
    with pytest.raises(ActionRefused, match="behind the camera"):
        require_sound(doc, doc.changed({"body": far}), "resize")


def test_a_session_that_could_not_be_read_back_is_not_written_over_one_that_can(
    tmp_path: Path,
) -> None:
    doc, path = desk().doc, tmp_path / "session.json"
    save_session(doc, path)
    broken = doc.changed({"up_world": (float("nan"), 0.0, 0.0)})
    with pytest.raises(KeyposeError, match="could not be opened again"):
        save_session(broken, path)
    assert load_session(path) == doc
