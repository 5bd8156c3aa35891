"""Whether the camera stands still: chosen by a person, or as it was found in the film."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from keypose.app.document.new import new_session
from keypose.app.jobs.rerun import with_settings
from keypose.app.orders.tracking import TrackOrder
from keypose.tracker.session import Session, TrackSettings
from keypose.tracker.storage.files import load_session, save_session
from keypose.tracker.storage.fingerprints import segment_keys
from keypose.tracker.video import Video
from tests.tracker import session_cases as cases
from tests.tracker.session_cases import written

BALANCE = Path(__file__).parents[3] / "sample_videos" / "balance"


def session(chosen: bool | None, found: bool | None) -> Session:
    of = cases.session()
    return of.changed(
        {
            "settings": TrackSettings(static_camera=chosen),
            "video": of.view.video.model_copy(update={"stands_still": found}),
        }
    )


@pytest.mark.parametrize("found", [None, False, True])
def test_what_a_person_chose_counts_whatever_was_found(found: bool | None) -> None:
    for chosen in (False, True):
        assert session(chosen, found).has_static_camera is chosen
        assert segment_keys(session(chosen, found)) == segment_keys(session(chosen, None))


def test_where_nobody_chose_it_is_as_found_and_the_results_are_those_of_that_choice() -> None:
    for found in (False, True):
        assert session(None, found).has_static_camera is found
        assert segment_keys(session(None, found)) == segment_keys(session(found, None))


def test_where_nobody_chose_and_nobody_looked_it_is_no_static_camera() -> None:
    """As in sessions of before it was looked for."""
    assert segment_keys(session(None, None)) == segment_keys(session(False, None))


def test_an_older_session_keeps_its_choice_and_gains_no_field(tmp_path: Path) -> None:
    for chosen in (False, True):
        path = tmp_path / "session.json"
        save_session(session(chosen, None), path)
        data = written(path)
        assert data["settings"]["static_camera"] is chosen
        assert "stands_still" not in data["video"]
        assert load_session(path).has_static_camera is chosen


def test_a_new_session_knows_what_was_found_and_leaves_the_choice_open(tmp_path: Path) -> None:
    path = tmp_path / "session.json"
    with Video.open(BALANCE / "balance.mp4") as video:
        begun = new_session(video, path)
    assert begun.settings.static_camera is None
    assert begun.view.video.stands_still is True
    save_session(begun, path)
    assert load_session(path) == begun


def test_the_session_of_a_film_that_shakes_is_begun_without(tmp_path: Path) -> None:
    (tmp_path / "frames").mkdir()
    rng = np.random.default_rng(0)
    for k in range(8):
        noise = rng.integers(0, 256, (96, 128, 3)).astype(np.uint8)
        cv2.imwrite(str(tmp_path / "frames" / f"{k}.png"), noise)
    with Video.open(tmp_path / "frames") as video:
        begun = new_session(video, tmp_path / "session.json")
    assert begun.view.video.stands_still is False
    assert not begun.has_static_camera


def test_a_run_may_choose_otherwise_and_the_session_keeps_its_own() -> None:
    of = session(None, True)
    assert not with_settings(of, TrackOrder(static_camera=False)).has_static_camera
    assert with_settings(of, TrackOrder()).settings.static_camera is None
