"""Files from elsewhere told apart: what each holds, or one sentence why it cannot be imported."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from keypose.app.export.recognising import kind_of, recognise
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import FormatError
from keypose.tracker.formats.csv import joints_csv
from keypose.tracker.storage.files import open_video_of
from keypose.tracker.video.info import VideoInfo
from tests.tracker.formats import recordings

SESSION = recordings.session("person")
TRUTH = recordings.trajectory("person")
SKELETON = Skeleton.of(SESSION.subject.body)
DEEPLABCUT = "scorer,net,net,net\nbodyparts,nose,nose,nose\ncoords,x,y,likelihood\n0,1,2,0.9\n"


@pytest.fixture(scope="module")
def info() -> VideoInfo:
    path = recordings.SAMPLES / "person" / "session.json"
    with open_video_of(SESSION, path) as video:
        return video.info


def test_a_table_is_a_motion_or_keypoints_by_its_head(tmp_path: Path) -> None:
    ours, theirs = tmp_path / "ours.csv", tmp_path / "theirs.csv"
    ours.write_text(joints_csv(SKELETON, TRUTH, np.arange(len(TRUTH)) / 30), newline="")
    theirs.write_text(DEEPLABCUT)
    assert (kind_of(ours), kind_of(theirs)) == ("motion", "keypoints")


def test_json_is_a_camera_or_keypoints_by_what_it_says(tmp_path: Path) -> None:
    file = tmp_path / "a.json"
    for content, kind in (({"format": "keypose camera"}, "camera"), ([], "keypoints")):
        file.write_text(json.dumps(content))
        assert kind_of(file) == kind


def test_a_motion_is_reported_with_its_rate_its_unit_and_the_names_that_are_known(
    tmp_path: Path, info: VideoInfo
) -> None:
    file = tmp_path / "a.bvh"
    file.write_text(recordings.bvh_of(SKELETON, TRUTH, 1 / 60))
    found = recognise(SESSION, file, info)
    facts = found.facts
    assert (found.kind, found.program) == ("motion", "BVH")
    assert facts["fps"] == pytest.approx(60, rel=1e-3)
    assert facts["frames"] == len(TRUTH)
    assert set(facts["matched"].values()) >= {"chest", "head"}


def test_people_in_a_frame_are_counted(tmp_path: Path, info: VideoInfo) -> None:
    file = tmp_path / "a.json"
    person = {"image_id": 3, "keypoints": [9.0, 9.0, 2.0] * 17}
    file.write_text(json.dumps([person, person, {**person, "image_id": 5}]))
    found = recognise(SESSION, file, info)
    assert found.program == "COCO"
    assert (found.facts["people"], found.facts["frames"]) == (2, 2)


def test_an_order_of_keypoints_that_may_be_several_is_to_be_chosen(
    tmp_path: Path, info: VideoInfo
) -> None:
    file = tmp_path / "a.json"
    file.write_text(json.dumps([{"image_id": 0, "keypoints": [9.0, 9.0, 1.0] * 25}]))
    found = recognise(SESSION, file, info)
    assert len(found.facts["layouts"]) > 1


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("walk.bvh", b"HIERARCHY\nROOT", "walk.bvh"),
        ("walk.bvh", b"\xff\xfe\x00", "HIERARCHY"),
        ("walk.trc", b"", "walk.trc"),
        ("walk.c3d", b"nothing", "does not begin as a C3D file does"),
        ("poses.npz", b"PK\x03\x04", "poses.npz"),
        ("poses.pt", b"PK\x03\x04", "poses.pt"),
        ("poses.pkl", b"cos\nsystem\n(S'true'\ntR.", "poses.pkl"),
        ("table.csv", b"", "table.csv"),
        ("points.slp", b"", "SLEAP project"),
        ("points.json", b"[" * 200_000, "is not JSON"),
        ("points.json", b"{}", "form that is known"),
        ("session.json", b'{"schema_version": 3}', "is a session"),
        ("shot.chan", b"1 2 3", "should have 8 numbers"),
        ("shot.glb", b"glTF", "shot.glb"),
        ("notes.txt", b"hello", "holds nothing that can be imported"),
    ],
)
def test_what_cannot_be_read_is_refused_in_one_sentence(
    tmp_path: Path, info: VideoInfo, name: str, content: bytes, words: str
) -> None:
    file = tmp_path / name
    file.write_bytes(content)
    with pytest.raises(FormatError) as refused:
        recognise(SESSION, file, info)
    assert words in str(refused.value)
    assert str(refused.value).endswith(".")
    assert "\n" not in str(refused.value)
