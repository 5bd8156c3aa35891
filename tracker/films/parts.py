"""Whether all of a film shows what another shows: of one that was cut, one side of the cut does."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.films.bundle import ENDS, OF_BONE, SPREAD_M, BundleData, triangulated
from keypose.tracker.films.epipolar import epipolar_residuals
from keypose.tracker.films.offset import KERNEL, FoundOffset, OffsetSearch, likely_begins
from keypose.tracker.films.sightings import Sightings
from keypose.tracker.geometry.film_clock import FilmClock
from keypose.tracker.geometry.rotations import Array

LEAST_PART_S = 0.8
"""Of either side of a cut: shorter ones are a body that is hidden or taken for another."""
FITS = 1.25
MISFITS = 2.0
"""Medians of what a moment's rays and bones are off, in standard deviations and weighed by Cauchy's
kernel: up to here a side fits (recorded motions: 0.2 to 0.7), from here on it does not (2 to 7)."""
MAY_MISFIT = 1.5
"""The same where the camera may be a compromise between both sides."""
MOST_LOSS = 10.0
"""What one moment counts at most where a cut is looked for."""


def part_in_common(search: OffsetSearch, rate: float) -> range | None:
    """The frames of a film that alone show what the other shows, where its whole does not."""
    for begins in likely_begins(search.first, search.film, rate, search.fps):
        offset = search.about(FilmClock(begins, rate))
        part = None if offset is None else part_that_fits(search, offset)
        if part is not None:
            return part
    return None


def part_that_fits(search: OffsetSearch, offset: FoundOffset) -> range | None:
    """The frames of a film on the side of a cut on which an offset explains it; None where it
    explains both sides, or neither."""
    part = _better_side(search, offset, MAY_MISFIT)
    if part is None:
        return None
    alone = replace(search, film=_only(search, part))
    # with a camera that only this side has led to
    again = alone.about(offset.clock)
    if again is None or not alone.explains(again):
        return None
    return _better_side(search, again, MISFITS)


def _only(search: OffsetSearch, part: range) -> Sightings:
    """What is seen in these frames of the film."""
    inside = np.isin(np.arange(len(search.film)), part)
    film = search.film
    return replace(film, visibility=np.where(inside[:, None], film.visibility, 0.0))


def _better_side(search: OffsetSearch, offset: FoundOffset, misfits: float) -> range | None:
    """The side of the likeliest cut that fits, where the other is off by so much."""
    moments, losses = _by_moment(search, offset)
    least = int(np.ceil(LEAST_PART_S * search.fps))
    if len(moments) < 2 * least:
        return None
    cut = _change(np.minimum(losses, MOST_LOSS), least)
    before, after = np.median(losses[:cut]), np.median(losses[cut:])
    if min(before, after) > FITS or max(before, after) < misfits:
        return None
    frame = int(np.ceil(offset.clock.frames_at(moments[cut])))
    return range(frame) if before < after else range(frame, len(search.film))


def _by_moment(search: OffsetSearch, offset: FoundOffset) -> tuple[NDArray[np.int64], Array]:
    """Moments (M,) at which both films show the body, and how badly (M,) it fits there: in how far
    rays miss one another, and how long the bones between their joints are then."""
    camera, first = offset.camera, search.first
    film = search.film.at(offset.clock, np.arange(len(first)))
    residuals = epipolar_residuals(first, film, camera)
    lenses = first.zoomed(camera.first_focal), film.zoomed(camera.focal)
    data = BundleData.of(lenses, search.lengths_m, (False, False))
    joints = triangulated(data, np.stack([np.eye(4), camera.T_camera_first]))
    length = np.linalg.norm(joints[:, ENDS[:, 0]] - joints[:, ENDS[:, 1]], axis=-1)
    moments = np.flatnonzero(np.isfinite(length).any(axis=1))
    length = length[moments]
    usual = np.nanmedian(length, axis=0) if len(moments) else 0.0
    away = np.concatenate([residuals[moments], (length - usual) / SPREAD_M[OF_BONE]], axis=1)
    return np.asarray(moments, np.int64), np.asarray(np.nanmean(KERNEL.loss(away), axis=1))


def _change(values: Array, least: int) -> int:
    """Where the mean of values (M,) changes most, so many of them on either side at least."""
    count = np.arange(1, len(values))
    left = np.cumsum(values)[:-1]
    right = values.sum() - left
    # two means explain so much more than one
    explained = left**2 / count + right**2 / (len(values) - count)
    return int(np.argmax(explained[least - 1 : len(values) - least])) + least
