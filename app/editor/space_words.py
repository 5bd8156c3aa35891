"""What is not plausible in space, in the page's words."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final

from keypose.app.posing.labels import part_label
from keypose.tracker.session.results import PinResult, SpaceFinding

_SENTENCES: Final[Mapping[str, str]] = {
    "slides": "{part} slides {cm} cm, {frames}",
    "off_floor": "{part} leaves the floor by {cm} cm, {frames}",
    "below_floor": "{part} goes {cm} cm into the floor, {frames}",
    "keyframe_depth": "At keyframe {go} {part} stands {cm} cm {way} than nearby",
    "mirrored": "At keyframe {go} {part} may point the wrong way in depth",
    "twisted": "At keyframe {go} {part} is turned {deg}° too far about its length",
    "leans": "The body leans {deg}° out of balance, {frames}",
    "shakes": "{part} shakes with {acceleration} m/s², {frames}",
}


def space_sentence(found: SpaceFinding) -> str:
    """Such as "Left foot slides 9 cm, 40–55"."""
    part = part_label(found.part)
    if found.kind in ("keyframe_depth", "mirrored", "twisted"):
        part = f"the {part[:1].lower()}{part[1:]}"
    return _SENTENCES[found.kind].format(
        part=part,
        cm=_centimetres(found.amount),
        frames=f"{found.first_frame}–{found.last_frame}",
        go=found.go,
        way="nearer" if found.amount < 0 else "farther away",
        deg=round(abs(math.degrees(found.amount))),
        acceleration=f"{found.amount:.0f}",
    )


def pin_sentence(pin: PinResult) -> str:
    """Such as "Keyframe 50 is 3 cm off the pin of the left foot"."""
    part = part_label(pin.part)
    return (
        f"Keyframe {pin.keyframe} is {_centimetres(pin.off_m)} cm off the pin of the "
        f"{part[:1].lower()}{part[1:]}"
    )


def _centimetres(metres: float) -> str:
    return f"{100 * abs(metres):.0f}"
