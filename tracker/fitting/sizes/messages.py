"""What was found about a body's sizes, in sentences and in centimetres."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.modify import height
from keypose.tracker.errors import listed, readable
from keypose.tracker.fitting.sizes.proportions import Proportions
from keypose.tracker.fitting.sizes.shared import Shared

WHAT = ("length", "width")
MORE = ("longer", "wider")
LESS = ("shorter", "narrower")
NO_GAIN = "No better sizes found. Unchanged."
UNLIKELY = "The best fit was unrealistic, so it was not used. Set sizes by hand."


@dataclass(frozen=True, eq=False)
class FoundBeside:
    """What several films tell besides proportions.

    films: how many show the same keyframe.  larger: as how many times its size all of the body
    turned out, by a measured distance of cameras.  sigma_share: of its height, a share of it; None
    where nobody measured that distance.
    """

    films: int
    larger: float = 1.0
    sigma_share: float | None = None


@dataclass(frozen=True, eq=False)
class SizesFound:
    """The sizes found, and how they were found.

    changed, observable, implausible (S + 2,): which of the shared values changed, which the
    pictures determine, and which fit best at an unlikely value. enough: whether the pictures show
    the body's contour at all. beside: what other films told; None where none shows a keyframe.
    """

    proportions: Proportions
    shared: Shared
    changed: NDArray[np.bool_]
    observable: NDArray[np.bool_]
    implausible: NDArray[np.bool_]
    enough: bool
    focal_asked: bool
    telephoto: bool
    beside: FoundBeside | None = None


def describe_sizes(sizes_found: SizesFound) -> str:
    """A few sentences for a person."""
    if not sizes_found.enough:
        return "The images do not show the body’s outline well enough. Sizes unchanged."
    if sizes_found.implausible.any() and not sizes_found.changed.any():
        return UNLIKELY
    sentences = [_changed(sizes_found)]
    names, sizes = sizes_found.proportions.names, sizes_found.proportions.count
    unobservable = _unobservable(sizes_found)
    left = [
        f"{kind} of {_listed(group_names)}"
        for k, kind in enumerate(WHAT)
        if (group_names := [names[g] for g in np.flatnonzero(unobservable[k:sizes:2])])
    ]
    if left:
        text = " and ".join(left)
        sentences.append(f"{text[:1].upper()}{text[1:]} could not be estimated. Unchanged.")
    implausible = [
        f"{readable(sizes_found.proportions.names[s // 2])}'s {WHAT[s % 2]}"
        for s in np.flatnonzero(sizes_found.implausible[:sizes]).tolist()
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
    sizes = sizes_found.proportions.count
    return tuple(
        (sizes_found.proportions.names[s // 2], WHAT[s % 2], float(before[s]), float(after[s]))
        for s in np.flatnonzero(sizes_found.changed[:sizes]).tolist()
    )


def fitted_height(sizes_found: SizesFound) -> float:
    """Of the body with the sizes found, before all of it is larger, metres."""
    return height(sizes_found.proportions.body_at(sizes_found.shared.sizes))


def films_note(sizes_found: SizesFound) -> str:
    """Sentences about what several films tell; empty where one alone shows the keyframes."""
    beside = sizes_found.beside
    if beside is None:
        return ""
    if beside.sigma_share is None:
        return (
            f"Proportions are from {beside.films} films. They do not show how tall the person is: "
            "set the height if you know it."
        )
    tall_cm = 100 * beside.larger * fitted_height(sizes_found)
    return (
        f"{beside.films} films and the measured distance of their cameras show a height of "
        f"{tall_cm:.0f} ± {max(tall_cm * beside.sigma_share, 1.0):.0f} cm."
    )


def unseen_parts(sizes_found: SizesFound) -> tuple[str, ...]:
    """Parts whose length the pictures do not determine."""
    unseen = np.flatnonzero(_unobservable(sizes_found)[: sizes_found.proportions.count : 2])
    return tuple(sizes_found.proportions.names[g] for g in unseen)


def _unobservable(sizes_found: SizesFound) -> NDArray[np.bool_]:
    return ~(sizes_found.observable | sizes_found.changed | sizes_found.implausible)


def _changed(sizes_found: SizesFound) -> str:
    names, sizes = sizes_found.proportions.names, sizes_found.shared.sizes
    changes = [
        f"{readable(names[s // 2])} {_by(sizes[s], s % 2)}"
        for s in np.flatnonzero(sizes_found.changed[: len(sizes)]).tolist()
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
    at = sizes_found.proportions.count
    if sizes_found.implausible[at]:
        return "The best focal length was unrealistic, so it was not used."
    if not sizes_found.changed[at]:
        return "The focal length could not be estimated. Unchanged."
    percent = 100 * np.expm1(sizes_found.shared.values[at])
    return f"The focal length is {abs(percent):.0f} % {'longer' if percent > 0 else 'shorter'}."


def _listed(names: list[str]) -> str:
    return listed([readable(name) for name in names])
