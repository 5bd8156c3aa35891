"""Words, scale bars and little axes on finished pictures (H, W, 3) uint8, all drawn in place."""

from __future__ import annotations

import cv2

from app.palette import AXIS_COLOURS, TEXT, Colour, Picture

FONT = cv2.FONT_HERSHEY_SIMPLEX
LETTER_PX = 22.0
"""Height of a capital letter at OpenCV's font scale 1."""


def write(
    picture: Picture, words: str, left: int, baseline: int, height_px: float, colour: Colour = TEXT
) -> None:
    """Words from (left, baseline) on, capitals height_px tall."""
    weight = max(1, round(height_px / 11))
    scale = height_px / LETTER_PX
    cv2.putText(picture, words, (left, baseline), FONT, scale, colour, weight, cv2.LINE_AA)


def written_width(words: str, height_px: float) -> int:
    """How many pixels the words take."""
    (width, _), _ = cv2.getTextSize(words, FONT, height_px / LETTER_PX, 1)
    return int(width)


def plate(picture: Picture, words: str, left: int, top: int, height_px: float) -> None:
    """White words on a dark see-through plate whose corner is at (left, top)."""
    pad = round(0.7 * height_px)
    right = left + written_width(words, height_px) + 2 * pad
    bottom = top + round(height_px) + 2 * pad
    ground = picture[top:bottom, left:right]
    ground[:] = ground * 0.35 + 12
    write(picture, words, left + pad, bottom - pad, height_px, (238, 240, 243))


def scale_bar(picture: Picture, metres: float, pixels_per_metre: float, letter_px: float) -> None:
    """A bar of that length, with its name, in the lower left corner."""
    gap, bottom = round(1.1 * letter_px), picture.shape[0] - round(1.1 * letter_px)
    end = gap + round(metres * pixels_per_metre)
    for start, stop in (
        ((gap, bottom), (end, bottom)),
        ((gap, bottom - 4), (gap, bottom)),
        ((end, bottom - 4), (end, bottom)),
    ):
        cv2.line(picture, start, stop, TEXT, 1)
    write(picture, f"{metres:g} m", end + round(0.6 * letter_px), bottom, 0.8 * letter_px)


def axes(picture: Picture, right: str, up: str, letter_px: float) -> None:
    """Two arrows with their letters in the lower right corner; "-y" names one that points down."""
    reach = round(2.6 * letter_px)
    x = picture.shape[1] - reach - round(2.4 * letter_px)
    y = picture.shape[0] - round(1.6 * letter_px)
    downward = up.startswith("-")
    y -= reach if downward else 0
    tip = y + reach if downward else y - reach
    letter = up.lstrip("-")
    for end, name in (((x + reach, y), right), ((x, tip), letter)):
        cv2.arrowedLine(picture, (x, y), end, AXIS_COLOURS[name], 1, cv2.LINE_AA, tipLength=0.22)
    drop = round(0.4 * letter_px)
    size = 0.8 * letter_px
    write(picture, right, x + reach + drop, y + drop, size, AXIS_COLOURS[right])
    write(picture, letter, x - 2 * drop - 4, tip + drop, size, AXIS_COLOURS[letter])
