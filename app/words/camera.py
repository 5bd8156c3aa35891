"""What was found of a film's camera, in sentences."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

from keypose.app.words.up import SIGMAS_SAID
from keypose.tracker.session import Session
from keypose.tracker.session.camera_motion import CameraFinding, CameraMotion, CameraWay

MOST_DECIMALS: Final = 3
"""Millimetres."""
KINDS: Final = {
    "static": "The camera stands still",
    "turns": "The camera turns",
    "moves": "The camera moves",
}
_FINDINGS: Final = {
    "no_texture": "{frames}: the background shows too little to follow, or fades. The camera is "
    "bridged there.",
    "body_fills": "{frames}: too little background is seen beside the body. The camera is bridged "
    "there.",
    "cut": "{frames}: another scene begins. What is before and after it has no common world.",
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
    "no_scale": "{frames}: the scale of the camera's path is not known yet, so it is taken to turn "
    "alone. Say how far the camera went, or track the body and stand it on the floor: feet that "
    "stand still give the scale.",
}


def camera_sentence(kind: str, zooms: bool, error_px: float | None) -> str:
    """Say how the camera moves, and how well the background agrees."""
    words = KINDS[kind]
    if zooms:
        words += " and zooms"
    if error_px is None:
        return f"{words}."
    return f"{words}: background points agree within {error_px:.2g} px."


def way_sentences(motion: CameraMotion) -> list[str]:
    """Say how far the camera went, where that was found and is no more than likely."""
    camera_ways = [
        camera_way
        for camera_way in motion.ways
        if camera_way.farthest_m is not None and camera_way.sigma is not None
    ]
    several = len(motion.pieces) > 1
    return [_way_sentence(camera_way, several) for camera_way in camera_ways]


def _way_sentence(camera_way: CameraWay, several: bool) -> str:
    assert camera_way.farthest_m is not None
    assert camera_way.sigma is not None
    off_m = SIGMAS_SAID * camera_way.sigma * camera_way.farthest_m
    frames = f"Frames {camera_way.first_frame}–{camera_way.last_frame}: the" if several else "The"
    return (
        f"{frames} camera went {_metres(camera_way.farthest_m, off_m)} from where it began, by "
        "where feet stand and how the body moves."
    )


def _metres(length: float, off: float) -> str:
    """Such as "123 m ± 21 m" or "0.34 m ± 0.05 m": as many decimals as the ± has a meaning for."""
    decimals = min(max(-math.floor(math.log10(off)), 0), MOST_DECIMALS) if off > 0 else 2
    return f"{length:.{decimals}f} m ± {off:.{decimals}f} m"


def unscaled_words(session: Session) -> str | None:
    """Say that exports have no way of the camera over some frames; None where they have."""
    motion = session.view.camera_motion
    if motion is None or not motion.unscaled or session.camera_path is None:
        return None
    frames = ", ".join(
        f"{camera_finding.first_frame}–{camera_finding.last_frame}"
        for camera_finding in motion.unscaled
    )
    return (
        f"The scale of the camera's path is not known in frames {frames}: the motion is written as "
        "if the camera had only turned there. Stand it on the floor, or say how far the camera "
        "went."
    )


def lens_sentence(focal_mm: float) -> str:
    """Say which lens the camera's motion gave, in place of a guess."""
    return f"The lens is set to {focal_mm:.0f} mm by how the camera moves: it was a guess before."


def finding_sentence(*camera_findings: CameraFinding) -> str:
    """Say what is not known of a camera's motion, of findings of one kind."""
    spans = [
        (camera_finding.first_frame, camera_finding.last_frame)
        for camera_finding in camera_findings
    ]
    several = len(camera_findings) > 1 or spans[0][1] > spans[0][0]
    frames = ", ".join(f"{first}–{last}" if last > first else f"{first}" for first, last in spans)
    kind: str = camera_findings[0].kind
    if kind == "rolling_shutter" and not camera_findings[0].amount:
        kind = "rolling_shutter_left"
    return _FINDINGS[kind].format(
        frames=f"{'Frames' if several else 'Frame'} {frames}", amount=camera_findings[0].amount
    )


def finding_sentences(camera_findings: Sequence[CameraFinding]) -> list[str]:
    """One for every kind, that of cuts first."""
    kinds = sorted(
        dict.fromkeys(finding.kind for finding in camera_findings), key=lambda kind: kind != "cut"
    )
    return [
        finding_sentence(
            *(camera_finding for camera_finding in camera_findings if camera_finding.kind == kind)
        )
        for kind in kinds
    ]


def imported_words(made: Session, background_px: float | None) -> list[str]:
    """What is known of the motion of a camera that was imported, sentences; none where it stands
    still. background_px: by how much points of the background are off."""
    motion = made.view.camera_motion
    if motion is None:
        return []
    words = finding_sentences((*motion.findings, *motion.unscaled))
    if background_px is None:
        return [*words, "The film's background does not show whether the camera is right."]
    off = in_pixels(background_px)
    return [*words, f"Points of the film's background are usually {off} off."]


def in_pixels(length: float) -> str:
    """A length in the picture: "0.15 px", "33 px"."""
    return f"{length:.0f} px" if length >= 10 else f"{length:.2g} px"
