"""What was found of a film's camera, in sentences."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from keypose.tracker.session.camera_motion import CameraFinding

KINDS: Final = {
    "static": "The camera stands still",
    "turns": "The camera turns",
    "moves": "The camera moves",
}
_FINDINGS: Final = {
    "no_texture": "{frames}: the background shows too little to follow. The camera is bridged "
    "there.",
    "body_fills": "{frames}: too little background is seen beside the body. The camera is bridged "
    "there.",
    "cut": "Frame {first}: another scene begins. What is before and after it has no common world.",
    "not_rigid": "{frames}: the background moves by itself, as water or a crowd does. Mask what "
    "moves, and find the camera again.",
    "no_picture": "{frames}: the pictures cannot be read. The camera is bridged there.",
    "rolling_shutter": "The shutter rolls: a picture is exposed over {amount:.0%} of the time "
    "between frames. The camera's turns are freed of it.",
    "rolling_shutter_left": "The shutter rolls, and the way of the camera is not freed of that: it "
    "may be off by a hundredth, and feet by 2 cm.",
    "not_in_file": "{frames}: the imported file does not have them. The camera is bridged there.",
    "no_parallax": "{frames}: nothing shows that the camera went anywhere. It is taken to turn "
    "alone.",
    "no_scale": "{frames}: how far the camera went is known but for its scale, so it is taken to "
    "turn alone. Track the body, and stand it on the floor or find the camera again: feet that "
    "stand still tell the scale.",
}


def camera_sentence(kind: str, zooms: bool, error_px: float | None) -> str:
    """Say how the camera moves, and how well the background agrees."""
    words = KINDS[kind]
    if zooms:
        words += " and zooms"
    if error_px is None:
        return f"{words}."
    return f"{words}: background points agree within {error_px:.2g} px."


def lens_sentence(focal_mm: float) -> str:
    """Say which lens the camera's motion told, in place of a guess."""
    return f"Its motion tells a lens of {focal_mm:.0f} mm, which was a guess before."


def finding_sentence(found: CameraFinding) -> str:
    """Say what is not known of a camera's motion."""
    first, last = found.first_frame, found.last_frame
    frames = f"Frames {first}–{last}" if last > first else f"Frame {first}"
    kind: str = found.kind
    if kind == "rolling_shutter" and not found.amount:
        kind = "rolling_shutter_left"
    return _FINDINGS[kind].format(frames=frames, first=first, amount=found.amount)


def finding_sentences(found: Sequence[CameraFinding]) -> list[str]:
    """All of them, those of a cut first."""
    return [finding_sentence(one) for one in sorted(found, key=lambda one: one.kind != "cut")]
