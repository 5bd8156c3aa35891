"""How far to trust a motion, frame by frame: the table of frames, and the archive of everything."""

from __future__ import annotations

import csv
import io
from dataclasses import replace

import numpy as np
import pytest

from keypose.tracker.errors import FormatError
from keypose.tracker.formats.csv import frames_csv, joints_csv
from keypose.tracker.formats.npz import npz
from keypose.tracker.formats.recording import Recording
from keypose.tracker.formats.sampling import at_rate
from keypose.tracker.geometry.rotations import rotation_from_euler
from keypose.tracker.session.annotations import Note
from keypose.tracker.session.verdict import GOOD
from keypose.tracker.video.info import Timecode
from tests.tracker.formats import recordings


def rows(text: str) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(text)))


def arrays(content: bytes) -> dict[str, np.ndarray]:  # type: ignore[type-arg]
    with np.load(io.BytesIO(content), allow_pickle=False) as archive:
        return dict(archive)


def test_every_frame_has_the_verdict_of_its_segment() -> None:
    table = rows(frames_csv(recordings.recording("person")))
    assert [row["frame"] for row in table] == [str(i) for i in range(73)]
    assert [row["verdict"] for row in table] == ["good"] * 24 + ["check"] * 24 + ["lost"] * 25
    assert table[30]["words"] == "check frames 3–4: left hand not seen"
    assert (table[30]["first_frame"], table[30]["last_frame"]) == ("24", "48")
    keyed = [int(row["frame"]) for row in table if row["pose"] == "keyframe"]
    assert keyed == [0, 24, 48, 72]
    assert {row["pose"] for row in table} == {"keyframe", "tracked"}


def test_a_frame_at_which_limbs_alone_were_keyed_is_reported() -> None:
    made = replace(recordings.recording("person"), part_frames=(30,))
    poses = [row["pose"] for row in rows(frames_csv(made))]
    assert [i for i, pose in enumerate(poses) if pose == "part_keyframe"] == [30]
    assert poses[24] == "keyframe"


def test_the_evidence_is_that_of_the_step_to_the_next_frame() -> None:
    made = recordings.recording("person")
    table = rows(frames_csv(made))
    assert [row["rank"] for row in table] == [str(i % 5) for i in range(72)] + [""]
    assert table[3]["degrees_of_freedom"] == str(made.skeleton.dof_count)
    for i in (0, 40):
        seen = [float(table[i][f"{part}_observability"]) for part in made.skeleton.body.names]
        np.testing.assert_allclose(seen, made.tracks.diagnostics.observability[i], atol=1e-6)
        left = [float(table[i][f"{part}_residual"]) for part in made.skeleton.body.names]
        np.testing.assert_allclose(left, made.tracks.diagnostics.residual[i], atol=1e-6)
    assert table[-1]["waist_residual"] == ""


def test_frames_that_are_not_tracked_say_so_and_are_empty() -> None:
    made = recordings.recording("person", without=(1,))
    table = rows(frames_csv(made))
    assert [int(row["frame"]) for row in table if row["pose"] == "missing"] == list(range(25, 48))
    assert {row["verdict"] for row in table[25:48]} == {""}
    assert {row["rank"] for row in table[24:48]} == {""}
    assert table[24]["verdict"] == "good"
    assert table[48]["verdict"] == "lost"
    assert len({row["time_s"] for row in table}) == 73
    joints = rows(joints_csv(made.skeleton, made.trajectory, made.times_s))
    cells = [value for name, value in joints[30].items() if name not in ("frame", "time_s")]
    assert set(cells) == {""}


def test_the_table_goes_from_keyframe_to_keyframe_where_less_is_tracked() -> None:
    made = recordings.recording("person", without=(0, 2))
    table = rows(frames_csv(made))
    assert [int(row["frame"]) for row in table] == list(range(73))
    assert [row["pose"] == "missing" for row in table] == [True] * 24 + [False] * 25 + [True] * 24
    assert [row["rank"] != "" for row in table] == [False] * 24 + [True] * 24 + [False] * 25
    found = arrays(npz(made))
    assert found["segment_frames"].tolist() == [[24, 48]]
    assert np.flatnonzero(found["tracked"]).tolist() == list(range(24, 49))
    whole = made.whole("BVH")
    assert list(whole.frames) == list(range(24, 49))
    np.testing.assert_array_equal(whole.times_s, made.times_s[24:49])
    np.testing.assert_array_equal(
        whole.tracks.diagnostics.rank, made.tracks.diagnostics.rank[24:48]
    )


@pytest.mark.parametrize("name", recordings.NAMES)
def test_the_archive_holds_poses_times_and_the_camera(name: str) -> None:
    made = recordings.recording(name)
    found = arrays(npz(made))
    np.testing.assert_array_equal(found["frame"], list(made.frames))
    np.testing.assert_array_equal(found["time_s"], made.times_s)
    np.testing.assert_allclose(
        found["ps_camera_joint"] @ recordings.TO_FILE, recordings.joints_in_file(made), atol=1e-12
    )
    Rs = np.array([rotation_from_euler(*t) for t in found["angles_zyx_rad"].reshape(-1, 3)])
    np.testing.assert_allclose(Rs, made.tracks.Rs_parent_part.reshape(-1, 3, 3), atol=1e-7)
    assert found["part_names"].tolist() == list(made.skeleton.body.names)
    camera = made.camera
    np.testing.assert_array_equal(found["K"], camera.K)
    np.testing.assert_array_equal(found["distortion"], camera.distortion)
    assert found["image_size"].tolist() == [camera.width, camera.height]
    assert str(found["projection"]) == "perspective"
    np.testing.assert_allclose(np.linalg.norm(found["up_camera"]), 1)


def test_the_archive_holds_the_verdicts_and_their_segments() -> None:
    found = arrays(npz(recordings.recording("person", without=(1,))))
    assert found["segment_frames"].tolist() == [[0, 24], [48, 72]]
    assert found["segment_verdict"].tolist() == ["good", "lost"]
    assert found["segment_words"][1] == "lost: add a keyframe near 7"
    assert found["segment"].tolist() == [0] * 25 + [-1] * 23 + [1] * 25
    assert found["verdict"].tolist() == ["good"] * 25 + [""] * 23 + ["lost"] * 25
    assert np.flatnonzero(found["keyframe"]).tolist() == [0, 24, 48, 72]
    assert np.isnan(found["ps_camera_joint"][30]).all()
    assert np.isnan(found["angles_zyx_rad"][~found["tracked"]]).all()
    assert found["tracked"].sum() == 50
    assert found["rank"].shape == (72,)
    assert (found["rank"][24:48] == -1).all()


def test_the_same_motion_has_the_same_bytes() -> None:
    assert npz(recordings.recording("box")) == npz(recordings.recording("box"))


def test_a_segment_the_tracks_do_not_hold_has_no_say() -> None:
    made = recordings.recording("person", without=(1,))
    odd = [made.segments[0].__class__(20, 60, GOOD)]
    odd += [made.segments[0].__class__(-5, 3, GOOD), *made.segments]
    again = Recording.of(
        recordings.session("person"), made.tracks, odd, recordings.uneven_times(73)
    )
    assert again.segments == made.segments


def test_a_motion_beyond_the_video_is_refused() -> None:
    made = recordings.recording("box")
    with pytest.raises(FormatError, match="longer than the video"):
        Recording.of(recordings.session("box"), made.tracks, (), recordings.uneven_times(5))


def test_a_note_stands_in_the_row_of_its_frame_and_is_no_formula() -> None:
    notes = (
        Note(frame=3, text="left elbow\nhidden, “here”"),
        Note(frame=7),
        Note(frame=9, text='=HYPERLINK("http://x")'),
    )
    made = replace(recordings.recording("person"), notes=notes)
    message = {int(row["frame"]): row["note"] for row in rows(frames_csv(made)) if row["note"]}
    assert message == {
        3: "left elbow hidden, “here”",
        7: "flag",
        9: '\'=HYPERLINK("http://x")',
    }


def test_at_a_rate_of_its_own_a_note_stands_in_the_nearest_row() -> None:
    made = recordings.recording("person")
    notes = (Note(frame=30, text="a"), Note(frame=31, text="b"), Note(frame=500, text="beyond"))
    coarse = replace(made, sampled_at=np.linspace(0.0, 300.0, len(made)), notes=notes)
    message = [row["note"] for row in rows(frames_csv(coarse)) if row["note"]]
    assert message == ["a · b"]


def test_the_films_timecode_stands_in_every_row_and_in_the_archive() -> None:
    made = replace(recordings.recording("person"), timecode=Timecode.read("10:00:00:20", 25))
    table = rows(frames_csv(made))
    assert [table[i]["timecode"] for i in (0, 5, 72)] == [
        "10:00:00:20",
        "10:00:01:00",
        "10:00:03:17",
    ]
    at_half = rows(frames_csv(at_rate(made, 12.5)))
    assert at_half[1]["timecode"] == made.timecode_at(round(float(at_half[1]["film_frame"])))
    assert str(arrays(npz(made))["timecode"]) == "10:00:00:20"
    bare = recordings.recording("person")
    assert {row["timecode"] for row in rows(frames_csv(bare))} == {""}
    assert str(arrays(npz(bare))["timecode"]) == ""
