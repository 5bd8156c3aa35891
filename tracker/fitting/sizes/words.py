"""What was found about a body's sizes, in words and in centimetres."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tracker.errors import listed
from tracker.fitting.sizes.proportions import Proportions
from tracker.fitting.sizes.shared import Shared

WHAT = ("length", "thickness")
MORE, LESS = ("longer", "thicker"), ("shorter", "thinner")


@dataclass(frozen=True, eq=False)
class Found:
    """The sizes found, and how they were found.

    changed, told, doubted (S + 2,): which of the shared values are no longer what they were, which
    the pictures tell, and which they tell to be more different than can be believed. enough:
    whether the pictures show the body's contour at all.
    """

    proportions: Proportions
    shared: Shared
    changed: NDArray[np.bool_]
    told: NDArray[np.bool_]
    doubted: NDArray[np.bool_]
    enough: bool
    focal_asked: bool
    telephoto: bool


def words_of(found: Found) -> str:
    """A few sentences for a person."""
    if not found.enough:
        return (
            "The pictures hardly show where the body ends and the background begins, "
            "so nothing was changed."
        )
    sentences = [_changed(found)]
    names = found.proportions.names
    untold = ~(found.told | found.changed | found.doubted)
    left = [
        f"{what} of {_listed(some)}"
        for k, what in enumerate(WHAT)
        if (some := [names[g] for g in np.flatnonzero(untold[k:-2:2])])
    ]
    if left:
        sentences.append(
            f"These pictures do not tell the {' and the '.join(left)}: left as it was."
        )
    doubted = [
        f"{found.proportions.names[s // 2].replace('_', ' ')}'s {WHAT[s % 2]}"
        for s in np.flatnonzero(found.doubted[:-2]).tolist()
    ]
    if doubted:
        sentences.append(
            f"The {_listed(doubted)} would have to change by more than is likely: set by hand "
            "what you see to be wrong."
        )
    if found.focal_asked:
        sentences.append(_focal(found))
    return " ".join(sentences)


def changes_of(found: Found) -> tuple[tuple[str, str, float, float], ...]:
    """(part, what, before, after) of every size that changed, centimetres."""
    before = 100 * found.proportions.metres()
    after = before * np.exp(found.shared.sizes)
    return tuple(
        (found.proportions.names[s // 2], WHAT[s % 2], float(before[s]), float(after[s]))
        for s in np.flatnonzero(found.changed[:-2]).tolist()
    )


def _changed(found: Found) -> str:
    some = [
        f"{found.proportions.names[s // 2].replace('_', ' ')} {_by(found.shared.sizes[s], s % 2)}"
        for s in np.flatnonzero(found.changed[:-2]).tolist()
    ]
    if not some:
        return "The sizes agree with the pictures as they are."
    return f"Fitted to the pictures: {', '.join(some)}. The keyframes were posed anew with it."


def _by(size: float, what: int) -> str:
    """Such as "8 % longer"."""
    percent = 100 * abs(np.expm1(size))
    return f"{percent:.0f} % {(MORE if size > 0 else LESS)[what]}"


def _focal(found: Found) -> str:
    if found.telephoto:
        return "A telephoto camera has no focal length of its own to be found."
    if found.doubted[-2]:
        return "The focal length would have to change by more than is likely: it stays."
    if not found.changed[-2]:
        return "The pictures do not tell another focal length: it stays."
    percent = 100 * np.expm1(found.shared.values[-2])
    return f"The focal length is {abs(percent):.0f} % {'longer' if percent > 0 else 'shorter'}."


def _listed(names: list[str]) -> str:
    return listed([name.replace("_", " ") for name in names])
