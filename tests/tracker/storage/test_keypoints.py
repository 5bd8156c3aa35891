"""Keypoints beside a session: written once, read whole or refused, taken along."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from keypose.app.document.open import copy_session
from keypose.tracker.errors import KeypointError
from keypose.tracker.keypoints.keypoints import JOINTS, Keypoints
from keypose.tracker.keypoints.person_mask import MASK_SIDE, PersonMask
from keypose.tracker.keypoints.region import Region
from keypose.tracker.session import Session
from keypose.tracker.storage.archive import archive_bytes
from keypose.tracker.storage.files import load_session, save_session
from keypose.tracker.storage.mask_arrays import arrays_of_masks
from keypose.tracker.storage.sidecars import keypoints_of_session, load_keypoints, save_keypoints
from tests.tracker import session_cases as cases

FRAMES = 6


def keypoints(*, depth: bool = True, first_frame: int = 1) -> Keypoints:
    rng = np.random.default_rng(4)
    uv = rng.uniform(0, 60, (FRAMES, len(JOINTS), 2))
    visibility = rng.uniform(0, 1, uv.shape[:2])
    p_hips = rng.normal(size=(*uv.shape[:2], 3))
    uv[2], visibility[2], p_hips[2] = np.nan, 0, np.nan
    return Keypoints(first_frame, JOINTS, uv, visibility, p_hips if depth else None)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    place = tmp_path / "session.json"
    save_session(cases.session(), place)
    return place


def saved(path: Path, found: Keypoints) -> Session:
    session = save_keypoints(load_session(path), path, found, "full", network="a", seeds=(4, 1, 4))
    save_session(session, path)
    return load_session(path)


@pytest.mark.parametrize("depth", [True, False])
def test_saved_keypoints_come_back(path: Path, depth: bool) -> None:
    given = keypoints(depth=depth)
    session = saved(path, given)
    assert session.view.keypoints is not None
    assert (session.view.keypoints.source, session.view.keypoints.seeds) == ("full", (1, 4))
    found = keypoints_of_session(session, path.parent)
    assert found is not None
    assert (found.first_frame, found.names) == (given.first_frame, given.names)
    np.testing.assert_allclose(found.uv, given.uv, rtol=1e-6)
    np.testing.assert_allclose(found.visibility, given.visibility, rtol=1e-6)
    if given.p_hips is None:
        assert found.p_hips is None
    else:
        np.testing.assert_allclose(found.p_hips, given.p_hips, rtol=1e-6)


def masked(found: Keypoints) -> Keypoints:
    """With an outline in each frame that shows somebody."""
    share = np.zeros((MASK_SIDE, MASK_SIDE))
    share[40:200, 90:160] = 0.8
    masks = [
        None if np.isnan(uv).any() else PersonMask.of(Region(30.0 + n, 20.0, 90.0, 0.1), share)
        for n, uv in enumerate(found.uv)
    ]
    return replace(found, masks=tuple(masks))


def test_outlines_come_back_in_the_frames_that_have_one(path: Path) -> None:
    given = masked(keypoints())
    session = saved(path, given)
    found = keypoints_of_session(session, path.parent)
    assert found is not None
    assert found.masks == given.masks
    assert session.view.keypoints is not None
    assert session.view.keypoints.masks
    assert given.masks is not None
    some = replace(given, masks=(None, *given.masks[1:]))
    assert not saved(path, some).view.keypoints.masks  # type: ignore[union-attr]


def test_equal_keypoints_are_one_file(path: Path) -> None:
    assert saved(path, keypoints()).view.keypoints == saved(path, keypoints()).view.keypoints
    assert len(list(path.parent.glob("keypoints-*.npz"))) == 1


def test_a_session_without_keypoints_is_saved_as_before_there_were_any(path: Path) -> None:
    assert "keypoints" not in json.loads(path.read_text("utf-8"))
    assert keypoints_of_session(load_session(path), path.parent) is None


def test_missing_or_damaged_keypoints_are_reported_in_one_sentence(path: Path) -> None:
    session = saved(path, keypoints())
    assert session.view.keypoints is not None
    place = path.parent / session.view.keypoints.file
    place.write_bytes(place.read_bytes()[:-40])
    with pytest.raises(KeypointError, match="damaged"):
        keypoints_of_session(session, path.parent)
    place.unlink()
    with pytest.raises(KeypointError, match=r"cannot be read.*find them again"):
        keypoints_of_session(session, path.parent)


def test_keypoints_of_a_longer_film_are_reported(path: Path) -> None:
    count = load_session(path).view.video.frame_count
    session = saved(path, keypoints(first_frame=count - 2))
    with pytest.raises(KeypointError, match=f"the video ends at {count - 1}"):
        keypoints_of_session(session, path.parent)


GOOD = {
    "first_frame": np.array(0),
    "names": np.array(["nose", "left_knee"]),
    "uv": np.zeros((3, 2, 2)),
    "visibility": np.ones((3, 2)),
}


MASKED = arrays_of_masks([None, None, None])


@pytest.mark.parametrize(
    "wrong",
    [
        {"uv": np.zeros((3, 1, 2))},
        {"uv": np.full((3, 2, 2), np.nan)},
        {"uv": np.array("text")},
        {"visibility": np.full((3, 2), np.nan)},
        {"visibility": np.full((3, 2), 1.5)},
        {"names": np.array(["nose", "nose"])},
        {"first_frame": np.array(-1)},
        {"p_hips": np.zeros((3, 2, 2))},
        {**MASKED, "lengths": np.array([-1, 1, 0])},
        {**MASKED, "lengths": np.array([4, 0, 0])},
        {**MASKED, "packed": np.frombuffer(b"torn", np.uint8), "lengths": np.array([4, 0, 0])},
        {**MASKED, "looked": np.zeros((2, 4))},
        {name: rows[:2] for name, rows in MASKED.items()},
    ],
)
def test_an_archive_of_something_else_is_refused(
    tmp_path: Path, wrong: dict[str, np.ndarray], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        "keypose.tracker.storage.sidecars._keypoints_name", lambda content: "given.npz"
    )
    place = tmp_path / "given.npz"
    place.write_bytes(archive_bytes(GOOD))
    assert len(load_keypoints(place)) == 3
    place.write_bytes(archive_bytes({**GOOD, **MASKED}))
    assert load_keypoints(place).masks == (None, None, None)
    place.write_bytes(archive_bytes({**GOOD, **wrong}))
    with pytest.raises(KeypointError, match="damaged"):
        load_keypoints(place)


def test_a_copied_session_takes_its_keypoints_along(path: Path, tmp_path: Path) -> None:
    saved(path, keypoints())
    copied = copy_session(path, tmp_path / "copy")
    found = keypoints_of_session(load_session(copied), copied.parent)
    assert found is not None
    assert found.names == JOINTS
