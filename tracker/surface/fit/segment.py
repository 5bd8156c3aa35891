"""Observed surfaces and posed keyframes to a motion: what the fit does for one session.

Between two keyframes the steps are fitted from both and blended; before the first keyframe and
after the last there is one chain.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from keypose.tracker.body.body import Body
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.trajectory import Pass, Trajectory
from keypose.tracker.errors import SessionError
from keypose.tracker.session.verdict import Verdict
from keypose.tracker.surface.fit.blend_chains import JoinedChains, join_chains
from keypose.tracker.surface.fit.chain import Link, follow, keyframe_link
from keypose.tracker.surface.fit.judging import (
    judge_links,
    not_reached,
    unseen_turns,
    unusable_steps,
)
from keypose.tracker.surface.fit.model import SurfaceModel
from keypose.tracker.surface.fit.options import Options
from keypose.tracker.surface.fit.pairing import TargetSurface
from keypose.tracker.surface.fit.solving import fit_pose
from keypose.tracker.surface.mesh import Steps
from keypose.tracker.tracking.pool import Cancelled
from keypose.tracker.tracking.result import Diagnostics, SegmentResult

REPORT_S = 0.25
"""Between two trajectories on the way."""

Report = Callable[[Pass, int], None]


class _Reporter:
    """Reports trajectories on the way, not too often. done: steps reported before."""

    def __init__(self, span: tuple[int, int], emit: Report, done: int) -> None:
        self._span, self._emit = span, emit
        self._done, self._reported_at = done, time.monotonic()

    def report(self, links: Sequence[Link]) -> None:
        """One more step is done: links from one end of the span so far, the latest last."""
        self._done += 1
        now = time.monotonic()
        if now - self._reported_at < REPORT_S:
            return
        self._reported_at = now
        first, last = self._span
        held = [links[-1]] * (last - first + 1 - len(links))
        onward = links[0].frame == first
        every = [*links, *held] if onward else [*held, *reversed(links)]
        step = links[-1].step
        score = None if step is None else step.rms_m
        self._emit(Pass("fit", _trajectory(first, every), score), self._done)


class SurfaceTracker:
    """Surfaces, a body and its keyposes, made ready to be fitted.

    Raises SessionError without a keypose at `model_frame`, SurfaceError where that step's surface
    cannot be used.
    """

    def __init__(
        self,
        steps: Steps,
        body: Body,
        keyposes: Mapping[int, Pose],
        model_frame: int,
        options: Options,
    ) -> None:
        if model_frame not in keyposes:
            raise SessionError(f"Frame {model_frame} has no keyframe: pose the body there first.")
        self.keyposes = dict(keyposes)
        model = SurfaceModel.of(
            steps.mesh(model_frame), body, keyposes[model_frame], options.points, options.smooth
        )
        posed = [pose.Rs_parent_part for pose in keyposes.values()]
        self.model = replace(model, limits=model.limits.widened(posed))
        self._steps, self._options = steps, options
        self._unfinished: dict[tuple[int, int], list[list[Link]]] = {}

    def run_segment(self, span: tuple[int, int], emit: Report) -> SegmentResult:
        """Fit the steps from span[0] to span[1].

        emit: given a trajectory now and then, with the number of steps that are done; where a step
        has not been fitted yet it keeps the nearest pose. It may raise Cancelled: then the result
        has what was done until then, and the next run of the segment goes on from there.
        SessionError unless one end of the span at least is a keyframe.
        """
        keys = [frame for frame in span if frame in self.keyposes]
        if not keys:
            raise SessionError(f"Neither {span[0]} nor {span[1]} has a keyframe: pose one of them.")
        chains = self._unfinished.pop(span, None) or [[self._begin_chain(frame)] for frame in keys]
        reporter = _Reporter(span, emit, sum(len(chain) - 1 for chain in chains))
        try:
            for chain in chains:
                self._extend(chain, span, reporter)
        except Cancelled:
            if all(len(chain) == 1 for chain in chains):
                raise
        every = join_chains(self.model.skeleton, span, chains, self.keyposes)
        if every.missing:
            self._unfinished[span] = chains
        return _result(self.model, every, keys)

    def expected_steps(self, span: tuple[int, int]) -> int:
        """Steps that `run_segment` works through."""
        chains = sum(frame in self.keyposes for frame in span)
        return chains * (span[1] - span[0])

    def fit_frame(self, frame: int, pose: Pose) -> Pose:
        """A pose fitted to the surface of one step; SurfaceError where that cannot be used."""
        observed = TargetSurface.of(self._steps.mesh(frame), self._options)
        return fit_pose(self.model, observed, pose, self._options).pose

    def _extend(self, chain: list[Link], span: tuple[int, int], reporter: _Reporter) -> None:
        """Follow a chain on to the other end of the span."""
        first, last = span
        at = chain[-1].frame
        onward = (
            range(at + 1, last + 1) if chain[0].frame == first else range(at - 1, first - 1, -1)
        )
        for link in follow(self.model, self._steps, chain, onward, self._options):
            chain[-1] = replace(chain[-1], reliability=None)  # only the last link needs its own
            chain.append(link)
            reporter.report(chain)

    def _begin_chain(self, frame: int) -> Link:
        return keyframe_link(self.model, self._steps, frame, self.keyposes[frame], self._options)


def _result(model: SurfaceModel, every: JoinedChains, keys: Sequence[int]) -> SegmentResult:
    links = every.links
    steps = [link.step for link in links[1:]]
    parts, dofs = model.skeleton.part_count, model.skeleton.dof_count
    unknown = np.full(parts, np.nan)
    rms = [step.rms_m for step in steps if step is not None and np.isfinite(step.rms_m)]
    return SegmentResult(
        trajectory=_trajectory(links[0].frame, links),
        scores=(float(np.mean(rms)) if rms else np.nan,),
        steps=("fit",),
        best_pass=0,
        closing_error=0.0,
        verdict=_verdict(model, every, keys),
        diagnostics=Diagnostics(
            rank=np.array([-1 if step is None else step.rank for step in steps], np.int64),
            singular_values=np.array(
                [np.full(dofs, np.nan) if step is None else step.singular for step in steps]
            ),
            observability=np.array([unknown if s is None else s.observability for s in steps]),
            residual=np.array([unknown if s is None else s.residual for s in steps]),
        ),
        notes=(*unusable_steps(links), *unseen_turns(model, links)),
        missing=every.missing,
        unreached=every.unreached,
    )


def _verdict(model: SurfaceModel, every: JoinedChains, keys: Sequence[int]) -> Verdict:
    """Judge what was reached; where that is not lost, what was not reached comes first."""
    first, last = every.unreached or (0, -1)
    reached = [link for link in every.links if not first <= link.frame <= last]
    verdict = judge_links(model, reached, keys, every.apart_m)
    if not every.missing or verdict.kind == "lost":
        return verdict
    return not_reached(every.unreached, (every.links[0].frame, every.links[-1].frame))


def _trajectory(first: int, links: Sequence[Link]) -> Trajectory:
    return Trajectory(
        first,
        np.array([link.pose.Rs_parent_part for link in links]),
        np.array([link.pose.p_camera_root for link in links]),
    )
