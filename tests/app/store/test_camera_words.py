"""What is doubtful about a camera's motion is said with its frames, in a sentence each."""

from __future__ import annotations

from typing import get_args

import pytest

from keypose.app.words.camera import finding_sentence
from keypose.tracker.session.camera_motion import CameraFinding

KINDS = get_args(CameraFinding.model_fields["kind"].annotation)


@pytest.mark.parametrize("kind", KINDS)
def test_every_finding_has_a_sentence(kind: str) -> None:
    found = CameraFinding.model_validate({"kind": kind, "first_frame": 3, "last_frame": 9})
    said = finding_sentence(found)
    assert said.endswith(".")
    assert "{" not in said


def test_a_rolling_shutter_says_whether_it_is_taken_out() -> None:
    said = [
        finding_sentence(
            CameraFinding(kind="rolling_shutter", first_frame=0, last_frame=9, amount=amount)
        )
        for amount in (0.6, 0.0)
    ]
    assert "60%" in said[0]
    assert "not freed" in said[1]
