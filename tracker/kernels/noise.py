"""What the histogram of residuals gives: their noise, and the score of what they belong to."""

from __future__ import annotations

from keypose.tracker.kernels import compiled

BINS = 257
FAR = 255
LOST = 256
"""Histogram of |r|: quarter grey levels, all beyond in FAR; and how many left the picture."""


@compiled
def median_residual(histogram, count):
    """Median |r| in grey levels, linear inside its bin; the last bin stands for all beyond."""
    half, below = 0.5 * count, 0.0
    for k in range(FAR + 1):
        if below + histogram[k] >= half:
            return (k + (half - below) / max(1, histogram[k])) * 0.25
        below += histogram[k]
    return 0.25 * FAR


@compiled
def robust_sigma(histogram, count):
    """max(2 grey levels, 1.4826 MAD): noise of the residuals; 10 where there is hardly any data."""
    if count <= 50:
        return 10.0
    return max(2.0, 1.4826 * median_residual(histogram, count))


@compiled
def capped_square(histogram, count, cap):
    """Mean of min(r², cap²) in grey levels squared, from the histogram.

    A point that left the picture counts as one at the cap: else the best path would lead out of it.
    """
    s = histogram[LOST] * cap * cap
    for k in range(FAR + 1):
        r = (k + 0.5) * 0.25
        s += histogram[k] * min(r * r, cap * cap)
    return s / max(1, count + histogram[LOST])
