"""With Live on the motion follows a hand at every move."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from keypose.app.editor.live import at_hand, let_go, moved_spans
from keypose.app.editor.motion import EndTrail, end_trail
from keypose.app.editor.shown import find
from keypose.app.editor.state import EditorState, Stroke
from keypose.tracker.body.trajectory import Pass, interpolate
from keypose.tracker.session.verdict import GOOD
from keypose.tracker.storage.results import Results, segment_keys
from keypose.tracker.tracking.result import SegmentResult
from tests.app.editor.desk import after, desk

LIVE = {"do": "live", "on": True}
AT_24 = ({"do": "go", "frame": 24}, {"do": "select", "part": "left_forearm"})


def turned(deg: float, **more: Any) -> dict[str, Any]:
    return {"do": "angles", "part": "left_forearm", "x": deg, "stroke": "s", **more}


def trail(state: EditorState) -> EndTrail:
    found = end_trail(state)
    assert found is not None
    return found


def track(state: EditorState, span: tuple[int, int], aside_m: float) -> SegmentResult:
    """A segment tracked between its keyframes, in its middle so far aside of where interpolation
    has the body."""
    start, end = (find(state.doc.subject.keyframes, frame) for frame in span)
    assert start is not None
    assert end is not None
    path = interpolate(start.pose(state.skeleton), end.pose(state.skeleton), *span)
    way = aside_m * np.sin(np.linspace(0.0, np.pi, len(path)))
    moved = path.ps_camera_root + np.outer(way, (1.0, 0.0, 0.0))
    motion = replace(path, ps_camera_root=moved)
    found = SegmentResult.on_the_way(Pass("pass", motion, 1.0), segment_keys(state.doc)[span])
    return replace(found, verdict=GOOD)


def previewed(
    state: EditorState, gesture: str, found: dict[tuple[int, int], SegmentResult]
) -> EditorState:
    """The same with previews for poses of a gesture."""
    return replace(state, motion=replace(state.motion, gesture=gesture, previews=found))


def live() -> EditorState:
    """All segments tracked, at the keyframe of frame 24."""
    state, results = desk(), Results()
    for span in state.doc.spans:
        results = results.with_result(track(state, span, 0.1))
    return after(state.with_results(results), LIVE, *AT_24)


def test_the_trail_of_both_segments_follows_a_keyframe_that_is_moved() -> None:
    before, during = live(), after(live(), turned(-70))
    assert moved_spans(during) == ((0, 24), (24, 48))
    was, now = trail(before), trail(during)
    assert (now.frames, now.keys) == (was.frames, was.keys)
    apart = np.linalg.norm(now.p_camera - was.p_camera, axis=1)
    assert apart[24] == pytest.approx(apart.max())
    assert apart[24] > 0.05
    assert apart[[0, -1]] == pytest.approx(0.0, abs=1e-9), "the other keyframes stay"
    assert (apart[12:24] > 0).all()


def test_it_follows_no_hand_without_live_nor_where_no_keyframe_is_moved() -> None:
    off = after(live(), {"do": "live", "on": False}, turned(-70))
    draft = after(live(), {"do": "go", "frame": 30}, turned(-70))
    lens = after(live(), {"do": "field_of_view", "deg": 50.0, "stroke": "s"})
    assert lens.stroke is not None
    assert lens.doc.subject.keyframes != live().doc.subject.keyframes, "seen as before"
    for state in (live(), off, draft, lens):
        assert moved_spans(state) == ()
        assert at_hand(state) is state


def test_a_motion_that_nobody_tracked_is_interpolated_to_the_hand() -> None:
    during = after(desk(), LIVE, *AT_24, turned(-70))
    ended = after(during, {"do": "end_stroke", "stroke": "s"})
    np.testing.assert_allclose(trail(during).p_camera, trail(ended).p_camera)


def test_what_a_preview_found_for_an_earlier_move_is_bent_to_this_one() -> None:
    before = after(live(), turned(-30))
    found = {(0, 24): track(before, (0, 24), 0.3)}
    during = after(before, turned(-70))
    without = trail(during).p_camera
    apart = trail(previewed(during, "s", found)).p_camera - without
    assert apart[12, 0] == pytest.approx(0.2, abs=0.02)
    np.testing.assert_allclose(apart[[0, *range(24, 49)]], 0.0, atol=1e-9)
    other = previewed(during, "another gesture", found)
    np.testing.assert_allclose(trail(other).p_camera, without)


def test_a_new_keyframe_parts_the_segment_it_is_set_in() -> None:
    state = after(live(), {"do": "go", "frame": 30}, {"do": "add_key", "frame": 30})
    during = after(live(), {"do": "go", "frame": 30})
    assert during.doc.subject.keyframes != state.doc.subject.keyframes
    gesture = Stroke("s", during.doc, "Add a keyframe", 30)
    during = replace(state, stroke=gesture).with_results(during.results)
    assert moved_spans(during) == ((24, 30), (30, 48))
    np.testing.assert_allclose(trail(during).p_camera, trail(live()).p_camera[24:], atol=1e-9)


def test_when_the_hand_lets_go_the_motion_stays_until_it_is_tracked() -> None:
    during = after(live(), turned(-70))
    found = replace(track(during, (0, 24), 0.3), quality="preview")
    during = previewed(during, "s", {(0, 24): found})
    ended = after(during, {"do": "end_stroke", "stroke": "s"})
    results = let_go(during)
    assert results.fitting(ended.doc)[0, 24] is found
    wanted = [(first, last) for first, last, _ in results.wanted(ended.doc)]
    assert wanted == [(0, 24), (24, 48)], "what is kept for now is not what was asked for"
    previews = [(first, last) for first, last, _ in results.wanted(ended.doc, "preview")]
    assert previews == [(24, 48)]
    kept = trail(ended.with_results(results)).p_camera
    np.testing.assert_allclose(kept, trail(during).p_camera, atol=1e-9)
