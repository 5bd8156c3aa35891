"""The verdict on fitted surfaces: good, check these frames, or lost: add a keyframe there.

The evidence is how near the surfaces lie, never the truth. The thresholds are shares of the
surface's size; they were set where, on generated arms and walkers of known motion, they separate
right steps from wrong ones.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.pose import Pose
from keypose.tracker.body.trajectory import runs
from keypose.tracker.errors import listed, readable
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.verdict import GOOD, Cause, Verdict
from keypose.tracker.surface.fit.chain import Link
from keypose.tracker.surface.fit.model import SurfaceModel
from keypose.tracker.surface.fit.solving import UNSEEN

LOST_UNEXPLAINED = 0.25
LOST_UNCOVERED = 0.45
"""Of what is seen, and of the body: so much without a counterpart is another pose."""
ROUGH_SHARE = 0.012
"""Of the surface's size: a part whose pairs lie farther apart is misplaced."""
APART_SHARE = 0.03
"""Of the surface's size: chains from two keyframes that put a joint so far apart."""
HIDDEN = 0.12
"""Of a part's surface: where less of it counts, its pose is hardly observed."""
BEYOND_RAD = np.radians(10.0)
"""Past a joint's limits: so far nothing but a wrong pose, or wrong sizes, turns it."""
OFF_SHARE = 0.04
"""Of the surface's size. Bodies a sixth too large or too small, or half a limb's thickness beside
their surface, come to 0.03; three times too large or small, or a limb's thickness and a half across
their limbs, to more."""
SHORTEST_RUN = 3
"""Steps for which a part must be doubtful before that is reported."""
RANK: Mapping[Cause, int] = {"beyond_limits": 0, "not_seen": 1, "uncertain": 2}
"""Of doubts that last equally long, the highest is the cause."""
MOST_LISTED = 5
"""Steps that could not be used, listed one by one."""


def judge_links(
    model: SurfaceModel, links: Sequence[Link], keyed: Collection[int], apart_m: Array | None
) -> Verdict:
    """The verdict on the steps of one segment.

    keyed: the frames of those that are keyframes.  apart_m: (N, P) how far two chains put each
    joint apart; None where there was one chain.
    """
    frames = [link.frame for link in links]
    astray = np.array([_is_astray(link) for link in links])
    followed = np.array([frame not in keyed for frame in frames])
    lost = _longest_run(astray & followed)
    if lost is not None:
        return Verdict.not_followed(frames[lost[0]])
    if astray.any():  # a person posed it so, but at another frame, or in another mesh
        frame = frames[int(astray.argmax())]
        return Verdict.check("keyframe_off_surface", (frame, frame))
    unusable = _longest_run(np.array([link.step is None for link in links]))
    if unusable is not None:
        return Verdict.check("no_surface", (frames[unusable[0]], frames[unusable[1]]))
    doubts = [
        (last - first, RANK[cause], part, first, last, cause)
        for cause, flags in _doubts(model, links, apart_m).items()
        for part in range(flags.shape[1])
        for first, last in runs(flags[:, part])
        if last - first + 1 >= min(SHORTEST_RUN, len(links))
    ]
    if not doubts:
        return GOOD
    _, _, part, first, last, cause = max(doubts)
    return Verdict.check(cause, (frames[first], frames[last]), model.skeleton.body.names[part])


def lies_off(model: SurfaceModel, pose: Pose) -> bool:
    """Whether the body, in the pose at which its surface was bound, lies elsewhere."""
    return model.off_share(pose) > OFF_SHARE


def off_its_surface(frame: int) -> Verdict:
    """The verdict on every segment where the body, as it was posed at this frame, does not lie in
    the mesh that moves with it: no other keyframe mends what follows from that."""
    return Verdict.check("body_off_surface", (frame, frame))


def not_reached(unreached: tuple[int, int] | None, span: tuple[int, int]) -> Verdict:
    """The verdict on a segment whose fit was stopped; without frames that no chain has reached,
    those between its keyframes still lack the second one."""
    if unreached is None:
        first = span[0] + 1
        return Verdict.check("one_keyframe", (first, max(first, span[1] - 1)))
    return Verdict.check("not_fitted", unreached)


def unseen_turns(model: SurfaceModel, links: Sequence[Link]) -> tuple[str, ...]:
    """A sentence on the parts whose turning the surface does not show, most of the time."""
    steps = [link.step for link in links if link.step is not None]
    if not steps:
        return ()
    unseen = np.mean([step.least_seen < UNSEEN for step in steps], axis=0) > 0.5
    unseen &= _carries_surface(model)
    names = [readable(n) for n, no in zip(model.skeleton.body.names, unseen, strict=True) if no]
    if not names:
        return ()
    return (
        f"The surface does not show the turn of {listed(names)} about "
        f"{'its' if len(names) == 1 else 'their'} own length: that stays as it was posed.",
    )


def unusable_steps(links: Sequence[Link]) -> tuple[str, ...]:
    """What was wrong with steps that were left out, a few of them in full."""
    problems = [link.problem for link in links if link.step is None and link.problem]
    more = len(problems) - MOST_LISTED
    rest = (f"{more} more steps could not be used either.",) if more > 0 else ()
    return (*problems[:MOST_LISTED], *rest)


def _is_astray(link: Link) -> bool:
    step = link.step
    return step is not None and (
        step.unexplained > LOST_UNEXPLAINED or step.uncovered > LOST_UNCOVERED
    )


def _doubts(
    model: SurfaceModel, links: Sequence[Link], apart_m: Array | None
) -> dict[Cause, NDArray[np.bool_]]:
    """(N, P) of every kind of doubt."""
    count, size = model.skeleton.part_count, model.size_m
    nothing = np.full(count, np.nan)
    residual = np.array([link.step.residual if link.step else nothing for link in links])
    counts = np.array([link.step.counts if link.step else nothing for link in links])
    carries = _carries_surface(model)
    uncertain = residual > ROUGH_SHARE * size
    if apart_m is not None:
        uncertain |= apart_m > APART_SHARE * size
    excess = np.array([model.limits.excess(link.pose.Rs_parent_part)[0] for link in links])
    return {
        "uncertain": uncertain & carries,
        "not_seen": (counts < HIDDEN) & carries,
        "beyond_limits": np.asarray(np.abs(excess).max(axis=2) > BEYOND_RAD),
    }


def _carries_surface(model: SurfaceModel) -> NDArray[np.bool_]:
    """(P,) whether anything of the surface goes with a part."""
    return np.asarray(np.bincount(model.own, minlength=model.skeleton.part_count) > 0)


def _longest_run(flags: NDArray[np.bool_]) -> tuple[int, int] | None:
    return max(runs(flags), key=lambda run: run[1] - run[0], default=None)
