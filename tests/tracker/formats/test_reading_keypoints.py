"""2D keypoints in, as COCO, AlphaPose, OpenPose and MediaPipe write them."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from keypose.tracker.errors import FormatError
from keypose.tracker.formats import reading_keypoints
from keypose.tracker.formats.reading_keypoints import VideoFacts, load_keypoints
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.layouts import LAYOUTS
from tests.tracker.keypoints.people import seen_person


def _person(count: int, offset: float, sure: float) -> list[float]:
    return [value for j in range(count) for value in (offset + j, offset - j, sure)]


def _numbers(uv: Array) -> list[float]:
    """(L, 2), NaN where not seen, as u, v and confidence in turn."""
    seen = np.isfinite(uv).all(-1)
    return [float(x) for x in np.concatenate([np.nan_to_num(uv), seen[:, None]], axis=1).ravel()]


def _write(path: Path, data: Any) -> Path:
    path.write_text(json.dumps(data), encoding="utf-8")
    return path


def _coco(path: Path, uv: Array, **beside: Any) -> Path:
    """People (N, L, 2) as annotations of frames 0 to N - 1."""
    annotations = [{"image_id": n, "keypoints": _numbers(row)} for n, row in enumerate(uv)]
    return _write(path, {"annotations": annotations, **beside})


def _frames(keypoints: Any) -> list[int]:
    """Frames that show anything."""
    seen = (keypoints.visibility > 0).any(axis=1)
    return [int(n) + keypoints.first_frame for n in np.flatnonzero(seen)]


def test_a_list_of_coco_annotations_is_read_by_image_id(tmp_path: Path) -> None:
    numbers = _person(17, 100, 2)
    numbers[3 * 9 + 2] = 0  # left wrist: not labelled
    path = _write(tmp_path / "a.json", [{"image_id": 12, "keypoints": numbers}])
    found = load_keypoints(path)
    assert found.names == LAYOUTS["COCO_17"]
    assert (found.first_frame, len(found)) == (12, 1)
    assert np.allclose(found.uv[0, 0], [100, 100])
    assert np.isnan(found.uv[0, 9]).all()
    assert found.visibility[0, 9] == 0
    assert found.visibility[0, 0] == 1


def test_frames_between_are_there_and_unseen(tmp_path: Path) -> None:
    data = [{"image_id": f"{n:03}.png", "keypoints": _person(17, 100, 2)} for n in (4, 9, 7)]
    found = load_keypoints(_write(tmp_path / "a.json", data))
    assert (found.first_frame, found.last_frame) == (4, 9)
    assert _frames(found) == [4, 7, 9]
    assert np.isnan(found.uv[1]).all()


def test_coco_images_and_categories_say_frames_and_names(tmp_path: Path) -> None:
    data = {
        "images": [{"id": 7, "file_name": "clip/frame_0031.png"}],
        "categories": [{"keypoints": ["left_knee", "RKnee"]}],
        "annotations": [{"image_id": 7, "keypoints": [1, 2, 2, 3, 4, 1]}],
    }
    found = load_keypoints(_write(tmp_path / "a.json", data))
    assert found.names == ("left_knee", "right_knee")
    assert _frames(found) == [31]


def test_openpose_files_are_frames_and_the_surest_person_counts(tmp_path: Path) -> None:
    people = [{"pose_keypoints_2d": _person(18, o, s)} for o, s in ((10, 0.3), (20, 0.9))]
    _write(tmp_path / "clip_000000000003_keypoints.json", {"people": people})
    _write(tmp_path / "clip_000000000004_keypoints.json", {"people": []})
    found = load_keypoints(tmp_path)
    assert found.names == LAYOUTS["OPENPOSE_18"]
    assert _frames(found) == [3]
    assert np.allclose(found.uv[0, 0], [20, 20])
    assert np.allclose(found.visibility, 0.9)


EMPTY = ({}, {"keypoints": []}, {"keypoints": None})


@pytest.mark.parametrize("empty", EMPTY, ids=str)
def test_a_coco_annotation_without_keypoints_is_passed_over(
    tmp_path: Path, empty: dict[str, Any]
) -> None:
    one = {"image_id": 3, "keypoints": _person(17, 100, 2)}
    boxes = [{"image_id": image, "bbox": [0, 0, 1, 1], **empty} for image in (3, 4)]
    found = load_keypoints(_write(tmp_path / "a.json", [*boxes, one]))
    assert _frames(found) == [3]
    assert np.allclose(found.uv[0, 0], [100, 100])
    with pytest.raises(FormatError, match="anybody"):
        load_keypoints(_write(tmp_path / "b.json", boxes))


def test_openpose_files_in_one_list_are_those_of_the_folder(tmp_path: Path) -> None:
    folder, listed = tmp_path / "seen", []
    folder.mkdir()
    for frame in (3, 5):
        name = f"walk_{frame:012}_keypoints.json"
        message = {"people": [{"pose_keypoints_2d": _person(18, 10.0 * frame, 0.5)}]}
        _write(folder / name, message)
        listed.append({**message, "file_name": name})
    ours = load_keypoints(_write(tmp_path / "seen.json", listed))
    theirs = load_keypoints(folder)
    assert _frames(ours) == _frames(theirs) == [3, 5]
    assert ours.names == theirs.names
    np.testing.assert_array_equal(ours.uv, theirs.uv)


def test_an_openpose_person_without_keypoints_is_passed_over(tmp_path: Path) -> None:
    people = [{"pose_keypoints_2d": []}, {}, {"pose_keypoints_2d": _person(18, 20, 0.9)}]
    path = _write(tmp_path / "clip_000000000003_keypoints.json", {"people": people})
    for place in (tmp_path, path):
        found = load_keypoints(place)
        assert _frames(found) == [3]
        assert np.allclose(found.uv[0, 0], [20, 20])


def test_images_that_are_no_list_name_no_frames(tmp_path: Path) -> None:
    data = {"images": 5, "annotations": [{"image_id": 8, "keypoints": _person(17, 100, 2)}]}
    assert _frames(load_keypoints(_write(tmp_path / "a.json", data))) == [8]


@pytest.mark.parametrize("layout", LAYOUTS)
def test_every_layout_comes_back_as_it_was_written(tmp_path: Path, layout: str) -> None:
    uv = seen_person(layout, np.random.default_rng(7), frames=6, missing=0.1)
    found = load_keypoints(_coco(tmp_path / "a.json", uv))
    assert found.names == LAYOUTS[layout]
    assert np.array_equal(found.uv, uv, equal_nan=True)
    assert np.array_equal(found.visibility, np.isfinite(uv).all(-1))
    named = load_keypoints(_coco(tmp_path / "b.json", uv), layout)
    assert named.names == found.names


@pytest.mark.parametrize("layout", LAYOUTS)
def test_exchanging_left_and_right_twice_changes_nothing(tmp_path: Path, layout: str) -> None:
    uv = seen_person(layout, np.random.default_rng(8))
    keypoints = load_keypoints(_coco(tmp_path / "a.json", uv))
    names, once = keypoints.names, keypoints.exchanged()
    left, right, nose = (names.index(n) for n in ("left_knee", "right_knee", "nose"))
    assert np.array_equal(once.uv[:, left], keypoints.uv[:, right])
    assert np.array_equal(once.uv[:, nose], keypoints.uv[:, nose])
    assert np.array_equal(once.exchanged().uv, keypoints.uv, equal_nan=True)


# --- layouts


@pytest.mark.parametrize("layout", ["BODY_25", "BODY_25B"])
def test_names_in_the_file_win_over_what_the_limbs_look_like(tmp_path: Path, layout: str) -> None:
    other = {"BODY_25": "BODY_25B", "BODY_25B": "BODY_25"}[layout]
    uv = seen_person(other, np.random.default_rng(9), frames=4)
    given = {"categories": [{"name": "person", "keypoints": list(LAYOUTS[layout])}]}
    path = _coco(tmp_path / "a.json", uv, **given)
    assert load_keypoints(path).names == LAYOUTS[layout]
    assert load_keypoints(path, layout).names == LAYOUTS[layout]
    with pytest.raises(FormatError, match="names its keypoints itself"):
        load_keypoints(path, other)


def test_a_layout_that_is_not_clear_is_asked_for(tmp_path: Path) -> None:
    uv = np.random.default_rng(10).uniform(0, 500, (3, 25, 2))
    path = _coco(tmp_path / "a.json", uv)
    with pytest.raises(FormatError, match="BODY_25 or BODY_25B"):
        load_keypoints(path)
    for layout in ("BODY_25", "BODY_25B"):
        assert load_keypoints(path, layout).names == LAYOUTS[layout]
    with pytest.raises(FormatError, match=r"25 keypoints .* not COCO_17"):
        load_keypoints(path, "COCO_17")
    with pytest.raises(FormatError, match="no layout 'body'"):
        load_keypoints(path, "body")


# --- MediaPipe


def _landmarks(uv: Array) -> list[dict[str, float]]:
    return [{"x": u, "y": v, "z": 0.1, "visibility": 0.8} for u, v in uv.tolist()]


def _as_lists(uv: Array) -> list[list[float]]:
    return [[u, v, 0.1, 0.8] for u, v in uv.tolist()]


def _mediapipe(uv: Array) -> Sequence[Any]:
    """The same two frames in every form that results are saved in."""
    a, b = (_landmarks(row) for row in uv)
    return (
        {"frames": [{"poseLandmarks": a}, {"poseLandmarks": b}]},
        {"frames": [{"pose_landmarks": [a]}, {"pose_landmarks": [b], "pose_world_landmarks": []}]},
        [{"landmarks": [a], "worldLandmarks": []}, {"landmarks": [b]}],
        [{"pose_landmarks": {"landmark": a}}, {"pose_landmarks": {"landmark": b}}],
        [{"frame_index": 1, "landmark": b}, {"frame_index": 0, "landmark": a}],
        [a, b],
        [[a], [b]],
        [_as_lists(row) for row in uv],
    )


@pytest.mark.parametrize("form", range(8))
def test_mediapipe_landmarks_are_read_in_every_form(tmp_path: Path, form: int) -> None:
    uv = np.nan_to_num(seen_person("MEDIAPIPE_33", np.random.default_rng(11), 2), nan=50.0)
    found = load_keypoints(_write(tmp_path / "a.json", _mediapipe(uv)[form]))
    assert found.names == LAYOUTS["MEDIAPIPE_33"]
    assert (found.first_frame, len(found)) == (0, 2)
    assert np.allclose(found.uv, uv)
    assert np.allclose(found.visibility, 0.8)


def test_one_frame_and_frames_without_anybody_are_read(tmp_path: Path) -> None:
    uv = np.nan_to_num(seen_person("MEDIAPIPE_33", np.random.default_rng(12))[0], nan=50.0)
    found = load_keypoints(_write(tmp_path / "a.json", {"poseLandmarks": _landmarks(uv)}))
    assert _frames(found) == [0]
    frames = [{"landmarks": []}, {"landmarks": None}, {}, {"landmarks": [_landmarks(uv)]}]
    found = load_keypoints(_write(tmp_path / "b.json", frames))
    assert _frames(found) == [3]


@pytest.mark.parametrize("about", [{}, {"metadata": {"fps": 30}}])
def test_shares_of_an_unknown_size_are_refused(tmp_path: Path, about: dict[str, Any]) -> None:
    shares = np.random.default_rng(13).uniform(0, 1, (33, 2))
    data = {"frames": [{"poseLandmarks": _landmarks(shares)}], **about}
    with pytest.raises(FormatError, match="width and height"):
        load_keypoints(_write(tmp_path / "a.json", data))


@pytest.mark.parametrize("beside", [None, "metadata", "info", "video"])
def test_shares_become_pixels_by_the_size_in_the_file(tmp_path: Path, beside: str | None) -> None:
    shares = np.random.default_rng(14).uniform(0, 1, (33, 2))
    shares[:2] = (0.0, 0.0), (1.0, 1.0)
    size = {"width": 640, "height": 360}
    data = {"frames": [_landmarks(shares)], **(size if beside is None else {beside: size})}
    uv = load_keypoints(_write(tmp_path / "a.json", data)).uv[0]
    assert np.allclose(uv[0], [-0.5, -0.5])  # the picture's edges, as centres are at integers
    assert np.allclose(uv[1], [639.5, 359.5])


# --- what is wrong


@pytest.mark.parametrize(
    ("data", "words"),
    [
        ({"what": 1}, "form that is known"),
        ([1, 2], "form that is known"),
        ([], "anybody"),
        ([[]], "form that is known"),
        ([{"keypoints": [1, 2]}], "in turn"),
        ([{"keypoints": ["a", 1, 1]}], "in turn"),
        ([{"keypoints": [[1, 2, 1]] * 17}], "in turn"),
        ([{"keypoints": {"nose": [1, 2, 1]}}], "form that is known"),
        ([[{"keypoints": {"x": [1], "y": [2]}}]], "form that is known"),
        ({"keypoints": [{"0": [[1, 2, 1]]}], "skeleton": {}}, "form that is known"),
        ([{"frame_id": -1, "instances": []}], "numbered -1"),
        ([{"frame_id": 1, "instances": [{"keypoints": [1]}]}], "form that is known"),
        ([{"keypoints": [10**400, 1, 1] * 17}], "in turn"),
        ([{"keypoints": _person(9, 0, 1)}], "9 keypoints"),
        ([{"keypoints": _person(17, 1e9, 1)}], "nowhere near"),
        ([{"keypoints": _person(17, float("nan"), 1)}], "not a finite number"),
        ([{"keypoints": _person(17, 5, float("inf"))}], "not a finite number"),
        ([{"keypoints": _person(17, 0, 0)}], "anybody"),
        ([{"keypoints": _person(n, 9, 1), "image_id": n} for n in (17, 26)], "of 17 and of 26"),
        ([{"keypoints": _person(17, 9, 1), "image_id": n} for n in (1, 9**9)], "too many frames"),
        (
            {
                "annotations": [{"keypoints": _person(17, 9, 1)}],
                "categories": [{"keypoints": ["nose", "left_eye"]}],
            },
            "17 keypoints and names 2",
        ),
        (
            {
                "annotations": [{"keypoints": _person(2, 9, 1)}],
                "categories": [{"keypoints": ["LEye", "left_eye"]}],
            },
            "left_eye twice",
        ),
        ({"people": 1}, "lists no people"),
        ({"frames": 3}, "no list of frames"),
        ({"frames": []}, "anybody"),
        ({"frames": [{"frame": "x", "landmarks": []}]}, "numbered 'x'"),
        ({"frames": [{"frame": -2, "landmarks": []}]}, "numbered -2"),
        ({"landmarks": [{"x": 1.0, "y": 2.0}] * 21}, "21 keypoints; known are 33"),
        ({"landmarks": [{"x": 1.0}] * 33}, "x, y, z and visibility"),
        ({"landmarks": [[1, 2, 3]] * 33}, "x, y, z and visibility"),
        ({"landmarks": [{"x": "a", "y": 1}] * 33}, "in turn"),
        ({"landmarks": [[[[{"x": 1, "y": 1}]]]]}, "list for each person"),
        ({"landmarks": 7}, "list for each person"),
    ],
)
def test_what_is_no_keypoints_is_refused_in_one_sentence(
    tmp_path: Path, data: Any, words: str
) -> None:
    with pytest.raises(FormatError, match=words) as refused:
        load_keypoints(_write(tmp_path / "a.json", data))
    assert str(refused.value).count("\n") == 0


VIDEO = VideoFacts(100, 640, 360, 30.0)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"images": [{"id": 5, "width": 320, "height": 180}]}, "320 × 180 .* 640 × 360"),
        ({"width": 360, "height": 640}, "360 × 640"),
        (
            {"images": [{"id": 5, "width": 640, "height": 360}], "width": 320, "height": 180},
            "different sizes",
        ),
        ({"info": {"fps": 25}}, "25 frames a second; this one has 30"),
        ({"annotations": [{"image_id": 100, "keypoints": _person(17, 9, 1)}]}, "0 to 99"),
    ],
)
def test_keypoints_of_another_video_are_refused(
    tmp_path: Path, changes: dict[str, Any], words: str
) -> None:
    data = {"annotations": [{"image_id": 5, "keypoints": _person(17, 9, 1)}], **changes}
    with pytest.raises(FormatError, match=words):
        load_keypoints(_write(tmp_path / "a.json", data), video=VIDEO)


def test_the_same_video_is_reported_by_its_size_and_rate(tmp_path: Path) -> None:
    data = {
        "info": {"fps": 29.97},
        "images": [{"id": 5, "width": 640, "height": 360}, {"id": 6, "width": 1, "height": 1}],
        "annotations": [{"image_id": 5, "keypoints": _person(17, 9, 1)}],
    }
    assert _frames(load_keypoints(_write(tmp_path / "a.json", data), video=VIDEO)) == [5]


def test_too_large_a_file_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = _write(tmp_path / "a.json", [{"keypoints": _person(17, 9, 1)}])
    monkeypatch.setattr("keypose.tracker.formats.keypoint_files.LARGEST_KEYPOINT_BYTES", 9)
    with pytest.raises(FormatError, match="too large"):
        load_keypoints(path)
    monkeypatch.undo()
    monkeypatch.setattr(reading_keypoints, "MOST_NUMBERS", 16)
    with pytest.raises(FormatError, match="too many frames"):
        load_keypoints(path)


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
