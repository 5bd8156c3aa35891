"""In how many frames a session's network looks for the person."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from keypose.tracker.storage.files import load_session
from keypose.tracker.storage.tracking import keypoint_source
from tests.tracker.keypoints.keypoint_cases import BALANCE

BOTH, ALL = ("brightness", "keypoints"), ("brightness", "keypoints", "silhouette")


@pytest.mark.parametrize(
    ("fps", "network", "cues", "still", "every_second"),
    [
        (60.0, "thunder", BOTH, True, True),
        (60.0, "thunder", ALL, True, True),
        (60.0, "thunder", ALL, False, False),  # each frame's mask judges
        (30.0, "thunder", BOTH, True, False),
        (60.0, "full", BOTH, True, False),  # as in sessions of before
    ],
)
def test_quick_films_are_looked_at_in_every_second_frame_where_no_mask_is_needed(
    fps: float, network: str, cues: tuple[str, ...], still: bool, every_second: bool
) -> None:
    session = load_session(BALANCE / "session.json")
    changed = {"network": network, "cues": cues, "static_camera": still}
    settings = session.settings.model_copy(update=changed)
    video: Any = SimpleNamespace(info=SimpleNamespace(fps=fps))
    source: Any = keypoint_source(session.changed({"settings": settings}), video, None)
    assert source.every_second is every_second
