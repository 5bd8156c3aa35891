"""Motions in space among the results: kept by their keys, written and read again."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from keypose.tracker.session import Session
from keypose.tracker.session.results import SpaceSummary
from keypose.tracker.storage.files import load_session, save_session
from keypose.tracker.storage.outdated import outdated_keyframes, outdated_words
from keypose.tracker.storage.results import Results, load_results, save_results
from keypose.tracker.storage.tracks import Tracks, load_tracks
from tests.app.results_cases import track
from tests.tracker.operations.space_cases import (
    PIN,
    both,
    depths,
    pinned,
    session,
    smooth,
    softened,
    solution,
    solved,
)
from tests.tracker.session_cases import result, segment


def saved(results: Results, folder: Path, of: Session) -> tuple[Session, Path]:
    path = folder / "session.json"
    save_session(save_results(of, path, results), path)
    return load_session(path), path


def test_segments_have_the_motion_in_space_and_remember_what_was_tracked() -> None:
    of = smooth()
    tracked, found = both(of), solved(of)
    assert found.unsolved(of) == []
    for span, one in found.fitting(of).items():
        before = tracked.fitting(of)[span]
        assert one.before_space is not None
        np.testing.assert_array_equal(
            one.before_space.ps_camera_root, before.trajectory.ps_camera_root
        )
        assert np.abs(one.trajectory.ps_camera_root - before.trajectory.ps_camera_root).max() > 0
        np.testing.assert_array_equal(
            one.as_tracked.trajectory.ps_camera_root, before.trajectory.ps_camera_root
        )


def test_undoing_a_pin_finds_the_earlier_motion_again() -> None:
    without, with_pin = smooth(), smooth(pinned())
    results = solved(without, shift_m=0.01)
    earlier = depths(results, without)
    results = solved(with_pin, results, shift_m=0.05)
    assert depths(results, with_pin) != earlier
    assert results.unsolved(without) == []
    assert depths(results, without) == earlier


def test_pinning_and_smoothing_leave_the_segments_tracked() -> None:
    for of in (smooth(), pinned(), softened(smooth(pinned()), 4)):
        assert both(session()).wanted(of, "full") == []


def test_results_in_space_come_back_from_the_disk_as_they_were(tmp_path: Path) -> None:
    of = smooth(pinned())
    results = solved(of)
    again, path = saved(results, tmp_path, of)
    loaded = load_results(again, path)
    assert loaded.unsolved(again) == []
    (mine,), (its,) = results.space(of), loaded.space(again)
    assert (its.key, its.span, its.floor_m) == (mine.key, mine.span, mine.floor_m)
    assert (its.pins, its.proposed, its.findings) == (mine.pins, mine.proposed, mine.findings)
    assert len(its.pins) == len(its.proposed) == len(its.findings) == 1
    np.testing.assert_array_equal(its.motion.Rs_parent_part, mine.motion.Rs_parent_part)
    np.testing.assert_array_equal(its.motion.ps_camera_root, mine.motion.ps_camera_root)
    for span, one in results.fitting(of).items():
        other = loaded.fitting(again)[span]
        assert one.before_space is not None
        assert other.before_space is not None
        for name in ("trajectory", "before_space"):
            np.testing.assert_array_equal(
                getattr(one, name).ps_camera_root, getattr(other, name).ps_camera_root
            )


def test_saved_again_they_are_the_same_bytes(tmp_path: Path) -> None:
    of = smooth(pinned())
    again, path = saved(solved(of), tmp_path, of)
    before = path.read_bytes()
    once_more = save_results(again, path, load_results(again, path))
    save_session(once_more, path)
    assert path.read_bytes() == before


def test_the_file_has_the_motion_in_space_and_the_one_that_was_tracked(tmp_path: Path) -> None:
    of = smooth()
    again, path = saved(solved(of), tmp_path, of)
    tracks = load_tracks(again, path)
    assert tracks.before_space is not None
    raw = both(of).fitting(of)[0, 4].trajectory.ps_camera_root
    np.testing.assert_array_equal(tracks.as_tracked.ps_camera_root[:5], raw)
    assert np.abs(tracks.ps_camera_root[1:4, 2] - raw[1:4, 2]).min() > 1e-3


def test_without_pins_and_smoothing_the_files_are_those_of_before(tmp_path: Path) -> None:
    of = session()
    again, path = saved(both(of), tmp_path, of)
    assert again.subject.results is not None
    assert again.subject.results.space == ()
    words = path.read_text("utf-8")
    for name in ("space", "pins", "floor_m", "soft", "smooth"):
        assert f'"{name}"' not in words
    content = Tracks.of(result().segments, result().skeleton).to_bytes()
    assert b"before_space" not in content
    assert (tmp_path / again.subject.results.tracks).read_bytes() == content


def test_where_a_part_is_solved_the_rest_stays_as_tracked(tmp_path: Path) -> None:
    of = smooth()
    results = Results().with_result(track(of, 0, 4)).with_result(track(of, 4, 8, "preview"))
    (stretch,) = results.unsolved(of)
    again, path = saved(results.with_space(solution(stretch)), tmp_path, of)
    loaded = load_results(again, path).fitting(again)
    assert loaded[0, 4].before_space is not None
    np.testing.assert_array_equal(
        loaded[4, 8].trajectory.ps_camera_root, segment(4, 8).trajectory.ps_camera_root
    )


def test_the_newest_motions_are_kept(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("keypose.tracker.storage.results.collection.MOST_STRETCHES", 2)
    results, ofs = Results(), [smooth(session(floor_m=height)) for height in (0.1, 0.2, 0.3)]
    for of in ofs:
        results = solved(of, results if len(results) else both(of))
    assert [bool(results.unsolved(of)) for of in ofs] == [True, False, False]


# --- what is out of date


def test_a_motion_that_was_solved_for_the_session_is_up_to_date(tmp_path: Path) -> None:
    of = smooth(pinned())
    again, path = saved(solved(of), tmp_path, of)
    assert outdated_words(again, load_tracks(again, path)) is None


@pytest.mark.parametrize(
    "change",
    [
        lambda of: of.changed({"pins": ()}),
        lambda of: of.changed({"pins": (PIN.model_copy(update={"last_frame": 7}),)}),
        lambda of: of.changed({"floor_m": -0.7}),
        lambda of: smooth(of, smooth=False),
    ],
    ids=["no pin", "longer pin", "floor", "not smooth"],
)
def test_changed_pins_are_reported(tmp_path: Path, change: object) -> None:
    assert callable(change)
    of = smooth(pinned())
    again, path = saved(solved(of), tmp_path, of)
    assert outdated_words(change(again), load_tracks(again, path)) == (
        "the tracked motion is out of date (pins, the floor, smoothing or the frame rate have "
        "changed)."
    )


def test_pins_set_after_tracking_are_reported(tmp_path: Path) -> None:
    of = session()
    again, path = saved(both(of), tmp_path, of)
    tracks = load_tracks(again, path)
    assert outdated_words(again, tracks) is None
    words = outdated_words(again.changed({"pins": (PIN,)}), tracks)
    assert words is not None
    assert "pins" in words


def test_a_soft_keyframe_that_the_motion_only_comes_near_is_not_out_of_date(
    tmp_path: Path,
) -> None:
    of = softened(smooth(), 4)
    again, path = saved(solved(of, shift_m=0.05), tmp_path, of)
    tracks = load_tracks(again, path)
    keyframe = again.subject.keyframes[1]
    pose = tracks.pose(4)
    assert pose is not None
    assert abs(pose.p_camera_root[2] - keyframe.root_m[2]) > 0.01
    assert outdated_keyframes(again, tracks) == ()
    assert outdated_words(again, tracks) is None


def test_a_summary_says_nothing_that_is_not_there() -> None:
    plain = SpaceSummary(first_frame=0, last_frame=4, key="0" * 64)
    reported = plain.model_dump(mode="json")
    assert set(reported) == {"first_frame", "last_frame", "key", "pins", "floor_m"}
