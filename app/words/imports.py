"""Word what was odd about an imported file."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final

from keypose.app.words.camera import in_pixels
from keypose.tracker.errors import listed, readable
from keypose.tracker.formats.text import Note, Oddity

SHOWN: Final = 4
"""Parts in a sentence."""


def note_words(notes: Sequence[Note]) -> list[str]:
    """One sentence for each note, with what to do."""
    return [_WORDS[note.oddity](*note.values) for note in notes]


def _rows(said: str, actual: int) -> str:
    return f"The file says it has {said} frames and has {actual}; all {actual} were read."


def _markers(said: str, actual: int) -> str:
    return f"The file says it has {said} markers and names {actual}."


def _beyond(count: int, last: int) -> str:
    frames_left_out = "1 frame" if count == 1 else f"{count} frames"
    return f"Left out {frames_left_out} outside the video, whose last frame is {last}."


def _undetermined(*parts: str) -> str:
    shown = [readable(part) for part in parts[:SHOWN]]
    more = [f"{len(parts) - SHOWN} more"] if len(parts) > SHOWN else []
    return (
        f"Nothing in the file says how {listed([*shown, *more])} move: name the places of more "
        "joints, or pose these parts yourself."
    )


def _unplaced(*parts: str) -> str:
    shown = listed([readable(part) for part in parts[:SHOWN]])
    return f"Nothing in the file says where {shown} begin, so how these limbs bend is a guess."


def _proportions(*bones: tuple[str, float]) -> str:
    shown = listed([f"{readable(part)} × {ratio:.2g}" for part, ratio in bones[:SHOWN]])
    return (
        f"Its proportions are not the body's ({shown}): check what its joints were taken for, or "
        "the body's sizes."
    )


def _poor(rms_cm: float) -> str:
    return (
        f"The joint error of {rms_cm:.1f} cm is well above the usual 2–5 cm: check what the "
        "joints were taken for, the unit, and the start frame."
    )


def _lying(angle: float) -> str:
    return (
        f"The body is tilted by {angle:.0f}° from upright: if it should stand, choose another "
        "world (z up or y up)."
    )


_OTHERWISE: Final = "choose the start frame (--offset-frames) if not."
_READINGS: Final[dict[str, str]] = {
    "order": "the rotation order {} (--rotation-order {})",
    "lens": "the last column as {} (--lens-column {})",
    "rate": "{} frames a second as its rate",
    "offset": "the start frame {} (--offset-frames {})",
}
_LENSES: Final = {
    "vertical": "the vertical field of view",
    "horizontal": "the horizontal field of view",
    "mm": "the focal length in mm",
    "session": "nothing, the lens staying as it was",
}


def _camera_frames(why: str, first: float, last: float, here: float, end: float) -> str:
    file, film = _span(first, last), _span(here, end)
    return {
        "files": f"Its frames {file} are taken for {film} of the film, by the numbers of the "
        f"film's pictures: {_OTHERWISE}",
        "from 1": f"Its pictures are taken as counted from 1, {file} for the film's frames {film}: "
        f"{_OTHERWISE}",
        "whole": f"It has as many frames as the film, so its {file} are taken for {film}: "
        f"{_OTHERWISE}",
        "times": f"Its times are taken for the film's, {file} s for the frames {film}: "
        f"{_OTHERWISE}",
    }[why]


def _span(first: float, last: float) -> str:
    return f"{first:.4g}–{last:.4g}" if last < 10_000 else f"{first:.0f}–{last:.0f}"


def _upright(by_y: float, by_z: float) -> str:
    return (
        f"The camera leans by {by_y:.0f}° from upright with y up, as the file is read, and by "
        f"{by_z:.0f}° with z up: choose z up (--world z-up) if the file has that."
    )


def _speed(metres: float, seconds: float) -> str:
    return (
        f"The camera goes {metres:.1f} m in {seconds:.1f} s: choose the unit (--unit cm) if the "
        "file is not in metres."
    )


def _background_off(off: float, error: float | None = None, kind: str = "", value: str = "") -> str:
    off_px = in_pixels(off)
    words = f"Points of the film's background are {off_px} off where this camera shows them"
    if error is None:
        return (
            f"{words}: the file may have another rotation order, other frame numbers or another "
            "lens, or be of another shot."
        )
    reading = _READINGS[kind].format(_LENSES.get(value, value.upper()), value)
    return f"{words}. With {reading} they agree within {in_pixels(error)}."


def _background_still(off: float) -> str:
    return (
        "The background of the film stands still, and with this camera it would go by "
        f"{in_pixels(off)}: the file may be of another shot."
    )


_WORDS: Final[dict[Oddity, Callable[..., str]]] = {
    "row count": _rows,
    "marker count": _markers,
    "frames beyond": _beyond,
    "row per frame": lambda: (
        "The file has no times: each row is taken for a frame of the video. Give its rate if not."
    ),
    "z up at rest": lambda: "Read with z up, as its rest pose shows.",
    "undetermined parts": _undetermined,
    "unplaced joints": _unplaced,
    "proportions": _proportions,
    "poor fit": _poor,
    "flat": lambda: (
        "All joints lie in one plane, so the file does not know depth: use it for the picture only."
    ),
    "lying": _lying,
    "starts at": lambda frame: (
        f"Taken to start at frame {frame}, where it meets the keyframes: choose start frame 0 if "
        "it begins with the video."
    ),
    "far from keyframes": lambda cm: (
        f"Its joints lie {cm:.0f} cm from the keyframes: check the frame at which it starts, or "
        "whether it is this motion."
    ),
    "camera frames": _camera_frames,
    "camera from first": lambda: (
        f"Its times are counted from its first line, which is taken for the film's frame 0: "
        f"{_OTHERWISE}"
    ),
    "camera lens kept": lambda: "The file says nothing of the lens, which stays as it was.",
    "camera upright": _upright,
    "camera hanging": lambda by_y: (
        f"The camera leans by {by_y:.0f}° from upright: check which way is up in the file."
    ),
    "camera speed": _speed,
    "several animations": lambda: "Several animations move the camera: the first one was read.",
    "background off": _background_off,
    "background still": _background_still,
    "film not compared": lambda: (
        "The film cannot be opened, so the camera was not compared with its background."
    ),
}
