"""What the page is told of a motion that is not plausible in space."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, get_args

import numpy as np
import pytest

from keypose.app.editor.state import EditorState
from keypose.app.state.app_state import AppState
from keypose.app.store.sections import Sections, space_values
from keypose.app.words import problems, review
from keypose.app.words.problems import space_sentence
from keypose.app.words.review import reason_of_place
from keypose.tracker.review.places import REVIEWED_IN_SPACE, review_of
from keypose.tracker.review.segment_errors import LEAST_PX
from keypose.tracker.session.pins import Pin
from keypose.tracker.session.results import PinResult, SpaceFinding
from keypose.tracker.space.result import SpaceResult
from keypose.tracker.storage.results import Results
from keypose.tracker.storage.stretches import stretches
from tests.app.editor.desk import after
from tests.app.editor.test_pins import SOLE, stepping


def found(kind: str, amount: float, part: str = "left_foot") -> SpaceFinding:
    frames = {"first_frame": 10, "last_frame": 20, "go": 14}
    return SpaceFinding.model_validate({"kind": kind, "part": part, "amount": amount, **frames})


@pytest.mark.parametrize(
    ("finding", "words"),
    [
        (found("slides", 0.09), "Left foot slides 9 cm, 10–20"),
        (found("off_floor", 0.06), "Left foot leaves the floor by 6 cm, 10–20"),
        (found("below_floor", 0.04), "Left foot goes 4 cm into the floor, 10–20"),
        (
            found("keyframe_depth", -0.12),
            "At keyframe 14 the left foot stands 12 cm nearer than nearby",
        ),
        (
            found("mirrored", 0.2, "right_forearm"),
            "At keyframe 14 the right forearm may point the wrong way in depth",
        ),
        (
            found("twisted", -0.9, "left_upper_arm"),
            "At keyframe 14 the left upper arm is turned 52° too far about its length",
        ),
        (found("leans", 0.4, "waist"), "The body leans 23° out of balance, 10–20"),
        (found("shakes", 11.3, "waist"), "Waist shakes with 11 m/s², 10–20"),
        (
            found("pulled", 12.3),
            "The pin of the left foot moves it by 12 px in the picture, 10–20",
        ),
        (
            found("bent", 0.3),
            "The pin of the left foot bends the knee by 17°, which was not seen, 10–20",
        ),
        (found("jumps", 30.0), "Left foot jumps at 14, where its pin begins or ends"),
    ],
)
def test_every_finding_is_a_sentence_with_its_amount_and_frames(
    finding: SpaceFinding, words: str
) -> None:
    assert space_sentence(finding) == words


def solved(edit: EditorState, *findings: SpaceFinding, pins: tuple[PinResult, ...] = ()) -> Any:
    """What the page is told where the solve in space found this."""
    state = AppState(edit=with_found(edit, *findings, pins=pins))
    return Sections().changed(state)["space"]


def with_found(
    edit: EditorState, *findings: SpaceFinding, pins: tuple[PinResult, ...] = ()
) -> EditorState:
    smooth = after(edit, {"do": "settings", "smooth": True})
    (stretch,) = stretches(smooth.doc, smooth.results.fitting(smooth.doc))
    motion = next(iter(smooth.results.by_key.values())).trajectory
    space = SpaceResult(stretch.key, motion, pins, findings=findings)
    return smooth.with_results(Results(smooth.results.by_key, {stretch.key: space}))


def known(edit: EditorState) -> EditorState:
    return edit.with_doc(edit.doc.changed({"lens_source": "person"}))


def test_the_worst_is_reported_first_with_what_mends_it() -> None:
    off = PinResult(
        part="left_foot", first_frame=0, last_frame=20, off_m=0.08, usual_off_m=0.001, frame=0,
        keyframe=0, others=(12, 16),
    )  # fmt: skip
    reported = solved(
        known(stepping((5, 12))), found("slides", 0.06), found("off_floor", 0.1), pins=(off,)
    )
    assert [(one["kind"], one["remedy"]) for one in reported] == [
        ("off_floor", "pin"), ("pin", "soften"), ("slides", "pin"),
    ]  # fmt: skip
    assert reported[1]["words"] == "Keyframe 0 is 8 cm off the pin of the left foot"
    assert (reported[1]["keyframes"], reported[1]["cm"]) == ([0, 12, 16], 8.0)


@pytest.mark.parametrize(
    ("finding", "reason"),
    [
        (found("off_floor", 0.2), "leaves the floor by 20 cm"),
        (found("pulled", 12.3), "its pin moves it by 12 px"),
        (found("bent", 0.4), "its pin bends the knee by 23°"),
    ],
)
def test_what_pins_and_floors_do_to_a_foot_is_a_place_of_the_review(
    finding: SpaceFinding, reason: str
) -> None:
    state = with_found(known(stepping((5, 12))), finding)
    (place,) = review_of(state.doc, state.results).places
    assert (place.part, place.frame, place.frames) == ("left_foot", 14, (10, 20))
    assert reason_of_place(place) == reason
    assert place.px is not None
    assert place.px > LEAST_PX
    small = with_found(known(stepping((5, 12))), found(finding.kind, finding.amount / 50))
    assert not review_of(small.doc, small.results).places
    assert solved(known(stepping((5, 12))), finding)[0]["remedy"] in ("pin", "unpin")


@pytest.mark.parametrize("kind", sorted(REVIEWED_IN_SPACE))
def test_a_finding_that_is_accepted_in_the_review_leaves_the_list(kind: str) -> None:
    state = with_found(known(stepping((5, 12))), found(kind, 20.0))
    (place,) = review_of(state.doc, state.results).places
    answer = {"do": "accept_place", "frame": place.frame, "part": place.part}
    accepted = AppState(edit=after(state, answer))
    assert Sections().changed(AppState(edit=state))["space"]
    assert Sections().changed(accepted)["space"] == []


def test_a_limb_that_may_be_mirrored_is_turned_with_one_press() -> None:
    (reported,) = solved(known(stepping((5, 12))), found("mirrored", 0.2, "right_forearm"))
    assert (reported["remedy"], reported["part"], reported["go"]) == ("turn", "right_forearm", 14)


def test_an_arm_that_is_twisted_at_a_keyframe_is_untwisted_with_one_press() -> None:
    (reported,) = solved(known(stepping((5, 12))), found("twisted", -0.9, "left_upper_arm"))
    assert reported["remedy"] == "untwist"
    assert (reported["part"], reported["go"]) == ("left_upper_arm", 14)


def test_a_guessed_lens_is_reported_last_and_only_of_a_motion_that_was_solved() -> None:
    guessed = stepping((5, 12))
    guessed = guessed.with_doc(guessed.doc.changed({"lens_source": "guess"}))
    reported = solved(guessed, found("slides", 0.06))
    assert [one["kind"] for one in reported] == ["slides", "lens"]
    share = guessed.doc.view.depth_share
    assert share is not None
    assert f"may be off by {100 * share:.0f} %." in reported[-1]["words"]
    assert Sections().changed(AppState(edit=guessed))["space"] == []
    assert [one["kind"] for one in solved(known(guessed), found("slides", 0.06))] == ["slides"]


def climbing() -> EditorState:
    """As one sees somebody walk away who is filmed from above, with two pins of a foot."""
    edit = stepping((5, 12), m_per_frame=0.1)
    ((key, one),) = edit.results.by_key.items()
    path = one.trajectory
    rise = 0.04 * np.arange(len(path.ps_camera_root))[:, None] * [0.0, -1.0, 0.0]
    higher = replace(one, trajectory=replace(path, ps_camera_root=path.ps_camera_root + rise))
    pins = tuple(
        Pin(part="left_foot", landmarks=SOLE, first_frame=at, last_frame=at) for at in (2, 20)
    )
    doc = edit.doc.changed({"pins": pins})
    return edit.with_doc(doc).with_results(Results({key: higher}))


def test_pinned_feet_on_a_slope_that_nobody_has_spoken_of_are_levelled_with_one_press() -> None:
    """All else in space depends on which way is up: that is named first."""
    uneven = known(climbing())
    reported = solved(uneven, found("slides", 0.06))
    assert [one["kind"] for one in reported] == ["up", "slides"]
    assert reported[0]["remedy"] == "level"
    assert "cm in height: the camera’s tilt is a guess." in reported[0]["words"]
    level = after(uneven, {"do": "up_from_feet"})
    assert [one["kind"] for one in solved(level, found("slides", 0.06))] == ["slides"]


def test_every_kind_of_finding_has_its_words_its_remedy_and_its_weight() -> None:
    kinds = set(get_args(SpaceFinding.model_fields["kind"].annotation))
    assert kinds == set(problems._SPACE_SENTENCES)
    assert kinds == set(space_values._REMEDIES) == set(space_values._WEIGHTS)


def test_what_is_reviewed_in_space_is_worded_there() -> None:
    assert set(review._IN_SPACE) == REVIEWED_IN_SPACE
