"""What was found about a body's sizes, in sentences and in centimetres."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.errors import listed, readable
from keypose.tracker.fitting.sizes.proportions import Proportions
from keypose.tracker.fitting.sizes.shared import Shared

WHAT = ("length", "width")
MORE = ("longer", "wider")
LESS = ("shorter", "narrower")
NO_GAIN = "No better sizes found. Unchanged."
UNLIKELY = "The best fit was unrealistic, so it was not used. Set sizes by hand."


@dataclass(frozen=True, eq=False)
class SizesFound:
    """The sizes found, and how they were found.

    changed, observable, implausible (S + 2,): which of the shared values changed, which the
    pictures determine, and which fit best at an unlikely value. enough: whether the pictures show
    the body's contour at all.
    """

    proportions: Proportions
    shared: Shared
    changed: NDArray[np.bool_]
    observable: NDArray[np.bool_]
    implausible: NDArray[np.bool_]
    enough: bool
    focal_asked: bool
    telephoto: bool


def describe_sizes(sizes_found: SizesFound) -> str:
    """A few sentences for a person."""
    if not sizes_found.enough:
        return "The images do not show the body’s outline well enough. Sizes unchanged."
    if sizes_found.implausible.any() and not sizes_found.changed.any():
        return UNLIKELY
    sentences = [_changed(sizes_found)]
    names = sizes_found.proportions.names
    unobservable = _unobservable(sizes_found)
    left = [
        f"{kind} of {_listed(group_names)}"
        for k, kind in enumerate(WHAT)
        if (group_names := [names[g] for g in np.flatnonzero(unobservable[k:-2:2])])
    ]
    if left:
        text = " and ".join(left)
        sentences.append(f"{text[:1].upper()}{text[1:]} could not be estimated. Unchanged.")
    implausible = [
        f"{readable(sizes_found.proportions.names[s // 2])}'s {WHAT[s % 2]}"
        for s in np.flatnonzero(sizes_found.implausible[:-2]).tolist()
    ]
    if implausible:
        sentences.append(
            f"The best fit of the {_listed(implausible)} was unrealistic, so it was not used. "
            "Set it by hand."
        )
    if sizes_found.focal_asked:
        sentences.append(_focal(sizes_found))
    return " ".join(sentences)


def size_changes(sizes_found: SizesFound) -> tuple[tuple[str, str, float, float], ...]:
    """(part, what, before, after) of every size that changed, centimetres."""
    before = 100 * sizes_found.proportions.metres()
    after = before * np.exp(sizes_found.shared.sizes)
    return tuple(
        (sizes_found.proportions.names[s // 2], WHAT[s % 2], float(before[s]), float(after[s]))
        for s in np.flatnonzero(sizes_found.changed[:-2]).tolist()
    )


def unseen_parts(sizes_found: SizesFound) -> tuple[str, ...]:
    """Parts whose length the pictures do not determine."""
    unseen = np.flatnonzero(_unobservable(sizes_found)[:-2:2])
    return tuple(sizes_found.proportions.names[g] for g in unseen)


def _unobservable(sizes_found: SizesFound) -> NDArray[np.bool_]:
    return ~(sizes_found.observable | sizes_found.changed | sizes_found.implausible)


def _changed(sizes_found: SizesFound) -> str:
    names, sizes = sizes_found.proportions.names, sizes_found.shared.sizes
    changes = [
        f"{readable(names[s // 2])} {_by(sizes[s], s % 2)}"
        for s in np.flatnonzero(sizes_found.changed[:-2]).tolist()
    ]
    if not changes:
        return NO_GAIN
    return (
        f"{changes[0][:1].upper()}{changes[0][1:]}."
        if len(changes) == 1
        else f"{len(changes)} sizes fit better."
    )


def _by(size: float, kind: int) -> str:
    """Such as "8 % longer"."""
    percent = 100 * abs(np.expm1(size))
    return f"{percent:.0f} % {(MORE if size > 0 else LESS)[kind]}"


def _focal(sizes_found: SizesFound) -> str:
    if sizes_found.telephoto:
        return "A telephoto camera has no focal length to estimate."
    if sizes_found.implausible[-2]:
        return "The best focal length was unrealistic, so it was not used."
    if not sizes_found.changed[-2]:
        return "The focal length could not be estimated. Unchanged."
    percent = 100 * np.expm1(sizes_found.shared.values[-2])
    return f"The focal length is {abs(percent):.0f} % {'longer' if percent > 0 else 'shorter'}."


def _listed(names: list[str]) -> str:
    return listed([readable(name) for name in names])
