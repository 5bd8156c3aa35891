"""Where a segment starts from: what is asked for by name, and by its score where nothing is."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pydantic import ValidationError

from keypose.tracker.session import Session
from keypose.tracker.session.settings import Initial, TrackSettings
from keypose.tracker.storage.files import load_session
from keypose.tracker.tracking.initial.choose import printed_start, starts
from keypose.tracker.tracking.method import FULL, PREVIEW, Paper, method_of
from tests.tracker.tracking_cases import Case, case, plain, segment_of, worked

BOX = Path(__file__).parents[4] / "sample_videos" / "box" / "session.json"


@pytest.fixture(scope="module")
def person() -> Case:
    return case("stride", 30, 50)


@pytest.mark.parametrize(
    ("initial", "our_start", "printed_one"),
    [("auto", "both ways", "interpolation"), ("templates", "templates", "templates")],
)
def test_what_is_begun_with_is_what_is_asked_for_or_the_methods_own(
    person: Case, initial: Initial, our_start: str, printed_one: str
) -> None:
    segment, scene = segment_of(person), person.scene()
    ours = starts(scene, segment, replace(FULL, initial=initial))
    printed = printed_start(scene, segment, Paper(initial=initial))
    assert (ours.ways[0].what, printed.ways[0].what) == (our_start, printed_one)
    for begun in (ours, printed):
        first = begun.ways[0].trajectory
        for frame, keyed in ((0, segment.start), (20, segment.end)):
            np.testing.assert_allclose(
                first.pose(frame).Rs_parent_part, keyed.Rs_parent_part, atol=1e-9
            )
            np.testing.assert_allclose(
                first.pose(frame).p_camera_root, keyed.p_camera_root, atol=1e-9
            )


def test_every_way_but_the_plain_one_starts_nearer_to_the_truth(person: Case) -> None:
    segment, scene = segment_of(person), person.scene()
    for initial in ("auto", "templates"):
        first = starts(scene, segment, replace(FULL, initial=initial)).ways[0].trajectory
        assert person.error_cm(first) < 0.6 * person.error_cm(plain(person))


def test_auto_begins_with_the_best_score_and_keeps_the_others_as_choices(person: Case) -> None:
    segment, scene = segment_of(person), person.scene()
    strayed = plain(person)
    ps = strayed.ps_camera_root.copy()
    ps[1:-1, 1] -= 0.3
    bad = replace(strayed, ps_camera_root=ps)
    for imported, is_first in ((person.truth, True), (bad, False)):
        begun = starts(scene, replace(segment, imported=imported), FULL)
        scores = [way.score for way in begun.ways]
        assert (begun.ways[0].what == "import") == is_first
        assert len(scores) >= 2
        assert scores == sorted(scores)  # type: ignore[type-var]
        _, outcome = worked(person, replace(segment, imported=imported), FULL)
        kept = outcome.passes[outcome.best].score
        assert kept is not None
        assert kept <= 1.15 * min(scores) + 2.0  # type: ignore[type-var, operator]


def test_a_preview_looks_for_no_templates_unless_it_is_asked_to(person: Case) -> None:
    segment, scene = segment_of(person), person.scene()
    assert all(way.what != "templates" for way in starts(scene, segment, PREVIEW).ways)
    asked = starts(scene, segment, replace(PREVIEW, initial="templates"))
    assert asked.ways[0].what == "templates"


def test_an_imported_motion_that_does_not_reach_is_reported_and_another_start_taken(
    person: Case,
) -> None:
    segment, scene = segment_of(person), person.scene()
    begun = starts(scene, segment, replace(FULL, initial="import"))
    assert begun.ways[0].what == "both ways"
    assert any("does not reach" in note for note in begun.notes)
    begun = printed_start(scene, segment, Paper(initial="import"))
    assert begun.ways[0].what == "interpolation"
    assert any("does not reach" in note for note in begun.notes)


def test_a_limb_that_is_left_out_is_not_followed(person: Case) -> None:
    segment, scene = segment_of(person), person.scene()
    thigh = scene.skeleton.body.index("left_thigh")
    with_it, without = (
        printed_start(scene, segment, Paper(initial="templates", left_out=left_out))
        for left_out in ((), ("left_foot",))
    )
    straight = plain(person).Rs_parent_part[:, thigh]
    found, kept = (s.ways[0].trajectory.Rs_parent_part[:, thigh] for s in (with_it, without))
    np.testing.assert_allclose(kept, straight, atol=1e-9)
    assert np.abs(found - straight).max() > 0.01


def test_the_settings_reach_the_method() -> None:
    for method in ("keypose", "paper"):
        found = method_of(
            TrackSettings(method=method, initial="templates", left_out=("head",))  # type: ignore[arg-type]
        )
        assert (found.initial, found.left_out) == ("templates", ("head",))


def test_a_part_left_out_that_the_body_does_not_have_is_refused_by_name() -> None:
    session = load_session(BOX)
    reported = session.model_dump() | {"settings": {"left_out": ["left_wing"]}}
    with pytest.raises(ValidationError, match=r"left_wing.*its parts are box"):
        Session.model_validate(reported)
