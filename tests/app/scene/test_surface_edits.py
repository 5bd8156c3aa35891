"""Edits of observed surfaces, and what the page is told of them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from keypose.app.editor.advice import surface_suggestion
from keypose.app.editor.documents import ActionRefused
from keypose.app.editor.motion import end_trail
from keypose.app.editor.state import EditorState
from keypose.app.posing import opening_pose
from keypose.app.state.app_state import AppState, Running, SurfaceSeen
from keypose.app.store.sections import Sections, image_version
from keypose.tracker.body.pose import pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Pass, interpolate
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.references import Surface
from keypose.tracker.session.verdict import GOOD, Verdict
from keypose.tracker.storage.files import load_session
from keypose.tracker.storage.results import Results, segment_keys
from keypose.tracker.surface.placing import Placement
from keypose.tracker.tracking.result import SegmentResult
from tests.app.editor.desk import after
from tests.app.editor.desk import desk as film

SAMPLE = Path(__file__).resolve().parents[3] / "sample_videos" / "arms" / "session.json"
CORNERS = np.array([[x, y, z] for x in (-60, 90) for y in (-40, 50) for z in (0, 130)], float)
"""Points of a mesh's file, centimetres."""


def desk() -> EditorState:
    """The arms, posed at frame 0 alone."""
    session = load_session(SAMPLE)
    return EditorState(
        doc=session.changed({"results": None}),
        skeleton=Skeleton.of(session.subject.body),
        file_times_s=np.arange(session.view.video.frame_count) / 25,
        opening=opening_pose(session.subject.body, session.view.camera, (0.0, -1.0, 0.0)),
    )


def surface(state: EditorState) -> Surface:
    assert state.doc.view.surface is not None
    return state.doc.view.surface


def p_camera(state: EditorState) -> Array:
    """Where the corners lie."""
    given = surface(state)
    return Placement(given.units, given.up, np.array(given.p_camera_surface)).points(CORNERS)


def observed_from(state: EditorState, index: int) -> Array:
    """(P·3) where a corner of the mesh is in every part's frame, at a keyframe."""
    pose = state.doc.subject.keyframes[index].pose(state.skeleton)
    Ts = pose_transforms(state.skeleton, pose)
    return np.ravel(
        Ts[:, :3, :3].transpose(0, 2, 1) @ (p_camera(state)[0] - Ts[:, :3, 3])[..., None]
    )


def observe(state: EditorState, **fields: Any) -> EditorState:
    return after(state, {"do": "observe", **fields})


def test_what_is_left_out_stays() -> None:
    changed = observe(desk(), weights="contact")
    assert surface(changed) == surface(desk()).model_copy(update={"weights": "contact"})
    assert after(changed, {"do": "undo"}).doc == desk().doc


def test_other_units_leave_the_picture_as_it_was() -> None:
    before, changed = desk(), observe(desk(), units="mm")
    camera = before.doc.view.camera
    np.testing.assert_allclose(p_camera(changed), p_camera(before) / 10)
    np.testing.assert_allclose(
        camera.project(p_camera(changed)), camera.project(p_camera(before)), atol=1e-6
    )


def test_poses_go_along_with_the_surface_when_its_units_change() -> None:
    before, changed = desk(), observe(desk(), units="m")
    old, new = (np.array(state.doc.subject.keyframes[0].root_m) for state in (before, changed))
    np.testing.assert_allclose(new, 100 * old)


def test_units_that_put_the_body_behind_the_camera_are_refused() -> None:
    near = after(desk(), {"do": "root", "z": 0.5})
    with pytest.raises(ActionRefused, match="would be at the camera"):
        observe(near, units="mm")


def test_another_axis_turns_the_surface_about_its_middle() -> None:
    before = desk()
    middle = p_camera(before).mean(axis=0)
    changed = observe(before, up="+y", about=middle.tolist())
    np.testing.assert_allclose(p_camera(changed).mean(axis=0), middle, atol=1e-9)
    up = p_camera(changed)[CORNERS[:, 1] > 0].mean(axis=0)
    assert up[1] < middle[1] - 0.1  # the file's y is up now, and the camera's y is down


def test_poses_turn_with_the_surface_when_its_axes_change() -> None:
    posed = after(desk(), {"do": "root", "x": 0.2})
    before = after(posed, {"do": "go", "frame": 5}, {"do": "root", "x": 0.3})
    middle = p_camera(before).mean(axis=0)
    changed = observe(before, up="-y", about=middle.tolist())
    assert observed_from(changed, 0) == pytest.approx(observed_from(before, 0), abs=1e-6)
    for poses in ("keyframes", "drafts"):
        (old,), (new,) = (state.doc.value(poses) for state in (before, changed))
        assert new.frame == old.frame
        assert np.abs(np.array(new.root_m) - old.root_m).max() > 0.01
    assert after(changed, {"do": "undo"}).doc == before.doc


def test_axes_that_put_the_body_behind_the_camera_are_refused() -> None:
    with pytest.raises(ActionRefused, match="behind the camera"):
        observe(desk(), up="-z")  # turned about the camera itself


def test_with_another_rate_everything_is_at_other_times() -> None:
    state = after(desk(), {"do": "duplicate_key", "frame": 0, "to": 10})
    changed = observe(state, fps=50)
    assert [key.time_s for key in changed.doc.subject.keyframes] == [0.0, 0.2]
    assert changed.times_s[10] == 0.2
    later = after(changed, {"do": "duplicate_key", "frame": 0, "to": 5})
    assert later.doc.subject.keyframes[1].time_s == 0.1
    undone = after(later, {"do": "undo"}, {"do": "undo"})
    assert undone.times_s[10] == 0.4
    assert undone.doc == state.doc


def test_only_a_keyframe_s_surface_can_move_with_the_body() -> None:
    with pytest.raises(ActionRefused, match="Frame 4 is not a keyframe"):
        observe(desk(), model_frame=4)
    keyed = after(desk(), {"do": "duplicate_key", "frame": 0, "to": 4})
    model = observe(keyed, model_frame=4).doc.model_keyframe
    assert model is not None
    assert model.frame == 4


def test_the_moving_surface_stays_with_its_keyframe_when_that_is_moved() -> None:
    keyed = after(desk(), {"do": "duplicate_key", "frame": 0, "to": 4})
    moved = after(observe(keyed, model_frame=4), {"do": "move_key", "frame": 4, "to": 7})
    assert surface(moved).model_frame == 7
    assert surface(after(moved, {"do": "undo"})).model_frame == 4


def test_a_film_has_no_surfaces_to_edit() -> None:
    with pytest.raises(ActionRefused, match="not surfaces"):
        observe(film(), weights="none")


def test_the_trail_reaches_to_where_nobody_has_posed() -> None:
    found = end_trail(replace(desk(), frame=6))
    assert found is not None
    assert (found.frames[0], found.frames[-1], found.keys) == (0, 18, (0,))


# --- what the page is told


def reported(state: EditorState, name: str, **more: Any) -> Any:
    return Sections().changed(AppState(edit=state, **more))[name]


def fitted(state: EditorState, verdict: Verdict = GOOD, missing: int = 0) -> EditorState:
    """The arms fitted from 0 to 18."""
    pose = state.doc.subject.keyframes[0].pose(state.skeleton)
    path, key = interpolate(pose, pose, 0, 18), segment_keys(state.doc)[0, 18]
    track = SegmentResult.on_the_way(Pass("fit", path, 0.004), key)
    return state.with_results(Results({key: replace(track, verdict=verdict, missing=missing)}))


def test_of_a_film_no_surface_is_reported() -> None:
    assert Sections().changed(AppState(edit=film()))["surface"] is None


def test_one_keyframe_makes_a_segment_to_both_ends() -> None:
    (segment,) = reported(desk(), "segments")
    assert (segment["first"], segment["last"], segment["words"]) == (0, 18, "Not fitted")
    moved = after(desk(), {"do": "move_key", "frame": 0, "to": 6})
    assert [(s["first"], s["last"]) for s in reported(moved, "segments")] == [(0, 6), (6, 18)]


def test_of_a_segment_at_work_its_steps_are_reported() -> None:
    (segment,) = reported(desk(), "segments", running={(0, 18): Running("tracking", 7, 18, 39)})
    assert segment["words"] == "step 7 of 18"


def test_a_problem_is_reported_at_its_own_frame_alone() -> None:
    seen = SurfaceSeen(frame=3, problem="Step 3 is missing.")
    assert reported(replace(desk(), frame=3), "surface", surface=seen)["problem"] == seen.problem
    assert reported(replace(desk(), frame=4), "surface", surface=seen)["problem"] == ""


def test_a_colour_that_cannot_be_had_says_why() -> None:
    bare = after(desk(), {"do": "delete_key", "frame": 0})
    off = {tint["id"]: tint["off"] for tint in reported(bare, "surface")["tints"]}
    assert off["clay"] == ""
    assert "first keyframe" in off["contact"]
    assert "cameras" in off["photo"]
    rated = reported(desk(), "surface", surface=SurfaceSeen(photo=True))["tints"]
    assert not any(tint["off"] for tint in rated)


def version(state: EditorState) -> str:
    return image_version(AppState(edit=state))


def test_pictures_in_other_colours_have_other_names() -> None:
    names = {
        version(after(desk(), {"do": "display", "tint": tint}))
        for tint in ("clay", "contact", "photo", "distance")
    }
    assert len(names) == 4


def test_a_pose_renames_only_pictures_that_it_colours() -> None:
    for tint, renames in (("clay", False), ("photo", False), ("contact", True)):
        state = after(desk(), {"do": "display", "tint": tint})
        posed = after(state, {"do": "root", "x": 0.3})
        assert (version(posed) != version(state)) is renames
        assert (version(fitted(state)) != version(state)) is renames


def test_a_gesture_under_way_renames_no_picture() -> None:
    state = after(desk(), {"do": "display", "tint": "distance"})
    dragged = after(state, {"do": "root", "x": 0.3, "stroke": "a"})
    assert version(dragged) == version(state)
    assert version(after(dragged, {"do": "end_stroke", "stroke": "a"})) != version(state)


def test_surfaces_taken_by_other_cameras_have_other_pictures() -> None:
    read = surface(desk()).model_copy(update={"cameras_fingerprint": "sha256:0"})
    state = replace(desk(), doc=desk().doc.changed({"surface": read}))
    assert version(state) != version(desk())


def test_surfaces_that_lie_elsewhere_have_other_pictures() -> None:
    assert version(observe(desk(), units="m")) != version(desk())


# --- what to do next


def suggested(state: EditorState) -> tuple[str, int | None, str]:
    doc = state.doc
    found = surface_suggestion(state.keys, doc.spans, state.results.fitting(doc))
    return found.kind, found.frame, f"{found.title}: {found.detail}"


def test_without_a_keyframe_one_is_asked_for() -> None:
    kind, _, words = suggested(after(desk(), {"do": "delete_key", "frame": 0}))
    assert kind == "pose"
    assert "One keyframe is enough" in words


def test_with_one_keyframe_it_can_be_fitted() -> None:
    kind, _, words = suggested(desk())
    assert (kind, words) == ("track", "1 segment needs fitting: Frames 0–18")


def test_where_it_was_lost_a_keyframe_is_asked_for() -> None:
    state = fitted(desk(), Verdict.not_followed(9))
    assert suggested(state)[:2] == ("key", 9)


def test_what_is_in_doubt_is_to_be_looked_at() -> None:
    kind, frame, words = suggested(fitted(desk(), Verdict.check("not_seen", (8, 10), "arm_a")))
    assert (kind, frame) == ("look", 9)
    assert "Arm a hidden, frames 8–10" in words


def test_a_fit_that_was_stopped_goes_on_first() -> None:
    state = fitted(desk(), Verdict.check("not_fitted", (8, 18)), missing=11)
    assert suggested(state) == ("track", None, "Continue fitting: Frames 8–18 not fitted yet")
    assert state.results.wanted(state.doc)
    assert reported(state, "segments")[0]["unfinished"]
    lost = fitted(desk(), Verdict.not_followed(3), missing=11)
    assert suggested(lost)[:2] == ("key", 3)


def test_a_body_that_lies_off_its_surface_is_to_be_looked_at_before_anything_else() -> None:
    state = fitted(desk(), Verdict.check("body_off_surface", (0, 0)), missing=11)
    reason = "Check keyframe 0: The body is off its surface there"
    assert suggested(state) == ("look", 0, reason)
    assert reported(state, "segments")[0]["words"] == "Check: at key 0 the body is off its surface"


def test_what_is_good_needs_nothing() -> None:
    assert suggested(fitted(desk()))[0] == "good"
