"""Observed surfaces and posed keyframes to a motion: what the fit does for one session.

Between two keyframes the steps are fitted from both and blended; before the first keyframe and
after the last there is one chain.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from tracker.body import Body
from tracker.errors import SessionError
from tracker.geometry import Array
from tracker.pose import Pose, part_transforms
from tracker.scoring import Pass
from tracker.skeleton import Skeleton
from tracker.surface.fit.chain import Link, blended, filled, follow
from tracker.surface.fit.judging import judge_links, unseen_turns, unusable_steps
from tracker.surface.fit.model import SurfaceModel
from tracker.surface.fit.options import Options
from tracker.surface.fit.pairing import Observed
from tracker.surface.fit.solving import fit_pose
from tracker.surface.steps import Steps
from tracker.track import SegmentResult
from tracker.trajectory import Trajectory

TELL_S = 0.25
"""Between two trajectories on the way."""

Tell = Callable[[Pass, int], None]


class _Teller:
    """Tells trajectories on the way, not too often."""

    def __init__(self, span: tuple[int, int], emit: Tell) -> None:
        self._span, self._emit = span, emit
        self._done, self._told_at = 0, time.monotonic()

    def tell(self, links: Sequence[Link]) -> None:
        """One more step is done: links from one end of the span so far, the latest last."""
        self._done += 1
        now = time.monotonic()
        if now - self._told_at < TELL_S:
            return
        self._told_at = now
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

    def run_segment(self, span: tuple[int, int], emit: Tell) -> SegmentResult:
        """Fit the steps from span[0] to span[1].

        emit: told a trajectory now and then, with the number of steps that are done; where a step
        has not been fitted yet it keeps the nearest pose. It may raise to stop. SessionError unless
        one end of the span at least is a keyframe.
        """
        keyed = [frame for frame in span if frame in self.keyposes]
        if not keyed:
            raise SessionError(f"Neither {span[0]} nor {span[1]} has a keyframe: pose one of them.")
        teller = _Teller(span, emit)
        chains = [self._chain(span, frame, teller) for frame in keyed]
        one, two = chains[0], chains[-1]
        apart = None
        if len(chains) == 2:
            apart = _apart(self.model.skeleton, one, two)
            one = _both(self.model.skeleton, one, two)
        return _result(self.model, one, keyed, apart)

    def expected_steps(self, span: tuple[int, int]) -> int:
        """Steps that `run_segment` works through."""
        chains = sum(frame in self.keyposes for frame in span)
        return chains * (span[1] - span[0])

    def fit_frame(self, frame: int, pose: Pose) -> Pose:
        """A pose laid onto the surface of one step; SurfaceError where that cannot be used."""
        observed = Observed.of(self._steps.mesh(frame), self._options)
        return fit_pose(self.model, observed, pose, self._options).pose

    def _chain(self, span: tuple[int, int], start: int, teller: _Teller) -> list[Link]:
        """All steps of a span, followed from one of its ends, in the order of the frames."""
        first, last = span
        onward = range(first + 1, last + 1) if start == first else range(last - 1, first - 1, -1)
        links = [self._keyed(start)]
        for link in self._followed(start, onward):
            links.append(link)
            teller.tell(links)
        links = filled(sorted(links, key=lambda link: link.frame))
        far = last if start == first else first
        if far in self.keyposes:  # a keyframe is never changed
            place = far - first
            links[place] = Link(far, self.keyposes[far], links[place].step, links[place].problem)
        return links

    def _followed(self, start: int, frames: Sequence[int]) -> Iterator[Link]:
        return follow(self.model, self._steps, self.keyposes[start], frames, self._options)

    def _keyed(self, frame: int) -> Link:
        """A keyframe as it was posed, measured but not moved."""
        still = replace(self._options, solves=0)
        return next(follow(self.model, self._steps, self.keyposes[frame], [frame], still))


def _apart(skeleton: Skeleton, one: Sequence[Link], two: Sequence[Link]) -> Array:
    """(N, P) metres between the joints of two chains; near a keyframe the far one has no say."""
    joints = [_joints(skeleton, links) for links in (one, two)]
    share = np.linspace(0.0, 1.0, len(one))
    return np.asarray(
        np.linalg.norm(joints[0] - joints[1], axis=2) * (4 * share * (1 - share))[:, None]
    )


def _joints(skeleton: Skeleton, links: Sequence[Link]) -> Array:
    Rs = np.array([link.pose.Rs_parent_part for link in links])
    roots = np.array([link.pose.p_camera_root for link in links])
    return part_transforms(skeleton, Rs, roots)[..., :3, 3]


def _both(skeleton: Skeleton, one: Sequence[Link], two: Sequence[Link]) -> list[Link]:
    """Two chains as one; the keyframes at both ends stay as they are."""
    inner = [
        blended(skeleton, ahead, behind, k / (len(one) - 1))
        for k, (ahead, behind) in enumerate(zip(one, two, strict=True))
    ]
    return [one[0], *inner[1:-1], two[-1]]


def _result(
    model: SurfaceModel, links: Sequence[Link], keyed: Sequence[int], apart: Array | None
) -> SegmentResult:
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
        verdict=judge_links(model, links, keyed, apart),
        rank=np.array([-1 if step is None else step.rank for step in steps], np.int64),
        singular_values=np.array(
            [np.full(dofs, np.nan) if step is None else step.singular for step in steps]
        ),
        observability=np.array([unknown if s is None else s.observability for s in steps]),
        residual=np.array([unknown if s is None else s.residual for s in steps]),
        notes=(*unusable_steps(links), *unseen_turns(model, links)),
    )


def _trajectory(first: int, links: Sequence[Link]) -> Trajectory:
    return Trajectory(
        first,
        np.array([link.pose.Rs_parent_part for link in links]),
        np.array([link.pose.p_camera_root for link in links]),
    )
