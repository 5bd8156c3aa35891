"""What is up is said with its figure and its doubt, and both ways where they disagree."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.app.words.up import nothing_words, unsure_words, up_words
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.geometry.up import UpEvidence, UpSource, combined


def evidence(tilt: float, roll: float, sigma_deg: float, source: UpSource) -> UpEvidence:
    turn = exp_rotation(np.radians([tilt, 0.0, roll]))
    return UpEvidence.of(turn @ [0.0, -1.0, 0.0], np.radians(sigma_deg), source)


def sloping(roll: float, tilt: float, source: UpSource) -> UpEvidence:
    """Sure of the roll to 1°, of the tilt to 20°."""
    x, z = np.sin(np.radians([roll, tilt]))
    spread = np.diag(np.radians([1.0, 1.0, 20.0]) ** 2)
    return UpEvidence.with_covariance(np.array([x, -np.sqrt(1 - x * x - z * z), z]), spread, source)


SAID = {
    "sure": (
        [evidence(3, 0, 0.9, "lines")], "The camera looks down by 3° ± 2°, by upright lines."
    ),
    "level": ([evidence(0, 0, 0.9, "lines")], "The camera is level to ± 2°, by upright lines."),
    "less sure": (
        [evidence(-3, 0, 3.0, "person")],
        "The camera looks up by 3° ± 6°, by how the person stands. Draw the horizon to be surer.",
    ),
    "two that agree": (
        [evidence(3, 0, 1.0, "lines"), evidence(4, 0, 2.0, "feet")],
        "The camera looks down by 3° ± 2°, by upright lines and where the feet stand.",
    ),
    "two that disagree": (
        [evidence(3, 0, 1.0, "lines"), evidence(12, 0, 1.5, "person")],
        "Upright lines say the camera looks down by 3° ± 2°, how the person stands says 12° ± 3°. "
        "Upright lines are used.",
    ),
    "the other way": (
        [evidence(3, 0, 1.0, "lines"), evidence(-12, 0, 1.5, "person")],
        "Upright lines say the camera looks down by 3° ± 2°, how the person stands says it looks "
        "up by 12° ± 3°. Upright lines are used.",
    ),
    "in the one that is known, not in the one that is farther off": (
        [evidence(0, 0, 1.0, "lines"), sloping(6, 9, "feet")],
        "Upright lines say the camera does not lean ± 2°, where the feet stand says it leans left "
        "by 6° ± 2°. Upright lines are used.",
    ),
    "in roll": (
        [evidence(3, 15, 1.0, "lines"), evidence(3, 0, 1.5, "person")],
        "Upright lines say the camera leans left by 15° ± 2°, how the person stands says it does "
        "not lean ± 3°. Upright lines are used.",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", SAID)
def test_it_says_what_it_rests_on_how_sure_it_is_and_what_disagrees(case: str) -> None:
    sources, words = SAID[case]
    found = combined(sources)
    assert found is not None
    assert up_words(found) == words


@pytest.mark.parametrize("tilt", [0, 30, 60])
def test_what_is_said_as_doubt_of_a_tilt_is_an_angle_however_far_a_camera_looks_down(
    tilt: float,
) -> None:
    ways = [evidence(tilt, 0, 3.0, "lines"), evidence(tilt + 25, 0, 3.0, "person")]
    found = combined(ways)
    assert found is not None
    words = up_words(found)
    assert words.count(" ± 6°") == 2, words


def test_lines_that_are_unsure_are_told_from_none() -> None:
    assert "no better than ± 12°" in unsure_words(evidence(0, 0, 6.0, "lines"))
    assert "no better than ± 90°" in unsure_words(evidence(0, 0, 600.0, "lines"))
    assert "too few" in nothing_words()
