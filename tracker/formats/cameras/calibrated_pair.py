"""Which two cameras of a calibration may have taken two films."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import permutations
from pathlib import Path

import numpy as np

from keypose.tracker.errors import FormatError
from keypose.tracker.formats.cameras.calibrations import CalibratedCamera, load_calibration
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, log_rotation, transpose
from keypose.tracker.session.views import View

UNITS_M = (0.001, 0.01, 1.0)
"""In which calibrations are: files of one kind have the unit of whoever made them."""
MOST_SIZE = 0.25
"""By which share a body may be off by which it is known about how far apart cameras stand."""


@dataclass(frozen=True, eq=False)
class CalibratedPair:
    """Two cameras of a file, for pictures of both films' sizes.

    T_film_first: (4, 4), its lengths in the file's unit.
    """

    file: str
    names: tuple[str, str]
    first: Camera
    film: Camera
    T_film_first: Array

    def turned_deg(self, T_film_first: Array) -> float:
        """By how much the film's camera is turned from where the file has it."""
        turn = log_rotation(T_film_first[:3, :3] @ transpose(self.T_film_first[:3, :3]))
        return float(np.degrees(np.linalg.norm(turn)))

    def apart_m(self, about_m: float) -> float | None:
        """How far the cameras stand from each other, in that unit of those that files are in which
        agrees with about how far that is; None where none does."""
        apart = float(np.linalg.norm(self.T_film_first[:3, 3]))
        if apart <= 0 or about_m <= 0:
            return None
        metres = min(UNITS_M, key=lambda unit: abs(np.log(apart * unit / about_m)))
        agrees = abs(np.log(apart * metres / about_m)) <= MOST_SIZE
        return apart * metres if agrees else None


def calibrated_pairs(path: Path, first: View, film: View) -> list[CalibratedPair]:
    """All pairs of a file's cameras that may be those of two views: one whose name is in a film's
    name is taken for that film's. FormatError in one sentence where there is none."""
    pairs: list[CalibratedPair] = []
    why: FormatError | None = None
    cameras = load_calibration(path)
    own, others = _of_film(cameras, first), _of_film(cameras, film)
    for camera, beside in permutations(cameras, 2):
        if camera not in own or beside not in others:
            continue
        try:
            lens = camera.seeing(path.name, _size(first))
            lens_beside = beside.seeing(path.name, _size(film))
        except FormatError as error:
            why = error
            continue
        T = beside.T_camera_world @ np.linalg.inv(camera.T_camera_world)
        pairs.append(CalibratedPair(path.name, (camera.name, beside.name), lens, lens_beside, T))
    if not pairs:
        raise why or FormatError(f"{path.name} has no camera for each of both films.")
    return pairs


def _size(view: View) -> tuple[int, int]:
    return view.camera.width, view.camera.height


def _of_film(cameras: Sequence[CalibratedCamera], view: View) -> list[CalibratedCamera]:
    """The cameras that may have taken a film: those whose names are in its file's as words of their
    own, as 1 is in take_1 and not in IMG_1044; all where none is."""
    stem = Path(view.video.path).stem.lower()
    named = [camera for camera in cameras if _is_word_in(camera.name.lower(), stem)]
    return named or list(cameras)


def _is_word_in(name: str, text: str) -> bool:
    return re.search(rf"(?<![^\W_]){re.escape(name)}(?![^\W_])", text) is not None
