"""When a film was taken beside another, by what both microphones heard."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.video.sound import STEP_S, Loudness

LEAST_S = 1.5
"""Of sound that both films have to share."""
CLEAR = 6.0
"""By so many standard deviations the loudness has to agree better than at other offsets."""
DISTINCT = 1.3
"""So many times as well as at any offset farther away than the next value."""
AWAY_S = 0.15


def heard_s(first: Loudness | None, film: Loudness | None) -> float | None:
    """Seconds after the first film at which another begins, as their sound says; None where that
    is not clear. Sound takes 3 ms a metre: two microphones are that much apart."""
    if first is None or film is None:
        return None
    own, beside = _onsets(first), _onsets(film)
    lags, agreement = _agreement(own, beside)
    if not len(lags):
        return None
    best = int(np.argmax(agreement))
    away = np.abs(lags - lags[best]) > round(AWAY_S / STEP_S)
    if not away.any() or agreement[best] < CLEAR:
        return None
    if agreement[best] < DISTINCT * agreement[away].max():
        return None
    return float(lags[best] * STEP_S + first.begins_s - film.begins_s)


def _onsets(loudness: Loudness) -> Array:
    """(N - 1,) how loudness rises, about its mean in standard deviations: steps, claps, a ball."""
    rises = np.maximum(np.diff(loudness.levels), 0.0)
    spread = rises.std()
    return np.asarray((rises - rises.mean()) / spread if spread > 0 else np.zeros_like(rises))


def _agreement(own: Array, beside: Array) -> tuple[NDArray[np.int64], Array]:
    """Lags (L,) of the other film in moments, and how well rises agree there, in standard
    deviations of what chance gives."""
    size = len(own) + len(beside) - 1
    length = 1 << (size - 1).bit_length()
    product = np.fft.rfft(own, length) * np.conj(np.fft.rfft(beside, length))
    sums = np.fft.irfft(product, length)
    lags = np.arange(-(len(beside) - 1), len(own))
    shared = np.minimum(len(own), lags + len(beside)) - np.maximum(0, lags)
    used = shared >= LEAST_S / STEP_S
    return lags[used], np.asarray(sums[lags[used]] / np.sqrt(shared[used]))
