"""Words, scale bars and little axes on finished pictures (H, W, 3) uint8, all drawn in place."""

from __future__ import annotations

import math

import cv2

from keypose.app.render.palette import AXIS_COLOURS, TEXT, Colour, Picture

FONT = cv2.FONT_HERSHEY_SIMPLEX
LETTER_PX = 22.0
"""Height of a capital letter at OpenCV's font scale 1."""

SHORTEST_BAR = 0.12
LONGEST_BAR = 0.35
"""A scale bar's length, as a share of the picture's width."""


def write(
    picture: Picture, words: str, left: int, baseline: int, height_px: float, colour: Colour = TEXT
) -> None:
    """Words from (left, baseline) on, capitals height_px tall."""
    scale = height_px / LETTER_PX
    weight = _weight(height_px)
    cv2.putText(picture, words, (left, baseline), FONT, scale, colour, weight, cv2.LINE_AA)


def written_width(words: str, height_px: float) -> int:
    """How many pixels the words take."""
    (width, _), _ = cv2.getTextSize(words, FONT, height_px / LETTER_PX, _weight(height_px))
    return int(width)


def _weight(height_px: float) -> int:
    """The width of a letter's lines, pixels."""
    return max(1, round(height_px / 11))


def write_name(picture: Picture, words: str, letter_px: float) -> None:
    """Words in the upper left corner, left out where they do not fit."""
    left = round(letter_px)
    right = left + written_width(words, letter_px)
    if right <= picture.shape[1] and picture.shape[0] >= 3 * letter_px:
        write(picture, words, left, round(2.1 * letter_px), letter_px)


def plate(picture: Picture, words: str, left: int, top: int, height_px: float) -> None:
    """White words on a dark see-through plate whose corner is at (left, top).

    Left out where they do not fit.
    """
    pad = round(0.7 * height_px)
    right = left + written_width(words, height_px) + 2 * pad
    bottom = top + round(height_px) + 2 * pad
    if right > picture.shape[1] or bottom > picture.shape[0]:
        return
    ground = picture[top:bottom, left:right]
    ground[:] = ground * 0.35 + 12
    write(picture, words, left + pad, bottom - pad, height_px, (238, 240, 243))


def round_length(metres_across: float) -> float:
    """A length of 1, 2 or 5 × 10ⁿ metres for the scale bar of a picture that many metres across.

    Those with a 5 come first, so that one length serves for all usual pictures of a person.
    """
    longest = [
        digit * 10.0 ** math.floor(math.log10(LONGEST_BAR * metres_across / digit))
        for digit in (5, 2, 1)
    ]
    return next(length for length in longest if length >= SHORTEST_BAR * metres_across)


def length_name(metres: float) -> str:
    """A length in the unit people would use for it: 5 mm, 2 cm, 0.5 m, 50 m, 2 km."""
    for least, unit, name in ((1000.0, 1000.0, "km"), (0.1, 1.0, "m"), (0.01, 0.01, "cm")):
        if metres > 0.99 * least:
            return f"{metres / unit:g} {name}"
    return f"{metres * 1000:g} mm"


def scale_bar(picture: Picture, metres: float, pixels_per_metre: float, letter_px: float) -> int:
    """A bar of that length, with its name, in the lower left corner, left out without room.

    Returns the column behind them, 0 without them.
    """
    gap, bottom = round(1.1 * letter_px), picture.shape[0] - round(1.1 * letter_px)
    end = gap + round(metres * pixels_per_metre)
    name, size = length_name(metres), 0.8 * letter_px
    left = end + round(0.6 * letter_px)
    right = left + written_width(name, size)
    if right > picture.shape[1] or picture.shape[0] < 4.5 * letter_px:
        return 0
    for start, stop in (
        ((gap, bottom), (end, bottom)),
        ((gap, bottom - 4), (gap, bottom)),
        ((end, bottom - 4), (end, bottom)),
    ):
        cv2.line(picture, start, stop, TEXT, 1)
    write(picture, name, left, bottom, size)
    return right


def axes(picture: Picture, right: str, up: str, letter_px: float, bar_end: int = 0) -> None:
    """Two arrows with their letters in the lower right corner; "-y" names one that points down.

    Left out of small pictures, where they would cover the body, and where they would run into the
    scale bar, which ends at column bar_end.
    """
    height, width = picture.shape[:2]
    reach = round(2.6 * letter_px)
    drop = round(0.4 * letter_px)
    x = width - reach - round(2.4 * letter_px)
    if x - 2 * drop - 4 < bar_end + 0.5 * letter_px or height < 12 * letter_px:
        return
    y = height - round(1.6 * letter_px)
    downward = up.startswith("-")
    y -= reach if downward else 0
    tip = y + reach if downward else y - reach
    letter = up.lstrip("-")
    for end, name in (((x + reach, y), right), ((x, tip), letter)):
        cv2.arrowedLine(picture, (x, y), end, AXIS_COLOURS[name], 1, cv2.LINE_AA, tipLength=0.22)
    size = 0.8 * letter_px
    write(picture, right, x + reach + drop, y + drop, size, AXIS_COLOURS[right])
    write(picture, letter, x - 2 * drop - 4, tip + drop, size, AXIS_COLOURS[letter])
