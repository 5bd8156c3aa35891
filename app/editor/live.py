"""The motion while a hand moves a keyframe, with Live on.

Segments beside the keyframe are shown as a preview found them for a pose of this gesture, or as
they were tracked before it, bent to where the keyframe is now: what either misses it by comes and
goes over the segment without a kink. So the motion follows every move, however long tracking takes.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache

from keypose.app.editor.state import EditorState
from keypose.tracker.body.trajectory import Pass, displaced
from keypose.tracker.session.keyframe import Keyframe
from keypose.tracker.storage.by_id import ById
from keypose.tracker.storage.fingerprints import Span
from keypose.tracker.storage.results import Fitting, Results, segment_keys
from keypose.tracker.tracking.result import SegmentResult


def moved_spans(state: EditorState) -> tuple[Span, ...]:
    """The segments of a film beside the keyframes that the gesture under way has moved; none
    without Live, nor where they follow a change of the body or the lens."""
    if state.stroke is None or not state.display.live or state.doc.evidence.has_surface:
        return ()
    before, now = state.stroke.before.subject, state.doc.subject
    is_same = now.body is before.body and state.doc.view is state.stroke.before.view
    if now.keyframes is before.keyframes or not is_same:
        return ()
    was, at = _by_frame(before.keyframes), _by_frame(now.keyframes)
    return tuple(
        span
        for span in state.doc.spans
        if all(end in at for end in span) and any(at[end] is not was.get(end) for end in span)
    )


def previewed_spans(state: EditorState) -> tuple[Span, ...]:
    """Those of `moved_spans` that are tracked while the hand moves; the published method has no
    previews."""
    return () if state.doc.settings.method == "paper" else moved_spans(state)


def at_hand(state: EditorState) -> EditorState:
    """The state as if the gesture were over, its motion bent to the keyframes that it moved; the
    state itself where it moved none."""
    moved = moved_spans(state)
    if not moved:
        return state
    assert state.stroke is not None
    tracked = _tracked(ById(state.results), ById(state.stroke.before))
    previews = state.motion.previews_of(state.stroke.name)
    at = _by_frame(state.doc.subject.keyframes)
    fitting = {span: tracked[span] for span in state.doc.spans if span in tracked}
    for span in moved:
        fitting.pop(span, None)
        segment_result = previews.get(span) or _around(tracked, span)
        if segment_result is not None:
            start, end = (at[frame].pose(state.skeleton) for frame in span)
            motion = displaced(segment_result.trajectory, start, end, *span)
            fitting[span] = SegmentResult.on_the_way(Pass("bent", motion, None))
    return replace(state, stroke=None, motion=replace(state.motion, bent=fitting))


def let_go(state: EditorState) -> Results:
    """The results once the gesture under way ends as it is: with the previews of its poses, and
    where there is none its bent motion, until the segment is tracked."""
    moved, shown, results = moved_spans(state), at_hand(state).fitting, state.results
    keys = segment_keys(state.doc)
    for span in moved:
        preview = state.motion.previews.get(span)
        if preview is not None and preview.key == keys[span]:
            results = results.with_result(preview, tuple(keys.values()))
        elif keys[span] not in results.by_key and span in shown:
            bent = replace(shown[span], key=keys[span], quality="preview")
            results = results.with_result(bent, tuple(keys.values()))
    return results


def _around(tracked: Mapping[Span, SegmentResult], span: Span) -> SegmentResult | None:
    """The segment in which a span lies: a new keyframe parts one."""
    first, last = span
    return next((t for (a, b), t in tracked.items() if a <= first and last <= b), None)


def _by_frame(keyframes: tuple[Keyframe, ...]) -> dict[int, Keyframe]:
    return {keyframe.frame: keyframe for keyframe in keyframes}


@lru_cache(maxsize=1)
def _tracked(results: ById, doc: ById) -> Fitting:
    """What was known before the gesture: the same at each of its moves."""
    segment_results: Fitting = results.it.fitting(doc.it)
    return segment_results
