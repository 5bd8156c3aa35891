"""What the page is told of tracking."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from app.store.sections import Sections
from app.store.state import AppState
from tests.app.editor.desk import SAMPLE, desk
from tracker.body.trajectory import Pass, interpolate
from tracker.geometry.rotations import Array
from tracker.session.verdict import GOOD
from tracker.storage.files import load_session
from tracker.storage.results import Results, segment_keys
from tracker.tracking.result import SegmentResult


def seen(need: Array | None = None, notes: tuple[str, ...] = ()) -> AppState:
    """The sample with 0–24 tracked and expected to gain so much, the rest not tracked."""
    edit = desk()
    one, other = (keyframe.pose(edit.skeleton) for keyframe in edit.doc.keyframes[:2])
    key, path = segment_keys(edit.doc)[0, 24], interpolate(one, other, 0, 24)
    passing = SegmentResult.on_the_way(Pass("pass", path, 1.0), key)
    known = replace(passing.diagnostics, expected_gain=need)
    found = replace(passing, verdict=GOOD, diagnostics=known, notes=notes)
    return AppState(edit=replace(edit, results=Results({key: found})))


def test_what_a_keyframe_would_mend_is_told_frame_by_frame() -> None:
    need = np.sin(np.linspace(0, np.pi, 25)) * 8
    listed = Sections().changed(seen(need))["need"]
    assert len(listed) == 73
    assert listed[12] == 8.0
    assert listed[0] == listed[24] == 0.0
    assert listed[25] is None


def test_where_it_is_not_known_nothing_is_told_of_it() -> None:
    assert set(Sections().changed(seen())["need"]) == {None}


def test_an_imported_motion_is_named_beside_the_settings() -> None:
    assert Sections().changed(seen())["settings"]["imported"] is None


def test_what_could_not_be_done_as_wished_is_told_of_its_segment() -> None:
    note = "Left hand lost at frame 31: followed from both keyframes instead."
    first, second, _ = Sections().changed(seen(notes=(note,)))["segments"]
    assert first["notes"] == [note]
    assert second["notes"] == []


def test_whether_keypoints_can_count_is_told_of_the_body() -> None:
    box = load_session(SAMPLE.parents[1] / "box" / "session.json").body
    edit = desk().with_doc(desk().doc.model_copy(update={"body": box, "keyframes": ()}))
    assert Sections().changed(AppState(edit=desk()))["body"]["is_persons"]
    assert not Sections().changed(AppState(edit=edit))["body"]["is_persons"]
