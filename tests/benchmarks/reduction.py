"""Recorded motions reduced to keyframes: how many frames one keyframe stands for."""

from __future__ import annotations

from collections.abc import Callable

from keypose.tracker.body.body import preset
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.reduction.reduce import reduce_motion
from keypose.tracker.reduction.result import Tolerance
from tests.benchmarks.keeping import Absent
from tests.benchmarks.table import Expected, Report
from tests.rendering import mocap
from tests.rendering.scenes import camera

FEWEST_PER_KEYFRAME = 20.0
"""Asked for with the film tracked between keyframes. By interpolation alone nothing comes near:
cubic curves, with velocities from neighbouring keyframes, reach 3.0 to 6.7, and with the motion's
own velocities 4.6 to 10.9."""
MOTIONS: dict[str, tuple[Callable[[Skeleton], Trajectory], str]] = {
    "walk": (mocap.walk, "adult_female"),
    "jump": (mocap.jump, "adult_male"),
    "wash": (mocap.wash, "elderly_male"),
    "pirouette": (mocap.pirouette, "adult_female"),
    "jumping jacks": (mocap.jumping_jacks, "adult_male"),
}


def reduction(report: Report) -> None:
    """Each to the tolerance that is offered first, by interpolation alone."""
    table = report.table("reduced to 2 cm", "frames", "keyframes", "frames a keyframe")
    for name, (made, body) in MOTIONS.items():
        skeleton = Skeleton.of(preset(body))
        try:
            motion = made(skeleton)
        except FileNotFoundError:
            raise Absent("the recorded motions beside the checkout") from None
        found = reduce_motion(skeleton, camera(), motion, Tolerance())
        each = found.frames_per_keyframe
        short = Expected("keyframes, of those allowed", FEWEST_PER_KEYFRAME / each, 1.0, "×")
        table.row(name, len(motion), len(found.frames), each, expected=[short])
