"""What standing on the floor did is said in short sentences, also what it left alone and why."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from keypose.app.words.standing import standing_words
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.up import Disagreement, UpEvidence, up_of_one
from keypose.tracker.operations.stand import Standing
from keypose.tracker.session.camera_motion import CameraMotion, CameraPiece
from keypose.tracker.session.pins import Pin
from keypose.tracker.space.harm import Harm
from tests.tracker import session_cases as cases

FOOT = Pin(part="right_foot", first_frame=46, last_frame=61)
SEEN = Harm(FOOT, "picture", 9.3, 1.16, "right_foot", 60)
BENT = Harm(FOOT, "knee", float(np.radians(11.0)), 1.1, "right_shin", 50)
LEVEL = (0.0, -1.0, 0.0)
SET = up_of_one(UpEvidence.of(np.array(LEVEL), np.radians(1.0), "set"))
STEEP = UpEvidence.of(np.array([0.0, -0.98, -0.199]), np.radians(1.0), "lines")
PLAIN_SESSION = cases.session().with_up(LEVEL)
WAY = np.tile(np.eye(4), (3, 1, 1))
WAY[:, 0, 3] = (0.0, 0.5, 1.0)
WALKED = CameraMotion.of(
    "moves",
    CameraPath(WAY, np.ones(3)),
    pieces=(CameraPiece(first_frame=0, metres=2.0, sigma=0.1),),
)
FAR = WALKED.model_copy(update={"pieces": (CameraPiece(first_frame=0, metres=123.2, sigma=0.1),)})
PLAIN = Standing(
    session=PLAIN_SESSION, taken=3, on_floor=4, softened=(0,), raised=(), up=SET,
    released=(), harms=(replace(SEEN, amount=2.2, share=0.3),), hanging=(), tilted_rad=0.0,
    scaled=False, unscaled=(),
)  # fmt: skip

SAID: dict[str, tuple[dict[str, Any], str]] = {
    "what moved": ({}, "Legs moved by up to 2 px, knees by up to 0°."),
    "released": (
        {"released": (SEEN,)},
        "Right foot, frames 46–61, is not pinned: that would move the right foot by 9 px.",
    ),
    "many released": ({"released": (SEEN,) * 5}, "2 more stances not pinned either."),
    "doubted": (
        {"harms": (BENT,)},
        "Right foot, frames 46–61, is pinned: check it, it may bend the knee by 11°.",
    ),
    "in the air": (
        {"hanging": ((FOOT, 0.12),)},
        "Right foot, frames 46–61, is still and 12 cm above the floor: pin it if it stands.",
    ),
    "higher": ({"raised": (FOOT,)}, "Right foot, frames 46–61, stands higher and was left there."),
    "tilted": (
        {"tilted_rad": np.radians(2.1)}, "Up was turned by 2°, to where feet stand level."
    ),
    "not as set": (
        {"up": replace(SET, apart=(Disagreement(STEEP, 8.0),))},
        "The up direction that is set says the camera looks straight ahead ± 2°, upright lines "
        "say it looks down by 11° ± 2°. Check the horizon.",
    ),
    "scaled": (
        {"scaled": True, "session": PLAIN_SESSION.changed({"camera_motion": WALKED})},
        "The camera went 2.0 m ± 0.4 m from where it began, by where feet stand and how the body "
        "moves.",
    ),
    "far": (
        {"scaled": True, "session": PLAIN_SESSION.changed({"camera_motion": FAR})},
        "The camera went 123 m ± 25 m from where it began, by where feet stand and how the body "
        "moves.",
    ),
    "no scale": (
        {"unscaled": ((45, 90),)},
        "The scale of the camera's path is not known in frames 45–90: no pins there.",
    ),
}  # fmt: skip


@pytest.mark.parametrize("fact", SAID)
def test_every_fact_has_its_sentence_and_only_where_it_is_one(fact: str) -> None:
    changes, sentence = SAID[fact]
    assert sentence in standing_words(replace(PLAIN, **changes))
    others = [words for name, (_, words) in SAID.items() if name not in (fact, "what moved")]
    if fact == "many released":
        others.remove(SAID["released"][1])
    assert not [words for words in others if words in standing_words(replace(PLAIN, **changes))]
