"""The result of a tracked segment: its motion, its verdict and its diagnostics."""

from __future__ import annotations

from dataclasses import replace

from keypose.tracker.tracking.cycle import Outcome
from keypose.tracker.tracking.diagnostics.expected_gain import expected_gain
from keypose.tracker.tracking.diagnostics.judge import judge
from keypose.tracker.tracking.diagnostics.observability import observe, unobserved
from keypose.tracker.tracking.drift import closing_error
from keypose.tracker.tracking.method import Method, Paper
from keypose.tracker.tracking.result import SegmentResult
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.tracking.segment import Segment


def segment_result(
    scene: Scene, segment: Segment, outcome: Outcome, method: Method, enlarged: float
) -> SegmentResult:
    """The result of an outcome, judged where the method asks for it.

    enlarged: pixels of the video to one of the pictures worked on.
    """
    judged = isinstance(method, Paper) or method.judged
    seen = (observe if judged else unobserved)(scene, segment.clip, outcome.trajectory)
    error = None
    if outcome.joints is not None:
        by_part = outcome.joints.expected_error(scene.skeleton.part_count)
        error = by_part * outcome.joints.height_px * enlarged
    diagnostics = replace(
        seen.diagnostics,
        expected_gain=expected_gain(scene, outcome, seen),
        expected_error=error,
    )
    return SegmentResult(
        trajectory=outcome.trajectory,
        scores=tuple(step.score_or_nan for step in outcome.passes),
        steps=tuple(step.what for step in outcome.passes),
        best_pass=outcome.best,
        closing_error=max(
            outcome.gap, closing_error(outcome.trajectory, segment.start, segment.end)
        ),
        verdict=judge(scene, segment, outcome, seen),
        diagnostics=diagnostics,
        notes=outcome.notes,
    )
