"""What a file says of the lens that took it: its focal length, and the device."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

NEAREST_MM, FARTHEST_MM = 4.0, 2000.0
"""Focal lengths, as a 35 mm film would have them, between which there are lenses."""

LONGEST_NAME = 60

_FOCAL = ("focal_length.35mm_equivalent", "focallengthin35mmfilm", "focallengthin35mmformat")
_MAKE = ("com.apple.quicktime.make", "com.android.manufacturer", "make")
_MODEL = ("com.apple.quicktime.model", "com.android.model", "model")
_NUMBER = re.compile(r"\s*([0-9]{1,4}(?:\.[0-9]{1,6})?)\s*(?:mm)?\s*", re.ASCII)


@dataclass(frozen=True)
class FileLens:
    """focal_mm: as on 35 mm film, whose frame is 36 mm wide.  device: its name, or empty."""

    focal_mm: float
    device: str = ""


def lens_in(tags: Iterable[Mapping[str, str]]) -> FileLens | None:
    """The lens named by tags of QuickTime and MP4 files, or by the EXIF tags of an image.

    None where no focal length is given, or one that no lens has.
    """
    known = {key.casefold(): value for some in tags for key, value in some.items()}
    texts = [value for key, value in known.items() if key.endswith(_FOCAL)]
    focal_mm = next((mm for mm in map(_millimetres, texts) if mm is not None), None)
    if focal_mm is None:
        return None
    return FileLens(focal_mm, _device(_first(known, _MAKE), _first(known, _MODEL)))


def _millimetres(text: str) -> float | None:
    found = _NUMBER.fullmatch(text)
    mm = float(found[1]) if found else math.nan
    return mm if NEAREST_MM <= mm <= FARTHEST_MM else None


def _first(known: Mapping[str, str], keys: tuple[str, ...]) -> str:
    return next((known[key] for key in keys if key in known), "")


def _device(make: str, model: str) -> str:
    """ "Google Pixel 7"; the maker once."""
    make, model = _printable(make), _printable(model)
    name = model if model.casefold().startswith(make.casefold()) else f"{make} {model}"
    return name.strip()[:LONGEST_NAME]


def _printable(text: str) -> str:
    return " ".join("".join(c for c in text if c.isprintable()).split())
