"""Where a limb ends."""

from __future__ import annotations

import numpy as np

from keypose.tracker.body.body import Part


def end_site(part: Part) -> tuple[float, float, float]:
    """Where a part without children ends, in its own frame, metres: in its farthest landmark or,
    when it has none, in the end of its shape."""
    if part.landmarks:
        return max(part.landmarks.values(), key=lambda p: float(np.linalg.norm(p)))
    return part.shape.far_end
