"""The second film's clock and camera, found from the body alone."""

from __future__ import annotations

from typing import Final

import numpy as np

from bench.films.man import BESIDE, FIRST, FPS, FRAMES, Man
from bench.table import Expected, Report
from keypose.tracker.films.cameras import lengths_of
from keypose.tracker.films.offset import FoundOffset, OffsetSearch, find_offsets
from keypose.tracker.films.sightings import Sightings
from keypose.tracker.geometry.film_clock import FilmClock
from keypose.tracker.geometry.rotations import (
    Array,
    log_rotation,
)
from keypose.tracker.storage.files import load_session

CUTS: Final = (0, 3, 11)
"""Frames that the second film is begun later by."""
MOST_OFFSET: Final = 0.5


def cameras_and_clocks(report: Report, man: Man) -> None:
    columns = ("offset", "±", "turn °", "± °", "place cm", "± cm", "lens %")
    table = report.table("the second film's clock and camera, found from the body", *columns)
    lengths_m = lengths_of(man.skeleton.body)
    for known in (True, False):
        for cut in CUTS:
            found, focal = _found(man, lengths_m, cut, known)
            off = found.clock.begins - cut
            T, true = found.camera.T_camera_first, man.T_beside_first
            turn = np.degrees(np.linalg.norm(log_rotation(T[:3, :3] @ true[:3, :3].T)))
            there, here = (-each[:3, :3].T @ each[:3, 3] for each in (T, true))
            table.row(
                f"{'lenses known' if known else 'lenses guessed'}, {cut} frames later",
                float(off),
                found.sigma,
                float(turn),
                float(np.degrees(found.camera.sigma_rad)),
                float(100 * np.linalg.norm(there - here)),
                100 * found.camera.sigma_m,
                focal,
                expected=[Expected("offset", abs(float(off)), MOST_OFFSET, "frames")],
            )


def _found(man: Man, lengths_m: Array, cut: int, known: bool) -> tuple[FoundOffset, float]:
    """The likeliest offset, and by how many per cent the worse lens is off then."""
    sightings, cameras = {}, {}
    for number, view in man.views.items():
        guess = load_session(man.folders[number] / "session.json").view.camera
        cameras[number] = view.camera if known else guess
        sightings[number] = Sightings.of(view.keypoints, cameras[number], FRAMES)
    film = sightings[BESIDE].at(FilmClock(), np.arange(cut, FRAMES))
    free = not known, not known
    best, *_ = find_offsets(OffsetSearch(sightings[FIRST], film, FPS, lengths_m, free), 1.0)
    ratios = {FIRST: best.camera.first_focal, BESIDE: best.camera.focal}
    off = [
        100 * abs(cameras[n].fx * ratios[n] / man.views[n].camera.fx - 1) for n in (FIRST, BESIDE)
    ]
    return best, float(max(off))
