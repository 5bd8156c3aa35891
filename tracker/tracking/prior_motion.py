"""A segment's own motion from before, as what its motion is compared with besides the film.

A motion that was known before, found or imported, says how a segment goes where the film does not:
its steps, not its places, since these give way where a keyframe was corrected. The film decides
where it shows the body, and a limb that is hidden moves as it did. This is drift correction about a
motion instead of about rest (DRIFT §3: what is missing at a keyframe is spread over the steps).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from keypose.tracker.solver.robust import SQUARED
from keypose.tracker.solver.sigmas import KNOWN_STEP
from keypose.tracker.solver.smoothness import Increments, Smoothness, increments
from keypose.tracker.solver.terms import Link

if TYPE_CHECKING:
    from keypose.tracker.body.trajectory import Trajectory
    from keypose.tracker.tracking.scene import Scene


def prior_motion_links(scene: Scene, own: Trajectory) -> tuple[Link, ...]:
    """What a segment's motion is compared with from frame to frame; it needs no other
    smoothness.

    own: a motion that meets both keyframes.
    """
    skeleton = scene.skeleton
    steps = increments(skeleton, own)
    precision = scene.precision(KNOWN_STEP)
    return (
        Increments(skeleton, steps, np.broadcast_to(precision, steps.shape), SQUARED),
        Smoothness(skeleton, np.diff(steps, axis=0), precision, SQUARED),
    )
