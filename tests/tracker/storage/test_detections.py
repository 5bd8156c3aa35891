"""The cache of detections: what was kept comes back, what is damaged does not."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from keypose.tracker.keypoints.detect import DetectionWindow, Seed, detect
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.storage.archive import archive_arrays, archive_bytes
from keypose.tracker.storage.cache import Detections
from tests.tracker.keypoints.keypoint_cases import NO_MASK, Walker, body_at, numbered, true_x

FRAMES = (0, 80)


def found(folder: Path) -> tuple[Keypoints, int]:
    """What is seen, and how often the network had to look."""
    walker = Walker(hidden=frozenset([50, 51]))
    seed = Seed(0, body_at(true_x(0), 120))
    keypoints = detect(numbered, FRAMES, [seed], walker, film="a", kept=Detections(folder))
    return keypoints, len(walker.looked)


def same(one: Keypoints, other: Keypoints) -> bool:
    return np.array_equal(one.uv, other.uv, equal_nan=True) and one.masks == other.masks


def stretch(rows: int = 2) -> DetectionWindow:
    uv, p = np.zeros((rows, 33, 2)), np.zeros((rows, 33, 3))
    lost_for = np.zeros(rows, dtype=np.int64)
    regions, masks = np.ones((rows, 4)), (NO_MASK,) * rows
    return DetectionWindow(uv, np.ones((rows, 33)), p, regions, lost_for, masks)


def test_what_was_found_before_is_not_looked_for_again(tmp_path: Path) -> None:
    first, looks = found(tmp_path / "kept")
    again, none = found(tmp_path / "kept")
    assert looks > FRAMES[1]
    assert none == 0
    assert same(first, again)


@pytest.mark.parametrize("damage", [b"", b"no archive", archive_bytes({"uv": np.zeros(3)})])
def test_a_damaged_file_is_made_anew(tmp_path: Path, damage: bytes) -> None:
    first, _ = found(tmp_path)
    files = list(tmp_path.glob("*.npz"))
    before = {path: path.read_bytes() for path in files}
    for path in files:
        path.write_bytes(damage)
    again, looks = found(tmp_path)
    assert looks > FRAMES[1]
    assert same(first, again)
    assert {path: path.read_bytes() for path in files} == before


def test_a_truncated_file_or_a_link_is_no_stretch(tmp_path: Path) -> None:
    kept = Detections(tmp_path)
    kept.put("a", stretch())
    content = (tmp_path / "a.npz").read_bytes()
    (tmp_path / "b.npz").write_bytes(content[:-30])
    (tmp_path / "c.npz").symlink_to(tmp_path / "a.npz")
    assert kept.get("a") is not None
    assert [kept.get(key) for key in "bcd"] == [None, None, None]


@pytest.mark.parametrize(
    "changed",
    [
        {"looked": None, "packed": None, "lengths": None},
        {"lengths": np.array([0, 1], dtype=np.int64)},
        {"lengths": np.array([-1, 2], dtype=np.int64)},
        {"packed": np.zeros(2, np.uint8), "lengths": np.array([1, 1], dtype=np.int64)},
        {"looked": np.ones((1, 4))},
        {"looked": np.full((2, 4), np.nan)},
    ],
)
def test_a_stretch_without_the_masks_of_its_frames_is_none(
    tmp_path: Path, changed: dict[str, np.ndarray | None]
) -> None:
    kept, place = Detections(tmp_path), tmp_path / "a.npz"
    kept.put("a", stretch())
    arrays = {**archive_arrays(place.read_bytes()), **changed}
    place.write_bytes(archive_bytes({n: a for n, a in arrays.items() if a is not None}))
    assert kept.get("a") is None


def test_what_was_used_longest_ago_goes_first(tmp_path: Path) -> None:
    Detections(tmp_path).put("a", stretch())
    kept = Detections(tmp_path, most_bytes=3 * (tmp_path / "a.npz").stat().st_size)
    for age, key in enumerate("abc"):
        kept.put(key, stretch())
        os.utime(tmp_path / f"{key}.npz", (age, age))
    assert kept.get("a") is not None  # used now
    kept.put("d", stretch())
    assert {path.stem for path in tmp_path.glob("*.npz")} == {"a", "c", "d"}


def test_a_folder_that_cannot_be_made_keeps_nothing_and_harms_nothing(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    _, looks = found(tmp_path / "file" / "kept")
    assert looks > FRAMES[1]
