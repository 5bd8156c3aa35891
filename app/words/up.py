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
    from keypose.tracker.geometry.up import UpEstimate, UpEvidence, UpSource

SIGMAS_SAID: Final = 2.0
"""Standard deviations that are said as ±: nine in ten are off by no more."""
SURE_DEG: Final = 2
"""A camera whose tilt is known to that needs no horizon."""
ROUNDING_DEG: Final = 0.05
"""Of what is no more than a whole number."""
MOST_SAID_DEG: Final = 45
"""A ± that is larger says nothing."""

SOURCES: Final[Mapping[UpSource, str]] = {
    "lines": "upright lines",
    "person": "how the person stands",
    "feet": "where the feet stand",
    "level": "that cameras are held level",
    "set": "the up direction that is set",
}
_SAY: Final = {"lines": "say", "set": "says"}
"""After a source; "says" after all others."""


def up_words(found: UpEstimate) -> str:
    """Such as "The camera looks down by 3° ± 2°, by upright lines."; where that is much, what makes
    it surer; where ways disagree what both say, and which is used."""
    if found.apart:
        used = _by(found)
        verb = "is" if len(found.sources) == 1 and found.sources[0] != "lines" else "are"
        return f"{apart_words(found)} {used[0].upper()}{used[1:]} {verb} used."
    words = f"{_camera_words(found.up.tolist(), off_words(found.sigma_rad))}, by {_by(found)}."
    is_sure = off_deg(found.sigma_rad) <= SURE_DEG
    return words if is_sure else f"{words} Draw the horizon to be surer."


def apart_words(found: UpEstimate) -> str:
    """Such as "Upright lines say the camera looks down by 3° ± 2°, how the person stands says 12° ±
    3°."; empty where all agree."""
    if not found.apart:
        return ""
    used, worst = found.used[0], max(found.apart, key=lambda one: one.sigmas).evidence
    axis = _axis_apart(used.up, worst.up)
    says = f"{SOURCES[worst.source]} {_SAY.get(worst.source, 'says')}"
    (way, deg), (other_way, other_deg) = (_angle(each.up, axis) for each in (used, worst))
    first = f"{SOURCES[used.source]} {_SAY.get(used.source, 'says')} the camera {way}{deg}"
    other = other_deg.removeprefix(" by ") if way == other_way else f"it {other_way}{other_deg}"
    return (
        f"{first[0].upper()}{first[1:]}{off_words(used.sigma_along(AXES[axis]))}, {says} {other}"
        f"{off_words(worst.sigma_along(AXES[axis]))}."
    )


def choice_words(evidence: UpEvidence) -> str:
    """Such as "Take upright lines"."""
    return f"Take {SOURCES[evidence.source]}"


def unsure_words(found: UpEstimate) -> str:
    """What was found and not taken."""
    return (
        f"Upright lines show the camera's tilt{off_words(found.sigma_rad) or ' hardly'} only, and "
        "were not used."
    )


def nothing_words() -> str:
    """Where nothing shows what is up."""
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


def _by(found: UpEstimate) -> str:
    return listed([SOURCES[source] for source in found.sources])


AXES: Final = {"tilt": np.array([0.0, 0.0, 1.0]), "roll": np.array([1.0, 0.0, 0.0])}
"""Along which up moves with a camera's tilt and with its roll."""


def _axis_apart(one: Array, other: Array) -> str:
    off = np.abs(one - other)
    return "roll" if off[0] > off[2] else "tilt"


def _angle(up_camera: Array, axis: str) -> tuple[str, str]:
    """Which way a camera looks or leans, and by how much: " by 3°"; empty where it does not."""
    tilt, roll = tilt_and_roll(up_camera)
    deg = round(abs(roll if axis == "roll" else tilt))
    if not deg:
        return ("does not lean" if axis == "roll" else "looks straight ahead"), ""
    if axis == "roll":
        return f"leans {'left' if roll > 0 else 'right'}", f" by {deg}°"
    return f"looks {'up' if tilt > 0 else 'down'}", f" by {deg}°"
