"""What the page is told of tracking."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from keypose.app.state.app_state import AppState
from keypose.app.store.sections import Sections
from keypose.tracker.body.body import preset
from keypose.tracker.body.pose import pose_transforms
from keypose.tracker.body.preset_names import PRESETS
from keypose.tracker.body.trajectory import Pass, interpolate
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.verdict import GOOD
from keypose.tracker.storage.files import load_session
from keypose.tracker.storage.results import Results, segment_keys
from keypose.tracker.tracking.result import SegmentResult
from tests.app.editor.desk import SAMPLE, desk


def seen(need: Array | None = None, notes: tuple[str, ...] = ()) -> AppState:
    """The sample with 0–24 tracked and expected to gain so much, the rest not tracked."""
    edit = desk()
    one, other = (keyframe.pose(edit.skeleton) for keyframe in edit.doc.subject.keyframes[:2])
    key, path = segment_keys(edit.doc)[0, 24], interpolate(one, other, 0, 24)
    passing = SegmentResult.on_the_way(Pass("pass", path, 1.0), key)
    known = replace(passing.diagnostics, expected_gain=need)
    found = replace(passing, verdict=GOOD, diagnostics=known, notes=notes)
    return AppState(edit=edit.with_results(Results({key: found})))


def test_what_a_keyframe_would_mend_is_reported_frame_by_frame() -> None:
    need = np.sin(np.linspace(0, np.pi, 25)) * 8
    listed = Sections().changed(seen(need))["need"]
    ((first, *values),) = listed
    assert (first, len(values)) == (0, 25)
    assert values[12] == 8.0
    assert values[0] == values[24] == 0.0


def test_where_it_is_not_known_nothing_is_reported_of_it() -> None:
    assert Sections().changed(seen())["need"] == []


def test_an_imported_motion_is_named_beside_the_settings() -> None:
    assert Sections().changed(seen())["settings"]["imported"] is None


def test_what_could_not_be_done_as_wished_is_reported_of_its_segment() -> None:
    note = "Left hand lost at frame 31: followed from both keyframes instead."
    first, second, _ = Sections().changed(seen(notes=(note,)))["segments"]
    assert first["notes"] == [note]
    assert second["notes"] == []


def expecting(error: Array | None, origin: str = "intrinsics") -> AppState:
    """The sample with these errors expected in 0–24."""
    edit = desk()
    camera = edit.doc.view.camera.model_copy(update={"origin": origin})
    edit = edit.with_doc(edit.doc.changed({"camera": camera}))
    (found,) = seen().edit.results.by_key.values()  # type: ignore[union-attr]
    known = replace(found.diagnostics, expected_error=error)
    key = segment_keys(edit.doc)[0, 24]
    results = Results({key: replace(found, key=key, diagnostics=known)})
    return AppState(edit=edit.with_results(results))


def some_errors() -> Array:
    """(25, P) known of seven parts, the largest in frame 5 + k of part k."""
    found = np.full((25, desk().skeleton.part_count), np.nan)
    for k in range(7):
        found[:, k] = 1.0 + k
        found[5 + k, k] = 3.0 + k
    return found


def test_the_parts_expected_to_be_farthest_off_come_first_each_at_its_worst_frame() -> None:
    reported = Sections().changed(expecting(some_errors()))["errors"]
    names = desk().doc.subject.body.names
    assert [one["part"] for one in reported] == [names[k] for k in (6, 5, 4, 3, 2)]
    assert [(one["first"], one["frame"], one["px"]) for one in reported[:2]] == [
        (0, 11, 9.0),
        (0, 10, 8.0),
    ]


def test_an_error_in_space_is_that_in_the_picture_at_the_part_s_depth() -> None:
    state = expecting(some_errors())
    (worst, *_) = Sections().changed(state)["errors"]
    assert state.edit is not None
    found = state.edit.fitting[0, 24]
    Ts = pose_transforms(state.edit.skeleton, found.trajectory.pose(worst["frame"]))
    p = Ts[6, :3, 3]
    uv = state.edit.doc.view.camera.project(
        np.stack([p, p + np.array([worst["cm"] / 100, 0.0, 0.0])])
    )
    assert np.linalg.norm(uv[1] - uv[0]) == pytest.approx(worst["px"], rel=0.01)


def test_of_a_guessed_lens_there_is_no_error_in_space() -> None:
    reported = Sections().changed(expecting(some_errors(), "guess"))["errors"]
    assert {one["cm"] for one in reported} == {None}
    assert reported[0]["px"] == 9.0


def test_where_no_error_is_expected_of_any_part_none_is_reported() -> None:
    nothing = np.full_like(some_errors(), np.nan)
    assert Sections().changed(expecting(None))["errors"] == []
    assert Sections().changed(expecting(nothing))["errors"] == []


def test_every_preset_is_sent_with_its_kind_and_only_people_can_be_drafted() -> None:
    sent = Sections().changed(AppState(edit=desk()))["body"]["presets"]
    assert [one["name"] for one in sent] == list(PRESETS)
    for named in sent:
        edit = desk().with_doc(desk().doc.changed({"body": preset(named["name"]), "keyframes": ()}))
        is_persons = Sections().changed(AppState(edit=edit))["body"]["is_persons"]
        assert is_persons == (named["kind"] in ("adult", "child")), named


def test_whether_keypoints_can_count_is_reported_of_the_body() -> None:
    box = load_session(SAMPLE.parents[1] / "box" / "session.json").subject.body
    edit = desk().with_doc(desk().doc.changed({"body": box, "keyframes": ()}))
    assert Sections().changed(AppState(edit=desk()))["body"]["is_persons"]
    assert not Sections().changed(AppState(edit=edit))["body"]["is_persons"]
