"""Results of surfaces go by what decides them; those of films by what always did."""

from __future__ import annotations

import hashlib
from typing import Any

import pytest

from keypose.app.document.library.recents import Recent, spans_of
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.session import Keyframe, Results, SegmentSummary, Session
from keypose.tracker.session.verdict import GOOD
from keypose.tracker.storage.edit_history import Moment, base_record, mark_of
from keypose.tracker.storage.files import session_json
from keypose.tracker.storage.fingerprints import setup_hash
from keypose.tracker.storage.outdated import outdated_words
from keypose.tracker.storage.results import segment_key, segment_keys
from tests.app import surface_cases as cases
from tests.tracker import session_cases

TWO = cases.session(keyframes=(1, 3))


def surface(of: Session, **changes: Any) -> Session:
    assert of.view.surface is not None
    return of.changed({"surface": of.view.surface.model_copy(update=changes)})


def nudged(of: Session, frame: int) -> Session:
    """With another pose at a keyframe."""
    keyframes = tuple(
        k.model_copy(update={"root_m": (*k.root_m[:2], k.root_m[2] + 0.1)})
        if k.frame == frame
        else k
        for k in of.subject.keyframes
    )
    return of.changed({"keyframes": keyframes})


def decided(of: Session) -> Session:
    """With a person's word on whether the camera stands still, as every older session has it."""
    settings = of.settings.model_copy(update={"static_camera": False})
    return of.changed({"settings": settings})


def changed(before: Session, after: Session) -> list[tuple[int, int]]:
    """The segments whose keys differ."""
    old, new = segment_keys(before), segment_keys(after)
    return [span for span in new if old.get(span) != new[span]]


def test_keys_and_marks_of_films_are_what_they_were_before_there_were_surfaces() -> None:
    of = session_cases.session()
    assert segment_key(of, 0, 4) == (
        "ffec13b18f97e7556c7e9b1a8e1a4888542c07d5694a6a692f27008d12543551"
    )
    assert mark_of(decided(of)) == "47bc4cf47cf4742f"


def test_segments_of_surfaces_reach_to_the_first_and_last_mesh() -> None:
    assert list(segment_keys(cases.session())) == [(0, 4)]
    assert list(segment_keys(TWO)) == [(0, 1), (1, 3), (3, 4)]
    assert spans_of(TWO) == [(0, 1, "none"), (1, 3, "none"), (3, 4, "none")]


def test_a_segment_that_is_none_has_no_key() -> None:
    with pytest.raises(KeyError):
        segment_key(TWO, 0, 4)


@pytest.mark.parametrize(
    "change",
    [
        {"weights": "none"}, {"distance": "point"}, {"binding": "smooth"}, {"units": "mm"},
        {"up": "+y"}, {"p_camera_surface": (0.0, 0.0, 3.0)}, {"model_frame": 3},
        {"cameras_fingerprint": "sha256:ab"},
    ],
    ids=lambda change: next(iter(change)),
)  # fmt: skip
def test_how_surfaces_are_read_and_fitted_decides_every_segment(change: dict[str, Any]) -> None:
    assert changed(TWO, surface(TWO, **change)) == list(TWO.spans)
    assert setup_hash(surface(TWO, **change)) != setup_hash(TWO)


def test_meshes_that_were_exported_again_decide_every_segment() -> None:
    video = TWO.view.video.model_copy(update={"fingerprint": "sha256:cd"})
    other = TWO.changed({"video": video})
    assert changed(TWO, other) == list(TWO.spans)
    assert setup_hash(other) != setup_hash(TWO)
    assert mark_of(other) == mark_of(TWO)  # it is no edit of a person's


def test_the_camera_that_looks_and_the_clock_decide_nothing() -> None:
    nearer = TWO.view.camera.model_copy(update={"fx": 1000.0, "fy": 1000.0})
    settings = TWO.settings.model_copy(update={"static_camera": True, "initial": "templates"})
    other = TWO.changed({"camera": nearer, "settings": settings})
    assert changed(TWO, surface(other, fps=50.0)) == []
    assert setup_hash(surface(other, fps=50.0)) == setup_hash(TWO)


def test_a_folder_may_move_with_its_cameras() -> None:
    one, other = (surface(TWO, cameras=path) for path in ("a/rig.json", "../rig.json"))
    assert changed(one, other) == []
    assert setup_hash(one) == setup_hash(other)


def test_the_pose_in_the_mesh_that_moves_decides_every_segment_and_others_only_theirs() -> None:
    assert changed(TWO, nudged(TWO, 1)) == list(TWO.spans)
    assert changed(TWO, nudged(TWO, 3)) == [(1, 3), (3, 4)]


def test_which_end_is_keyed_decides() -> None:
    one, other = cases.session(keyframes=(0,)), cases.session(keyframes=(4,))
    same_pose = one.subject.keyframes[0].model_copy(update={"frame": 4, "time_s": 1.0})
    assert changed(one, other.changed({"keyframes": (same_pose,)})) == [(0, 4)]


def test_other_meshes_are_not_taken_for_another_film(tmp_path: Any) -> None:
    """Their fingerprint is of another kind, so the start screen does not compare it."""
    path = cases.write_session(tmp_path / "job")
    from keypose.tracker.storage.files import load_session

    assert Recent.of(path, load_session(path), [], 0.0).fingerprint == ""


def test_a_motion_without_keyframes_at_its_ends_is_not_out_of_date(tmp_path: Any) -> None:
    from keypose.app.cli.main import main
    from keypose.tracker.storage.files import load_session
    from keypose.tracker.storage.tracks import load_tracks

    path = cases.write_session(tmp_path / "job", keyframes=(2,))
    assert main(["fit", "--session", str(path), "--quality", "preview"]) in (0, 1)
    session = load_session(path)
    tracks = load_tracks(session, path)
    assert outdated_words(session, tracks) is None
    words = outdated_words(surface(session, weights="none"), tracks)
    assert words is not None
    assert "body or surfaces have changed" in words


@pytest.mark.parametrize("frame", [0, 4])
def test_a_keyframe_taken_away_or_set_at_an_end_puts_the_motion_out_of_date(
    tmp_path: Any, frame: int
) -> None:
    from keypose.app.cli.main import main
    from keypose.tracker.storage.files import load_session
    from keypose.tracker.storage.tracks import load_tracks

    path = cases.write_session(tmp_path / "job", keyframes=(2, 4))
    assert main(["fit", "--session", str(path), "--quality", "preview"]) in (0, 1)
    session = load_session(path)
    tracks = load_tracks(session, path)
    assert outdated_words(session, tracks) is None
    assert session.subject.results is not None
    assert [segment.open_ends for segment in session.subject.results.segments] == [(0,), ()]
    if frame == 4:
        keyframes = session.subject.keyframes[:1]
    else:  # where the motion goes through it already
        found = tracks.pose(0)
        assert found is not None
        fresh = Keyframe.of(Skeleton.of(session.subject.body), found, 0, 0.0)
        keyframes = (fresh, *session.subject.keyframes)
    words = outdated_words(session.changed({"keyframes": keyframes}), tracks)
    assert words is not None
    assert f"set, changed or removed at frame {frame})" in words


def test_a_session_about_a_film_is_written_as_ever() -> None:
    """Byte for byte, results too."""
    of = decided(session_cases.session())
    segment = SegmentSummary(
        first_frame=0, last_frame=4, verdict=GOOD, scores=(1.5, None), best_pass=1,
        closing_error=1e-17,
    )  # fmt: skip
    results = Results(
        tracks="tracks-000000000000.npz", method="keypose", quality="full", segments=(segment,)
    )
    reported = session_json(of.changed({"results": results}))
    digest = "0100a2d753d8266e0047f6f61aef6ed69f4ec4d3f859de1c57c073fb434be22b"
    assert hashlib.sha256(reported).hexdigest() == digest
    assert b'"surface"' not in reported
    assert "surface" not in base_record(Moment(of))["base"]
