"""What is said of the people that were found, and of their drafts."""

from __future__ import annotations

from keypose.app.words.people import flipped_words
from keypose.tracker.session.annotations import FlippedDrafts


def test_drafts_that_are_wrong_are_named_with_their_limbs_and_frames() -> None:
    runs = [
        FlippedDrafts(first_frame=16, last_frame=23, parts=("left_thigh",)),
        FlippedDrafts(first_frame=40, last_frame=40, parts=("left_thigh", "right_thigh")),
    ]
    words = flipped_words(runs)
    assert "left thigh, frames 16–23; left thigh and right thigh, frame 40." in words
    assert flipped_words([]) == ""
