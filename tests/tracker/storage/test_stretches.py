"""Over which segments the last solve goes, and what makes another one of it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from keypose.tracker.body.body import Twist
from keypose.tracker.session import Keyframe, Session
from keypose.tracker.session.pins import Pin
from keypose.tracker.session.verdict import GOOD
from keypose.tracker.storage import stretches as of_stretches
from keypose.tracker.storage.results import Results
from keypose.tracker.storage.stretches import SegmentRun, stretches
from tests.app.results_cases import track
from tests.tracker.operations.space_cases import PIN, both, cases, pinned, session, smooth, softened


def wanted(of: Session, results: Results | None = None) -> list[SegmentRun]:
    return (both(of) if results is None else results).unsolved(of)


def keys(of: Session) -> list[str]:
    return [stretch.key for stretch in wanted(of)]


def test_without_pins_and_smoothing_nothing_is_solved() -> None:
    assert wanted(session()) == []
    assert wanted(session(floor_m=-0.8, up_world=(0.0, -1.0, 0.0))) == []


@pytest.mark.parametrize("of", [smooth(), pinned()], ids=["smooth", "pinned"])
def test_neighbouring_segments_are_solved_as_one(of: Session) -> None:
    (stretch,) = wanted(of)
    assert stretch.span == (0, 8)
    assert [segment.span for segment in stretch.segments] == [(0, 4), (4, 8)]


def test_a_segment_that_is_not_tracked_divides_what_is_solved() -> None:
    keyframes = tuple(
        Keyframe.of(cases.SKELETON, cases.pose(frame / 9), frame, frame / 25)
        for frame in (0, 2, 4, 8)
    )
    of = smooth(session(keyframes=keyframes))
    results = Results().with_result(track(of, 0, 2)).with_result(track(of, 4, 8))
    assert [stretch.span for stretch in wanted(of, results)] == [(0, 2), (4, 8)]


def test_pins_alone_are_solved_only_where_they_hold() -> None:
    early = PIN.model_copy(update={"first_frame": 0, "last_frame": 3})
    of = pinned(early)
    first = Results().with_result(track(of, 0, 4))
    second = Results().with_result(track(of, 4, 8))
    assert [stretch.span for stretch in wanted(of, first)] == [(0, 4)]
    assert wanted(of, second) == []


def test_pins_are_clipped_to_what_is_solved() -> None:
    of = pinned()
    (stretch,) = wanted(of, Results().with_result(track(of, 4, 8)))
    assert [pin.span for pin in stretch.pins] == [(4, 6)]


def changed(**changes: Any) -> Session:
    return smooth(pinned()).changed(changes)


LATER = PIN.model_copy(update={"last_frame": 7})


@pytest.mark.parametrize(
    "other",
    [
        changed(pins=()),
        changed(pins=(LATER,)),
        changed(pins=(PIN.model_copy(update={"landmarks": ("thumb",)}),)),
        changed(pins=(PIN.model_copy(update={"floor": True}),)),
        changed(pins=(PIN, Pin(part="right_arm", first_frame=1, last_frame=3))),
        changed(floor_m=-0.8),
        changed(up_world=(0.0, -1.0, 0.1)),
        smooth(pinned(), smooth=False),
        softened(smooth(pinned()), 4),
        softened(smooth(pinned()), 0),
    ],
    ids=["no pin", "longer pin", "other landmark", "on the floor", "one more", "floor", "up",
         "not smooth", "soft inside", "soft end"],
)  # fmt: skip
def test_what_decides_the_motion_in_space_makes_another_key(other: Session) -> None:
    assert keys(other) != keys(changed())
    assert keys(other) == keys(other)


def test_joint_limits_and_the_frame_rate_make_another_key() -> None:
    of = changed()
    parts = list(of.subject.body.parts)
    parts[1] = parts[1].model_copy(update={"limits_deg": {"x": (-10.0, 20.0)}})
    limited = of.changed({"body": of.subject.body.replaced(parts)})
    parts = list(of.subject.body.parts)
    parts[1] = parts[1].model_copy(update={"twist": Twist(range_deg=(-90.0, 90.0))})
    twisted = of.changed({"body": of.subject.body.replaced(parts)})
    faster = of.changed(
        {
            "keyframes": tuple(
                one.model_copy(update={"time_s": one.time_s / 2}) for one in of.subject.keyframes
            )
        }
    )
    assert both(of).wanted(limited) == both(of).wanted(faster) == []  # tracked as they were
    assert both(of).wanted(twisted) == []
    assert len({*keys(of), *keys(limited), *keys(twisted), *keys(faster)}) == 4


def test_a_segment_tracked_otherwise_makes_another_key() -> None:
    of = changed()
    camera = of.view.camera.model_copy(update={"fx": 80.0})
    assert keys(changed(camera=camera)) != keys(of)


@pytest.mark.parametrize(
    "other",
    [
        smooth(pinned(), quality="full"),
        changed(drafts=(session().subject.keyframes[1].model_copy(update={"frame": 2}),)),
        changed(pins=(PIN, PIN.model_copy(update={"first_frame": 8, "last_frame": 8}))),
    ],
    ids=["quality asked for", "a draft", "a pin that only touches the end"],
)
def test_what_does_not_decide_the_motion_leaves_the_key(other: Session) -> None:
    assert keys(other) == keys(changed())


def test_a_preview_and_what_is_not_whole_are_not_solved() -> None:
    of = smooth()
    preview = Results().with_result(track(of, 0, 4, "preview"))
    assert wanted(of, preview) == []
    part = Results().with_result(replace(track(of, 0, 4), missing=1, verdict=GOOD))
    assert wanted(of, part) == []
    found = preview.with_result(track(of, 4, 8))
    assert [stretch.span for stretch in wanted(of, found)] == [(4, 8)]


def test_the_printed_method_and_surfaces_are_not_solved() -> None:
    assert wanted(smooth(method="paper")) == []


def test_a_long_film_is_divided_at_keyframes_but_not_under_a_pin(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(of_stretches, "LONGEST", 6)
    assert [stretch.span for stretch in wanted(smooth())] == [(0, 4), (4, 8)]
    assert [stretch.span for stretch in wanted(changed())] == [(0, 8)]


def test_what_is_known_already_is_not_wanted_again() -> None:
    of = smooth()
    assert stretches(of, both(of).fitting(of))[0].key == keys(of)[0]
