"""What a detector of joints says of one keyframe's pose, as evidence beside texture and outline.

It finds joints of any pose, but puts them a little elsewhere than a person does. So a pose is moved
by it only where it falls clearly: a right pose, whose joints are off by no more than the detector's
own error, stays.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from keypose.tracker.body.pose import Pose
from keypose.tracker.fitting.pose.inputs import FitInputs
from keypose.tracker.fitting.pose.refinement import PosedKeyframe
from keypose.tracker.solver.least_squares import Criteria, Damping, least_squares
from keypose.tracker.solver.one_pose import OnePose
from keypose.tracker.solver.pose_terms import PointsInPicture
from keypose.tracker.solver.posed import Posed
from keypose.tracker.solver.robust import Cauchy
from keypose.tracker.solver.terms import Term
from keypose.tracker.tracking.cues.anchors import frame_anchors
from keypose.tracker.tracking.cues.sources import FrameSource

CRITERIA = Criteria(most_steps=20, settled=1e-4, damping=Damping(most=1e6))


@dataclass(frozen=True, eq=False)
class Joints:
    """Joints of one keyframe as a detector sees them, and the most likely pose by them alone."""

    keyframe: PosedKeyframe
    term: PointsInPicture
    likely: Pose

    @classmethod
    def of(
        cls, inputs: FitInputs, source: FrameSource | None, near: Mapping[int, Pose]
    ) -> Joints | None:
        """None where there is no detector, or it sees somebody else.

        near: keyframes beside it, which show where on a part the detector puts a joint.
        """
        if source is None:
            return None
        scene, keyframe = inputs.scene, inputs.keyframe
        seen = source.at(inputs.frame, scene.skeleton, keyframe.pose)
        if seen is None:
            return None
        keyed = [
            (pose, found)
            for frame, pose in near.items()
            if (found := source.at(frame, scene.skeleton, pose)) is not None
        ]
        camera = inputs.loader.camera
        term = frame_anchors(scene, camera, seen, keyframe.pose, keyed, Cauchy())
        if term is None:
            return None
        terms: list[Term] = [term, keyframe.prior, keyframe.joint_limits]
        solution = least_squares(OnePose(scene.skeleton, terms), keyframe.pose, CRITERIA)
        return cls(keyframe, term, solution.state)

    def gain(self, pose: Pose) -> float:
        """By how much likelier a pose is than the one as set, nats."""
        before, after = (
            Posed.of(self.keyframe.scene.skeleton, some) for some in (self.keyframe.pose, pose)
        )
        return self.term.cost(before) - self.term.cost(after) - self.keyframe.prior.cost(after)
