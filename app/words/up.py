"""Word what is up, how sure that is, what it rests on, and where ways of finding it disagree."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Final

import numpy as np

from keypose.app.posing.placing import tilt_and_roll
from keypose.tracker.errors import listed

if TYPE_CHECKING:
    from keypose.tracker.geometry.rotations import Array
    from keypose.tracker.geometry.up import UnsureUp, UpEstimate, UpEvidence, UpSource

SIGMAS_SAID: Final = 2.0
"""Standard deviations that are said as ±: nine in ten are off by no more."""
SURE_DEG: Final = 2
"""A camera whose tilt is known to that needs no horizon."""
ROUNDING_DEG: Final = 0.05
"""Of what is no more than a whole number."""
MOST_SAID_DEG: Final = 45
"""A ± that is larger says nothing."""
NOTHING_DEG: Final = 90
"""By no more anything is off whose sign is known."""

SOURCES: Final[Mapping[UpSource, str]] = {
    "lines": "upright lines",
    "person": "how the person stands",
    "feet": "where the feet stand",
    "level": "that cameras are held level",
    "set": "the up direction that is set",
}
_SAY: Final = {"lines": "say", "set": "says"}
"""After a source; "says" after all others."""


def up_words(up_estimate: UpEstimate) -> str:
    """Such as "The camera looks down by 3° ± 2°, by upright lines."; where that is much, what makes
    it surer; where ways disagree what both say, and which is used."""
    if up_estimate.apart:
        used = _by(up_estimate)
        verb = (
            "is" if len(up_estimate.sources) == 1 and up_estimate.sources[0] != "lines" else "are"
        )
        return f"{apart_words(up_estimate)} {used[0].upper()}{used[1:]} {verb} used."
    camera = _camera_words(up_estimate.up.tolist(), off_words(up_estimate.sigma_rad))
    words = f"{camera}, by {_by(up_estimate)}."
    is_sure = off_deg(up_estimate.sigma_rad) <= SURE_DEG
    return words if is_sure else f"{words} Draw the horizon to be surer."


def apart_words(up_estimate: UpEstimate) -> str:
    """Such as "Upright lines say the camera looks down by 3° ± 2°, how the person stands says 12° ±
    3°."; empty where all agree."""
    if not up_estimate.apart:
        return ""
    used, worst = (
        up_estimate.used[0],
        max(up_estimate.apart, key=lambda disagreement: disagreement.sigmas).evidence,
    )
    axis = _axis_apart(used, worst)
    says = f"{SOURCES[worst.source]} {_SAY.get(worst.source, 'says')}"
    (way, deg), (other_way, other_deg) = (_angle(each.up, axis) for each in (used, worst))
    off, other_off = (off_words(_sigma_rad(each, axis)) for each in (used, worst))
    first = f"{SOURCES[used.source]} {_SAY.get(used.source, 'says')} the camera {way}{deg}"
    other = other_deg.removeprefix(" by ") if way == other_way else f"it {other_way}{other_deg}"
    return f"{first[0].upper()}{first[1:]}{off}, {says} {other}{other_off}."


def choice_words(evidence: UpEvidence) -> str:
    """Such as "Take upright lines"."""
    return f"Take {SOURCES[evidence.source]}"


def unsure_words(lines: UnsureUp) -> str:
    """What upright lines show that agree, and are not taken alone."""
    off = min(off_deg(lines.sigma_rad), NOTHING_DEG)
    return (
        f"Upright lines agree, and show the up direction to no better than ± {off}°: that is not "
        "enough by itself. Draw the horizon, or two verticals."
    )


def nothing_words() -> str:
    """Where no lines agree and nothing else shows what is up."""
    return (
        "Nothing shows the up direction: too few upright lines agree. Draw the horizon, or two "
        "verticals."
    )


def _camera_words(up_camera: Sequence[float], off: str = "") -> str:
    """Such as "The camera looks down by 12° ± 2°", or "The camera is level to ± 2°"."""
    tilt, _ = tilt_and_roll(up_camera)
    deg = round(abs(tilt))
    if not deg:
        return f"The camera is level{' to' if off else ''}{off}"
    return f"The camera looks {'up' if tilt > 0 else 'down'} by {deg}°{off}"


def off_deg(sigma_rad: float) -> int:
    """What is said as ±, whole degrees, never less than it is."""
    return math.ceil(float(np.degrees(SIGMAS_SAID * sigma_rad)) - ROUNDING_DEG)


def off_words(sigma_rad: float) -> str:
    """Such as " ± 2°"; empty where it says nothing."""
    off = off_deg(sigma_rad)
    return f" ± {off}°" if off <= MOST_SAID_DEG else ""


def _by(up_estimate: UpEstimate) -> str:
    return listed([SOURCES[source] for source in up_estimate.sources])


LEAST_ACROSS: Final = 1e-3
"""Of up in a camera that looks straight down or up, which has no roll."""


def _sigma_rad(of: UnsureUp, axis: str) -> float:
    """The standard deviation of a camera's tilt or roll, by how these change with up."""
    x, y = of.up[:2].tolist()
    across = max(math.hypot(x, y), LEAST_ACROSS)
    by_up = {"tilt": (0.0, 0.0, 1.0 / across), "roll": (-y / across**2, x / across**2, 0.0)}
    return of.sigma_along(np.array(by_up[axis]))


def _axis_apart(up_evidence: UpEvidence, other: UpEvidence) -> str:
    """Tilt or roll: in which two differ by more of their standard deviation."""
    (tilt, roll), (other_tilt, other_roll) = (
        tilt_and_roll(each.up) for each in (up_evidence, other)
    )
    off_deg = {"tilt": tilt - other_tilt, "roll": math.remainder(roll - other_roll, 360.0)}
    return max(
        off_deg,
        key=lambda axis: (
            abs(off_deg[axis]) / math.hypot(_sigma_rad(up_evidence, axis), _sigma_rad(other, axis))
        ),
    )


def _angle(up_camera: Array, axis: str) -> tuple[str, str]:
    """Which way a camera looks or leans, and by how much: " by 3°"; empty where it does not."""
    tilt, roll = tilt_and_roll(up_camera)
    deg = round(abs(roll if axis == "roll" else tilt))
    if not deg:
        return ("does not lean" if axis == "roll" else "looks straight ahead"), ""
    if axis == "roll":
        return f"leans {'left' if roll > 0 else 'right'}", f" by {deg}°"
    return f"looks {'up' if tilt > 0 else 'down'}", f" by {deg}°"
