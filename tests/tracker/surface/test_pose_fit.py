"""What is said of the parts that a fit to a surface has moved."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.body.body import preset
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.surface.fit import fitter

SKELETON = Skeleton.of(preset("adult_male"))
REST = Pose.rest(SKELETON, (0.0, 0.0, 3.0))
MOVED = Pose.rest(SKELETON, (0.0, 0.0, 4.0))


@pytest.mark.parametrize(
    ("moved_m", "words"),
    [
        ({"left_hand": 0.03, "head": 0.06, "left_shin": 0.04, "neck": 0.02},
         "Head moved 6 cm, left shin 4 cm, left hand 3 cm."),
        ({"head": 0.0051, "neck": 0.0049}, "Head moved 1 cm."),
        ({"head": fitter.LEAST_REPORTED_M}, "Head moved 0 cm."),
        ({"head": 0.0049}, "No part moved by more than half a centimetre."),
    ],
)  # fmt: skip
def test_the_parts_that_moved_most_are_named_with_how_far(
    monkeypatch: pytest.MonkeyPatch, moved_m: dict[str, float], words: str
) -> None:
    far = np.zeros((SKELETON.part_count, 3))
    for name, metres in moved_m.items():
        far[SKELETON.body.index(name), 0] = metres
    monkeypatch.setattr(fitter, "_middles", lambda _, pose: far * (pose is MOVED))
    assert fitter._describe_moves(SKELETON, REST, MOVED) == words
