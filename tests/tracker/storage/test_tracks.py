"""Tracks files: the same result is the same bytes, and nothing odd is believed."""

from __future__ import annotations

import dataclasses
import io
import zipfile
from pathlib import Path

import numpy as np
import pytest

from keypose.tracker.errors import SessionError
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.session import IgnoreMask, Keyframe, Session
from keypose.tracker.session.camera_motion import CameraMotion
from keypose.tracker.session.references import Surface
from keypose.tracker.session.verdict import GOOD
from keypose.tracker.storage.archive import archive_arrays, archive_bytes
from keypose.tracker.storage.files import load_session, save_session
from keypose.tracker.storage.fingerprints import segment_key, setup_hash
from keypose.tracker.storage.outdated import outdated_keyframes, outdated_words, tracked_keyframes
from keypose.tracker.storage.tracks import (
    Tracks,
    load_tracks,
    load_trajectory,
    save_result,
    tracks_name,
)
from keypose.tracker.tracking.result import Diagnostics
from tests.tracker import session_cases as cases


def saved(folder: Path) -> tuple[Session, Path]:
    path = folder / "session.json"
    session = save_result(cases.session(), path, cases.result())
    save_session(session, path)
    return session, path


def test_a_result_is_read_back_as_it_was(tmp_path: Path) -> None:
    _, path = saved(tmp_path)
    session = load_session(path)
    trajectory = load_trajectory(session, path)
    first, second = cases.segment(0, 4).trajectory, cases.segment(4, 8).trajectory
    assert trajectory.first_frame == 0
    np.testing.assert_array_equal(trajectory.Rs_parent_part[:5], first.Rs_parent_part)
    np.testing.assert_array_equal(trajectory.Rs_parent_part[4:], second.Rs_parent_part)
    np.testing.assert_array_equal(trajectory.ps_camera_root[4:], second.ps_camera_root)
    tracks = load_tracks(session, path)
    assert tracks.diagnostics.rank.tolist() == [7] * 8
    assert tracks.diagnostics.singular_values.shape == (8, cases.SKELETON.dof_count)
    assert np.isnan(tracks.diagnostics.observability[:, 1]).all()
    assert not tracks.diagnostics.residual.flags.writeable


def test_the_session_shows_what_was_found(tmp_path: Path) -> None:
    session, _ = saved(tmp_path)
    assert session.subject.results is not None
    assert session.subject.results.quality == "full"
    assert [s.verdict for s in session.subject.results.segments] == [GOOD, GOOD]
    assert session.subject.results.segments[0].scores == (3.0, 2.0, None)


def test_the_same_result_has_the_same_bytes_and_name(tmp_path: Path) -> None:
    one, _ = saved(tmp_path)
    place = tmp_path / one.subject.results.tracks if one.subject.results else tmp_path
    before = (place.read_bytes(), place.stat().st_mtime_ns)
    other, _ = saved(tmp_path)
    assert other == one
    assert (place.read_bytes(), place.stat().st_mtime_ns) == before
    assert place.name == tracks_name(before[0])
    assert len(list(tmp_path.glob("*.npz"))) == 1


def test_numpy_reads_the_file_without_pickle(tmp_path: Path) -> None:
    session, _ = saved(tmp_path)
    assert session.subject.results is not None
    with np.load(tmp_path / session.subject.results.tracks, allow_pickle=False) as file:
        assert file["part_names"].tolist() == list(cases.SKELETON.body.names)
        assert file["Rs_parent_part"].shape == (9, 4, 3, 3)
        assert int(file["first_frame"]) == 0


def test_a_gap_between_finished_segments_stays_a_gap(tmp_path: Path) -> None:
    path = tmp_path / "session.json"
    partial = cases.result(cases.segment(6, 8), cases.segment(0, 4))
    session = save_result(cases.session(), path, partial)
    tracks = load_tracks(session, path)
    assert tracks.tracked.tolist() == [True] * 5 + [False] + [True] * 3
    assert tracks.diagnostics.rank.tolist() == [7] * 4 + [-1] * 2 + [7] * 2
    with pytest.raises(SessionError, match="not been tracked yet at frames 5: run `keypose"):
        load_trajectory(session, path)


def test_the_first_segments_alone_are_a_shorter_motion(tmp_path: Path) -> None:
    path = tmp_path / "session.json"
    session = save_result(cases.session(), path, cases.result(cases.segment(0, 4)))
    assert load_trajectory(session, path).last_frame == 4


def test_nothing_tracked_is_said(tmp_path: Path) -> None:
    path = tmp_path / "my session.json"
    with pytest.raises(SessionError, match=r"not been tracked yet: run `keypose track '.*'`\."):
        load_trajectory(cases.session(), path)
    nothing = cases.result()
    object.__setattr__(nothing, "segments", ())
    with pytest.raises(SessionError, match="no tracked segment"):
        save_result(cases.session(), path, nothing)
    assert not list(tmp_path.iterdir())


def test_of_a_session_about_surfaces_it_is_said_how_surfaces_are_fitted(tmp_path: Path) -> None:
    path = tmp_path / "my session.json"
    session = cases.session().changed({"surface": Surface(p_camera_surface=(0.0, 0.0, 3.0))})
    command = r"run `keypose fit --session '.*my session\.json'`\."
    with pytest.raises(SessionError, match=f"has not been fitted yet: {command}"):
        load_tracks(session, path)
    partial = save_result(session, path, cases.result(cases.segment(6, 8), cases.segment(0, 4)))
    with pytest.raises(SessionError, match=f"not been fitted yet at frames 5: {command}"):
        load_trajectory(partial, path)


def test_a_changed_byte_is_noticed(tmp_path: Path) -> None:
    session, path = saved(tmp_path)
    assert session.subject.results is not None
    place = tmp_path / session.subject.results.tracks
    content = bytearray(place.read_bytes())
    content[len(content) // 2] ^= 1
    place.write_bytes(bytes(content))
    with pytest.raises(SessionError, match="is damaged: its content does not fit its name"):
        load_trajectory(session, path)
    place.unlink()
    with pytest.raises(SessionError, match="cannot be read: No such file"):
        load_trajectory(session, path)


def test_a_motion_of_another_body_is_refused(tmp_path: Path) -> None:
    session, path = saved(tmp_path)
    shorter = session.subject.body.replaced(session.subject.body.parts[:3])
    other = session.changed({"body": shorter})
    with pytest.raises(SessionError, match="with other parts than the session's body has"):
        load_trajectory(other, path)


def test_keyframes_changed_after_tracking_are_reported(tmp_path: Path) -> None:
    session, path = saved(tmp_path)
    trajectory = load_trajectory(session, path)
    assert outdated_keyframes(session, trajectory) == ()
    moved = session.subject.keyframes[1].model_copy(update={"root_m": (0.0, 0.0, 3.0)})
    keyframes = (session.subject.keyframes[0], moved, session.subject.keyframes[2])
    assert outdated_keyframes(session.changed({"keyframes": keyframes}), trajectory) == (4,)


def test_keyframes_added_or_taken_away_after_tracking_are_reported(tmp_path: Path) -> None:
    session, path = saved(tmp_path)
    trajectory = load_trajectory(session, path)
    first, middle, last = session.subject.keyframes
    removed = session.changed({"keyframes": (first, last)})
    assert outdated_keyframes(removed, trajectory) == (4,)
    # On the motion itself, so that only its being there is new.
    there = Keyframe.of(cases.SKELETON, trajectory.pose(2), 2, 2 / 25)
    added = session.changed({"keyframes": (first, there, middle, last)})
    assert outdated_keyframes(added, trajectory) == (2,)
    assert tracked_keyframes(added) == (0, 4, 8)


def test_a_changed_body_camera_or_mask_is_reported(tmp_path: Path) -> None:
    session, path = saved(tmp_path)
    trajectory = load_trajectory(session, path)
    assert outdated_words(session, trajectory) is None
    mask = IgnoreMask(polygon=((0, 0), (9, 0), (9, 9)), first_frame=0, last_frame=8)
    hand = session.subject.body.parts[3].model_copy(update={"joint_m": (0.0, 0.5, 0.0)})
    changes: dict[str, object] = {
        "camera": session.view.camera.model_copy(update={"fx": 61.0}),
        "ignore_masks": (mask,),
        "body": session.subject.body.replaced((*session.subject.body.parts[:3], hand)),
    }
    for field, value in changes.items():
        changed = session.changed({field: value})
        words = outdated_words(changed, trajectory)
        assert words == (
            "the tracked motion is out of date (body, camera or ignore masks have changed)."
        )


def keyed(tmp_path: Path) -> tuple[Session, Path]:
    """A session whose two segments carry the keys of what they were tracked for."""
    session, path = cases.session(), tmp_path / "session.json"
    segments = [
        dataclasses.replace(cases.segment(first, last), key=segment_key(session, first, last))
        for first, last in session.spans
    ]
    return save_result(session, path, cases.result(*segments)), path


def test_a_mask_beyond_the_tracked_segments_outdates_nothing(tmp_path: Path) -> None:
    session, path = keyed(tmp_path)
    motion = load_trajectory(session, path)
    mask = IgnoreMask(polygon=((0, 0), (9, 0), (9, 9)), first_frame=30, last_frame=40)
    assert outdated_words(session.changed({"ignore_masks": (mask,)}), motion) is None
    within = mask.model_copy(update={"first_frame": 2})
    words = outdated_words(session.changed({"ignore_masks": (within,)}), motion)
    assert "ignore masks have changed" in (words or "")


def test_other_settings_outdate_a_motion_and_another_method_or_quality_does_not(
    tmp_path: Path,
) -> None:
    session, path = keyed(tmp_path)
    motion = load_trajectory(session, path)

    def words_with(**settings: object) -> str | None:
        changed = session.settings.model_copy(update=settings)
        return outdated_words(session.changed({"settings": changed}), motion)

    assert words_with(static_camera=True) == (
        "the tracked motion is out of date (settings have changed)."
    )
    assert words_with(quality="preview") is None
    assert words_with(method="paper") is None  # the file says by which one it was tracked


def test_what_changes_no_motion_leaves_the_results_up_to_date(tmp_path: Path) -> None:
    masks = (IgnoreMask(polygon=((0, 0), (9, 0), (9, 9)), first_frame=0, last_frame=8),)
    masked = cases.session().changed({"ignore_masks": masks})
    session = save_result(masked, tmp_path / "session.json", cases.result())
    changed = session.changed(
        {
            "camera": session.view.camera.model_copy(update={"origin": "guess"}),
            "ignore_masks": (masks[0].model_copy(update={"note": "a passer-by"}),),
        }
    )
    assert setup_hash(changed) == setup_hash(session)
    assert outdated_words(changed, load_trajectory(session, tmp_path / "session.json")) is None


def test_results_without_a_word_on_body_and_camera_open_and_are_believed(tmp_path: Path) -> None:
    _, path = saved(tmp_path)
    cases.altered(path, lambda data: data["results"].pop("tracked_for"))
    cases.altered(path, lambda data: data["camera"].update(fx=61.0))
    session = load_session(path)
    assert outdated_words(session, load_trajectory(session, path)) is None


def test_a_keyframe_in_a_gap_is_not_followed(tmp_path: Path) -> None:
    path = tmp_path / "session.json"
    partial = cases.result(cases.segment(6, 8), cases.segment(0, 2))
    session = save_result(cases.session(), path, partial)
    tracks = load_tracks(session, path)
    assert 4 in outdated_keyframes(session, tracks)
    assert outdated_words(session, tracks) == (
        "the tracked motion is out of date (keyframes were set, changed or removed at frames 2, 6)"
        " and does not reach the keyframes at frame 4."
    )
    assert tracks.runs() == "0 to 2, 6 to 8"
    assert tracks.runs(False) == "3 to 5"
    assert tracks.pose(4) is None
    assert tracks.pose(9) is None
    found = tracks.pose(7)
    assert found is not None
    np.testing.assert_array_equal(found.p_camera_root, tracks.ps_camera_root[7])


def test_a_motion_that_ends_early_is_not_called_out_of_date(tmp_path: Path) -> None:
    path = tmp_path / "session.json"
    session = save_result(cases.session(), path, cases.result(cases.segment(0, 4)))
    words = outdated_words(session, load_trajectory(session, path))
    assert words == "the tracked motion does not reach the keyframes at frame 8."


def test_a_preview_is_tracked_though_nothing_was_measured(tmp_path: Path) -> None:
    measured = cases.segment(0, 4)
    parts, dofs = cases.SKELETON.part_count, cases.SKELETON.dof_count
    nothing = Diagnostics.side_by_side((), 5, parts, dofs)
    preview = dataclasses.replace(measured, diagnostics=nothing)
    path = tmp_path / "session.json"
    session = save_result(cases.session(), path, cases.result(preview))
    tracks = load_tracks(session, path)
    assert tracks.tracked.all()
    assert (tracks.diagnostics.rank == -1).all()


def test_what_a_keyframe_would_mend_is_kept_where_it_is_known(tmp_path: Path) -> None:
    gains = np.array([0.0, 1.0, 5.0, 2.0, 0.0])
    found = cases.segment(0, 4)
    diagnostics = dataclasses.replace(found.diagnostics, expected_gain=gains)
    known = dataclasses.replace(found, diagnostics=diagnostics)
    path = tmp_path / "session.json"
    session = save_result(cases.session(), path, cases.result(known, cases.segment(4, 8)))
    kept = load_tracks(session, path).diagnostics.expected_gain
    np.testing.assert_array_equal(kept, [*gains, *[np.nan] * 4])


def test_a_file_that_does_not_show_it_is_the_file_of_an_older_keypose() -> None:
    content = Tracks.of(cases.result().segments, cases.SKELETON).to_bytes()
    assert "need" not in archive_arrays(content)
    assert Tracks.from_bytes(content).diagnostics.expected_gain is None


def _with(**changes: object) -> bytes:
    arrays = archive_arrays(Tracks.of(cases.result().segments, cases.SKELETON).to_bytes())
    for name, value in changes.items():
        if value is None:
            del arrays[name]
        else:
            arrays[name] = np.asarray(value)
    return archive_bytes(arrays)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"", "zip"),
        (b"PK\x03\x04 and no more", "zip"),
        (_with(rank=None), "entries"),
        (_with(more=[1.0]), "entries"),
        (_with(rank=[1, 2]), "rank has the shape"),
        (_with(residual=np.zeros((8, 3))), "residual has the shape"),
        (_with(ps_camera_root=[["a", "b", "c"]] * 9), "convert"),
        (_with(Rs_parent_part=np.ones((9, 4, 3, 3))), "no rotations"),
        (_with(singular_values=3.0), "entries"),
        (_with(first_frame=[1, 2]), "entries"),
        (_with(need=np.zeros(8)), "need has the shape"),
    ],
)
def test_an_archive_of_anything_else_is_refused(content: bytes, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        Tracks.from_bytes(content)


def test_a_header_that_promises_too_much_takes_no_memory() -> None:
    header, archive = io.BytesIO(), io.BytesIO()
    promise = {"descr": "<f8", "fortran_order": False, "shape": (10**15,)}
    np.lib.format.write_array_header_1_0(header, promise)
    with zipfile.ZipFile(archive, "w") as file:
        file.writestr("first_frame.npy", header.getvalue())
    with pytest.raises(ValueError, match="another size than it says"):
        archive_arrays(archive.getvalue())


def test_objects_and_compressed_entries_are_refused() -> None:
    objects, packed = io.BytesIO(), io.BytesIO()
    np.savez(objects, first_frame=np.array([None]))
    np.savez_compressed(packed, first_frame=np.zeros(3))
    for content, words in ((objects, "holds objects"), (packed, "is compressed")):
        with pytest.raises(ValueError, match=words):
            archive_arrays(content.getvalue())


def test_the_bytes_hold_no_clock() -> None:
    with zipfile.ZipFile(io.BytesIO(archive_bytes({"a": np.zeros(3)}))) as archive:
        assert [entry.date_time for entry in archive.infolist()] == [(1980, 1, 1, 0, 0, 0)]


def test_a_motion_that_another_camera_outdates_says_that_it_may_be_the_camera(
    tmp_path: Path,
) -> None:
    session, path = keyed(tmp_path)
    motion, count = load_trajectory(session, path), session.view.video.frame_count
    turns = exp_rotation(np.linspace(0, 0.1, count)[:, None] * np.array([0.0, 1.0, 0.0]))
    panned = CameraPath.of(turns, np.zeros((count, 3)), np.ones(count))
    turned = session.changed({"camera_motion": CameraMotion.of("turns", panned)})
    assert outdated_words(turned, motion) == (
        "the tracked motion is out of date (settings or the camera's motion have changed)."
    )
