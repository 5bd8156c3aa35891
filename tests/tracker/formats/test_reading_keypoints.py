"""2D keypoints in, as COCO and OpenPose write them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tracker.errors import FormatError
from tracker.formats.reading_keypoints import LAYOUTS, Keypoints, load_keypoints


def _person(count: int, offset: float, sure: float) -> list[float]:
    return [value for j in range(count) for value in (offset + j, offset - j, sure)]


def _write(path: Path, data: Any) -> Path:
    path.write_text(json.dumps(data), encoding="utf-8")
    return path


def test_a_list_of_coco_annotations_is_read_by_image_id(tmp_path: Path) -> None:
    numbers = _person(17, 100, 2)
    numbers[3 * 9 + 2] = 0  # LWrist: not labelled
    path = _write(tmp_path / "a.json", [{"image_id": 12, "keypoints": numbers}])
    found = load_keypoints(path)
    assert found.names == LAYOUTS[17]
    uv, sure = found.frames[12]
    assert np.allclose(uv[0], [100, 100])
    assert np.isnan(uv[9]).all()
    assert sure[9] == 0
    assert sure[0] == 1


def test_coco_images_and_categories_say_frames_and_names(tmp_path: Path) -> None:
    data = {
        "images": [{"id": 7, "file_name": "clip/frame_0031.png"}],
        "categories": [{"keypoints": ["left_knee", "right_knee"]}],
        "annotations": [{"image_id": 7, "keypoints": [1, 2, 2, 3, 4, 1]}],
    }
    found = load_keypoints(_write(tmp_path / "a.json", data))
    assert found.names == ("left_knee", "right_knee")
    assert list(found.frames) == [31]


def test_openpose_files_are_frames_and_the_surest_person_counts(tmp_path: Path) -> None:
    people = [{"pose_keypoints_2d": _person(25, o, s)} for o, s in ((10, 0.3), (20, 0.9))]
    _write(tmp_path / "clip_000000000003_keypoints.json", {"people": people})
    _write(tmp_path / "clip_000000000004_keypoints.json", {"people": []})
    found = load_keypoints(tmp_path)
    assert found.names == LAYOUTS[25]
    assert list(found.frames) == [3]
    assert np.allclose(found.frames[3][0][0], [20, 20])


EMPTY = ({}, {"keypoints": []}, {"keypoints": None})


@pytest.mark.parametrize("empty", EMPTY, ids=str)
def test_a_coco_annotation_without_keypoints_is_passed_over(
    tmp_path: Path, empty: dict[str, Any]
) -> None:
    one = {"image_id": 3, "keypoints": _person(17, 100, 2)}
    boxes = [{"image_id": image, "bbox": [0, 0, 1, 1], **empty} for image in (3, 4)]
    found = load_keypoints(_write(tmp_path / "a.json", [*boxes, one]))
    assert list(found.frames) == [3]
    assert np.allclose(found.frames[3][0][0], [100, 100])
    with pytest.raises(FormatError, match="anybody"):
        load_keypoints(_write(tmp_path / "b.json", boxes))


def test_an_openpose_person_without_keypoints_is_passed_over(tmp_path: Path) -> None:
    people = [{"pose_keypoints_2d": []}, {}, {"pose_keypoints_2d": _person(25, 20, 0.9)}]
    _write(tmp_path / "clip_000000000003_keypoints.json", {"people": people})
    assert np.allclose(load_keypoints(tmp_path).frames[3][0][0], [20, 20])


def test_images_that_are_no_list_name_no_frames(tmp_path: Path) -> None:
    data = {"images": 5, "annotations": [{"image_id": 8, "keypoints": _person(17, 100, 2)}]}
    assert list(load_keypoints(_write(tmp_path / "a.json", data)).frames) == [8]


@pytest.mark.parametrize("layout", sorted(LAYOUTS))
def test_exchanging_left_and_right_twice_changes_nothing(layout: int) -> None:
    names = LAYOUTS[layout]
    uv, sure = np.arange(2.0 * layout).reshape(-1, 2), np.linspace(0, 1, layout)
    keypoints = Keypoints(names, {0: (uv, sure)})
    once = keypoints.exchanged()
    assert np.allclose(once.frames[0][0][names.index("LKnee")], uv[names.index("RKnee")])
    assert np.allclose(once.frames[0][0][names.index("Nose")], uv[names.index("Nose")])
    assert np.allclose(once.exchanged().frames[0][0], uv)
    assert np.allclose(once.exchanged().frames[0][1], sure)


@pytest.mark.parametrize(
    ("data", "words"),
    [
        ({"what": 1}, "annotations"),
        ([1, 2], "annotations"),
        ([], "nobody|anybody"),
        ([{"keypoints": [1, 2]}], "in turn"),
        ([{"keypoints": ["a", 1, 1]}], "in turn"),
        ([{"keypoints": [10**400, 1, 1] * 17}], "in turn"),
        ([{"keypoints": _person(9, 0, 1)}], "9 keypoints"),
        ([{"keypoints": _person(17, 1e9, 1)}], "nowhere near"),
        ([{"keypoints": _person(17, 0, 0)}], "anybody"),
    ],
)
def test_what_is_no_keypoints_is_refused_in_one_sentence(
    tmp_path: Path, data: Any, words: str
) -> None:
    with pytest.raises(FormatError, match=words) as refused:
        load_keypoints(_write(tmp_path / "a.json", data))
    assert str(refused.value).count("\n") == 0


def test_a_folder_without_openpose_files_and_text_that_is_no_json_are_refused(
    tmp_path: Path,
) -> None:
    with pytest.raises(FormatError, match="holds no file"):
        load_keypoints(tmp_path)
    (tmp_path / "a.json").write_text("[1, 2")
    with pytest.raises(FormatError, match="not JSON"):
        load_keypoints(tmp_path / "a.json")
    with pytest.raises(FormatError, match="no file of keypoints"):
        load_keypoints(tmp_path / "b.json")
