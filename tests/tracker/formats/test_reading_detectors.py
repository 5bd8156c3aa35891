"""Keypoints as detectors and annotation tools write them: numbered, shared out, one frame more."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from keypose.tracker.errors import FormatError
from keypose.tracker.formats.keypoint_files import read_people
from keypose.tracker.formats.people import People, frame_numbers
from keypose.tracker.formats.reading_keypoints import (
    VideoFacts,
    keypoints_of,
    load_keypoints,
    on_video,
)
from keypose.tracker.formats.text import Note
from keypose.tracker.keypoints.layouts import LAYOUTS
from tests.tracker.keypoints.people import seen_person

UV = seen_person("COCO_17", np.random.default_rng(4), frames=3)
VIDEO = VideoFacts(40, 640, 480)


def _numbers(frame: int) -> list[float]:
    return [float(x) for uv in UV[frame] for x in (*uv, 0.9)]


def _openpose(folder: Path, name: str) -> Path:
    folder = folder / "walk_json"
    folder.mkdir()
    for n in range(3):
        people = [{"pose_keypoints_2d": _numbers(n)}]
        (folder / name.format(n + 12)).write_text(json.dumps({"people": people}))
    return folder


def _instances(frame: int) -> list[dict[str, Any]]:
    return [{"keypoints": UV[frame].tolist(), "keypoint_scores": [0.9] * 17, "bbox": [[0] * 4]}]


def _mmpose_list(folder: Path) -> Path:
    frames = [{"frame_id": n + 12, "instances": _instances(n)} for n in range(3)]
    return _write(folder, [{"frame_id": 11, "instances": []}, *frames])


def _mmpose_demo(folder: Path) -> Path:
    frames = [{"frame_id": n + 13, "instances": _instances(n)} for n in range(3)]
    return _write(folder, {"meta_info": {}, "instance_info": frames})


def _mmpose_folder(folder: Path) -> Path:
    folder = folder / "predictions"
    folder.mkdir()
    for n in range(3):
        (folder / f"frame{n + 12:04}_v2.json").write_text(json.dumps(_instances(n)))
    return folder


def _numbered(folder: Path) -> Path:
    names = [str(n + 1) for n in range(17)]
    annotations = [{"image_id": n + 12, "keypoints": _numbers(n)} for n in range(3)]
    path = _write(folder, {"annotations": annotations, "categories": [{"keypoints": names}]})
    path.write_text(path.read_text(), encoding="utf-8-sig")
    return path


def _landmarks(folder: Path) -> Path:
    """Shares of the picture's size, which is not said."""
    share = (UV + 0.5) / [VIDEO.width, VIDEO.height]
    rows = [[{"x": u, "y": v, "visibility": 0.9} for u, v in frame.tolist()] for frame in share]
    index = [LAYOUTS["COCO_17"].index(n) if n in LAYOUTS["COCO_17"] else None for n in FACE]
    nobody = {"x": 0.0, "y": 0.0, "visibility": 0.0}
    frames = [
        {"frame": n + 12, "pose_landmarks": [nobody if i is None else row[i] for i in index]}
        for n, row in enumerate(rows)
    ]
    return _write(folder, {"frames": frames})


FACE = LAYOUTS["MEDIAPIPE_33"]


def _write(folder: Path, data: Any) -> Path:
    path = folder / "points.json"
    path.write_text(json.dumps(data))
    return path


@pytest.mark.parametrize(
    ("write", "program"),
    [
        (lambda folder: _openpose(folder, "walk_{:06}.json"), "OpenPose"),
        (lambda folder: _openpose(folder, "{:05}.json"), "OpenPose"),
        (lambda folder: _openpose(folder, "a1_{:012}_keypoints.json"), "OpenPose"),
        (_mmpose_list, "MMPose"),
        (_mmpose_demo, "MMPose"),
        (_mmpose_folder, "MMPose"),
        (_numbered, "COCO"),
        (_landmarks, "MediaPipe"),
    ],
)
def test_every_kind_gives_the_same_keypoints_of_the_same_frames(
    tmp_path: Path, write: Callable[[Path], Path], program: str
) -> None:
    path = write(tmp_path)
    assert read_people(path).program == program
    found = load_keypoints(path, video=VIDEO)
    indices = [found.names.index(name) for name in LAYOUTS["COCO_17"]]
    rows = found.visibility.any(axis=1)
    assert np.flatnonzero(rows).tolist() == [12 - found.first_frame + n for n in range(3)]
    assert np.allclose(found.uv[rows][:, indices], UV, atol=1e-6)


def test_an_order_that_a_person_names_counts_for_points_that_are_only_numbered(
    tmp_path: Path,
) -> None:
    people = read_people(_numbered(tmp_path))
    assert keypoints_of("a.json", people, "COCO_17").names == LAYOUTS["COCO_17"]
    with pytest.raises(FormatError, match="is COCO_17, not HALPE_26"):
        keypoints_of("a.json", people, "HALPE_26")


@pytest.mark.parametrize(
    ("names", "frames"),
    [
        (["img_2024_0007.png", "img_2024_0009.png"], [7, 9]),
        (["cam1_00012_v2.jpg", "cam1_00013_v2.jpg"], [12, 13]),
        (["7_of_90.png", "8_of_90.png"], [7, 8]),
        (["walk_000000000012_keypoints.json"], [12]),
        (["a.png", "b.png"], [0, 1]),
        (["12.0", "13.0"], [12, 13]),
    ],
)
def test_of_several_numbers_in_a_name_the_frames_is_the_one_that_differs(
    names: list[str], frames: list[int]
) -> None:
    assert list(frame_numbers(names).values()) == frames


def _people(*frames: int) -> People:
    return People({frame: [_numbers(0)] for frame in frames})


def test_a_frame_more_than_the_video_has_is_left_out_and_told() -> None:
    kept, notes = on_video("a.json", _people(*range(41)), VIDEO)
    assert list(kept.frames) == list(range(40))
    assert notes == (Note("frames beyond", (1, 39)),)
    assert on_video("a.json", _people(3, 39), VIDEO) == (_people(3, 39), ())
    with pytest.raises(FormatError, match="frames are 0 to 39: choose the frame"):
        on_video("a.json", _people(*range(44)), VIDEO)
    with pytest.raises(FormatError, match="frames 40 to 40"):
        on_video("a.json", _people(40), VIDEO)


def test_pictures_that_count_from_1_are_moved_by_a_frame() -> None:
    kept, notes = on_video("a.json", _people(1, 40), VIDEO, -1)
    assert (list(kept.frames), notes) == ([0, 39], ())
