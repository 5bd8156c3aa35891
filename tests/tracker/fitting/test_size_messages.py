"""What is said of sizes that were looked for in pictures."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest

from keypose.tracker.body.body import preset
from keypose.tracker.fitting.sizes.messages import (
    NO_GAIN,
    UNLIKELY,
    SizesFound,
    describe_sizes,
    size_changes,
    unseen_parts,
)
from keypose.tracker.fitting.sizes.proportions import Proportions
from keypose.tracker.fitting.sizes.shared import Shared

BODY = Proportions.of(preset("adult_female"))
LENGTH = 0
WIDTH = 1
FOCAL = BODY.count
OF_TELEPHOTO = "A telephoto camera has no focal length to estimate."


def at(part: str, what: int) -> int:
    """Where a size is among the shared values."""
    return 2 * BODY.names.index(part) + what


def found(
    changed: Mapping[int, float] | None = None,
    unseen: tuple[int, ...] = (),
    implausible: tuple[int, ...] = (),
    *,
    enough: bool = True,
    focal_asked: bool = False,
    telephoto: bool = False,
) -> SizesFound:
    """Sizes of which some changed by a ratio."""
    values, flags = np.zeros(BODY.count + 2), np.zeros((3, BODY.count + 2), np.bool_)
    flags[1] = True
    for place, ratio in (changed or {}).items():
        values[place], flags[0, place] = np.log(ratio), True
    flags[1, list(unseen)] = False
    flags[2, list(implausible)] = True
    return SizesFound(BODY, Shared(values, ()), *flags, enough, focal_asked, telephoto)


SAID = {
    "nothing": (found(), NO_GAIN),
    "no outline": (
        found({at("shin", LENGTH): 1.1}, enough=False),
        "The images do not show the body’s outline well enough. Sizes unchanged.",
    ),
    "one longer": (found({at("forearm", LENGTH): 1.08}), "Forearm 8 % longer."),
    "one narrower": (found({at("upper_arm", WIDTH): 0.9}), "Upper arm 10 % narrower."),
    "several": (
        found({at("shin", LENGTH): 1.05, at("thigh", WIDTH): 1.1}),
        "2 sizes fit better.",
    ),
    "a length unseen": (
        found({at("shin", LENGTH): 1.05}, unseen=(at("head", LENGTH),)),
        "Shin 5 % longer. Length of head could not be estimated. Unchanged.",
    ),
    "lengths and a width unseen": (
        found(unseen=(at("head", LENGTH), at("foot", LENGTH), at("hand", WIDTH))),
        f"{NO_GAIN} Length of head and foot and width of hand could not be estimated. Unchanged.",
    ),
    "unseen but changed": (
        found({at("shin", LENGTH): 1.05}, unseen=(at("shin", LENGTH),)),
        "Shin 5 % longer.",
    ),
    "implausible alone": (found(implausible=(at("shin", WIDTH),)), UNLIKELY),
    "implausible beside another": (
        found({at("thigh", LENGTH): 1.05}, implausible=(at("shin", WIDTH),)),
        "Thigh 5 % longer. The best fit of the shin's width was unrealistic, so it was not used. "
        "Set it by hand.",
    ),
    "a longer lens": (
        found({FOCAL: 1.12}, focal_asked=True),
        f"{NO_GAIN} The focal length is 12 % longer.",
    ),
    "a shorter lens": (
        found({FOCAL: 0.9}, focal_asked=True),
        f"{NO_GAIN} The focal length is 10 % shorter.",
    ),
    "a lens unseen": (
        found({at("shin", LENGTH): 1.05}, focal_asked=True),
        "Shin 5 % longer. The focal length could not be estimated. Unchanged.",
    ),
    "a lens that cannot be": (
        found({at("shin", LENGTH): 1.05}, implausible=(FOCAL,), focal_asked=True),
        "Shin 5 % longer. The best focal length was unrealistic, so it was not used.",
    ),
    "a telephoto lens": (
        found({at("shin", LENGTH): 1.05}, focal_asked=True, telephoto=True),
        f"Shin 5 % longer. {OF_TELEPHOTO}",
    ),
    "a lens nobody asked for": (found({at("shin", LENGTH): 1.05, FOCAL: 1.2}), "Shin 5 % longer."),
}


@pytest.mark.parametrize("name", SAID)
def test_what_was_found_is_said_in_plain_sentences(name: str) -> None:
    sizes, words = SAID[name]
    assert describe_sizes(sizes) == words


def test_changes_are_in_centimetres_before_and_after_and_no_lens_is_among_them() -> None:
    sizes = found({at("shin", LENGTH): 1.1, at("chest", WIDTH): 0.95, FOCAL: 1.2})
    metres = BODY.metres()
    expected = {
        (part, what): (100 * metres[at(part, k)], 100 * metres[at(part, k)] * ratio)
        for part, what, k, ratio in (
            ("shin", "length", LENGTH, 1.1),
            ("chest", "width", WIDTH, 0.95),
        )
    }
    changes = size_changes(sizes)
    assert len(changes) == 2
    for part, what, before, after in changes:
        assert (before, after) == pytest.approx(expected[part, what])


def test_parts_whose_length_is_not_seen_are_named_and_those_whose_width_alone_is_not_are_not() -> (
    None
):
    sizes = found(
        {at("foot", LENGTH): 1.1},
        unseen=(at("head", LENGTH), at("hand", WIDTH), at("foot", LENGTH)),
    )
    assert unseen_parts(sizes) == ("head",)
