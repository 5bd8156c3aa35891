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
from keypose.tracker.solver.smoothness import Increments, Link, Smoothness, increments

if TYPE_CHECKING:
    from keypose.tracker.body.trajectory import Trajectory
    from keypose.tracker.tracking.scene import Scene

STEP_TURN_RAD, STEP_SHIFT_PX = np.radians(0.3), 0.3
"""Standard deviations of a step's motion about that of before. Three times as much makes the worst
error of rendered films by half larger, half as much leaves more of an imported motion's error."""
BEND_TURN_RAD, BEND_SHIFT_PX = STEP_TURN_RAD, STEP_SHIFT_PX
"""Standard deviations of how that changes from frame to frame."""


def prior_motion_links(scene: Scene, own: Trajectory) -> tuple[Link, ...]:
    """Return what a segment's motion is compared with from frame to frame; it needs no other
    smoothness.

    own: a motion that meets both keyframes.
    """
    skeleton = scene.skeleton
    steps = increments(skeleton, own)
    turned = scene.precision(STEP_TURN_RAD, STEP_SHIFT_PX * scene.pixel_m)
    bent = scene.precision(BEND_TURN_RAD, BEND_SHIFT_PX * scene.pixel_m)
    return (
        Increments(skeleton, steps, np.broadcast_to(turned, steps.shape), SQUARED),
        Smoothness(skeleton, np.diff(steps, axis=0), bent, SQUARED),
    )
