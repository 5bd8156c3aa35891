"""The cache of detections: what was kept comes back, what is damaged does not."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from keypose.tracker.keypoints.detect import DetectionWindow, Seed, detect
from keypose.tracker.storage.archive import archive_bytes
from keypose.tracker.storage.cache import Detections
from tests.tracker.keypoints.keypoint_cases import Walker, body_at, numbered, true_x

FRAMES = (0, 80)


def found(folder: Path) -> tuple[np.ndarray, int]:
    """uv, and how often the network had to look."""
    walker = Walker(hidden=frozenset([50, 51]))
    seed = Seed(0, body_at(true_x(0), 120))
    keypoints = detect(numbered, FRAMES, [seed], walker, film="a", kept=Detections(folder))
    return keypoints.uv, len(walker.looked)


def stretch(rows: int = 2) -> DetectionWindow:
    uv, p = np.zeros((rows, 33, 2)), np.zeros((rows, 33, 3))
    lost_for = np.zeros(rows, dtype=np.int64)
    return DetectionWindow(uv, np.ones((rows, 33)), p, np.ones((rows, 4)), lost_for)


def test_what_was_found_before_is_not_looked_for_again(tmp_path: Path) -> None:
    first, looks = found(tmp_path / "kept")
    again, none = found(tmp_path / "kept")
    assert looks > FRAMES[1]
    assert none == 0
    assert np.array_equal(first, again, equal_nan=True)


@pytest.mark.parametrize("damage", [b"", b"no archive", archive_bytes({"uv": np.zeros(3)})])
def test_a_damaged_file_is_made_anew(tmp_path: Path, damage: bytes) -> None:
    first, _ = found(tmp_path)
    files = list(tmp_path.glob("*.npz"))
    before = {path: path.read_bytes() for path in files}
    for path in files:
        path.write_bytes(damage)
    again, looks = found(tmp_path)
    assert looks > FRAMES[1]
    assert np.array_equal(first, again, equal_nan=True)
    assert {path: path.read_bytes() for path in files} == before


def test_a_truncated_file_or_a_link_is_no_stretch(tmp_path: Path) -> None:
    kept = Detections(tmp_path)
    kept.put("a", stretch())
    content = (tmp_path / "a.npz").read_bytes()
    (tmp_path / "b.npz").write_bytes(content[:-30])
    (tmp_path / "c.npz").symlink_to(tmp_path / "a.npz")
    assert kept.get("a") is not None
    assert [kept.get(key) for key in "bcd"] == [None, None, None]


def test_what_was_used_longest_ago_goes_first(tmp_path: Path) -> None:
    size = len(archive_bytes(vars(stretch())))
    kept = Detections(tmp_path, most_bytes=3 * size)
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
